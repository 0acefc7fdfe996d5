// Determines the band limits of prolate windows (solvers/periodic/window.cpp) and tests that each is near the optimum.
// For each order, the optimum reaches the accuracy intended for that order with the coarsest mesh, if the mesh
// contributes half of the squared error (Hockney and Eastwood 8-23, cubic cells). The dependence on the number of boxes
// is informative: the estimate includes aliases up to six multiples of 2 pi / spacing, and with fewer boxes the
// remainder is larger.
//
// Bounds. The spacing is flat about its maximum: band limits with two digits are within 1.5 % of it, but changes of 10
// % are not.

#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/influence.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace windows_validation {

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using namespace lichtenberg::validation;

namespace {

/// Purpose of a window of an order: an accuracy, and the cut-off (contact: 1) at which it is reached.
struct Target {
  int order;
  double accuracy, cutoff;
};
constexpr Target targets[] = {{4, 1e-2, 3}, {5, 1e-3, 3.15}, {6, 1e-4, 3.8}, {7, 1e-5, 4.4}, {8, 1e-6, 5.2}};

/// Returns half of the integral of the squared force error between unit charges from contact on.
double half_of_squared_error(double accuracy) { return 0.5 * accuracy * accuracy * 4 * M_PI; }

Cloud cloud_for(const Target& target) {
  double low = 1, high = 40;
  while (high - low > 1e-3) {
    const double middle = 0.5 * (low + high);
    (prolate_cloud(middle, target.cutoff).neglected > half_of_squared_error(target.accuracy) ? low : high) = middle;
  }
  return prolate_cloud(high, target.cutoff);
}

/// Returns the spacing at which the mesh contributes half of the squared error.
double coarsest_spacing(const Target& target, const Cloud& cloud, const WindowTransform& window) {
  constexpr int points = 16;  // the error hardly depends on the size of the box
  double low = 0.1, high = 2;
  while (high - low > 1e-3) {
    const double h = 0.5 * (low + high), length = points * h;
    const Mesh mesh{{length, length, length}, {points, points, points}, target.order};
    (mesh_error(mesh, cloud, window) > half_of_squared_error(target.accuracy) ? high : low) = h;
  }
  return low;
}

struct BestWindow {
  ProlateRecipe recipe;
  double spacing = 0;
};

BestWindow best_of(const Target& target, const Cloud& cloud, int boxes) {
  BestWindow best;
  for (double limit = 0.4; limit < 0.9; limit += 0.02) {
    const ProlateRecipe recipe{boxes, limit};
    const double h = coarsest_spacing(target, cloud, WindowTransform(target.order, recipe));
    if (h > best.spacing) best = {recipe, h};
  }
  return best;
}

void search(Report& report, const Target& target) {
  const Cloud cloud = cloud_for(target);
  const ProlateRecipe used = prolate_recipe(target.order);
  const double spacing = coarsest_spacing(target, cloud, WindowTransform(target.order, used));
  const double by_splines = coarsest_spacing(target, cloud, WindowTransform::of(Window::spline, target.order));
  for (int boxes = 1; boxes < target.order - 1; ++boxes) {
    const BestWindow best = best_of(target, cloud, boxes);
    const bool are_used = boxes == used.boxes;
    report.at_most(fmt::format("order {}, to {:.0e}, {} boxes: best {:.2f}{}", target.order, target.accuracy, boxes,
                               best.recipe.band_limit, are_used ? fmt::format(", used {:.2f}", used.band_limit) : ""),
                   1 - spacing / best.spacing, are_used ? std::optional(0.015) : std::nullopt,
                   fmt::format("spacing {:.2f}{}", best.spacing,
                               are_used ? fmt::format(", used {:.2f}, splines {:.2f}", spacing, by_splines) : ""));
  }
}

}  // namespace

int validate(int, char**) {
  Report report("Prolate windows: by how much the coarsest spacing that serves falls short of the best window's");
  report.section("by number of boxes");
  for (const Target& target : targets) search(report, target);
  return report.exit_status();
}

const lichtenberg::validation::Program program("windows", validate);

}  // namespace windows_validation
