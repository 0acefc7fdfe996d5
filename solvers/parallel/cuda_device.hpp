#pragma once

#include <cuda_runtime.h>

#include <cstdlib>
#include <string>

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
