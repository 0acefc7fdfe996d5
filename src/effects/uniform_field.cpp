#include "src/effects/uniform_field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/effects/device_forces.hpp"
#include "src/effects/vector_key.hpp"
#include "src/model/grain_part.hpp"

namespace lichtenberg::effects {
namespace {

void check_uniform_field(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<UniformFieldOptions>();
  const auto refuse_it = [&](const std::string& key, const std::string& message) {
    refuse(draft.scene.path, draft.line(key), message);
  };
  check_components(draft, "effects.uniform_field.field", options.field);
  if (draft.scene.effects.has("induced_dipoles"))
    refuse_it("effects.uniform_field",
              "effects.uniform_field is not allowed with effects.induced_dipoles, whose dipoles are those in the field "
              "of the charges alone: leave one out");
  const auto& sides = draft.scene.domain.sides;
  for (int s = 0; s < 6; ++s)
    for (int k = 0; k < 3; ++k)
      if (sides[s].electrode && k != s / 2 && options.field.value[k] != 0)
        refuse_it("effects.uniform_field.field",
                  fmt::format("effects.uniform_field.field = {:g} along {} is not allowed with the conducting side "
                              "domain.{}: a field is perpendicular to it",
                              options.field.value[k], "xyz"[k], side_names[s]));
}

/// Adds the forces of the field to those of a device. Fixed-point sums are exact until the grains have crossed the
/// domain 2^11 times, all in one direction with the largest charge, which counts at least 1 (q0).
void uniform_field_on_device(const Scene& scene, DeviceForces& forces) {
  const Vec3 field = scene.effects.find<UniformFieldOptions>()->field.value, size = scene.domain.size;
  double charge = 1;
  for (const Conductor& grain : scene.conductors) charge = std::max(charge, std::abs(grain.charge));
  const double force = charge * norm(field), length = norm(size);
  const double many = std::max(1.0, static_cast<double>(scene.conductors.size()) / 16384);
  forces.charged = true;
  forces.parts.push_back(grain_form_with_kernels(FieldOnCharge{field}, {force, 64 * many * force * length}));
}

}  // namespace

const EffectKind& UniformFieldOptions::kind() {
  static const EffectKind kind = {
      .name = "uniform_field",
      .description = "external uniform electric field on the charges of grains",
      .help =
          "An external uniform electric field E acts on the charges of grains with the force q E. Its energy -q E.r is "
          "part of the potential energy, with unwrapped positions r along periodic axes. Between two conducting sides "
          "it is the field of a voltage, perpendicular to them.",
      .options = UniformFieldOptions{},
      .keys = {{.name = "field",
                .target = target<&UniformFieldOptions::field>,
                .unit = "m0 v0^2/(q0 d0)",
                .required = true,
                .help = "electric field, in reduced units (m0 v0^2/(q0 d0)): a vector with one component per dimension "
                        "of the domain. A field E in V/m is E q0 d0 / (m0 v0^2) in these units, with the scales of "
                        "[units]"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check = check_uniform_field,
      .make =
          [](const Scene& scene) { return std::make_unique<UniformField>(*scene.effects.find<UniformFieldOptions>()); },
      .device = uniform_field_on_device};
  return kind;
}

void UniformField::add_forces(const State& state, std::span<double> force) const {
  const Bodies& b = state.bodies;
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < b.dimension; ++k) force[i * b.dimension + k] += law_.force(b.charge[i], k);
}

double UniformField::stored_energy(const State& state) const {
  const Bodies& b = state.bodies;
  double energy = 0;
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < b.dimension; ++k) {
      const int n = i * b.dimension + k;
      const double unwrapped = b.position[n] + (b.image.empty() ? 0 : b.image[n] * b.box.lengths[k]);
      energy += law_.energy(b.charge[i], unwrapped, k);
    }
  return energy;
}

}  // namespace lichtenberg::effects
