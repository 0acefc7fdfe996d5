#include "solvers/laplace/multipole/arrangement.hpp"

#include <algorithm>
#include <numbers>

#include "solvers/error.hpp"

namespace lichtenberg::laplace::multipole {

namespace {

/// Multipoles alone do as long as no more than this many are needed.
constexpr double few_terms = 40;
/// A centre this close to a side, in units of the box, is meant to be on it.
constexpr double on_side = 1e-12;
/// Circles at one potential may overlap by this fraction of the smaller radius: what happens in an overlap deeper than
/// that is no longer below the resolution of the highest order.
constexpr double deepest_overlap = 0.01;

constexpr std::array<const char*, 4> side_name{"left", "right", "bottom", "top"};

std::string name(std::size_t body) { return "body " + std::to_string(body); }

std::vector<Source> circles(const LaplaceProblem& problem) {
  std::vector<Source> disks;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const auto* disk = std::get_if<Disk>(&problem.bodies[b].shape);
    if (!disk) throw InputError(name(b) + " is no disk: the multipole method solves scenes of disks only");
    const Complex centre = to_complex(disk->centre);
    disks.push_back({centre, disk->radius, 0, {centre, centre}});
  }
  return disks;
}

/// Distance of p from a side, positive inside the box.
double distance(Complex p, int side, Vec2 size) {
  switch (side) {
    case left:
      return p.real();
    case right:
      return size.x - p.real();
    case bottom:
      return p.imag();
    default:
      return size.y - p.imag();
  }
}

void put_on_side(Complex& p, int side, Vec2 size) {
  switch (side) {
    case left:
      p.real(0);
      break;
    case right:
      p.real(size.x);
      break;
    case bottom:
      p.imag(0);
      break;
    default:
      p.imag(size.y);
  }
}

/// The bipolar coordinate alpha of the circle of radius `radius` that has another of radius `other` at a distance `gap`
/// from surface to surface: images of charges in that other circle accumulate at radius exp(-alpha).
double bipolar_coordinate(double radius, double other, double gap) {
  const double t = gap * (gap + 2 * other) / (2 * (gap + radius + other) * radius);  // cosh(alpha) - 1
  return std::log1p(t + std::sqrt(t * (t + 2)));
}

/// Whether two groups are known to have one potential before anything is solved.
bool same_potential(const LaplaceProblem& problem, int a, int b) {
  const Group &one = problem.groups[a], &other = problem.groups[b];
  return a == b || (!one.floating && !other.floating && one.potential == other.potential);
}

/// Whether a disk is known to be on the side's potential, or the side insulates and shows it its own image.
bool same_potential(const LaplaceProblem& problem, int group, const Side& side) {
  const Group& own = problem.groups[group];
  return side.kind == Side::Kind::insulating || (!own.floating && own.potential == side.potential);
}

/// Radius over distance of the nearest corner in which electrodes of different potential meet: the field turns there.
double nearest_jump(const LaplaceProblem& problem, const Source& disk) {
  double ratio = 0;
  for (const int x : {left, right})
    for (const int y : {bottom, top}) {
      const Side &one = problem.sides[x], &other = problem.sides[y];
      const bool electrodes = one.kind == Side::Kind::electrode && other.kind == Side::Kind::electrode;
      if (!electrodes || one.potential == other.potential) continue;
      const Complex corner{x == left ? 0 : problem.size.x, y == bottom ? 0 : problem.size.y};
      ratio = std::max(ratio, disk.radius / std::abs(disk.centre - corner));
    }
  return ratio;
}

/// -ln of the coefficients that may be left out where they fall off like exp(-alpha k). Potentials and charges lack the
/// square of what is left out, forces a product of two neighbours, and sums over it 1 / alpha terms (README.md, where
/// the factor comes from).
double geometric_digits(Truncation wanted, double alpha) {
  if (!wanted.results_only) return -std::log(wanted.accuracy);
  return -std::log(1.8 * std::sqrt(wanted.accuracy) * std::min(1.0, alpha));
}

/// The same where circles touch, or are narrowly apart with a field between them: a tenth then (measured: README.md).
double contact_digits(Truncation wanted, double narrowness) {
  if (!wanted.results_only) return -std::log(wanted.accuracy);
  const double field_between = narrowness < 1 ? 0.1 * narrowness : 1;
  return -std::log(field_between * std::min(10.0, 1000 * std::sqrt(wanted.accuracy)) * wanted.accuracy);
}

/// Two charges +-Q have a potential difference of Q / (2 pi eps) times the sum of their circles' bipolar coordinates,
/// which falls like sqrt(gap / R), and their force goes with its square: an error of potentials weighs the more, the
/// smaller the sum. The shares of the tolerance are those of gaps of R / 100 and more, whose sum is this.
double narrowness_of(double coordinates) {
  constexpr double wide = 0.2;
  return std::min(1.0, coordinates / wide);
}

/// Terms for coefficients that fall off like exp(-alpha k).
double geometric_order(double alpha, Truncation wanted) { return geometric_digits(wanted, alpha) / alpha + 2; }

/// Terms for two circles at the same potential, however close: the field on the first falls off like exp(-beta / theta)
/// towards the gap with beta = 2 pi / (1 + R / R'), its Fourier coefficients like exp(-sqrt(2 beta k)) (README.md).
double contact_order(double radius, double other, Truncation wanted, double narrowness) {
  const double digits = contact_digits(wanted, narrowness);
  return digits * digits * (1 + radius / other) / (4 * std::numbers::pi) + 2;
}

}  // namespace

Arrangement::Arrangement(const LaplaceProblem& problem, const Mirrors& mirrors, Truncation truncation)
    : disks(static_cast<int>(problem.bodies.size())),
      sources(circles(problem)),
      decay(disks, 0.0),
      copies(disks, 1),
      anchored(disks, false),
      cells(mirrors, sources) {
  if (mirrors.bounded) check_against_sides(problem);
  find_orders(problem, truncation);
}

/// Puts centres that are meant to be on a side exactly there.
void Arrangement::check_against_sides(const LaplaceProblem& problem) {
  const double tiny = on_side * std::max(problem.size.x, problem.size.y);
  for (int b = 0; b < disks; ++b) {
    Source& disk = sources[b];
    for (int s = 0; s < 4; ++s) {
      const double away = distance(disk.centre, s, problem.size);
      if (std::abs(away) > tiny) {
        // Twice the gap to the side is the gap to the image.
        const bool may_touch = same_potential(problem, problem.bodies[b].group, problem.sides[s]);
        if (may_touch ? away < (1 - 0.5 * deepest_overlap) * disk.radius : away <= disk.radius)
          throw InputError(name(b) + " " + (may_touch ? "crosses" : "touches or crosses") + " the " + side_name[s] +
                           " side: the multipole method allows disks inside the box and disks centred on a side");
        continue;
      }
      put_on_side(disk.centre, s, problem.size);
      disk.constant_on = {disk.centre, disk.centre};
      copies[b] *= 2;
      if (problem.sides[s].kind == Side::Kind::insulating) continue;
      if (anchored[b])
        throw InputError(name(b) +
                         " is centred in a corner of two electrodes: the multipole method allows corners with " +
                         "at least one insulating side");
      anchored[b] = true;
      const Group& group = problem.groups[problem.bodies[b].group];
      if (group.floating || group.potential != problem.sides[s].potential)
        throw InputError(name(b) + " is centred on the " + side_name[s] +
                         " side, an electrode: its group must be fixed at that side's potential");
    }
  }
}

/// Centres inside the box are no farther from each other than from each other's images, and sides are checked before:
/// an image that overlaps has nothing new to say.
void Arrangement::check_overlap(const LaplaceProblem& problem, int i, int j, double depth) const {
  const std::string pair = name(i) + " and " + name(j);
  if (!same_potential(problem, problem.bodies[i].group, problem.bodies[j].group))
    throw InputError(pair + " touch or overlap: the multipole method needs a gap between disks of different groups");
  if (depth > deepest_overlap)
    throw InputError(pair +
                     " overlap by more than a hundredth of the smaller radius: the multipole method needs disks "
                     "of one group apart or in contact");
}

void Arrangement::find_orders(const LaplaceProblem& problem, Truncation truncation) {
  for (int i = 0; i < disks; ++i) {
    const Source disk = sources[i];
    // The charge and the force of a part of a circle go with the coefficients themselves.
    const Truncation wanted{truncation.accuracy, truncation.results_only && copies[i] == 1};
    // Whatever is not near is beyond the window.
    const double window = cells.window * std::min(cells.width, cells.height);
    decay[i] = std::max(disk.radius / (disk.radius + window), nearest_jump(problem, disk));
    double order = geometric_order(-std::log(decay[i]), wanted);
    std::vector<std::pair<int, std::pair<Image, Complex>>> close;
    cells.for_each_near(disk.centre, [&](int j, const Image& image, Complex shift) {
      if (j >= disks) return;
      const double d = std::abs(disk.centre - image.centre(sources[j].centre) - shift);
      if (i == j && d < disk.radius) return;
      const double other = sources[j].radius;
      double gap = d - disk.radius - other;
      if (!(gap > 0)) {
        if (i != j) check_overlap(problem, i, j, -gap / std::min(disk.radius, other));
        gap = 0;  // as if they touched: an overlap is below the resolution
      }
      const double alpha = bipolar_coordinate(disk.radius, other, gap);
      const double alpha_other = bipolar_coordinate(other, disk.radius, gap);
      const int group = problem.bodies[i].group, other_group = problem.bodies[j].group;
      const bool field_in_gap = gap > 0 && (i == j ? image.sign < 0 : !same_potential(problem, group, other_group));
      const double narrow = truncation.results_only && field_in_gap ? narrowness_of(alpha + alpha_other) : 1;
      narrowness = std::min(narrowness, narrow);
      const double geometric = geometric_order(alpha, wanted);
      const double contact = contact_order(disk.radius, other, wanted, narrow);
      decay[i] = std::max(decay[i], std::exp(-alpha));
      order = std::max(order, std::min(geometric, std::max(few_terms, contact)));
      const double geometric_other = geometric_order(alpha_other, wanted);
      if (geometric > std::max(few_terms, contact) ||
          geometric_other > std::max(few_terms, contact_order(other, disk.radius, wanted, narrow)))
        close.push_back({j, {image, shift}});
    });
    sources[i].order = static_cast<int>(std::min<double>(order, largest_order));
    for (const auto& [j, where] : close) add_close_pair(problem, i, j, where.first, where.second);
  }
  decay.resize(sources.size(), 0.0);
}

/// Two disks are met twice, a disk and its image in a side too: once is enough. Images of other disks are no closer
/// than the disks themselves.
void Arrangement::add_close_pair(const LaplaceProblem& problem, int i, int j, const Image& image, Complex shift) {
  const int group = problem.bodies[i].group;
  ClosePair pair;
  pair.first = i;
  const Source one = sources[i];
  const Complex other_centre = image.centre(sources[j].centre) + shift;
  if (i == j) {
    if (image.sign > 0 || image.across_x == image.across_y) return;  // its own potential, or round a corner
    pair.side = image.across_x ? (shift.real() == 0 ? left : right) : (shift.imag() == 0 ? bottom : top);
    if (same_potential(problem, group, problem.sides[pair.side])) return;
  } else {
    if (j < i || image.across_x || image.across_y || shift != 0.0 ||
        same_potential(problem, problem.bodies[j].group, group))
      return;
    pair.second = j;
  }
  const double other = sources[j].radius, gap = std::abs(one.centre - other_centre) - one.radius - other;
  const Complex way = (other_centre - one.centre) / std::abs(other_centre - one.centre);
  const auto add_charge = [&](Complex centre, double radius, Complex direction, double alpha) {
    sources.push_back({centre + radius * std::exp(-alpha) * direction, 0, 0, {one.centre, other_centre}});
    cells.add(static_cast<int>(sources.size()) - 1, sources.back());
    pair.difference += alpha;
    return static_cast<int>(sources.size()) - 1;
  };
  pair.first_charge = add_charge(one.centre, one.radius, way, bipolar_coordinate(one.radius, other, gap));
  if (i != j) pair.second_charge = add_charge(other_centre, other, -way, bipolar_coordinate(other, one.radius, gap));
  close_pairs.push_back(pair);
}

}  // namespace lichtenberg::laplace::multipole
