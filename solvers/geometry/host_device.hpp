#pragma once

/// Marks a function that runs on the CPU and on a CUDA device; empty for compilers other than CUDA's.
#ifdef __CUDACC__
#define LICHTENBERG_HOST_DEVICE __host__ __device__
#else
#define LICHTENBERG_HOST_DEVICE
#endif
