#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace lichtenberg::periodic {

/// Window (charge assignment function): function by which a charge is spread along each axis of a mesh. Its width in
/// points is its order.
enum class Window {
  spline,   ///< Cardinal B-spline: `order` boxes, each one spacing wide, convolved with each other
  prolate,  ///< Some boxes convolved with a prolate spheroidal wave function of the remaining width
};

/// Recipe of a prolate window: the number of boxes (one spacing wide) with which a prolate function is convolved, and
/// the function's band limit, divided by pi times its width. The width in spacings is the order minus the number of
/// boxes.
struct ProlateRecipe {
  int boxes;
  double band_limit;
};
/// Returns the recipe of the prolate window of an order from 4 to 8, found by a search (validation/windows.cpp).
ProlateRecipe prolate_recipe(int order);

/// Computes the weights of a window of order 4 to 8 as polynomials: pieces[d][c]. s is the offset (spacings, -1/2 to
/// 1/2) of a charge from the middle between two mesh points. The c-th of the `order` points around it, in ascending
/// order, has the weight sum_d pieces[d][c] s^d. There are as many terms as points.
std::vector<std::vector<double>> window_pieces(Window window, int order);

/// Fourier transform of a window along one axis.
class WindowTransform {
 public:
  static constexpr int far_aliases = 6;
  using Aliases = std::array<double, 2 * far_aliases + 1>;

  /// Returns the transform of a window of order 4 to 8: a constant object that all callers share.
  static const WindowTransform& of(Window window, int order);
  /// Makes the transform of a prolate window of any order. `recipe`: number of boxes (one spacing wide) convolved with
  /// the prolate function, less than the order, and the function's band limit.
  WindowTransform(int order, ProlateRecipe recipe);

  /// Computes the transform at the wave numbers k + 2 pi m (in 1 / spacing) for m from -far_aliases to far_aliases.
  /// These waves are aliases of each other on the mesh. The transform is 1 at wave number 0.
  Aliases operator()(double k) const;
  /// Returns the transform at the aliases of a mode of a mesh, 0 to points / 2. Those of `sample_points` are stored.
  Aliases at_mode(int mode, int points) const {
    return points == sample_points ? sample_[mode] : (*this)(2 * M_PI * mode / points);
  }
  static constexpr int sample_points = 16;  ///< Number of points for which many errors of meshes are estimated

 private:
  explicit WindowTransform(int boxes) : boxes_(boxes) { fill_sample(); }
  void fill_sample();

  struct Node {
    double position, weight, cosine, sine;  ///< Cosine and sine of 2 pi position
  };
  int boxes_;
  std::vector<Node> nodes_;  ///< Quadrature nodes of the prolate function; empty for a spline
  std::array<Aliases, sample_points / 2 + 1> sample_{};
};

}  // namespace lichtenberg::periodic
