#pragma once

#include <vector>

#include "solvers/minimize/minimizer.hpp"
#include "solvers/parallel/team.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/model/model.hpp"
#include "src/statics/close_contacts.hpp"

namespace lichtenberg::statics {

/// Contact energy (J) of a model's bodies as a function of their positions (m, [N * dimension]).
class PotentialEnergy : public minimize::SmoothObjective {
 public:
  /// Makes the objective of the minimization. `scene`: a scene with a contact potential.
  PotentialEnergy(const Scene& scene, int threads);

  int size() const override { return static_cast<int>(model_.bodies.position.size()); }
  double evaluate(std::span<const double> x, std::span<double> gradient) override;
  void share(int tasks, const std::function<void(int)>& task) const override { team_.for_each(tasks, task); }
  void linearize(std::span<const double> x) override;
  void multiply(std::span<const double> v, std::span<double> product) const override;
  void precondition(std::span<const double> r, std::span<double> z) const override;

  const Model& model() const { return model_; }
  const effects::SoftRepulsion& potential() const { return potential_; }

 private:
  PotentialEnergy(const Scene& scene, std::unique_ptr<effects::SoftRepulsion> potential, int threads);
  int ranges() const;
  /// Calls task(k, first, end) for every range of particles, from `first` to before `end`.
  template <class Task>
  void for_each_range(const Task& task) const;
  State move_to(std::span<const double> x);
  template <int dimension>
  void build_rows(const State& state);
  template <int dimension>
  void invert(double* positive) const;
  template <int dimension>
  void multiply_rows(std::span<const double> v, std::span<double> product) const;

  const effects::SoftRepulsion& potential_;  ///< owned by the model
  Model model_;
  mutable parallel::Team team_;
  CloseContacts contacts_;
  mutable std::vector<std::vector<ParticleForce>> outside_forces_;  ///< by range, for the last product
  /// Blocks right of the diagonal in the Hessian's rows of a range of particles, with reversed sign. Each block is
  /// stored as its upper triangle, in rows.
  struct Rows {
    std::vector<int> start, column;
    std::vector<double> block;
  };
  std::vector<Rows> rows_;
  /// Diagonal blocks, and the inverses of those of M, the preconditioner, which contains only non-negative terms.
  std::vector<double> diagonal_, inverse_;
};

}  // namespace lichtenberg::statics
