#pragma once

/// In front of a function that runs on the CPU and on a CUDA device alike; other compilers than CUDA's see nothing.
#ifdef __CUDACC__
#define LICHTENBERG_HOST_DEVICE __host__ __device__
#else
#define LICHTENBERG_HOST_DEVICE
#endif
