#include <algorithm>
#include <memory>
#include <thread>

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg {
namespace {

/// Makes a solver whose results are bitwise identical for any number of threads.
laplace::SphereSolver make_in_space(const FieldOptions& options, std::size_t conductors) {
  constexpr std::size_t few = 48;  // below this number a matrix product is too short for several threads
  const int available = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int threads = options.threads > 0 ? options.threads : conductors < few ? 1 : available;
  return {{.accuracy = options.tolerance}, std::make_unique<parallel::Team>(threads)};
}

}  // namespace

const FieldMethodKind& spheres_method() {
  static const FieldMethodKind kind = {
      .name = "spheres",
      .help = "spherical harmonics on each sphere, in three dimensions",
      .describe =
          [](const FieldOptions&) { return std::string("spheres: real solid harmonics on each, walls as mirrors"); },
      .make_in_space = make_in_space,
      .cost =
          [](const FieldOptions&) { return FieldMethodCost{.solve = laplace::spheres_cost, .share_in_motion = 0.5}; },
      .tolerance = {.single = 1e-6, .moving = 1e-3, .least = 1e-12},
      .couplings = true};
  return kind;
}

}  // namespace lichtenberg
