#pragma once

#include <vector>

#include "solvers/minimize/minimizer.hpp"
#include "solvers/parallel/team.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/model/model.hpp"
#include "src/statics/close_contacts.hpp"

namespace lichtenberg::statics {

/// Potential energy (J) of overlapping particles, and of their weight relative to the origin, as a function of their
/// positions (m, [N * dimension], unwrapped), with gradient and Hessian: the objective of the minimization.
class PotentialEnergy : public minimize::SmoothObjective {
 public:
  /// Makes the objective for a scene with effects.soft_repulsion, evaluated by this number of threads.
  PotentialEnergy(const Scene& scene, int threads);

  /// Returns the number of variables, N * dimension.
  int size() const override { return static_cast<int>(model_.bodies.position.size()); }
  /// Returns the energy (J) and overwrites the gradient (N), as CloseContacts::evaluate() does.
  double evaluate(std::span<const double> x, std::span<double> gradient) override;
  void share(int tasks, const std::function<void(int)>& task) const override { team_.for_each(tasks, task); }
  /// Computes the Hessian of the energy (J/m^2) at x, and the inverse diagonal blocks of the preconditioner.
  void linearize(std::span<const double> x) override;
  /// Computes product = Hessian * v.
  void multiply(std::span<const double> v, std::span<double> product) const override;
  /// Applies the block-Jacobi preconditioner: z = M^-1 r. Each block of M is a particle's diagonal block of the Hessian
  /// without its negative terms, regularized.
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
  std::vector<double> weight_;  ///< N, [N * dimension], of the particles; empty without gravity
  mutable std::vector<std::vector<ParticleForce>> outside_forces_;  ///< by range, for the last product
  /// Off-diagonal blocks of the Hessian's upper triangle, with reversed sign, in the rows of a range of particles
  /// (sparse block rows). `start`: index of each row's first block; `column`: partner of each block. Each symmetric
  /// block is stored as its upper triangle, in rows.
  struct Rows {
    std::vector<int> start, column;
    std::vector<double> block;
  };
  std::vector<Rows> rows_;
  /// Diagonal blocks of the Hessian, and inverse blocks of the preconditioner M, which has only non-negative terms.
  std::vector<double> diagonal_, inverse_;
};

}  // namespace lichtenberg::statics
