#pragma once

#include <fftw3.h>

#include <cstddef>
#include <memory>
#include <new>

namespace lichtenberg {

struct DestroyFftwPlan {
  void operator()(fftw_plan plan) const { fftw_destroy_plan(plan); }
};
/// Plan of FFTW with one owner.
using FftwPlan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, DestroyFftwPlan>;

/// Alignment (bytes) for vectors of 8 numbers, the longest that FFTW supports.
constexpr std::align_val_t fftw_alignment{64};
struct DeleteFftwNumbers {
  void operator()(double* numbers) const { ::operator delete[](numbers, fftw_alignment); }
};
/// Uninitialized numbers for in-place transforms by FFTW.
using FftwNumbers = std::unique_ptr<double[], DeleteFftwNumbers>;
inline FftwNumbers make_fftw_numbers(std::size_t count) {
  return FftwNumbers(static_cast<double*>(::operator new[](count * sizeof(double), fftw_alignment)));
}

}  // namespace lichtenberg
