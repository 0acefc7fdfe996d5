#pragma once

#include <memory>

#include "solvers/laplace/spheres/cell_convolution.hpp"

namespace lichtenberg::laplace::spheres {

/// Far field for many spheres: the field of sources in far cells at targets (spheres or points). It shifts multipoles
/// of sources to their cells' centres, applies the convolution between cells, and shifts the local coefficients of
/// cells to the targets.
class CellField {
 public:
  /// Prepares the shifts of multipoles from sources to their cells, and of local coefficients from cells to targets.
  /// `convolution`: far field between cells.
  CellField(std::shared_ptr<const CellConvolution> convolution, const Cells& cells, const std::vector<Site>& targets,
            const std::vector<Site>& sources);
  /// Adds the field of sources with `multipoles` (V) in far cells to the targets' `local` coefficients (V); both arrays
  /// are [site][harmonic].
  void add(const double* multipoles, double* local, parallel::Team& team) const;

 private:
  /// Site (centre of an expansion: a sphere or a point) with its cell and its displacement from the cell's centre.
  struct Member {
    int site = 0, cell = 0, degree = 0;
    Vec3 displacement;  ///< Displacement from the cell's centre to the site's centre (m)
  };
  /// Up to eight sites (expansion centres: spheres or points) of equal degree, whose expansions are shifted together.
  struct Batch {
    int degree = 0;
    PairDirections directions;
    Lanes length{};
    std::array<Member, lanes> member;
    int count = 0;
  };
  std::vector<Batch> batches(const Cells& cells, const std::vector<Site>& sites) const;
  void gather(const double* multipoles, std::vector<double>& in_cells, parallel::Team& team) const;
  void move_to_cells(const Batch& batch, const double* multipoles, Lanes* value) const;
  void spread(const std::vector<double>& in_cells, double* local, parallel::Team& team) const;
  void move_from_cells(const Batch& batch, const std::vector<double>& in_cells, double* local) const;

  std::shared_ptr<const CellConvolution> convolution_;
  std::vector<Site> targets_, sources_;
  std::vector<int> target_start_, source_start_;
  int cells_;
  std::vector<Batch> up_, down_;
  std::shared_ptr<const Translation> translation_;
  mutable std::vector<double> up_values_, down_values_;  ///< Layout [harmonic][cell]
  mutable std::vector<Lanes> moved_;                     ///< Layout [batch][harmonic]
};

}  // namespace lichtenberg::laplace::spheres
