#pragma once

#include <cooperative_groups.h>
#include <cuda_runtime.h>

#include "solvers/parallel/host_executor.hpp"

// Kernels that CudaExecutor launches, and the classes that algorithms use within a kernel.

namespace lichtenberg::parallel {

/// Begins a kernel, as its first statement: allows the next kernel to be loaded, then waits until all earlier kernels
/// have finished. No effect below compute capability 9. See CudaExecutor::launch.
__device__ inline void begin_kernel() {
#if __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
  cudaGridDependencySynchronize();
#endif
}

/// Kernel of CudaExecutor::for_each(n, f): thread k calls f(k).
template <class F>
__global__ void item_kernel(long n, F f) {
  begin_kernel();
  const long k = blockIdx.x * static_cast<long>(blockDim.x) + threadIdx.x;
  if (k < n) f(static_cast<int>(k));
}

/// Kernel of CudaExecutor::for_each(rows, columns, f): one thread per row and column.
template <class F>
__global__ void row_kernel(int rows, int columns, F f) {
  begin_kernel();
  const int row = blockIdx.x * blockDim.y + threadIdx.y, column = blockIdx.y * blockDim.x + threadIdx.x;
  if (row < rows && column < columns) f(row, column);
}

/// Warp shuffle: returns the `value` of the thread whose lane (index in the warp) is higher by `offset`. T is any type
/// of whole 4-byte words.
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

/// Warp reduction: returns the sum over `lanes` neighbouring threads of a warp, valid in the first of them. `lanes` is
/// a power of two up to 32.
template <int lanes, class T>
__device__ T sum_of_lanes(T sum) {
#pragma unroll
  for (int offset = lanes / 2; offset > 0; offset /= 2) sum += value_of_lane_above(sum, offset);
  return sum;
}

/// Kernel of CudaExecutor::sum_segments. `lanes` threads of a warp sum each segment: each thread sums every `lanes`-th
/// value, then a tree adds the threads' sums.
template <int lanes, class Count, class Value, class Finish>
__global__ void segment_kernel(long n, Count count, Value value, Finish finish) {
  begin_kernel();
  const long segment = (blockIdx.x * static_cast<long>(blockDim.x) + threadIdx.x) / lanes;
  if (lanes == 32 && segment >= n) return;
  const int s = static_cast<int>(segment), lane = threadIdx.x % lanes, end = segment < n ? count(s) : 0;
  using Sum = decltype(value(0, 0));
  Sum sum{};
  for (int t = lane; t < end; t += lanes) sum += value(s, t);
  sum = sum_of_lanes<lanes>(sum);
  if (lane == 0 && segment < n) finish(s, sum);
}

/// Detects the last of n calls by an atomic counter: returns true in the last call, and sets the counter `count` back
/// to 0. Earlier writes of the other callers are visible to the last caller.
__device__ inline bool is_last_call(int* count, int n) {
  __threadfence();
  const bool last = atomicAdd(count, 1) == n - 1;
  if (last) *count = 0;
  __threadfence();
  return last;
}

/// Kernel of CudaExecutor::sum_pieces. `lanes` threads sum each piece of a segment (SegmentPieces); the values of
/// `more` are added once per segment. For a segment of several pieces, the threads that finish last add the partial
/// sums. Further groups of `lanes` threads handle the segments without pieces.
template <int lanes, class Sum, class Value, class More, class Finish>
__global__ void pieces_kernel(SegmentPieces pieces, Sum* partial, Value value, More more, Finish finish) {
  begin_kernel();
  const int item = static_cast<int>((blockIdx.x * static_cast<long>(blockDim.x) + threadIdx.x) / lanes);
  const int lane = threadIdx.x % lanes, first = pieces.start[0], piece = first + item;
  int s = -1, count = 0;
  Sum sum{};
  if (item < pieces.capacity && piece < pieces.start[pieces.segments]) {
    s = pieces.of[piece] - pieces.first_segment;
    count = pieces.count(s);
    const int end = pieces.end[piece];
    for (int k = pieces.begin[piece] + lane; k < end; k += lanes) sum += value(k);
  } else if (item >= pieces.capacity && item - pieces.capacity < pieces.segments) {
    s = item - pieces.capacity;
    if (pieces.count(s) > 0) s = -1;
  }
  sum = sum_of_lanes<lanes>(sum);
  int finishes = s >= 0 && count <= 1;
  if (lane == 0 && count > 1) {
    partial[piece] = sum;
    finishes = is_last_call(pieces.done + s, count);
  }
  finishes = __shfl_sync(0xffffffffu, finishes, 0, lanes);
  Sum rest{};
  if (finishes) {
    for (int k = lane; count > 1 && k < count; k += lanes) rest += fresh(partial + pieces.start[s] + k);
    const int end = more.count(s);
    for (int t = lane; t < end; t += lanes) rest += more.value(s, t);
  }
  rest = sum_of_lanes<lanes>(rest);
  if (lane == 0 && finishes) finish(s, count > 1 ? rest : sum + rest);
}

/// Block reduction: returns the sum over all threads of a block, valid in the first thread. A tree sums each warp, a
/// second one the sums of the warps.
template <class Sum>
__device__ Sum sum_of_block(Sum sum) {
  constexpr int lanes = 32;
  const int warps = blockDim.x / lanes;
  __shared__ double memory[lanes * ((sizeof(Sum) + sizeof(double) - 1) / sizeof(double))];
  Sum* warp_sums = reinterpret_cast<Sum*>(memory);
  const int warp = threadIdx.x / lanes, lane = threadIdx.x % lanes;
  sum = sum_of_lanes<lanes>(sum);
  __syncthreads();  // warp_sums may still be in use by an earlier call
  if (lane == 0) warp_sums[warp] = sum;
  __syncthreads();
  if (warp == 0) {
    sum = sum_of_lanes<lanes>(lane < warps ? warp_sums[lane] : Sum{});
  }
  return sum;
}

/// Sums `mine` over all threads of a kernel with `threads` threads per block, and calls finish(sum) in one thread. The
/// block that finishes last adds the sums of all blocks, in a fixed order. `block_sums`: one element per block; `done`:
/// counter, 0 before and after.
template <int threads, class Sum, class Finish>
__device__ void sum_of_grid(const Sum& mine, Finish finish, Sum* block_sums, int* done) {
  __shared__ bool last;
  Sum sum = sum_of_block(mine);
  if (threadIdx.x == 0) {
    block_sums[blockIdx.x] = sum;
    __threadfence();
    last = atomicAdd(done, 1) == static_cast<int>(gridDim.x) - 1;
  }
  __syncthreads();
  if (!last) return;
  __threadfence();
  sum = Sum{};
  for (int block = threadIdx.x; block < static_cast<int>(gridDim.x); block += threads) sum += block_sums[block];
  sum = sum_of_block(sum);
  if (threadIdx.x > 0) return;
  *done = 0;
  finish(sum);
}

/// Kernel of CudaExecutor::sum(n, value, finish), see sum_of_grid.
template <int threads, class Sum, class Value, class Finish>
__global__ void __launch_bounds__(threads) sum_kernel(long n, Value value, Finish finish, Sum* block_sums, int* done) {
  begin_kernel();
  Sum sum{};
  for (long k = blockIdx.x * static_cast<long>(threads) + threadIdx.x; k < n;
       k += gridDim.x * static_cast<long>(threads))
    sum += value(static_cast<int>(k));
  sum_of_grid<threads>(sum, finish, block_sums, done);
}

/// Kernel of CudaExecutor::sum(rows, columns, value, finish), see sum_of_grid. A block takes a row at a time. Sums of
/// one value leave the registers for all threads that a multiprocessor can have.
template <int threads, class Sum, class Value, class Finish>
__global__ void __launch_bounds__(threads, sizeof(Sum) > sizeof(double) ? 3 : 2048 / threads)
    row_sum_kernel(int rows, int columns, Value value, Finish finish, Sum* block_sums, int* done) {
  begin_kernel();
  Sum sum{};
  for (int row = blockIdx.x; row < rows; row += gridDim.x)
    for (int column = threadIdx.x; column < columns; column += threads) sum += value(row, column);
  sum_of_grid<threads>(sum, finish, block_sums, done);
}

/// Stream compaction by warps: calls put(index, k) for all k = 0 ... n - 1 with keep(k), with successive indices from
/// *taken on. A warp tests `rounds` times 32 successive items and reserves their indices together. Items of a warp keep
/// their order; warps come in any order.
template <int rounds, class Keep, class Put>
__device__ void select_by_warps(int n, int* taken, Keep keep, Put put) {
  constexpr int lanes = 32;
  const int lane = threadIdx.x % lanes;
  const long warps = gridDim.x * static_cast<long>(blockDim.x) / lanes;
  long first = (threadIdx.x / lanes * static_cast<long>(gridDim.x) + blockIdx.x) * (rounds * lanes);
  for (; first < n; first += warps * rounds * lanes) {
    unsigned kept[rounds];
    int total = 0, index = 0;
#pragma unroll
    for (int r = 0; r < rounds; ++r) {
      const long k = first + r * lanes + lane;
      kept[r] = __ballot_sync(0xffffffffu, k < n && keep(static_cast<int>(k)));
      total += __popc(kept[r]);
    }
    if (total == 0) continue;
    if (lane == 0) index = atomicAdd(taken, total);
    index = __shfl_sync(0xffffffffu, index, 0);
#pragma unroll
    for (int r = 0; r < rounds; ++r) {
      if (kept[r] >> lane & 1)
        put(index + __popc(kept[r] & ((1u << lane) - 1)), static_cast<int>(first + r * lanes + lane));
      index += __popc(kept[r]);
    }
  }
}
/// Kernel of CudaExecutor::select; count() is evaluated on the device.
template <class Count, class Keep, class Put>
__global__ void select_kernel(Count count, int* taken, Keep keep, Put put) {
  begin_kernel();
  select_by_warps<8>(count(), taken, keep, put);
}

/// Cooperative operations of the threads of a CUDA block, with the functions documented at HostExecutor::Block.
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
  /// Calls f(row, column) for all rows and columns; a warp takes a row at a time.
  template <class F>
  __host__ __device__ void each(int rows, int columns, F f) const {
#ifdef __CUDA_ARCH__
    constexpr int lanes = 32;
    for (int row = threadIdx.x / lanes; row < rows; row += blockDim.x / lanes)
      for (int column = threadIdx.x % lanes; column < columns; column += lanes) f(row, column);
    __syncthreads();
#endif
  }
  template <int lanes = 8, class Count, class Value, class Finish>
  __host__ __device__ void sum_segments(int n, Count count, Value value, Finish finish) const {
#ifdef __CUDA_ARCH__
    const int at_once = blockDim.x / lanes, lane = threadIdx.x % lanes;
    for (int first = 0; first < n; first += at_once) {  // Equal numbers of rounds, because threads shuffle
      const int s = first + threadIdx.x / lanes, end = s < n ? count(s) : 0;
      decltype(value(0, 0)) sum{};
#pragma unroll 4
      for (int t = lane; t < end; t += lanes) sum += value(s, t);
      sum = sum_of_lanes<lanes>(sum);
      if (lane == 0 && s < n) finish(s, sum);
    }
    __syncthreads();
#endif
  }
  template <class Sum, class Value, class More, class Finish>
  __host__ __device__ void sum_pieces(const SegmentPieces& pieces, SegmentList listed, Sum* partial, Value value,
                                      More more, Finish finish) const {
    const int first = pieces.start[0];
    sum_segments(
        pieces.start[pieces.segments] - first, [&](int p) { return pieces.end[first + p] - pieces.begin[first + p]; },
        [&](int p, int t) { return value(pieces.begin[first + p] + t); },
        [&](int p, Sum sum) { partial[first + p] = sum; });
    sum_segments(
        listed.count, [&](int k) { return pieces.count(listed.segment[k]) + more.count(listed.segment[k]); },
        [&](int k, int t) {
          const int s = listed.segment[k], count = pieces.count(s);
          return t < count ? partial[pieces.start[s] + t] : more.value(s, t - count);
        },
        [&](int k, Sum sum) { finish(listed.segment[k], sum); });
  }
  template <class Sum, class Finish>
  __host__ __device__ void sum(const Sum& mine, Finish finish) const {
#ifdef __CUDA_ARCH__
    const Sum all = sum_of_block(mine);
    if (threadIdx.x == 0) finish(all);
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

/// Kernel of CudaExecutor::for_each_block: block b calls f(CudaBlock, b).
template <int threads, int at_once, class F>
__global__ void __launch_bounds__(threads, at_once) block_kernel(F f) {
  begin_kernel();
  f(CudaBlock{}, static_cast<int>(blockIdx.x));
}

/// Cooperative operations of all threads of a CUDA grid, with the functions documented at HostExecutor::Grid.
class CudaGrid {
 public:
  /// Calls f(k) for k = 0 ... n - 1, then waits for all threads of the grid. Successive groups of 32 indices belong to
  /// different blocks, so that a short loop uses all multiprocessors.
  template <class F>
  __host__ __device__ void each(int n, F f) const {
#ifdef __CUDA_ARCH__
    begin(n, f);
    cooperative_groups::this_grid().sync();
#endif
  }
  template <class Test, class F>
  __host__ __device__ void each_that(int n, Test test, F f) const {
#ifdef __CUDA_ARCH__
    constexpr int lanes = 32, tests_at_once = 4;
    const int warp = threadIdx.x / lanes * gridDim.x + blockIdx.x, all = gridDim.x * blockDim.x;
    for (int first = warp * lanes + threadIdx.x % lanes; first < n; first += tests_at_once * all) {
      bool found[tests_at_once];
#pragma unroll
      for (int i = 0; i < tests_at_once; ++i) found[i] = first + i * all < n && test(first + i * all);
#pragma unroll 1
      for (int i = 0; i < tests_at_once; ++i) {
        // Shifts the array, since registers cannot be indexed at run time.
        const bool now = found[0];
#pragma unroll
        for (int j = 1; j < tests_at_once; ++j) found[j - 1] = found[j];
        if (now) f(first + i * all);
      }
    }
    cooperative_groups::this_grid().sync();
#endif
  }
  template <class F>
  __host__ __device__ void begin(int n, F f) const {
#ifdef __CUDA_ARCH__
    constexpr int lanes = 32;
    const int warp = threadIdx.x / lanes * gridDim.x + blockIdx.x, all = gridDim.x * blockDim.x;
    for (int k = warp * lanes + threadIdx.x % lanes; k < n; k += all) f(k);
#endif
  }
  template <class F>
  __host__ __device__ void begin_last(int n, F f) const {
#ifdef __CUDA_ARCH__
    constexpr int lanes = 32;
    const int warp = threadIdx.x / lanes * gridDim.x + blockIdx.x, all = gridDim.x * blockDim.x;
    for (int k = all - 1 - warp * lanes - threadIdx.x % lanes; k < n; k += all) f(k);
#endif
  }
  template <class Keep, class Put>
  __host__ __device__ void select(int n, int* taken, Keep keep, Put put) const {
#ifdef __CUDA_ARCH__
    // Few rounds per warp keep all warps busy; for large n, more rounds reduce the contention for positions.
    if (n > 1 << 20)
      select_by_warps<8>(n, taken, keep, put);
    else
      select_by_warps<2>(n, taken, keep, put);
    cooperative_groups::this_grid().sync();
#endif
  }
};

/// Kernel of CudaExecutor::run_cooperative: calls f(CudaGrid).
template <int threads, class F>
__global__ void __launch_bounds__(threads) grid_kernel(F f) {
  f(CudaGrid{});
}

/// Kernel that sets the condition of a conditional node of a CUDA graph: its body is executed (again) if *flag is not
/// 0.
template <class Flag>
__global__ void condition_kernel(cudaGraphConditionalHandle condition, const Flag* flag) {
  begin_kernel();
  cudaGraphSetConditional(condition, *flag != 0);
}

/// Condition of CudaExecutor::repeat for its kernels: a call with the argument `go` sets whether the body is executed
/// again. It sets the condition of the CUDA graph or, if the host evaluates loops, *more.
struct CudaRepeatCondition {
  cudaGraphConditionalHandle condition{};
  int* more = nullptr;

  __host__ __device__ void operator()(bool go) const {
#ifdef __CUDA_ARCH__
    if (more)
      *more = go;
    else
      cudaGraphSetConditional(condition, go);
#endif
  }
};

/// Copies the k-th 4-byte word of `from` to `to`.
struct Copy {
  int* to;
  const int* from;
  __host__ __device__ void operator()(int k) const { to[k] = from[k]; }
};

/// Addition, as a function object for scans.
struct Plus {
  template <class T>
  __host__ __device__ T operator()(const T& a, const T& b) const {
    return a + b;
  }
};

}  // namespace lichtenberg::parallel
