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
  Iteration(MatrixFreeContext& context, const double* b, double* x)
      : context_(context),
        op_(*context.op),
        multigrid_(*context.multigrid),
        layout_(op_.level().layout),
        cells_(op_.cells()),
        groups_(op_.size() - op_.cells()),
        b_(b),
        x_(x),
        r_(context.r),
        p_(context.p),
        q_(context.q),
        row_product_(layout_.ny) {
    for (SplitVector* vector : {&p_, &q_}) {
      parallel::resize_in_huge_pages(vector->cell, cells_);
      vector->group.resize(groups_);
    }
  }

  /// Starts the iterations with the residual of x in r, or with r = b and x = 0 (`from_zero`).
  void start(bool from_zero) {
    if (from_zero) {
      in_rows([&](std::ptrdiff_t k) { r_.cell[k] = static_cast<float>(b_[k]); });
      r_.group.assign(b_ + cells_, b_ + op_.size());
    }
    for_each_row(op_.team(), layout_, [&](int j) { multigrid_.take_row(j, r_.cell.data()); });
    multigrid_.take_groups(r_.group.data());
  }

  // Parts of `iterate`; q = A p.
  PetscErrorCode precondition(double* product) {
    product_ = *product = multigrid_.cycle(r_.cell.data(), r_.group.data());
    product_of_residual_ = std::max(product_of_residual_, product_);
    return 0;
  }

  PetscErrorCode update_direction(double beta, double* curvature) {
    ++context_.applications;
    if (starts_again_) beta = 0;
    starts_again_ = false;
    const float* z = multigrid_.cells();
    const double* z_group = multigrid_.groups();
    const double mean = context_.null_space ? mean_correction() : 0.0;
    const double* diagonal = op_.level().diagonal.data();
    float* p = p_.cell.data();
    for (std::ptrdiff_t g = 0; g < groups_; ++g) p_.group[g] = z_group[g] - mean + (beta == 0 ? 0 : beta * p_.group[g]);
    const auto shift = static_cast<float>(mean), share = static_cast<float>(beta);
    wavefront(op_.team(), layout_, 2, [&](int stage, int j) {
      if (stage == 1)
        row_product_[j] = op_.apply_row(j, p_.cell.data(), p_.group.data(), q_.cell.data());
      else if (mean != 0)
        in_row(j, [&](std::ptrdiff_t k) {
          p[k] = diagonal[k] > 0 ? z[k] - shift + (share == 0 ? 0 : share * p[k]) : 0.0f;
        });
      else if (beta == 0)
        in_row(j, [&](std::ptrdiff_t k) { p[k] = z[k]; });
      else
        in_row(j, [&](std::ptrdiff_t k) { p[k] = z[k] + share * p[k]; });
    });
    *curvature = ordered_sum(row_product_) + op_.apply_groups(p_.cell.data(), p_.group.data(), q_.group.data());
    return 0;
  }

  PetscErrorCode step(double alpha) {
    constexpr double least_ratio = 1e-6;  // of squared norms
    const bool refreshes = product_ < least_ratio * product_of_residual_;
    const float *p = p_.cell.data(), *q = q_.cell.data(), share = static_cast<float>(alpha);
    float* r = r_.cell.data();
    for_each_row(op_.team(), layout_, [&](int j) {
      in_row(j, [=, x = x_](std::ptrdiff_t k) {
        x[k] += alpha * p[k];
        r[k] -= share * q[k];
      });
      if (!refreshes) multigrid_.take_row(j, r);
    });
    for (std::ptrdiff_t g = 0; g < groups_; ++g) {
      x_[cells_ + g] += alpha * p_.group[g];
      r_.group[g] -= alpha * q_.group[g];
    }
    if (refreshes) refresh_residual();
    multigrid_.take_groups(r_.group.data());
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
  void in_rows(const Entry& entry) {
    for_each_row(op_.team(), layout_, [&](int j) { in_row(j, entry); });
  }

  /// Computes the residual of x, because that of the iteration has the rounding errors of its first, largest values.
  void refresh_residual() {
    ++context_.applications;
    op_.residual(b_, x_, r_);
    if (op_.grounded_by_couplings()) op_.fix_potential_level(x_, r_);
    for_each_row(op_.team(), layout_, [&](int j) { multigrid_.take_row(j, r_.cell.data()); });
    product_of_residual_ = 0;
    starts_again_ = true;
  }

  /// Returns the mean of z over all unknowns: its component in the null space.
  double mean_correction() const {
    const std::vector<double>& diagonal = op_.level().diagonal;
    double sum = 0, count = static_cast<double>(groups_);
    for (std::ptrdiff_t k = 0; k < cells_; ++k)
      if (diagonal[k] > 0) {
        sum += multigrid_.cells()[k];
        ++count;
      }
    for (std::ptrdiff_t g = 0; g < groups_; ++g) sum += multigrid_.groups()[g];
    return sum / count;
  }

  MatrixFreeContext& context_;
  const CutCellOperator& op_;
  Multigrid& multigrid_;
  const Layout& layout_;
  std::ptrdiff_t cells_, groups_;
  const double* b_;
  double* x_;
  SplitVector &r_, &p_, &q_;
  // Last scalar product r'z, and the largest since the residual of x was computed.
  double product_ = 0, product_of_residual_ = 0;
  // Whether the next direction is the first for a residual of x.
  bool starts_again_ = false;
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
  Iteration iteration(*context, b, x);
  iteration.start(ksp->guess_zero);
  PetscCall(iterate(ksp, iteration));
  PetscCall(VecRestoreArray(ksp->vec_sol, &x));
  PetscCall(VecRestoreArrayRead(ksp->vec_rhs, &b));
  return 0;
}

}  // namespace

void register_fused_cg() { register_natural_method<solve>(fused_cg); }

}  // namespace lichtenberg::laplace
