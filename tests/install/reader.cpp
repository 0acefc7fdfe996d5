// Program outside the source tree. It includes headers by their paths and calls a module that needs other libraries.
#include <cstdio>

#include "solvers/laplace/problem.hpp"
#include "src/effects/read_scene.hpp"

int main() {
  const lichtenberg::Scene scene = lichtenberg::parse_scene(R"(
    [domain]
    size = [0.02, 0.01]
    [[conductor]]
    position = [5e-3, 5e-3]
    radius = 1e-3
    [[conductor]]
    position = [15e-3, 5e-3]
    radius = 1e-3
  )",
                                                            "reader.toml");
  const lichtenberg::laplace::LaplaceProblem problem{.size = plane(scene.domain.size)};
  std::printf("%zu conductors in %g m x %g m\n", scene.conductors.size(), problem.size.x, problem.size.y);
}
