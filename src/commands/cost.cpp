#include "src/commands/cost.hpp"

#include <cmath>

namespace lichtenberg {
namespace {

/// What was measured on one core (README.md of this folder).
struct Figures {
  double bytes;                ///< an unknown (of a grid: a cell)
  double setup;                ///< s, an unknown
  double iteration;            ///< s, an unknown and iteration
  double iterations_a_decade;  ///< of the tolerance
};

Figures figures_of(const FieldOptions& options) {
  // Sweeps of an over-relaxed lattice grow with its side (D 6.9), and with them the time of an iteration.
  if (options.method == "relaxation") return {16, 0, 3.5e-10 * options.cells, 60};
  if (options.method == "multipole") return {2000, 1.5e-6, 1.8e-7, 3};
  if (options.linear_solver == "assembled") return {373, 1.3e-6, 4.5e-8, 2.25};
  return {100, 2.5e-8, 8.5e-9, 1.25};
}

constexpr double bytes_at_start = 40e6;  // PETSc and the other libraries
constexpr double share_in_motion = 0.8;  // of the iterations: earlier solutions are a good first guess

}  // namespace

FieldCost estimate_field_cost(const FieldOptions& options, double size) {
  const Figures a = figures_of(options);
  const auto seconds = [&](double tolerance, double share) {
    return size * (a.setup + share * a.iterations_a_decade * -std::log10(tolerance) * a.iteration);
  };
  return {.bytes = bytes_at_start + a.bytes * size,
          .single_seconds = seconds(options.tolerance, 1),
          .moving_seconds = seconds(options.moving_tolerance, share_in_motion)};
}

std::optional<double> estimate_field_solves(const Scene& scene) {
  if (scene.mechanics.integrator == "euler") return scene.stop.time / scene.mechanics.euler_field_step;
  const Effects& effects = scene.effects;
  if (!effects.current_source || !effects.stokes_drag || !effects.contact_discharge) return std::nullopt;
  return 0.4 * std::pow(static_cast<double>(scene.conductors.size()), 1.6);
}

}  // namespace lichtenberg
