// Checks of dimensions and periodic sides against effects and keys that do not support them.
#include <array>
#include <string>

#include <fmt/format.h>

#include "solvers/geometry/box.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/value.hpp"

namespace lichtenberg {
namespace {

std::string key_of(int side) { return fmt::format("domain.{}", side_names[side]); }

/// Returns the first periodic side; -1 if there is none.
int periodic_side(const Domain& domain) {
  for (std::size_t s = 0; s < domain.sides.size(); ++s)
    if (domain.sides[s].periodic) return static_cast<int>(s);
  return -1;
}

/// Checks that an axis is periodic on both its sides or on neither.
void check_sides(const Draft& draft, int dimension) {
  const std::array<DomainSide, 6>& sides = draft.scene.domain.sides;
  for (int s = 0; s < 6; ++s) {
    const std::string key = key_of(s), across = key_of(s ^ 1);
    const auto refuse_it = [&](const std::string& message) {
      refuse(draft.scene.path, draft.line(key), fmt::format("{} {}", key, message));
    };
    if (s >= 2 * dimension && draft.line(key) > 0)
      refuse_it("is not allowed in two dimensions: only a domain.size of three numbers has a front and a back");
    if (dimension == 3 && sides[s].electrode && !draft.scene.effects.has(&EffectKind::field) && !draft.scene.reference)
      refuse_it(
          fmt::format("= {} is not allowed in three dimensions without [effects.floating_conductors]: \"insulating\" "
                      "and \"periodic\" are",
                      show(sides[s])));
    if (sides[s].periodic && !sides[s ^ 1].periodic)
      refuse_it(
          fmt::format("= \"periodic\" is not allowed with {} = {}: an axis is periodic on both its sides or on "
                      "none",
                      across, show(sides[s ^ 1])));
  }
}

/// Checks that a uniform field is in free space and has three components.
void check_uniform_field(const Draft& draft) {
  if (!draft.uniform_field) return;
  const auto refuse_it = [&](const std::string& message) {
    refuse(draft.scene.path, draft.line("domain.uniform_field"), "domain.uniform_field " + message);
  };
  if (draft.scene.reference)
    refuse_it("is not allowed in a scene of grains: effects.uniform_field is the field on grains");
  if (!draft.scene.domain.open)
    refuse_it(
        "needs domain.unbounded = true: in a box, two opposite sides with different potentials make a uniform field");
  if (draft.uniform_field->count != 3) refuse_it("has 2 numbers, but the domain has 3: both must have the same number");
}

/// Checks that free space has no sides, and except for grains a field and three dimensions.
void check_open(const Draft& draft, int dimension) {
  const Domain& domain = draft.scene.domain;
  check_uniform_field(draft);
  if (!domain.open) return;
  const auto refuse_it = [&](const std::string& key, const std::string& message) {
    refuse(draft.scene.path, draft.line(key), message);
  };
  if (dimension == 2 && !draft.scene.reference)
    refuse_it(
        "domain.unbounded",
        "domain.unbounded = true is not allowed in two dimensions, where the potential of charges has no limit at "
        "infinity: it needs a domain.size of three numbers");
  if (!draft.scene.effects.has(&EffectKind::field) && !draft.scene.reference)
    refuse_it(
        "domain.unbounded",
        "domain.unbounded = true needs the table [effects.floating_conductors], or [units] for grains: add one, or "
        "leave the key out");
  for (int s = 0; s < 6; ++s)
    refuse_if_given(draft, key_of(s),
                    "is not allowed with domain.unbounded = true, which has no sides: leave one of the two out");
}

/// Throws InputError for keys that need a field, apart from effects, in a scene without one.
void check_without_field(const Draft& draft, const std::string& where) {
  const std::string effects = "effects.floating_conductors, which the scene does not have";
  struct PlaneOnly {
    std::string key, header, used_by;
  };
  for (const PlaneOnly& only : {PlaneOnly{"electrode", "[[electrode]]", effects},
                                {"group", "[[group]]", effects},
                                {"field", "[field]", effects},
                                {"conductor.charge", "conductor.charge", effects},
                                {"population.charge", "population.charge", effects}})
    if (const int line = draft.line(only.key))
      refuse(draft.scene.path, line,
             fmt::format("{} is not allowed {}: it is for {}; leave it out", only.header, where, only.used_by));
}

void check_effects(const Draft& draft, int dimension) {
  const int side = periodic_side(draft.scene.domain);
  for (const Effects::Entry& entry : draft.scene.effects) {
    entry.kind->check_dimension(dimension, location_prefix(draft.scene.path, draft.line("domain.size")));
    if (side < 0) continue;
    const std::string where = location_prefix(draft.scene.path, draft.line(key_of(side)));
    entry.kind->check_periodic(where);
    if (entry.kind->field && dimension == 2)
      throw InputError(where + fmt::format("effects.{} is not allowed with a periodic side of a domain of two "
                                           "dimensions: it supports walls and electrodes there",
                                           entry.kind->name));
  }
}

}  // namespace

void set_dimension(Draft& draft) {
  Domain& domain = draft.scene.domain;
  const int dimension = draft.domain_size.count;
  domain.size = draft.domain_size.value;
  if (draft.uniform_field) domain.uniform_field = draft.uniform_field->value;
  check_sides(draft, dimension);
  check_open(draft, dimension);
  check_effects(draft, dimension);
  if (!draft.scene.effects.has(&EffectKind::packing) && !draft.scene.reference) {
    const bool field = draft.scene.effects.has(&EffectKind::field);
    if (dimension == 3 && !field) check_without_field(draft, "in three dimensions");
    if (periodic_side(domain) >= 0 && !field) check_without_field(draft, "with a periodic side");
    if (periodic_side(domain) >= 0)
      refuse_if_given(draft, "network",
                      "is not allowed with a periodic side, because contacts across it are not searched: leave it out");
  }
  if (dimension == 2)
    refuse_if_given(draft, "mechanics.fix_z",
                    "is not allowed in two dimensions, where nothing moves along z: leave it out");
  const auto check = [&](const Coordinates& given, int line, const std::string& key) {
    if (given.count != dimension)
      refuse(draft.scene.path, line,
             fmt::format("{} has {} numbers, but the domain has {}: both must have the same number", key, given.count,
                         dimension));
  };
  for (ConductorDraft& conductor : draft.conductors) {
    check(conductor.position, conductor.line, "conductor.position");
    conductor.conductor.position = conductor.position.value;
    if (!conductor.velocity) continue;
    check(*conductor.velocity, conductor.line, "conductor.velocity");
    conductor.conductor.velocity = conductor.velocity->value;
  }
  for (const WallDraft& wall : draft.walls) {
    check(wall.point, wall.line, "wall.point");
    check(wall.normal, wall.line, "wall.normal");
  }
  for (const PopulationDraft& population : draft.populations)
    if (population.region && population.region->axes() > dimension)
      refuse(draft.scene.path, population.line,
             "population.region has corners of 3 numbers, but the domain has 2: both must have the same number");
}

}  // namespace lichtenberg
