#pragma once

#include <array>
#include <vector>

namespace lichtenberg::periodic {

/// What a charge becomes along each axis of a mesh, as many points wide as an order says.
enum class Window {
  spline,   ///< a cardinal B-spline: as many boxes, each a spacing wide, folded with each other
  prolate,  ///< some boxes folded with a prolate spheroidal wave function as wide as the rest (README, windows)
};

/// How a prolate window is made: so many boxes folded with a prolate function as wide as the rest of the order, of this
/// band limit over pi times its width.
struct ProlateRecipe {
  int boxes;
  double band_limit;
};
/// The one of a window of order 4 to 8, found by a search (validation/windows.cpp).
ProlateRecipe prolate_recipe(int order);

/// A window between two mesh points: with s from -1/2 to 1/2 the place between them, from their middle and in spacings,
/// the c-th of the points around it has the weight sum_d pieces[d][c] s^d, with as many terms as points. Points and
/// their order are those of Spline; orders from 4 to 8.
std::vector<std::vector<double>> window_pieces(Window window, int order);

/// Fourier transforms of a window.
class WindowTransform {
 public:
  static constexpr int far_turns = 6;
  using Turned = std::array<double, 2 * far_turns + 1>;

  /// Orders from 4 to 8, each made once.
  static const WindowTransform& of(Window window, int order);
  /// Of a prolate window of any order and recipe with fewer boxes than the order.
  WindowTransform(int order, ProlateRecipe recipe);

  /// At k + 2 pi m, m from -far_turns to far_turns, for k in 1 / spacing: 1 at 0. Such waves look alike on a mesh.
  Turned operator()(double k) const;

 private:
  explicit WindowTransform(int boxes) : boxes_(boxes) {}

  struct Node {
    double place, weight, cosine, sine;  ///< of 2 pi place
  };
  int boxes_;
  std::vector<Node> nodes_;  ///< of what the boxes are folded with; none: of nothing
};

}  // namespace lichtenberg::periodic
