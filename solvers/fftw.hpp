#pragma once

#include <fftw3.h>

#include <cstddef>
#include <memory>
#include <new>

namespace lichtenberg {

/// Deleter that destroys a plan of FFTW.
struct DestroyFftwPlan {
  void operator()(fftw_plan plan) const { fftw_destroy_plan(plan); }
};
/// Plan of an FFTW transform. The pointer owns the plan and destroys it.
using FftwPlan = std::unique_ptr<std::remove_pointer_t<fftw_plan>, DestroyFftwPlan>;

/// Flags of all plans. FFTW_MEASURE would choose by timing, so that bits would differ between runs. Without SIMD they
/// do not depend on the vectors of the processor.
#ifdef LICHTENBERG_REPEATABLE
constexpr unsigned fftw_planning = FFTW_ESTIMATE | FFTW_NO_SIMD;
#else
constexpr unsigned fftw_planning = FFTW_ESTIMATE;
#endif

/// Alignment (bytes) for SIMD vectors of 8 doubles, the longest vectors that FFTW supports.
constexpr std::align_val_t fftw_alignment{64};
/// Deleter of arrays of make_fftw_numbers().
struct DeleteFftwNumbers {
  void operator()(double* numbers) const { ::operator delete[](numbers, fftw_alignment); }
};
/// Array of doubles for input or output of an FFTW transform, aligned for SIMD. The pointer owns the memory and frees
/// it.
using FftwNumbers = std::unique_ptr<double[], DeleteFftwNumbers>;
/// Allocates an array of `count` doubles with undefined values, aligned to fftw_alignment.
inline FftwNumbers make_fftw_numbers(std::size_t count) {
  return FftwNumbers(static_cast<double*>(::operator new[](count * sizeof(double), fftw_alignment)));
}

}  // namespace lichtenberg
