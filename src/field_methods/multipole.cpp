#include "solvers/laplace/multipole/solver.hpp"

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg {
namespace {

/// Returns the solver's options. With a requested accuracy the solver computes only the results that it needs.
laplace::MultipoleOptions multipole_options(const FieldOptions& options) {
  return {.tolerance = options.tolerance, .results_only = options.chosen_for.has_value(), .cells = options.cells};
}

}  // namespace

const FieldMethodKind& multipole_method() {
  static const FieldMethodKind kind = {
      .name = "multipole",
      .help = "spectral, with multipoles of each disk, for any number of digits; for disks only",
      .describe =
          [](const FieldOptions&) {
            return std::string("multipole: spectral, a Fourier series a disk and walls as mirrors; GMRES with FFT");
          },
      .make = [](const FieldOptions& options) -> std::unique_ptr<laplace::LaplaceSolver> {
        return std::make_unique<laplace::MultipoleSolver>(multipole_options(options));
      },
      .unknowns =
          [](const laplace::LaplaceProblem& problem, const FieldOptions& options) {
            return laplace::multipole_unknowns(problem, multipole_options(options));
          },
      .cost = [](const FieldOptions&) { return FieldMethodCost{laplace::multipole_cost}; },
      .tolerance = {.single = 1e-10, .moving = 1e-6, .least = 1e-13},
      .accuracy = laplace::Method::multipole,
      .only_disks = true,
      .only_separate = true};
  return kind;
}

}  // namespace lichtenberg
