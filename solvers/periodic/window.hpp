#pragma once

#include <array>
#include <vector>

namespace lichtenberg::periodic {

/// Function by which a charge is spread along each axis of a mesh; its width in points is its order.
enum class Window {
  spline,   ///< Cardinal B-spline: `order` boxes, each one spacing wide, convolved with each other
  prolate,  ///< Some boxes convolved with a prolate spheroidal wave function of the remaining width
};

/// Recipe of a prolate window: number of boxes, and the prolate function's band limit over pi times its width. The
/// prolate function is as wide as the order less the number of boxes.
struct ProlateRecipe {
  int boxes;
  double band_limit;
};
/// Returns the recipe of a window of order 4 to 8, found by a search (validation/windows.cpp).
ProlateRecipe prolate_recipe(int order);

/// Returns the polynomials of a window between two mesh points; orders from 4 to 8. With s from -1/2 to 1/2 the offset
/// from the middle between them, in spacings, the c-th of the `order` surrounding points, in ascending order, has the
/// weight sum_d pieces[d][c] s^d. There are as many terms as points.
std::vector<std::vector<double>> window_pieces(Window window, int order);

/// Fourier transform of a window.
class WindowTransform {
 public:
  static constexpr int far_aliases = 6;
  using Aliases = std::array<double, 2 * far_aliases + 1>;

  /// Returns the shared transform of a window of order 4 to 8.
  static const WindowTransform& of(Window window, int order);
  /// Makes the transform of a prolate window of any order, for a recipe with fewer boxes than the order.
  WindowTransform(int order, ProlateRecipe recipe);

  /// Returns the transform at k + 2 pi m, m from -far_aliases to far_aliases, with k in 1 / spacing; it is 1 at 0.
  /// These waves are aliases of each other on the mesh.
  Aliases operator()(double k) const;

 private:
  explicit WindowTransform(int boxes) : boxes_(boxes) {}

  struct Node {
    double position, weight, cosine, sine;  ///< Cosine and sine of 2 pi position
  };
  int boxes_;
  std::vector<Node> nodes_;  ///< Quadrature nodes of the prolate function; empty for a spline
};

}  // namespace lichtenberg::periodic
