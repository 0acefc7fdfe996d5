#include "solvers/laplace/multipole/arrangement.hpp"

#include <algorithm>
#include <numbers>

#include "solvers/error.hpp"

namespace lichtenberg::laplace::multipole {

namespace {

/// Number of terms up to which multipoles alone are used.
constexpr double few_terms = 40;
/// Tolerance, in units of the box, within which a centre counts as lying on a side.
constexpr double on_side = 1e-12;
/// Largest overlap of circles at equal potential, as a fraction of the smaller radius. The highest order would resolve
/// the effects of deeper overlaps.
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

/// Returns the distance of p from a side, positive inside the box.
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

/// Returns the bipolar coordinate alpha of a circle of radius `radius` at distance `gap`, from surface to surface, from
/// one of radius `other`. Images of charges in the other circle accumulate at exp(-alpha) times the radius.
double bipolar_coordinate(double radius, double other, double gap) {
  const double t = gap * (gap + 2 * other) / (2 * (gap + radius + other) * radius);  // cosh(alpha) - 1
  return std::log1p(t + std::sqrt(t * (t + 2)));
}

/// Returns true if two groups have the same potential for any solution.
bool same_potential(const LaplaceProblem& problem, int a, int b) {
  const Group &one = problem.groups[a], &other = problem.groups[b];
  return a == b || (!one.floating && !other.floating && one.potential == other.potential);
}

/// Returns true if a disk has the side's potential for any solution, or if the side is insulating and reflects the disk
/// to its own image.
bool same_potential(const LaplaceProblem& problem, int group, const Side& side) {
  const Group& own = problem.groups[group];
  return side.kind == Side::Kind::insulating || (!own.floating && own.potential == side.potential);
}

/// Returns radius over distance for the nearest corner in which electrodes of different potential meet: the field is
/// singular there.
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

/// Returns -ln of the size below which coefficients that decrease like exp(-alpha k) are neglected. The error of
/// potentials and charges is the square of the neglected coefficients. The error of forces is a product of two
/// neighbours, summed over 1 / alpha terms (docs/numerics/multipole-plane.md).
double geometric_digits(Truncation required, double alpha) {
  if (!required.results_only) return -std::log(required.accuracy);
  return -std::log(1.8 * std::sqrt(required.accuracy) * std::min(1.0, alpha));
}

/// Like geometric_digits, for circles in contact or with a field across a narrow gap; a factor of 0.1 in the latter
/// case (empirical).
double contact_digits(Truncation required, double narrowness) {
  if (!required.results_only) return -std::log(required.accuracy);
  const double field_between = narrowness < 1 ? 0.1 * narrowness : 1;
  return -std::log(field_between * std::min(10.0, 1000 * std::sqrt(required.accuracy)) * required.accuracy);
}

/// Returns the factor by which a narrow gap reduces the permitted errors. Two charges +-Q have a potential difference
/// of Q / (2 pi eps) times the sum of their circles' bipolar coordinates, which decreases like sqrt(gap / R), and their
/// force varies with its square. Errors of potentials therefore matter more for smaller sums. The permitted errors
/// refer to gaps of at least R / 100, with the sum `wide`.
double narrowness_of(double coordinates) {
  constexpr double wide = 0.2;
  return std::min(1.0, coordinates / wide);
}

/// Returns the number of terms for coefficients that decrease like exp(-alpha k).
double geometric_order(double alpha, Truncation required) { return geometric_digits(required, alpha) / alpha + 2; }

/// Returns the number of terms for two circles at equal potential at any distance. The field on the first decreases
/// like exp(-beta / theta) towards the gap with beta = 2 pi / (1 + R / R'), its Fourier coefficients like exp(-sqrt(2
/// beta k)) (docs/numerics/multipole-plane.md).
double contact_order(double radius, double other, Truncation required, double narrowness) {
  const double digits = contact_digits(required, narrowness);
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

/// Checks disks against the sides; moves centres within rounding of a side exactly onto it.
void Arrangement::check_against_sides(const LaplaceProblem& problem) {
  const double tiny = on_side * std::max(problem.size.x, problem.size.y);
  for (int b = 0; b < disks; ++b) {
    Source& disk = sources[b];
    for (int s = 0; s < 4; ++s) {
      const double away = distance(disk.centre, s, problem.size);
      if (std::abs(away) > tiny) {
        // The gap to the image is twice the gap to the side.
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

/// Checks a pair that touches or overlaps. Images need no separate check: centres inside the box are at least as close
/// to each other as to each other's images, and sides are checked before.
void Arrangement::check_overlap(const LaplaceProblem& problem, int i, int j, double depth) const {
  const std::string pair = name(i) + " and " + name(j);
  if (!same_potential(problem, problem.bodies[i].group, problem.bodies[j].group))
    throw InputError(pair + " touch or overlap: the multipole method needs a gap between disks of different groups");
  if (depth > deepest_overlap)
    throw InputError(pair +
                     " overlap by more than 1 % of the smaller radius: the multipole method needs disks of one group "
                     "apart or in contact");
}

void Arrangement::find_orders(const LaplaceProblem& problem, Truncation truncation) {
  for (int i = 0; i < disks; ++i) {
    const Source disk = sources[i];
    // Charge and force of a part of a circle are linear in the coefficients.
    const Truncation required{truncation.accuracy, truncation.results_only && copies[i] == 1};
    // Far sources are beyond the window.
    const double window = cells.window * std::min(cells.width, cells.height);
    decay[i] = std::max(disk.radius / (disk.radius + window), nearest_jump(problem, disk));
    double order = geometric_order(-std::log(decay[i]), required);
    std::vector<std::pair<int, std::pair<Image, Complex>>> close;
    cells.for_each_near(disk.centre, [&](int j, const Image& image, Complex shift) {
      if (j >= disks) return;
      const double d = std::abs(disk.centre - image.centre(sources[j].centre) - shift);
      if (i == j && d < disk.radius) return;
      const double other = sources[j].radius;
      double gap = d - disk.radius - other;
      if (!(gap > 0)) {
        if (i != j) check_overlap(problem, i, j, -gap / std::min(disk.radius, other));
        gap = 0;  // An overlap is below the resolution, so it is treated as contact
      }
      const double alpha = bipolar_coordinate(disk.radius, other, gap);
      const double alpha_other = bipolar_coordinate(other, disk.radius, gap);
      const int group = problem.bodies[i].group, other_group = problem.bodies[j].group;
      const bool field_in_gap = gap > 0 && (i == j ? image.sign < 0 : !same_potential(problem, group, other_group));
      const double narrow = truncation.results_only && field_in_gap ? narrowness_of(alpha + alpha_other) : 1;
      narrowness = std::min(narrowness, narrow);
      const double geometric = geometric_order(alpha, required);
      const double contact = contact_order(disk.radius, other, required, narrow);
      decay[i] = std::max(decay[i], std::exp(-alpha));
      order = std::max(order, std::min(geometric, std::max(few_terms, contact)));
      const double geometric_other = geometric_order(alpha_other, required);
      if (geometric > std::max(few_terms, contact) ||
          geometric_other > std::max(few_terms, contact_order(other, disk.radius, required, narrow)))
        close.push_back({j, {image, shift}});
    });
    sources[i].order = static_cast<int>(std::min<double>(order, largest_order));
    for (const auto& [j, where] : close) add_close_pair(problem, i, j, where.first, where.second);
  }
  decay.resize(sources.size(), 0.0);
}

/// Adds the point charges of a close pair. Each pair of disks, and each disk with its image in a side, occurs twice,
/// and is added once. Images of other disks are no closer than the disks themselves.
void Arrangement::add_close_pair(const LaplaceProblem& problem, int i, int j, const Image& image, Complex shift) {
  const int group = problem.bodies[i].group;
  ClosePair pair;
  pair.first = i;
  const Source one = sources[i];
  const Complex other_centre = image.centre(sources[j].centre) + shift;
  if (i == j) {
    if (image.sign > 0 || image.across_x == image.across_y) return;  // Image at equal potential, or around a corner
    pair.side = image.across_x ? (shift.real() == 0 ? left : right) : (shift.imag() == 0 ? bottom : top);
    if (same_potential(problem, group, problem.sides[pair.side])) return;
  } else {
    if (j < i || image.across_x || image.across_y || shift != 0.0 ||
        same_potential(problem, problem.bodies[j].group, group))
      return;
    pair.second = j;
  }
  const double other = sources[j].radius, gap = std::abs(one.centre - other_centre) - one.radius - other;
  const Complex axis = (other_centre - one.centre) / std::abs(other_centre - one.centre);
  const auto add_charge = [&](Complex centre, double radius, Complex direction, double alpha) {
    sources.push_back({centre + radius * std::exp(-alpha) * direction, 0, 0, {one.centre, other_centre}});
    cells.add(static_cast<int>(sources.size()) - 1, sources.back());
    pair.difference += alpha;
    return static_cast<int>(sources.size()) - 1;
  };
  pair.first_charge = add_charge(one.centre, one.radius, axis, bipolar_coordinate(one.radius, other, gap));
  if (i != j) pair.second_charge = add_charge(other_centre, other, -axis, bipolar_coordinate(other, one.radius, gap));
  close_pairs.push_back(pair);
}

}  // namespace lichtenberg::laplace::multipole
