#include "src/granular/rough_motion.hpp"

#include <algorithm>
#include <cmath>

#include "src/granular/rough_steps.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {
namespace {

template <int d, class Law>
class Rough final : public RoughMotion {
 public:
  Rough(const Law& law, const SurfaceLaw& surface) : laws_(law, surface) {}

  const SurfaceLaw& surface() const override { return laws_.surface(); }
  void begin(const Bodies& bodies) override {
    springs_.clear(), walls_.clear();
    sides_ = RoughSides(bodies, laws_.surface().walls.has_value());
    for (int i = 0; i < bodies.size(); ++i)
      sides_.visit(position_in_space(bodies, i), bodies.radius[i], [&](int side, double gap) {
        if (gap < 0) walls_.push_back({.contact = {.pair = {i, bodies.size() + side}}});
      });
  }

  ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, std::span<const double> slow_force,
                           const ContactSteps& substeps, parallel::Team& team) override {
    ContactsFollowed followed{.record = {.time = substeps.begin + substeps.time, .dt = substeps.time}};
    const double h = substeps.time / substeps.steps, rotation = rotational_energy(bodies);
    followed.stored_at_start = stored_energy(bodies, contacts);
    open_contacts(bodies, contacts);
    for (int n = 0; n < substeps.steps;) {
      constexpr int most = 1024;
      const double speed = bound_on_speeds(bodies, substeps.gain);
      const double within = std::clamp(substeps.search_path / (speed * h), 1.0, 1.0 * most);
      const RoughChunk chunk{.begin = substeps.begin + n * h,
                             .h = h,
                             .steps = std::min(static_cast<int>(within), substeps.steps - n),
                             .speed = speed,
                             .gain = substeps.gain,
                             .slow_force = slow_force};
      n += steps_.advance(bodies, open_, chunk, followed, team);
      ++followed.searches;
    }
    close_contacts(bodies.size(), contacts);
    followed.stored_at_end = stored_energy(bodies, contacts);
    followed.rotation = rotational_energy(bodies) - rotation;
    followed.fastest_release = fastest_release(bodies, contacts);
    followed.record.open = contacts;
    return followed;
  }

  double stored_energy(const Bodies& bodies, std::span<const GrainContact> contacts) const override {
    double energy = 0;
    visit_energies(bodies, contacts, [&](double stored, double) { energy += stored; });
    return energy;
  }
  double fastest_release(const Bodies& bodies, std::span<const GrainContact> contacts) const override {
    double square = 0;
    visit_energies(bodies, contacts, [&](double stored, double mass) { square = std::max(square, 2 * stored / mass); });
    return std::sqrt(square);
  }
  double time_to_resolve(double impact, const GrainProperties& grains) const override {
    return laws_.pace(grains).time_to_resolve(impact, grains);
  }

  void save(Checkpoint& checkpoint) const override {
    std::vector<double>&springs = checkpoint.reals["surface_springs"], &at_walls = checkpoint.reals["wall_springs"];
    std::vector<std::int64_t>& walls = checkpoint.integers["wall_contacts"];
    for (const Vec3 s : springs_) springs.insert(springs.end(), {s.x, s.y, s.z});
    for (const auto& [contact, spring] : walls_) {
      walls.insert(walls.end(), {contact.pair.i, contact.pair.j});
      at_walls.insert(at_walls.end(), {contact.since, contact.impact_speed, spring.x, spring.y, spring.z});
    }
  }
  void restore(const Checkpoint& checkpoint) override {
    const std::vector<std::int64_t>& walls = integers(checkpoint, "wall_contacts");
    const std::size_t contacts = integers(checkpoint, "contact_pairs").size() / 3;
    const bool none = checkpoint.reals.contains("surface_springs") && checkpoint.reals.at("surface_springs").empty();
    const std::vector<double>& springs = reals(checkpoint, "surface_springs", none ? 0 : 3 * contacts);
    const std::vector<double>& at_walls = reals(checkpoint, "wall_springs", walls.size() / 2 * 5);
    springs_.clear(), walls_.clear();
    for (std::size_t k = 0; k + 2 < springs.size(); k += 3)
      springs_.push_back({springs[k], springs[k + 1], springs[k + 2]});
    for (std::size_t k = 0; 2 * k + 1 < walls.size(); ++k) {
      const double* of = &at_walls[5 * k];
      const Pair pair{static_cast<int>(walls[2 * k]), static_cast<int>(walls[2 * k + 1])};
      walls_.push_back({{.pair = pair, .since = of[0], .impact_speed = of[1]}, {of[2], of[3], of[4]}});
    }
  }

 private:
  struct WallSpring {
    GrainContact contact;
    Vec3 spring{};
  };

  /// Returns the elongation of the spring of contact k among `count`; 0 for contacts that another motion has begun.
  Vec3 spring(std::size_t k, std::size_t count) const { return springs_.size() == count ? springs_[k] : Vec3{}; }

  /// Fills the list of open contacts from `contacts`, which ascend, and those with walls.
  void open_contacts(const Bodies& bodies, std::span<const GrainContact> contacts) {
    open_.clear();
    for (std::size_t k = 0; k < contacts.size(); ++k)
      open_.push_back(laws_.opened(bodies, contacts[k], spring(k, contacts.size())));
    if (walls_.empty()) return;
    for (const auto& [contact, spring] : walls_) open_.push_back(laws_.opened(bodies, contact, spring));
    std::ranges::sort(open_, {}, [](const RoughOpen& one) { return one.contact.pair; });
  }
  void close_contacts(int grains, std::vector<GrainContact>& contacts) {
    contacts.clear(), springs_.clear(), walls_.clear();
    for (const RoughOpen& one : open_)
      if (one.j >= 0 || one.contact.pair.j < grains)
        contacts.push_back(one.contact), springs_.push_back(one.spring.elongation);
      else
        walls_.push_back({one.contact, one.spring.elongation});
  }

  /// Calls use(stored energy, effective mass) for each contact.
  template <class Use>
  void visit_energies(const Bodies& bodies, std::span<const GrainContact> contacts, const Use& use) const {
    const NearestImage<3> nearest(RoughSteps<d, Law>::box_of(bodies));
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Pair pair = contacts[k].pair;
      Vec3 r = position_in_space(bodies, pair.j) - position_in_space(bodies, pair.i);
      for (int axis = 0; axis < 3; ++axis) r[axis] = nearest(r[axis], axis);
      use(laws_.energy(bodies, pair, reach(bodies, pair) - norm(r), spring(k, contacts.size())),
          reduced_mass(bodies, pair));
    }
    for (const auto& [contact, spring] : walls_) {
      const auto [i, j] = contact.pair;
      const double gap = sides_.gap(position_in_space(bodies, i), bodies.radius[i], j - bodies.size());
      use(laws_.energy(bodies, contact.pair, -gap, spring), bodies.mass[i]);
    }
  }

  /// Returns a bound (v0) on the speeds of the grains, somewhat larger than the largest speed at present with the
  /// velocity change `gain` by slow forces. Substeps end early when a grain exceeds it.
  static double bound_on_speeds(const Bodies& bodies, double gain) {
    double fastest = 0;
    for (int i = 0; i < bodies.size(); ++i) fastest = std::max(fastest, norm2(velocity_in_space(bodies, i)));
    constexpr double margin = 1.2, least = 1e-9;  // bodies at rest
    return margin * (std::sqrt(fastest) + gain) + least;
  }

  RoughLaws<Law> laws_;
  RoughSides sides_;
  std::vector<Vec3> springs_;      ///< elongations of the contacts of grains, between two calls of advance()
  std::vector<WallSpring> walls_;  ///< contacts with walls, between two calls of advance()
  std::vector<RoughOpen> open_;    ///< during a call of advance()
  RoughSteps<d, Law> steps_{laws_, sides_};
};

}  // namespace

std::unique_ptr<RoughMotion> make_rough_motion(const GrainContactLaw& law, const SurfaceLaw& surface, int dimension) {
  return std::visit(
      [&]<class Law>(const Law& one) -> std::unique_ptr<RoughMotion> {
        if (dimension == 3) return std::make_unique<Rough<3, Law>>(one, surface);
        return std::make_unique<Rough<2, Law>>(one, surface);
      },
      law);
}

SurfaceLaw elastic(const SurfaceLaw& law) {
  SurfaceLaw other{.inertia = law.inertia, .walls = law.walls, .materials = law.materials};
  for (GrainMaterial& one : other.materials) one.damping = 1;
  if (other.walls) other.walls->friction.reset();
  return other;
}

double rotational_energy(const Bodies& bodies) {
  double energy = 0;
  for (std::size_t i = 0; i < bodies.inertia.size(); ++i)
    energy += 0.5 * bodies.inertia[i] * norm2(spin_of(bodies, static_cast<int>(i)));
  return energy;
}

void set_rotation(const Scene& scene, const SurfaceLaw& law, Bodies& bodies) {
  if (!(law.inertia > 0)) return;
  bodies.angular_velocity.clear(), bodies.inertia.clear();
  for (int i = 0; i < bodies.size(); ++i) {
    bodies.inertia.push_back(law.inertia * bodies.mass[i] * bodies.radius[i] * bodies.radius[i]);
    const Vec3 w = scene.conductors[i].angular_velocity;
    if (bodies.dimension == 3) bodies.angular_velocity.insert(bodies.angular_velocity.end(), {w.x, w.y});
    bodies.angular_velocity.push_back(w.z);
  }
}

}  // namespace lichtenberg::granular
