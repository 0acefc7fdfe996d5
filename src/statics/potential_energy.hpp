#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/team.hpp"
#include "solvers/minimize/minimizer.hpp"
#include "src/effects/contact_potential.hpp"
#include "src/model/model.hpp"

namespace lichtenberg::statics {

/// The contact energy (J) of a model's bodies as a function of their positions (m, [N * dimension]).
class PotentialEnergy : public minimize::SmoothObjective {
 public:
  /// The model must have a contact potential.
  PotentialEnergy(Model model, int threads);

  int size() const override { return static_cast<int>(model_.bodies.position.size()); }
  double evaluate(std::span<const double> x, std::span<double> gradient) override;
  void share(int tasks, const std::function<void(int)>& task) const override { team_.for_each(tasks, task); }
  void linearize(std::span<const double> x) override;
  void multiply(std::span<const double> v, std::span<double> product) const override;
  void precondition(std::span<const double> r, std::span<double> z) const override;

  const Model& model() const { return model_; }

 private:
  State move_to(std::span<const double> x);
  template <int dimension>
  void build_rows(const std::vector<effects::Overlap>& overlaps);

  Model model_;
  const effects::ContactPotential& potential_;
  mutable laplace::Team team_;
  std::vector<std::vector<effects::Push>> pushes_;  ///< by task, of the last evaluation
  // The Hessian by rows of blocks, each stored from its upper triangle, row by row; the diagonal blocks apart, with the
  // inverses of those of M, in which nothing is negative.
  std::vector<int> row_start_, column_;
  std::vector<double> block_, diagonal_, inverse_;
};

}  // namespace lichtenberg::statics
