#pragma once

#include <functional>
#include <vector>

#include "solvers/periodic/accuracy.hpp"

namespace lichtenberg::periodic {

constexpr int highest_double_order = 7;

/// Capabilities of a method of summation, and its cost model: nanoseconds on one core
/// (validation/benchmarks/periodic.cpp).
struct SumMethod {
  std::vector<int> points;      ///< Numbers of points per side with efficient transforms
  std::vector<Window> windows;  ///< Windows, in the order of preference
  int lowest_order, highest_order;
  double longest_cutoff;
  double cutoff_ratio;                                        ///< Ratio of successive cut-offs that are tried
  std::function<double(double density, double cutoff)> near;  ///< Cost of the near part, per charge
  double charge, row;  ///< Costs of a charge on the mesh: fixed, and per row of mesh points
  /// Cost of both transforms of a mesh of points^3, per point and doubling of the number of points
  std::function<double(int points)> point;
  double unused_point = 0;  ///< Cost of points on rows without charges (Convolution::use)
  bool on_device = false;   ///< True: the window with the least work is taken, not the first that reaches the accuracy
};

/// Numbers of points for which RowTransform is efficient.
std::vector<int> quick_numbers();

/// Returns the method of a ParticleMesh for cut-offs up to half of `length`.
SumMethod in_double_precision(double length, int lowest_order);
/// Returns the method of a SingleMesh.
SumMethod in_single_precision(double longest_cutoff, const std::vector<Window>& windows);
/// Returns the method of a DeviceMesh for cut-offs up to half of `length`. The cost model is that of an H200, where
/// memory access limits all threads (docs/measurements/device-gas.json). Neighbour lists have a skin. Tiles add to each
/// point of the mesh when they spread, and copy it when they interpolate.
SumMethod on_device(double length, const std::vector<Window>& windows);

/// Estimated work (ns) on the mesh points, for a mesh made for the request.
double work_on_mesh(const SumMethod& method, const Mesh& mesh, const MeshRequest& request);

}  // namespace lichtenberg::periodic
