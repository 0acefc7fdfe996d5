#include "solvers/laplace/multipole/results.hpp"

#include <limits>
#include <numbers>

#include "solvers/fftw.hpp"

namespace lichtenberg::laplace::multipole {

namespace {

using std::numbers::pi;

struct Arc {
  double from = 0, to = 2 * pi;
};

/// Returns the part of a circle around `centre` inside the box: all, half (centred on a side) or a quarter (in a
/// corner).
Arc arc_in_box(Complex centre, Vec2 size) {
  const bool on_left = centre.real() == 0, on_right = centre.real() == size.x;
  const bool on_bottom = centre.imag() == 0, on_top = centre.imag() == size.y;
  Arc arc;
  if (on_left || on_right) arc = on_left ? Arc{-pi / 2, pi / 2} : Arc{pi / 2, 3 * pi / 2};
  if (on_bottom || on_top) {
    const Arc half = on_bottom ? Arc{0, pi} : Arc{pi, 2 * pi};
    if (on_left && on_top)
      arc = {3 * pi / 2, 2 * pi};
    else
      arc = on_left || on_right ? Arc{std::max(arc.from, half.from), std::min(arc.to, half.to)} : half;
  }
  return arc;
}

/// Returns the integral of exp(i n theta) over the arc.
Complex integral(int n, Arc arc) {
  if (n == 0) return arc.to - arc.from;
  return (std::polar(1.0, n * arc.to) - std::polar(1.0, n * arc.from)) / Complex(0, n);
}

/// Returns each disk's multipoles with those of the point charges inside it, about the same centre: sum lambda
/// (z_0/R)^k / k each. They converge slowly, but the sums over them cost one operation per term.
std::vector<std::vector<Complex>> all_multipoles(const Setting& setting, const std::vector<Complex>& coefficients) {
  const Arrangement& arrangement = setting.arrangement;
  const std::vector<int>& start = setting.layout.start;
  std::vector<std::vector<Complex>> multipoles;
  multipoles.reserve(arrangement.disks);
  for (int i = 0; i < arrangement.disks; ++i)
    multipoles.emplace_back(coefficients.begin() + start[i], coefficients.begin() + start[i + 1]);
  const auto add = [&](int disk, int point) {
    if (point < 0) return;
    const Source &circle = arrangement.sources[disk], &source = arrangement.sources[point];
    const Complex ratio = (source.centre - circle.centre) / circle.radius;
    const double lambda = coefficients[start[point]].real();
    const auto terms = static_cast<std::size_t>(std::log(1e-17) / std::log(std::abs(ratio)));
    std::vector<Complex>& a = multipoles[disk];
    if (a.size() < terms + 1) a.resize(terms + 1);
    a[0] += lambda;
    Complex power = lambda;
    for (std::size_t k = 1; k <= terms; ++k) a[k] += (power = multiply(power, ratio)) / static_cast<double>(k);
  };
  for (const ClosePair& pair : arrangement.close_pairs) {
    add(pair.first, pair.first_charge);
    add(pair.second, pair.second_charge);
  }
  return multipoles;
}

/// Adds the multipoles of the images that coincide with a disk centred on a side.
void add_coinciding_images(const Mirrors& mirrors, const Source& disk, std::vector<Complex>& a) {
  const std::vector<Complex> own = a;
  const Vec2 size = mirrors.size;
  for (const Image& image : mirrors.images) {
    if (!image.across_x && !image.across_y) continue;
    const bool beyond_x = image.across_x && disk.centre.real() == size.x;
    const bool beyond_y = image.across_y && disk.centre.imag() == size.y;
    const Complex shift{beyond_x ? 2 * size.x : 0, beyond_y ? 2 * size.y : 0};
    if (image.centre(disk.centre) + shift != disk.centre) continue;
    const double sign = (beyond_x ? mirrors.period_sign_x() : 1) * (beyond_y ? mirrors.period_sign_y() : 1);
    for (std::size_t k = 0; k < a.size(); ++k) a[k] += sign * image.coefficient(static_cast<int>(k), own[k]);
  }
}

/// Returns the coefficients of R dV/dr = -sum_n c_n exp(i n theta) on the circle, due to multipoles and local field
/// together: c_0 = lambda, c_-k = k a_k = conj(c_k). Order: c_-order ... c_order.
std::vector<Complex> surface_charge(const std::vector<Complex>& a) {
  const int order = static_cast<int>(a.size()) - 1;
  std::vector<Complex> c(2 * order + 1);
  c[order] = a[0].real();
  for (int k = 1; k <= order; ++k) {
    c[order - k] = static_cast<double>(k) * a[k];
    c[order + k] = std::conj(c[order - k]);
  }
  return c;
}

double charge_on_arc(const std::vector<Complex>& c, Arc arc) {
  const int order = static_cast<int>(c.size()) / 2;
  double sum = 0;
  for (int n = -order; n <= order; ++n) sum += multiply(c[n + order], integral(n, arc)).real();
  return sum;
}

/// Returns the Fourier coefficients of the square of a real function, given those of the function (-order ... order),
/// by sampling.
std::vector<Complex> square(const std::vector<Complex>& c) {
  const int order = static_cast<int>(c.size()) / 2;
  const int points = 4 * order + 2;
  std::vector<Complex> data(points), squared(4 * order + 1);
  for (int n = -order; n <= order; ++n) data[(n + points) % points] = c[n + order];
  auto* values = reinterpret_cast<fftw_complex*>(data.data());
  const auto transform = [&](int direction) {
    const FftwPlan plan(fftw_plan_dft_1d(points, values, values, direction, fftw_planning));
    fftw_execute(plan.get());
  };
  transform(FFTW_BACKWARD);
  for (Complex& value : data) value = multiply(value, value) / static_cast<double>(points);
  transform(FFTW_FORWARD);
  for (int n = -2 * order; n <= 2 * order; ++n) squared[n + 2 * order] = data[(n + points) % points];
  return squared;
}

/// Returns the integral of (R dV/dr)^2 exp(i theta) over the arc.
Complex force_on_arc(const std::vector<Complex>& c, Arc arc) {
  const std::vector<Complex> squared = square(c);
  const int order = static_cast<int>(squared.size()) / 2;
  Complex sum = 0;
  for (int n = -order; n <= order; ++n) sum += multiply(squared[n + order], integral(n + 1, arc));
  return sum;
}

/// Returns the integral of (R dV/dr)^2 exp(i theta) over the whole circle (Blasius' theorem).
Complex force_on_circle(const std::vector<Complex>& a) {
  const int order = static_cast<int>(a.size()) - 1;
  Complex sum = 0;
  for (int k = 0; k < order; ++k) sum += (k == 0 ? 1.0 : k * (k + 1.0)) * multiply(std::conj(a[k]), a[k + 1]);
  return 4 * pi * sum;
}

/// Returns the induced charge of an electrode side over the permittivity. By reciprocity it follows from the field at
/// the disks with that side at 1 V and all others at 0 V.
double induced_flux(const WallField& side_at_one, const Setting& setting, const std::vector<Complex>& coefficients) {
  double sum = 0;
  std::vector<Complex> field;
  for (int s = 0; s < setting.layout.sources(); ++s) {
    const Source& source = setting.arrangement.sources[s];
    field.resize(source.order + 1);
    side_at_one.local(source.centre, source.radius, source.order + 1, field.data());
    const Complex* a = &coefficients[setting.layout.start[s]];
    sum -= a[0].real() * field[0].real();
    for (int k = 1; k <= source.order; ++k) sum -= k * multiply(a[k], field[k]).real();
  }
  return 2 * pi * sum;
}

/// Returns the electrode side on which a disk is centred, -1: none.
int electrode_side_of(const Setting& setting, int disk) {
  if (!setting.arrangement.anchored[disk]) return -1;
  const Complex c = setting.arrangement.sources[disk].centre;
  const Vec2 size = setting.mirrors.size;
  const std::array<bool, 4> on{c.real() == 0, c.real() == size.x, c.imag() == 0, c.imag() == size.y};
  for (int s = 0; s < 4; ++s)
    if (on[s] && setting.mirrors.side_sign[s] < 0) return s;
  return -1;
}

void find_side_charges(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution) {
  solution.side_charge.fill(0);
  for (const SideIndex s : {left, right, bottom, top}) {
    if (setting.mirrors.side_sign[s] > 0) continue;
    std::array<Side, 4> unit;
    unit[s].potential = 1;
    const WallField side_at_one(setting.mirrors, setting.lattice, unit);
    solution.side_charge[s] =
        setting.problem.permittivity * (setting.wall.side_flux(s) + induced_flux(side_at_one, setting, coefficients));
  }
  // The part of a side inside a half-disk is not a surface of the box: the disk's curved surface carries that charge.
  for (int i = 0; i < setting.arrangement.disks; ++i)
    if (const int s = electrode_side_of(setting, i); s >= 0) solution.side_charge[s] -= solution.body_charge[i];
}

double field_energy(const Setting& setting, const LaplaceSolution& solution) {
  if (setting.wall.singular()) return std::numeric_limits<double>::infinity();
  double energy = 0;
  for (int i = 0; i < setting.arrangement.disks; ++i)
    energy += 0.5 * solution.body_charge[i] * solution.group_potential[setting.problem.bodies[i].group];
  for (int s = 0; s < 4; ++s) energy += 0.5 * solution.side_charge[s] * setting.problem.sides[s].potential;
  return energy;
}

}  // namespace

void evaluate_bodies(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution) {
  const double eps = setting.problem.permittivity;
  std::vector<std::vector<Complex>> multipoles = all_multipoles(setting, coefficients);
  for (int i = 0; i < setting.arrangement.disks; ++i) {
    const Source& disk = setting.arrangement.sources[i];
    std::vector<Complex>& a = multipoles[i];
    double flux = 2 * pi * a[0].real();
    Complex force = force_on_circle(a);
    if (setting.arrangement.copies[i] > 1) {
      const Arc arc = arc_in_box(disk.centre, setting.problem.size);
      add_coinciding_images(setting.mirrors, disk, a);
      const std::vector<Complex> c = surface_charge(a);
      flux = charge_on_arc(c, arc);
      force = force_on_arc(c, arc);
    }
    solution.body_charge.push_back(eps * flux);
    solution.body_force.push_back(0.5 * eps / disk.radius * Vec2{force.real(), force.imag()});
  }
}

void evaluate_sides(const Setting& setting, const std::vector<Complex>& coefficients, LaplaceSolution& solution) {
  find_side_charges(setting, coefficients, solution);
  solution.energy = field_energy(setting, solution);
}

}  // namespace lichtenberg::laplace::multipole
