#include "solvers/granular_flow/rates.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

namespace lichtenberg::granular_flow {
namespace {

constexpr int reach = 3;  // Cells on either side of a face that contribute to its flux

/// Returns the value at the face after the third of five cells: a weighted mean of three parabolas, with small weights
/// for those that are not smooth (WENO).
[[gnu::always_inline]] inline double at_face(double a, double b, double c, double d, double e) {
  const auto square = [](double x) { return x * x; };
  const double left = 13.0 / 12 * square(a - 2 * b + c) + square(a - 4 * b + 3 * c) / 4;
  const double middle = 13.0 / 12 * square(b - 2 * c + d) + square(b - d) / 4;
  const double right = 13.0 / 12 * square(c - 2 * d + e) + square(3 * c - 4 * d + e) / 4;
  constexpr double none = 1e-30;  // Above the squared rounding error of a constant
  const double far = square(left - right);
  const double left_weight = 1 + far / square(left + none), middle_weight = 6 * (1 + far / square(middle + none)),
               right_weight = 3 * (1 + far / square(right + none));
  const double sum = left_weight * (2 * a - 7 * b + 11 * c) + middle_weight * (-b + 5 * c + 2 * d) +
                     right_weight * (2 * c + 5 * d - e);
  return sum / (6 * (left_weight + middle_weight + right_weight));
}

/// Returns the value of a logarithm at the face, limited to a factor of two relative to the third cell. Otherwise the
/// outflow could empty the cell.
[[gnu::always_inline]] inline double log_at_face(double a, double b, double c, double d, double e) {
  return std::clamp(at_face(a, b, c, d, e), c - std::numbers::ln2, c + std::numbers::ln2);
}

/// Computes the values at the faces after a line of cells. `below` follows from the first five of the six cells around
/// a face, `above` from the last five. at[k][i]: cell k of the six around face i. Compilers vectorize this loop.
template <class AtFace>
void find_line(const std::array<const double*, 6>& at, int cells, const AtFace& found, double* __restrict below,
               double* __restrict above) {
  const auto [a, b, c, d, e, f] = at;
  for (int i = 0; i < cells; ++i) {
    below[i] = found(a[i], b[i], c[i], d[i], e[i]);
    above[i] = found(f[i], e[i], d[i], c[i], b[i]);
  }
}

/// Return, from the means of the four cells around a face and to fourth order, the difference across it and the value
/// at it.
double step_at_face(double a, double b, double c, double d) { return (15 * (c - b) - (d - a)) / 12; }
double mean_at_face(double a, double b, double c, double d) { return (7 * (b + c) - (a + d)) / 12; }

double sum_of(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace

/// State of the gas at one side of a face.
struct Rates::Side {
  double density = 0, temperature = 0, charge = 0;  ///< Ratio c/n
  std::array<double, 3> velocity{};
  /// Returns the speed of the fastest waves along this axis, with (5/3) p / rho = (5/6) T.
  double fastest(int axis) const { return std::abs(velocity[axis]) + std::sqrt(5.0 / 6 * temperature); }
};

Rates::Rates(const Gas& gas, const Grid& grid, parallel::Team& team)
    : gas_(gas), grid_(grid), team_(team), size_(grid.size()), potential_(grid) {
  std::size_t stride = 1;
  for (int axis = grid.dimension - 1; axis >= 0; --axis) stride_[axis] = stride, stride *= grid.cells;
  for (int axis = 0; axis < grid.dimension; ++axis)
    for (std::size_t cell = 0; cell < size_; ++cell) {
      const std::size_t around = stride_[axis] * grid.cells, x = cell / stride_[axis] % grid.cells;
      next_[axis].push_back(x + 1 < static_cast<std::size_t>(grid.cells) ? cell + stride_[axis]
                                                                         : cell + stride_[axis] - around);
      before_[axis].push_back(x > 0 ? cell - stride_[axis] : cell - stride_[axis] + around);
    }
  for (auto* values : {&log_density_, &log_temperature_, &temperature_, &root_temperature_, &charge_})
    values->resize(size_);
  for (int axis = 0; axis < grid.dimension; ++axis) {
    velocity_[axis].resize(size_);
    for (int of = 0; of < grid.dimension; ++of) gradient_[axis][of].resize(size_);
  }
  for (auto* values : {&below_, &above_, &flow_}) values->resize(unknowns() * size_);
  face_velocity_.resize(size_);
  heating_.resize(size_);
}

std::vector<double> Rates::pack(const Fields& fields) const {
  std::vector<double> y(unknowns() * size_);
  const std::span<double> all(y);
  std::ranges::copy(fields.density, part(all, 0).begin());
  std::ranges::copy(fields.charge, part(all, 1).begin());
  for (int axis = 0; axis < grid_.dimension; ++axis) {
    const std::span<double> momentum = part(all, 2 + axis);
    std::ranges::transform(fields.density, fields.velocity[axis], momentum.begin(), std::multiplies());
    const double mean = sum_of(momentum) / sum_of(fields.density);
    for (std::size_t cell = 0; cell < size_; ++cell) momentum[cell] -= mean * fields.density[cell];
  }
  std::ranges::transform(fields.temperature, part(all, unknowns() - 1).begin(), [](double t) { return std::log(t); });
  return y;
}

Fields Rates::unpack(std::span<const double> y) const {
  const auto copy = [&](int which) { return std::vector(part(y, which).begin(), part(y, which).end()); };
  Fields fields{.density = copy(0), .temperature = copy(unknowns() - 1), .charge = copy(1), .velocity = {}};
  for (double& t : fields.temperature) t = std::exp(t);
  for (int axis = 0; axis < grid_.dimension; ++axis) {
    fields.velocity[axis] = copy(2 + axis);
    for (std::size_t cell = 0; cell < size_; ++cell) fields.velocity[axis][cell] /= fields.density[cell];
  }
  return fields;
}

/// Calls work(cell) for all cells; one task consists of the cells with the same first coordinate.
template <class Work>
void Rates::for_cells(const Work& work) const {
  team_.for_each(grid_.cells, [&](int x) {
    for (std::size_t cell = x * stride_[0]; cell < (x + 1) * stride_[0]; ++cell) work(cell);
  });
}

std::size_t Rates::neighbour(std::size_t cell, int axis, int far) const {
  for (; far > 0; --far) cell = next_[axis][cell];
  for (; far < 0; ++far) cell = before_[axis][cell];
  return cell;
}

Rates::Around Rates::around(std::size_t cell, int axis) const {
  Around cells{neighbour(cell, axis, 1 - reach)};
  for (int k = 1; k < 2 * reach; ++k) cells[k] = next_[axis][cells[k - 1]];
  return cells;
}

template <class Work>
void Rates::for_lines(const Work& work) const {
  team_.for_each(grid_.cells, [&](int x) {
    for (std::size_t first = x * stride_[0]; first < (x + 1) * stride_[0]; first += grid_.cells) work(first);
  });
}

void Rates::find_primitives(std::span<const double> y) {
  const auto density = part(y, 0), charge = part(y, 1), log_temperature = part(y, unknowns() - 1);
  for_cells([&](std::size_t cell) {
    log_density_[cell] = std::log(density[cell]);
    log_temperature_[cell] = log_temperature[cell];
    root_temperature_[cell] = std::exp(log_temperature[cell] / 2);
    temperature_[cell] = root_temperature_[cell] * root_temperature_[cell];
    charge_[cell] = charge[cell] / density[cell];
    for (int axis = 0; axis < grid_.dimension; ++axis)
      velocity_[axis][cell] = y[(2 + axis) * size_ + cell] / density[cell];
  });
}

/// Computes the velocity gradients in the cells, to fourth order.
void Rates::find_gradients() {
  const double by = 1 / (12 * grid_.step());
  for_cells([&](std::size_t cell) {
    for (int axis = 0; axis < grid_.dimension; ++axis) {
      const std::size_t next = neighbour(cell, axis, 1), before = neighbour(cell, axis, -1),
                        second = neighbour(cell, axis, 2), second_before = neighbour(cell, axis, -2);
      for (int of = 0; of < grid_.dimension; ++of) {
        const std::vector<double>& u = velocity_[of];
        gradient_[axis][of][cell] = by * (8 * (u[next] - u[before]) - (u[second] - u[second_before]));
      }
    }
  });
}

/// Computes the values of one quantity below and above the faces along the line of cells that begins with `first`.
void Rates::find_sides(int which, std::size_t first, int axis) {
  const std::vector<double>& of = which == 0   ? log_density_
                                  : which == 1 ? log_temperature_
                                  : which == 2 ? charge_
                                               : velocity_[which - 3];
  std::array<const double*, 2 * reach> at;
  std::vector<double> line;  // Line continued periodically
  if (axis + 1 == grid_.dimension)
    for (int x = 1 - reach; x < grid_.cells + reach; ++x) line.push_back(of[first + (x + grid_.cells) % grid_.cells]);
  for (int k = 0; k < 2 * reach; ++k) at[k] = line.empty() ? &of[neighbour(first, axis, k + 1 - reach)] : &line[k];
  double *below = &below_[which * size_ + first], *above = &above_[which * size_ + first];
  if (which > 1)
    return find_line(
        at, grid_.cells, [](auto... value) { return at_face(value...); }, below, above);
  find_line(
      at, grid_.cells, [](auto... value) { return log_at_face(value...); }, below, above);
  for (int i = 0; i < grid_.cells; ++i) below[i] = std::exp(below[i]), above[i] = std::exp(above[i]);
}

Rates::Side Rates::side(std::size_t cell, bool above) const {
  const double* of = above ? &above_[cell] : &below_[cell];
  Side side{of[0], of[size_], of[2 * size_], {}};
  for (int axis = 0; axis < grid_.dimension; ++axis) side.velocity[axis] = of[(3 + axis) * size_];
  return side;
}

/// Sets the advective fluxes: (u + a)/2 of the state below and (u - a)/2 of the state above. The loss of kinetic energy
/// becomes heat. A gain, which is of the order of rounding or of the scheme's error, is ignored.
void Rates::set_advection(std::size_t cell, std::size_t next, int axis, const Side& below, const Side& above) {
  const double fastest = std::max(below.fastest(axis), above.fastest(axis));
  const double from_below = (below.velocity[axis] + fastest) / 2 * below.density,
               from_above = (above.velocity[axis] - fastest) / 2 * above.density;
  flow(0)[cell] = from_below + from_above;
  flow(1)[cell] = from_below * below.charge + from_above * above.charge;
  flow(unknowns() - 1)[cell] = 1.5 * (from_below * below.temperature + from_above * above.temperature);
  double lost = 0;
  for (int of = 0; of < grid_.dimension; ++of) {
    const double momentum = from_below * below.velocity[of] + from_above * above.velocity[of];
    flow(2 + of)[cell] = momentum;
    const double mean = (velocity_[of][cell] + velocity_[of][next]) / 2;
    lost += 2 * (velocity_[of][cell] - velocity_[of][next]) * (momentum - flow(0)[cell] * mean);
  }
  flow(2 + axis)[cell] += (below.density * below.temperature + above.density * above.temperature) / 4;
  face_velocity_[cell] = (below.velocity[axis] + above.velocity[axis]) / 2;
  heating_[cell] = std::max(lost, 0.0) / grid_.step();
}

void Rates::add_diffusion(const Around& c, int axis) {
  const std::size_t cell = c[2], next = c[3];
  const double h = grid_.step(), root = (root_temperature_[cell] + root_temperature_[next]) / 2;
  const int dimension = grid_.dimension;
  const auto step = [&](const std::vector<double>& of) { return step_at_face(of[c[1]], of[c[2]], of[c[3]], of[c[4]]); };
  const auto mean = [&](const std::vector<double>& of) { return mean_at_face(of[c[1]], of[c[2]], of[c[3]], of[c[4]]); };
  std::array<std::array<double, 3>, 3> gradient{};  // Indices [by][of]
  for (int by = 0; by < dimension; ++by)
    for (int of = 0; of < dimension; ++of)
      gradient[by][of] = by == axis ? step(velocity_[of]) / h : mean(gradient_[by][of]);
  double divergence = 0, squares = 0;
  for (int of = 0; of < dimension; ++of) divergence += gradient[of][of];
  for (int by = 0; by < dimension; ++by)
    for (int of = 0; of < dimension; ++of) squares += std::pow(gradient[by][of] + gradient[of][by], 2) / 2;
  for (int of = 0; of < dimension; ++of)
    flow(2 + of)[cell] -=
        gas_.viscosity * root * (gradient[axis][of] + gradient[of][axis] - (of == axis ? 2.0 / 3 * divergence : 0.0));
  // Viscous heating 2 s : grad u, shared equally by the faces of each axis.
  heating_[cell] += 2 * gas_.viscosity * root * (squares - 2.0 / 3 * divergence * divergence) / dimension;
  // Limits heat fluxes so that a cold cell cannot lose more heat than it has. Conduction flows from warm to cold, with
  // a limited high-order correction. The flux due to density gradients uses a mean temperature that vanishes with that
  // of either cell.
  const double warmer = temperature_[next] - temperature_[cell];
  const double warming = std::clamp(step(temperature_), std::min(0.0, 2 * warmer), std::max(0.0, 2 * warmer));
  const double cold = 2 * temperature_[cell] * temperature_[next] / (temperature_[cell] + temperature_[next]);
  const double heat =
      gas_.conduction * root * warming + gas_.density_conduction * cold * std::sqrt(cold) * step(log_density_);
  flow(unknowns() - 1)[cell] -= 15.0 / 4 * heat / h;
}

/// Computes the fluxes through the face after each cell along this axis.
void Rates::find_flows(int axis) {
  for_lines([&](std::size_t first) {
    for (int which = 0; which < 3 + grid_.dimension; ++which) find_sides(which, first, axis);
  });
  for_cells([&](std::size_t cell) {
    const Around cells = around(cell, axis);
    set_advection(cell, cells[3], axis, side(cell, false), side(cell, true));
    add_diffusion(cells, axis);
  });
}

/// Subtracts the net outflow. The entry of ln T temporarily holds the rate of (3/2) n T: inflow, heating, and the work
/// of pressure.
void Rates::subtract_outflow(int axis, std::span<double> rate) const {
  const double by = 1 / grid_.step();
  for_cells([&](std::size_t cell) {
    const std::size_t before = neighbour(cell, axis, -1);
    for (std::size_t which = 0; which < flow_.size(); which += size_)
      rate[which + cell] -= by * (flow_[which + cell] - flow_[which + before]);
    const double pressure = std::exp(log_density_[cell]) * temperature_[cell];
    rate[flow_.size() - size_ + cell] +=
        (heating_[cell] + heating_[before]) / 2 - by * pressure * (face_velocity_[cell] - face_velocity_[before]);
  });
}

/// Converts to the rate of ln T, and adds cooling, the field, and the change of the unit of speed.
void Rates::finish(double time, std::span<const double> y, std::span<double> rate) {
  const double slowing = gas_.cooling / 4;
  const double force = gas_.charge_number * (gas_.charges_last ? std::exp(2 * slowing * time) : 1);
  const auto* field = force > 0 ? &potential_.field(part(y, 1)) : nullptr;
  const auto density = part(y, 0), charge = part(y, 1), grown = std::span<const double>(part(rate, 0));
  for (int axis = 0; axis < grid_.dimension; ++axis) {
    const auto momentum = part(y, 2 + axis);
    const auto momentum_rate = part(rate, 2 + axis);
    const double mean = sum_of(momentum) / static_cast<double>(size_);
    for_cells([&](std::size_t cell) {
      momentum_rate[cell] += slowing * (momentum[cell] - mean);
      if (field) momentum_rate[cell] += force * charge[cell] * (*field)[axis][cell];
    });
  }
  const auto log_rate = part(rate, unknowns() - 1);
  for_cells([&](std::size_t cell) {
    log_rate[cell] = (log_rate[cell] / (1.5 * temperature_[cell]) - grown[cell]) / density[cell] +
                     2 * slowing * (1 - density[cell] * root_temperature_[cell]);
  });
}

void Rates::operator()(double time, std::span<const double> y, std::span<double> rate) {
  std::ranges::fill(rate, 0.0);
  find_primitives(y);
  find_gradients();
  for (int axis = 0; axis < grid_.dimension; ++axis) {
    find_flows(axis);
    subtract_outflow(axis, rate);
  }
  finish(time, y, rate);
}

}  // namespace lichtenberg::granular_flow
