#pragma once

#include <array>
#include <complex>
#include <vector>

#include "solvers/parallel/host_executor.hpp"

#ifdef __CUDACC__
#include <cufft.h>

#include "solvers/parallel/cuda_executor.hpp"
#else
#include <mutex>

#include "solvers/fftw.hpp"
#endif

namespace lichtenberg::periodic::device {

/// Three-dimensional FFT on an executor: unnormalized single-precision transforms between real numbers on a mesh and
/// their complex modes. Point (x, y, z) is at (x * points[1] + y) * points[2] + z. Mode (x, y, z) is the pair of
/// numbers at (x * points[1] + y) * (points[2] / 2 + 1) + z. The transform back may overwrite the modes.
template <class Executor>
class Fft;

#ifdef __CUDACC__
/// FFT on a CUDA device, by cuFFT. Throws Failure if cuFFT fails.
template <>
class Fft<parallel::CudaExecutor> {
 public:
  Fft(const parallel::CudaExecutor& run, std::array<int, 3> points) : run_(&run) {
    check(cufftPlan3d(&forward_, points[0], points[1], points[2], CUFFT_R2C));
    check(cufftPlan3d(&backward_, points[0], points[1], points[2], CUFFT_C2R));
  }
  Fft(const Fft&) = delete;
  Fft& operator=(const Fft&) = delete;
  ~Fft() {
    cufftDestroy(forward_);
    cufftDestroy(backward_);
  }
  void forward(float* points, float* modes) const {
    check(cufftSetStream(forward_, run_->stream()));
    check(cufftExecR2C(forward_, points, reinterpret_cast<cufftComplex*>(modes)));
  }
  void backward(float* modes, float* points) const {
    check(cufftSetStream(backward_, run_->stream()));
    check(cufftExecC2R(backward_, reinterpret_cast<cufftComplex*>(modes), points));
  }

 private:
  static void check(cufftResult code) {
    if (code == CUFFT_ALLOC_FAILED) throw Failure("the CUDA device has not enough memory for a Fourier transform");
    if (code != CUFFT_SUCCESS) throw Failure("CUDA device: cuFFT fails with code " + std::to_string(code));
  }
  const parallel::CudaExecutor* run_;
  cufftHandle forward_ = 0, backward_ = 0;
};
#else
/// FFT on the CPU for tests, by FFTW in double precision.
template <>
class Fft<parallel::HostExecutor> {
 public:
  Fft(const parallel::HostExecutor&, std::array<int, 3> points)
      : points_(points),
        real_(static_cast<std::size_t>(points[0]) * points[1] * points[2]),
        modes_(static_cast<std::size_t>(points[0]) * points[1] * (points[2] / 2 + 1)) {
    const std::scoped_lock one_at_a_time(planner());
    forward_ = fftw_plan_dft_r2c_3d(points[0], points[1], points[2], real_.data(), modes(), fftw_planning);
    backward_ = fftw_plan_dft_c2r_3d(points[0], points[1], points[2], modes(), real_.data(), fftw_planning);
  }
  Fft(const Fft&) = delete;
  Fft& operator=(const Fft&) = delete;
  ~Fft() {
    const std::scoped_lock one_at_a_time(planner());
    fftw_destroy_plan(forward_);
    fftw_destroy_plan(backward_);
  }
  void forward(float* points, float* modes_out) {
    std::copy_n(points, real_.size(), real_.begin());
    fftw_execute(forward_);
    for (std::size_t k = 0; k < modes_.size(); ++k)
      modes_out[2 * k] = static_cast<float>(modes_[k].real()),
                    modes_out[2 * k + 1] = static_cast<float>(modes_[k].imag());
  }
  void backward(float* modes_in, float* points) {
    for (std::size_t k = 0; k < modes_.size(); ++k) modes_[k] = {modes_in[2 * k], modes_in[2 * k + 1]};
    fftw_execute(backward_);
    std::ranges::transform(real_, points, [](double value) { return static_cast<float>(value); });
  }

 private:
  /// FFTW makes one plan at a time; ranks on the CPU are threads.
  static std::mutex& planner() {
    static std::mutex mutex;
    return mutex;
  }
  fftw_complex* modes() { return reinterpret_cast<fftw_complex*>(modes_.data()); }
  std::array<int, 3> points_;
  std::vector<double> real_;
  std::vector<std::complex<double> > modes_;
  fftw_plan forward_ = nullptr, backward_ = nullptr;
};
#endif

}  // namespace lichtenberg::periodic::device
