#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "solvers/error.hpp"

namespace lichtenberg::parallel {

/// Throws Failure with CUDA's error message if a CUDA call returned an error code.
inline void check_cuda(cudaError_t code) {
  if (code == cudaSuccess) return;
  cudaGetLastError();
  throw Failure(std::string("CUDA device: ") + cudaGetErrorString(code));
}

/// Checks that the machine has a usable CUDA device; throws InputError if it has none.
inline void require_cuda_device() {
  int count = 0;
  const cudaError_t code = cudaGetDeviceCount(&count);
  if (code == cudaSuccess && count > 0) return;
  cudaGetLastError();
  throw InputError(std::string("device = \"cuda\": this machine has no CUDA device that can be used (") +
                   cudaGetErrorString(code == cudaSuccess ? cudaErrorNoDevice : code) + ")");
}

/// Returns the number of CUDA devices. Throws InputError if there is no usable one.
inline int cuda_device_count() {
  require_cuda_device();
  int count = 0;
  check_cuda(cudaGetDeviceCount(&count));
  return count;
}
/// Returns the given numbers of CUDA devices; for -1 those of all. Throws InputError for a device that does not exist.
inline std::vector<int> cuda_devices(std::vector<int> numbers) {
  const int present = cuda_device_count();
  if (numbers == std::vector{-1}) {
    numbers.resize(present);
    std::iota(numbers.begin(), numbers.end(), 0);
  }
  for (const int each : numbers)
    if (each >= present)
      throw InputError("device \"cuda:" + std::to_string(each) + "\": this machine has " + std::to_string(present) +
                       " CUDA devices, numbered from 0");
  return numbers;
}

/// Returns an attribute of the current CUDA device. Throws Failure if a CUDA call fails.
inline int device_attribute(cudaDeviceAttr attribute) {
  int device = 0, value = 0;
  check_cuda(cudaGetDevice(&device));
  check_cuda(cudaDeviceGetAttribute(&value, attribute, device));
  return value;
}

/// Moment in a CUDA stream (CudaExecutor::mark). Throws Failure if a CUDA call fails.
class CudaTimePoint {
 public:
  CudaTimePoint() { check_cuda(cudaEventCreate(&event_)); }
  CudaTimePoint(const CudaTimePoint&) = delete;
  CudaTimePoint& operator=(const CudaTimePoint&) = delete;
  ~CudaTimePoint() { cudaEventDestroy(event_); }
  cudaEvent_t event() const { return event_; }
  double seconds_since(const CudaTimePoint& earlier) const {
    float milliseconds = 0;
    check_cuda(cudaEventElapsedTime(&milliseconds, earlier.event_, event_));
    return 1e-3 * milliseconds;
  }

 private:
  cudaEvent_t event_ = nullptr;
};

/// Free and total memory of a CUDA device (bytes).
struct DeviceMemory {
  std::size_t available = 0, all = 0;
};
/// Returns the memory of the current CUDA device. Throws Failure if the CUDA call fails.
inline DeviceMemory device_memory() {
  DeviceMemory now;
  check_cuda(cudaMemGetInfo(&now.available, &now.all));
  return now;
}
/// Throws Failure for a request of `bytes` beyond the available memory of the device.
[[noreturn]] inline void refuse_memory(std::size_t bytes, const DeviceMemory& now) {
  const auto megabytes = [](std::size_t b) { return std::to_string(b >> 20) + " MiB"; };
  throw Failure("the CUDA device has not enough memory for " + megabytes(bytes) + " more: " + megabytes(now.available) +
                " of its " + megabytes(now.all) + " are free");
}

/// Returns whether the host evaluates the conditions and loops of recorded kernels: true if the environment variable
/// LICHTENBERG_CUDA_LOOPS is "host". By default ("device") conditional nodes of CUDA graphs evaluate them. The tools of
/// compute-sanitizer 2025.3 report false errors or crash for kernels in such nodes. Throws InputError for values other
/// than "host" and "device".
inline bool cuda_loops_on_host() {
  const char* name = "LICHTENBERG_CUDA_LOOPS";
  const char* value = std::getenv(name);
  const std::string wanted = value ? value : "device";
  if (wanted == "host" || wanted == "device") return wanted == "host";
  throw InputError(std::string(name) + ": \"" + wanted + "\" is neither \"device\" nor \"host\"");
}

}  // namespace lichtenberg::parallel
