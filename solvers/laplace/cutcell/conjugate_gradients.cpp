#include "solvers/laplace/cutcell/conjugate_gradients.hpp"

#include "solvers/laplace/cutcell/fused_iteration.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

/// Vectors and steps of conjugate gradients for one solve, with three passes over memory per iteration.
class Iteration {
 public:
  Iteration(MatrixFreeContext& context, double* x)
      : context_(context),
        op_(*context.op),
        multigrid_(*context.multigrid),
        layout_(op_.level().layout),
        cells_(op_.cells()),
        groups_(op_.size() - op_.cells()),
        x_(x) {
    for (std::vector<double>* vector : {&context.p, &context.q}) parallel::resize_in_huge_pages(*vector, op_.size());
    r_ = context.r.data();
    p_ = context.p.data();
    q_ = context.q.data();
    row_product_.resize(layout_.ny);
  }

  /// Starts the iterations with the residual of x in r, or with r = b and x = 0 (`from_zero`).
  void start(const double* b, bool from_zero) {
    for_each_row(op_.team(), layout_, [&](int j) {
      if (from_zero) in_row(j, [&](std::ptrdiff_t k) { r_[k] = b[k]; });
      multigrid_.take_row(j, r_);
    });
    if (from_zero) in_groups([&](std::ptrdiff_t k) { r_[k] = b[k]; });
    multigrid_.take_groups(r_);
  }

  // Parts of `iterate`; q = A p.
  PetscErrorCode precondition(double* product) {
    *product = multigrid_.cycle(r_);
    return 0;
  }

  PetscErrorCode update_direction(double beta, double* curvature) {
    ++context_.applications;
    const float* z = multigrid_.cells();
    const double* z_group = multigrid_.groups();
    const double mean = context_.null_space ? mean_correction() : 0.0;
    const std::vector<double>& diagonal = op_.level().diagonal;
    in_groups([&](std::ptrdiff_t k) { p_[k] = z_group[k - cells_] - mean + (beta == 0 ? 0 : beta * p_[k]); });
    wavefront(op_.team(), layout_, 2, 0, [&](int stage, int j) {
      if (stage == 1)
        row_product_[j] = op_.apply_row(j, p_, q_);
      else if (mean != 0)
        in_row(j,
               [&](std::ptrdiff_t k) { p_[k] = diagonal[k] > 0 ? z[k] - mean + (beta == 0 ? 0 : beta * p_[k]) : 0.0; });
      else if (beta == 0)
        in_row(j, [&](std::ptrdiff_t k) { p_[k] = z[k]; });
      else
        in_row(j, [&](std::ptrdiff_t k) { p_[k] = z[k] + beta * p_[k]; });
    });
    *curvature = ordered_sum(layout_, row_product_) + op_.apply_groups(p_, q_ + cells_);
    return 0;
  }

  PetscErrorCode step(double alpha) {
    const auto update = [this, alpha](std::ptrdiff_t k) {
      x_[k] += alpha * p_[k];
      r_[k] -= alpha * q_[k];
    };
    for_each_row(op_.team(), layout_, [&](int j) {
      in_row(j, update);
      multigrid_.take_row(j, r_);
    });
    in_groups(update);
    multigrid_.take_groups(r_);
    return 0;
  }

 private:
  template <class Entry>
  void in_row(int j, const Entry& entry) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = layout_.row(colour, j);
      const int n = layout_.row_length(colour, j);
#pragma GCC ivdep
      for (int k = 0; k < n; ++k) entry(row + k);
    }
  }
  template <class Entry>
  void in_groups(const Entry& entry) {
    for (std::ptrdiff_t k = 0; k < groups_; ++k) entry(cells_ + k);
  }

  /// Returns the mean of z over all unknowns: its component in the null space.
  double mean_correction() const {
    const std::vector<double>& diagonal = op_.level().diagonal;
    double sum = 0, count = 0;
    for (int colour = 0; colour < 2; ++colour)
      for (std::ptrdiff_t k = layout_.row(colour, layout_.own.begin); k < layout_.row(colour, layout_.own.end); ++k)
        if (diagonal[k] > 0) {
          sum += multigrid_.cells()[k];
          ++count;
        }
    sum = sum_over_slabs(layout_, sum);
    count = sum_over_slabs(layout_, count) + static_cast<double>(groups_);
    for (std::ptrdiff_t g = 0; g < groups_; ++g) sum += multigrid_.groups()[g];
    return sum / count;
  }

  MatrixFreeContext& context_;
  const CutCellOperator& op_;
  Multigrid& multigrid_;
  const Layout& layout_;
  std::ptrdiff_t cells_, groups_;
  double *x_, *r_ = nullptr, *p_ = nullptr, *q_ = nullptr;
  std::vector<double> row_product_;
};

PetscErrorCode solve(KSP ksp) {
  MatrixFreeContext* context = nullptr;
  PetscCall(PCShellGetContext(ksp->pc, &context));
  PetscCheck(context, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONGSTATE,
             "-field_ksp_type %s needs field.linear_solver = \"multigrid\" and its preconditioner", fused_cg);
  double* x = nullptr;
  const double* b = nullptr;
  PetscCall(VecGetArray(ksp->vec_sol, &x));
  PetscCall(VecGetArrayRead(ksp->vec_rhs, &b));
  Iteration iteration(*context, x);
  iteration.start(b, ksp->guess_zero);
  PetscCall(iterate(ksp, iteration));
  PetscCall(VecRestoreArray(ksp->vec_sol, &x));
  PetscCall(VecRestoreArrayRead(ksp->vec_rhs, &b));
  return 0;
}

}  // namespace

void register_fused_cg() { register_natural_method<solve>(fused_cg); }

}  // namespace lichtenberg::laplace
