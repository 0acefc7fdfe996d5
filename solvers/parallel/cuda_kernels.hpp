#pragma once

#include <cooperative_groups.h>
#include <cuda_runtime.h>

#include "solvers/parallel/host_executor.hpp"

// What CudaExecutor launches, and what an algorithm on it meets within a kernel.

namespace lichtenberg::parallel {

/// The first words of a kernel. What follows may be brought to the processors now, but begins, as this kernel's own
/// work, when all before it is done: launch() lets it.
__device__ inline void begin_kernel() {
#if __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
  cudaGridDependencySynchronize();
#endif
}

template <class F>
__global__ void item_kernel(long n, F f) {
  begin_kernel();
  const long k = blockIdx.x * static_cast<long>(blockDim.x) + threadIdx.x;
  if (k < n) f(static_cast<int>(k));
}

template <class F>
__global__ void row_kernel(int rows, int columns, F f) {
  begin_kernel();
  const int row = blockIdx.x * blockDim.y + threadIdx.y, column = blockIdx.y * blockDim.x + threadIdx.x;
  if (row < rows && column < columns) f(row, column);
}

/// The value of the lane `offset` above.
template <class T>
__device__ T value_of_lane_above(T value, int offset) {
  static_assert(sizeof(T) % sizeof(int) == 0);
  int word[sizeof(T) / sizeof(int)];
  memcpy(word, &value, sizeof(T));
#pragma unroll
  for (int& w : word) w = __shfl_down_sync(0xffffffffu, w, offset);
  memcpy(&value, word, sizeof(T));
  return value;
}

/// Some lanes of a warp a segment: each sums every so-manieth value, then the lanes are summed as a tree.
template <int lanes, class Count, class Value, class Finish>
__global__ void segment_kernel(long n, Count count, Value value, Finish finish) {
  begin_kernel();
  const long segment = (blockIdx.x * static_cast<long>(blockDim.x) + threadIdx.x) / lanes;
  if (lanes == 32 && segment >= n) return;
  const int s = static_cast<int>(segment), lane = threadIdx.x % lanes, end = segment < n ? count(s) : 0;
  using Sum = decltype(value(0, 0));
  Sum sum{};
  for (int t = lane; t < end; t += lanes) sum += value(s, t);
#pragma unroll
  for (int offset = lanes / 2; offset > 0; offset /= 2) sum += value_of_lane_above(sum, offset);
  if (lane == 0 && segment < n) finish(s, sum);
}

/// The sum over a block's threads, in its first one: warps, then the warps' sums, each as a tree.
template <int threads, class Sum>
__device__ Sum sum_of_block(Sum sum) {
  constexpr int lanes = 32, warps = threads / lanes;
  __shared__ double memory[warps * ((sizeof(Sum) + sizeof(double) - 1) / sizeof(double))];
  Sum* of_warp = reinterpret_cast<Sum*>(memory);
  const int warp = threadIdx.x / lanes, lane = threadIdx.x % lanes;
#pragma unroll
  for (int offset = lanes / 2; offset > 0; offset /= 2) sum += value_of_lane_above(sum, offset);
  __syncthreads();  // of_warp may still be read from before
  if (lane == 0) of_warp[warp] = sum;
  __syncthreads();
  if (warp == 0) {
    sum = lane < warps ? of_warp[lane] : Sum{};
#pragma unroll
    for (int offset = lanes / 2; offset > 0; offset /= 2) sum += value_of_lane_above(sum, offset);
  }
  return sum;
}

/// The block that comes last adds up what all have left, in their order.
template <int threads, class Sum, class Value, class Finish>
__global__ void __launch_bounds__(threads) sum_kernel(long n, Value value, Finish finish, Sum* of_block, int* done) {
  __shared__ bool last;
  begin_kernel();
  Sum sum{};
  for (long k = blockIdx.x * static_cast<long>(threads) + threadIdx.x; k < n;
       k += gridDim.x * static_cast<long>(threads))
    sum += value(static_cast<int>(k));
  sum = sum_of_block<threads>(sum);
  if (threadIdx.x == 0) {
    of_block[blockIdx.x] = sum;
    __threadfence();
    last = atomicAdd(done, 1) == static_cast<int>(gridDim.x) - 1;
  }
  __syncthreads();
  if (!last) return;
  __threadfence();
  sum = Sum{};
  for (int block = threadIdx.x; block < static_cast<int>(gridDim.x); block += threads) sum += of_block[block];
  sum = sum_of_block<threads>(sum);
  if (threadIdx.x > 0) return;
  *done = 0;
  finish(sum);
}

/// Places for all that a warp keeps are taken at once: they stand in order.
template <int rounds, class Keep, class Put>
__device__ void select_by_warps(int n, int* taken, Keep keep, Put put) {
  constexpr int lanes = 32;
  const int lane = threadIdx.x % lanes;
  const long warps = gridDim.x * static_cast<long>(blockDim.x) / lanes;
  long first = (threadIdx.x / lanes * static_cast<long>(gridDim.x) + blockIdx.x) * (rounds * lanes);
  for (; first < n; first += warps * rounds * lanes) {
    unsigned kept[rounds];
    int total = 0, place = 0;
#pragma unroll
    for (int r = 0; r < rounds; ++r) {
      const long k = first + r * lanes + lane;
      kept[r] = __ballot_sync(0xffffffffu, k < n && keep(static_cast<int>(k)));
      total += __popc(kept[r]);
    }
    if (total == 0) continue;
    if (lane == 0) place = atomicAdd(taken, total);
    place = __shfl_sync(0xffffffffu, place, 0);
#pragma unroll
    for (int r = 0; r < rounds; ++r) {
      if (kept[r] >> lane & 1)
        put(place + __popc(kept[r] & ((1u << lane) - 1)), static_cast<int>(first + r * lanes + lane));
      place += __popc(kept[r]);
    }
  }
}
template <class Count, class Keep, class Put>
__global__ void select_kernel(Count count, int* taken, Keep keep, Put put) {
  begin_kernel();
  select_by_warps<8>(count(), taken, keep, put);
}

/// The threads of a block, as HostExecutor::Block.
class CudaBlock {
 public:
  template <int unrolled = 1, class F>
  __host__ __device__ void each(int n, F f) const {
#ifdef __CUDA_ARCH__
#pragma unroll(unrolled)
    for (int k = threadIdx.x; k < n; k += blockDim.x) f(k);
    __syncthreads();
#endif
  }
  template <class T>
  __host__ __device__ T* memory() const {
#ifdef __CUDA_ARCH__
    extern __shared__ double block_memory[];
    return reinterpret_cast<T*>(block_memory);
#else
    return nullptr;
#endif
  }
};

template <int threads, class F>
__global__ void __launch_bounds__(threads) block_kernel(F f) {
  begin_kernel();
  f(CudaBlock{}, static_cast<int>(blockIdx.x));
}

/// All threads of a device at once, as HostExecutor::Grid.
class CudaGrid {
 public:
  /// Warps of one block lie as far apart as there are blocks: a short loop keeps all processors busy.
  template <class F>
  __host__ __device__ void each(int n, F f) const {
#ifdef __CUDA_ARCH__
    constexpr int lanes = 32;
    const int warp = threadIdx.x / lanes * gridDim.x + blockIdx.x, all = gridDim.x * blockDim.x;
    for (int k = warp * lanes + threadIdx.x % lanes; k < n; k += all) f(k);
    cooperative_groups::this_grid().sync();
#endif
  }
  template <class Keep, class Put>
  __host__ __device__ void select(int n, int* taken, Keep keep, Put put) const {
#ifdef __CUDA_ARCH__
    // As many to a warp as keep all warps busy; more, if many would otherwise ask for places at once.
    if (n > 1 << 20)
      select_by_warps<8>(n, taken, keep, put);
    else
      select_by_warps<2>(n, taken, keep, put);
    cooperative_groups::this_grid().sync();
#endif
  }
  template <class Value>
  __host__ __device__ void largest(int n, double* to, Value value) const {
#ifdef __CUDA_ARCH__
    constexpr int lanes = 32;
    double most = 0;
    for (long k = blockIdx.x * static_cast<long>(blockDim.x) + threadIdx.x; k < n;
         k += gridDim.x * static_cast<long>(blockDim.x))
      most = fmax(most, value(static_cast<int>(k)));
#pragma unroll
    for (int offset = lanes / 2; offset > 0; offset /= 2) most = fmax(most, __shfl_down_sync(0xffffffffu, most, offset));
    if (threadIdx.x % lanes == 0) enlarge_atomically(to, most);
    cooperative_groups::this_grid().sync();
#endif
  }
};

template <int threads, class F>
__global__ void __launch_bounds__(threads) grid_kernel(F f) {
  f(CudaGrid{});
}

/// Lets what a condition stands before in a graph be done, or done again, or not.
template <class Flag>
__global__ void condition_kernel(cudaGraphConditionalHandle condition, const Flag* flag) {
  begin_kernel();
  cudaGraphSetConditional(condition, *flag != 0);
}

/// Whether what is being recorded within `repeat` is done again.
struct CudaAgain {
  cudaGraphConditionalHandle condition;

  __host__ __device__ void operator()(bool go) const {
#ifdef __CUDA_ARCH__
    cudaGraphSetConditional(condition, go);
#endif
  }
};

struct Copy {
  int* to;
  const int* from;
  __host__ __device__ void operator()(int k) const { to[k] = from[k]; }
};

struct Plus {
  template <class T>
  __host__ __device__ T operator()(const T& a, const T& b) const {
    return a + b;
  }
};

}  // namespace lichtenberg::parallel
