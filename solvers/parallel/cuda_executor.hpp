#pragma once

#include <cuda_runtime.h>

#include <bit>
#include <cstring>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "solvers/parallel/cuda_device.hpp"
#include "solvers/parallel/cuda_kernels.hpp"
#include "solvers/parallel/host_executor.hpp"

namespace lichtenberg::parallel {

/// Launch mode of kernels. With in_turn a kernel is loaded after the preceding kernel has finished. With early it may
/// be loaded before and then waits in begin_kernel(); below compute capability 9 this is the same as in_turn.
enum class KernelStart { in_turn, early };

/// Executor for CUDA: runs loops, sums, scans, sorts and transfers of device algorithms on the current CUDA device, in
/// one stream. Only functions for concurrent work use further streams. The functions are documented at HostExecutor.
class CudaExecutor : public Communicator<CudaExecutor> {
 public:
  /// Prepares an executor on a stream, which may belong to another library; nullptr: the default stream. Throws Failure
  /// if a CUDA call fails, and the exceptions of cuda_loops_on_host().
  /// `link`: communication with other devices; null: one device.
  explicit CudaExecutor(cudaStream_t stream = nullptr, KernelStart start = KernelStart::in_turn,
                        std::shared_ptr<Link> link = nullptr)
      : Communicator(std::move(link)), stream_(stream) {
    recorder_ = make_stream(Priority::first);
    second_stream_ = make_stream(Priority::last);
    if (this->link()) stream_ = recorder_;  // Without recordings too, the near part must not delay the mesh.
    check_cuda(cudaEventCreateWithFlags(&fork_, cudaEventDisableTiming));
    check_cuda(cudaEventCreateWithFlags(&join_, cudaEventDisableTiming));
    check_cuda(cudaMallocHost(&pinned_, pinned_size));
    starts_early_ = start == KernelStart::early && device_attribute(cudaDevAttrComputeCapabilityMajor) >= 9;
    sums_ = allocate(2 * sizeof(int) + sums_size);
    fill(sums_, 0, 2 * sizeof(int) + sums_size);
    more_ = reinterpret_cast<int*>(static_cast<char*>(sums_) + sums_size) + 1;
  }
  CudaExecutor(const CudaExecutor&) = delete;
  CudaExecutor& operator=(const CudaExecutor&) = delete;
  ~CudaExecutor() {
    cudaStreamDestroy(recorder_);
    cudaStreamDestroy(second_stream_);
    cudaEventDestroy(fork_);
    cudaEventDestroy(join_);
    cudaFreeHost(pinned_);
    for (const Branch& branch : branches_) {
      if (branch.stream) cudaStreamDestroy(branch.stream);
      if (branch.end) cudaEventDestroy(branch.end);
      if (branch.scratch) cudaFree(branch.scratch);
      if (branch.sorted) cudaFree(branch.sorted);
    }
    cudaFree(sums_);
  }

  template <int threads = 256, class F>
  void for_each(long n, F f) const {
    if (n <= 0) return;
    launch(item_kernel<F>, static_cast<unsigned>((n + threads - 1) / threads), threads, 0, n, f);
  }

  template <class F>
  void for_each(int rows, int columns, F f) const {
    if (rows <= 0 || columns <= 0) return;
    const unsigned across = columns > 128 ? 256 : columns > 64 ? 128 : columns > 32 ? 64 : 32;
    const dim3 threads(across, 256 / across);
    // CUDA limits blocks in y to 65535. Rows are in x because a row has fewer blocks than there are rows.
    const dim3 blocks((rows + threads.y - 1) / threads.y, (columns + threads.x - 1) / threads.x);
    launch(row_kernel<F>, blocks, threads, 0, rows, columns, f);
  }

  using Block = CudaBlock;
  template <int threads = 128, int at_once = 0, class F>
  void for_each_block(int blocks, std::size_t bytes, F f) const {
    if (blocks <= 0) return;
    constexpr std::size_t unasked = 48 << 10;
    if (bytes > unasked)
      check_cuda(cudaFuncSetAttribute(block_kernel<threads, at_once, F>, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                      static_cast<int>(bytes)));
    launch(block_kernel<threads, at_once, F>, static_cast<unsigned>(blocks), threads, bytes, f);
  }
  std::size_t most_block_memory() const {
    return static_cast<std::size_t>(device_attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin));
  }

  using Grid = CudaGrid;
  template <class F>
  void run_cooperative(F f) const {
    constexpr int threads = 512;  // 128 registers each
    int blocks = 0;
    check_cuda(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, grid_kernel<threads, F>, threads, 0));
    void* arguments[] = {&f};
    check_cuda(cudaLaunchCooperativeKernel(
        reinterpret_cast<const void*>(&grid_kernel<threads, F>),
        dim3(static_cast<unsigned>(device_attribute(cudaDevAttrMultiProcessorCount) * blocks)), dim3(threads),
        arguments, 0, stream_));
  }

  template <class Count, class Keep, class Put>
  void select(long most, Count n, int* taken, Keep keep, Put put) const {
    if (most <= 0) return;
    constexpr long threads = 256, a_block = 8 * threads, blocks = 2048;
    const long wanted = (most + a_block - 1) / a_block;
    launch(select_kernel<Count, Keep, Put>, static_cast<unsigned>(wanted < blocks ? wanted : blocks), threads, 0, n,
           taken, keep, put);
  }

  template <int lanes = 32, class Count, class Value, class Finish>
  void sum_segments(long n, Count count, Value value, Finish finish) const {
    if (n <= 0) return;
    constexpr int threads = 128;
    launch(segment_kernel<lanes, Count, Value, Finish>, static_cast<unsigned>((lanes * n + threads - 1) / threads),
           threads, 0, n, count, value, finish);
  }
  template <class Sum, class Value, class More, class Finish>
  void sum_pieces(const SegmentPieces& pieces, Sum* partial, Value value, More more, Finish finish) const {
    constexpr long most_threads = 1 << 18;  // that a device holds at once; more lanes then wait less for memory
    const long items = static_cast<long>(pieces.capacity) + pieces.segments;
    if (32 * items <= most_threads)
      launch_pieces<32>(items, pieces, partial, value, more, finish);
    else
      launch_pieces<8>(items, pieces, partial, value, more, finish);
  }
  cudaStream_t stream() const { return stream_; }

  template <int a_thread = 4, class Value, class Finish>
  void sum(long n, Value value, Finish finish) const {
    using Sum = decltype(value(0));
    constexpr int threads = 512;
    static_assert(sizeof(Sum) <= sums_size / most_sums && alignof(Sum) <= alignof(double));
    const long wanted = (n + threads * a_thread - 1) / (threads * a_thread);
    const auto blocks = static_cast<unsigned>(wanted < 1 ? 1 : wanted < most_sums ? wanted : most_sums);
    auto* block_sums = static_cast<Sum*>(sums_);
    auto* done = reinterpret_cast<int*>(static_cast<char*>(sums_) + sums_size);
    launch(sum_kernel<threads, Sum, Value, Finish>, blocks, threads, 0, n, value, finish, block_sums, done);
  }

  template <class Value, class Finish>
  void sum(int rows, int columns, Value value, Finish finish) const {
    using Sum = decltype(value(0, 0));
    constexpr int threads = 256;
    static_assert(sizeof(Sum) <= sums_size / most_sums && alignof(Sum) <= alignof(double));
    const auto blocks = static_cast<unsigned>(rows < 1 ? 1 : rows < most_sums ? rows : most_sums);
    auto* block_sums = static_cast<Sum*>(sums_);
    auto* done = reinterpret_cast<int*>(static_cast<char*>(sums_) + sums_size);
    launch(row_sum_kernel<threads, Sum, Value, Finish>, blocks, threads, 0, rows, columns, value, finish, block_sums,
           done);
  }

  template <class T>
  void exclusive_scan(T* values, long n) const {
    const auto scan = [&](void* scratch, std::size_t& bytes) {
      return cub::DeviceScan::ExclusiveScan(scratch, bytes, values, values, Plus{}, T{}, n, stream_);
    };
    with_scratch(scan);
  }

  void sort(int* keys, int* values, int n, int largest = std::numeric_limits<int>::max()) const {
    if (n == 0) return;
    const std::size_t bytes = n * sizeof(int);
    Branch& branch = branches_[branch_];
    grow(branch.sorted, branch.sorted_size, 2 * bytes);
    int *sorted_keys = static_cast<int*>(branch.sorted), *sorted_values = sorted_keys + n;
    const int bits = std::bit_width(static_cast<unsigned>(largest));
    with_scratch([&](void* scratch, std::size_t& scratch_bytes) {
      return cub::DeviceRadixSort::SortPairs(scratch, scratch_bytes, keys, sorted_keys, values, sorted_values, n, 0,
                                             bits, stream_);
    });
    copy(keys, sorted_keys, bytes);
    copy(values, sorted_values, bytes);
  }

  std::size_t available_memory() const { return device_memory().available; }
  void check_memory(std::size_t bytes) const {
    if (const DeviceMemory now = device_memory(); bytes > now.available) refuse_memory(bytes, now);
  }
  void* allocate(std::size_t bytes) const {
    void* memory = nullptr;
    const cudaError_t code = cudaMalloc(&memory, bytes > 0 ? bytes : 1);
    if (code == cudaErrorMemoryAllocation) {
      cudaGetLastError();
      refuse_memory(bytes, device_memory());
    }
    check_cuda(code);
    return memory;
  }
  void release(void* memory) const { cudaFree(memory); }
  void fill(void* memory, int byte, std::size_t bytes) const {
    if (bytes > 0) check_cuda(cudaMemsetAsync(memory, byte, bytes, stream_));
  }
  void copy(void* to, const void* from, std::size_t bytes) const {
    if (bytes > 0) check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, stream_));
  }
  void to_device(void* to, const void* from, std::size_t bytes) const {
    check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_));
  }
  void to_host(void* to, const void* from, std::size_t bytes) const {
    const bool small = bytes <= pinned_size;
    check_cuda(cudaMemcpyAsync(small ? pinned_ : to, from, bytes, cudaMemcpyDeviceToHost, stream_));
    wait();
    if (small) std::memcpy(to, pinned_, bytes);
  }
  void* allocate_on_host(std::size_t bytes) const {
    void* memory = nullptr;
    check_cuda(cudaMallocHost(&memory, bytes));
    return memory;
  }
  void release_on_host(void* memory) const { cudaFreeHost(memory); }
  /// Starts a copy of small data from host to device. A kernel reads the host memory of allocate_on_host() directly,
  /// with a lower latency than the copy engines. The number of bytes must be a multiple of 4.
  void begin_to_device(void* to, const void* from, std::size_t bytes) const { copy_words(to, from, bytes); }
  /// Starts a copy of small data from device to host by a kernel. The number of bytes must be a multiple of 4.
  void begin_to_host(void* to, const void* from, std::size_t bytes) const { copy_words(to, from, bytes); }
  void wait() const { check_cuda(cudaStreamSynchronize(stream_)); }

  /// Recorded sequence of kernels: an instantiated CUDA graph, which launches many small kernels with less overhead.
  class Recording {
   public:
    Recording() = default;
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;
    ~Recording() { clear(); }
    /// Discards the graph; the next run() records again.
    void clear() {
      if (graph_) cudaGraphExecDestroy(std::exchange(graph_, nullptr));
    }

   private:
    friend class CudaExecutor;
    cudaGraphExec_t graph_ = nullptr;
  };

  /// Launches the recorded kernels of `recording`. If there are none yet, it first calls f and records the kernels that
  /// f launches as a CUDA graph; later calls do not call f. If the host evaluates loops (cuda_loops_on_host), f
  /// launches the kernels directly in each call, and also with several ranks.
  template <class F>
  void run(Recording& recording, F f) const {
    if (host_decides_ || link()) return f();
    if (!recording.graph_) {
      check_cuda(cudaStreamBeginCapture(recorder_, cudaStreamCaptureModeRelaxed));
      cudaStream_t stream = std::exchange(stream_, recorder_);
      f();
      stream_ = stream;
      cudaGraph_t graph = nullptr;
      check_cuda(cudaStreamEndCapture(recorder_, &graph));
      const cudaError_t code = cudaGraphInstantiate(&recording.graph_, graph, 0);
      cudaGraphDestroy(graph);
      check_cuda(code);
    }
    check_cuda(cudaGraphLaunch(recording.graph_, stream_));
  }

  template <class F>
  void when(const int* flag, F f) const {
    if (host_decides_) {
      if (value_of(flag)) f();
      return;
    }
    const cudaGraphConditionalHandle condition = make_condition();
    launch(condition_kernel<int>, 1, 1, 0, condition, flag);
    conditionally(cudaGraphCondTypeIf, condition, f);
  }
  template <class F>
  void repeat_while(const int* flag, F f) const {
    if (host_decides_) {
      while (value_of(flag)) f();
      return;
    }
    const cudaGraphConditionalHandle condition = make_condition();
    launch(condition_kernel<int>, 1, 1, 0, condition, flag);
    conditionally(cudaGraphCondTypeWhile, condition, [&] {
      f();
      launch(condition_kernel<int>, 1, 1, 0, condition, flag);
    });
  }
  using RepeatCondition = CudaRepeatCondition;
  template <class F>
  void repeat(F f) const {
    if (host_decides_) {
      do {
        fill(more_, 0, sizeof(int));
        f(RepeatCondition{.more = more_});
      } while (value_of(more_));
      return;
    }
    cudaGraphConditionalHandle condition{};
    check_cuda(cudaGraphConditionalHandleCreate(&condition, recorded().graph, 1, cudaGraphCondAssignDefault));
    conditionally(cudaGraphCondTypeWhile, condition, [&] { f(RepeatCondition{.condition = condition}); });
  }

  template <class F>
  void for_each_concurrently(int n, F f) const {
    while (static_cast<int>(branches_.size()) <= n) {
      Branch& branch = branches_.emplace_back();
      check_cuda(cudaStreamCreateWithFlags(&branch.stream, cudaStreamNonBlocking));
      check_cuda(cudaEventCreateWithFlags(&branch.end, cudaEventDisableTiming));
    }
    check_cuda(cudaEventRecord(fork_, stream_));
    cudaStream_t stream = stream_;
    for (int k = 0; k < n; ++k) {
      branch_ = k + 1;
      stream_ = branches_[branch_].stream;
      check_cuda(cudaStreamWaitEvent(stream_, fork_, 0));
      f(k);
      check_cuda(cudaEventRecord(branches_[branch_].end, stream_));
    }
    branch_ = 0;
    stream_ = stream;
    for (int k = 1; k <= n; ++k) check_cuda(cudaStreamWaitEvent(stream_, branches_[k].end, 0));
  }

  template <class F, class G>
  void run_concurrently(F f, G g) const {
    check_cuda(cudaEventRecord(fork_, stream_));
    check_cuda(cudaStreamWaitEvent(second_stream_, fork_, 0));
    f();
    cudaStream_t stream = std::exchange(stream_, second_stream_);
    g();
    stream_ = stream;
    check_cuda(cudaEventRecord(join_, second_stream_));
    check_cuda(cudaStreamWaitEvent(stream_, join_, 0));
  }

  using TimePoint = CudaTimePoint;
  void wait_until(const TimePoint& moment) const { check_cuda(cudaEventSynchronize(moment.event())); }
  void mark(TimePoint& moment) const { check_cuda(cudaEventRecord(moment.event(), stream_)); }

  template <class F>
  double seconds(F f) const {
    TimePoint start, end;
    wait();
    mark(start);
    f();
    mark(end);
    check_cuda(cudaEventSynchronize(end.event()));
    return end.seconds_since(start);
  }

 private:
  /// Priority of a stream when blocks of concurrent kernels compete for multiprocessors: highest or lowest.
  enum class Priority { first, last };
  static cudaStream_t make_stream(Priority priority) {
    int lowest = 0, highest = 0;
    check_cuda(cudaDeviceGetStreamPriorityRange(&lowest, &highest));
    cudaStream_t stream = nullptr;
    check_cuda(
        cudaStreamCreateWithPriority(&stream, cudaStreamNonBlocking, priority == Priority::first ? highest : lowest));
    return stream;
  }

  /// Graph that is being recorded, and the nodes on which the next recorded kernel will depend.
  struct Recorded {
    cudaGraph_t graph = nullptr;
    const cudaGraphNode_t* before = nullptr;
    const cudaGraphEdgeData* how = nullptr;
    std::size_t count = 0;
  };
  /// Returns the graph that is being recorded in the current stream. Throws Failure if there is none.
  Recorded recorded() const {
    Recorded now;
    cudaStreamCaptureStatus status = cudaStreamCaptureStatusNone;
    check_cuda(cudaStreamGetCaptureInfo(stream_, &status, nullptr, &now.graph, &now.before, &now.how, &now.count));
    if (status != cudaStreamCaptureStatusActive) throw Failure("CUDA device: a condition outside of a recording");
    return now;
  }
  /// Returns the value of a flag on the device, after all earlier kernels.
  int value_of(const int* flag) const {
    int value = 0;
    to_host(&value, flag, sizeof(int));
    return value;
  }
  cudaGraphConditionalHandle make_condition() const {
    cudaGraphConditionalHandle condition{};
    check_cuda(cudaGraphConditionalHandleCreate(&condition, recorded().graph, 0, 0));
    return condition;
  }
  /// Adds a conditional node (if or while) to the recorded graph, with the kernels that f launches as its body.
  template <class F>
  void conditionally(cudaGraphConditionalNodeType type, cudaGraphConditionalHandle condition, F f) const {
    cudaGraphNodeParams node{};
    node.type = cudaGraphNodeTypeConditional;
    node.conditional.handle = condition;
    node.conditional.type = type;
    node.conditional.size = 1;
    const Recorded now = recorded();
    cudaGraphNode_t added = nullptr;
    check_cuda(cudaGraphAddNode(&added, now.graph, now.before, now.how, now.count, &node));
    check_cuda(cudaStreamUpdateCaptureDependencies(stream_, &added, nullptr, 1, cudaStreamSetCaptureDependencies));
    // New streams, because a stream belongs to the recording in which it was used until that ends.
    cudaStream_t body = make_stream(Priority::first), second_body = make_stream(Priority::last);
    cudaGraph_t graph = node.conditional.phGraph_out[0];
    check_cuda(cudaStreamBeginCaptureToGraph(body, graph, nullptr, nullptr, 0, cudaStreamCaptureModeRelaxed));
    std::swap(stream_, body), std::swap(second_stream_, second_body);
    f();
    std::swap(stream_, body), std::swap(second_stream_, second_body);
    check_cuda(cudaStreamEndCapture(body, &graph));
    check_cuda(cudaStreamDestroy(body));
    check_cuda(cudaStreamDestroy(second_body));
  }

  /// Launches a kernel with `blocks` blocks of `threads` threads and `bytes` of dynamic shared memory per block. With
  /// KernelStart::early it may be loaded before earlier kernels have finished (begin_kernel).
  template <class... Parameters, class... Arguments>
  void launch(void (*kernel)(Parameters...), dim3 blocks, dim3 threads, std::size_t bytes,
              const Arguments&... arguments) const {
    cudaLaunchAttribute early{};
    early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    early.val.programmaticStreamSerializationAllowed = 1;
    cudaLaunchConfig_t how{};
    how.gridDim = blocks;
    how.blockDim = threads;
    how.dynamicSmemBytes = bytes;
    how.stream = stream_;
    how.attrs = &early;
    how.numAttrs = starts_early_;
    check_cuda(cudaLaunchKernelEx(&how, kernel, arguments...));
  }

  /// Launches the kernel of sum_pieces() with `lanes` threads for each of `items` pieces and segments.
  template <int lanes, class Sum, class Value, class More, class Finish>
  void launch_pieces(long items, const SegmentPieces& pieces, Sum* partial, Value value, More more,
                     Finish finish) const {
    if (items == 0) return;
    constexpr int threads = 128;
    launch(pieces_kernel<lanes, Sum, Value, More, Finish>,
           static_cast<unsigned>((lanes * items + threads - 1) / threads), threads, 0, pieces, partial, value, more,
           finish);
  }

  /// Copies bytes by a kernel, from and to memory that the device can access. The number of bytes must be a multiple of
  /// 4.
  void copy_words(void* to, const void* from, std::size_t bytes) const {
    auto* target = static_cast<int*>(to);
    const auto* source = static_cast<const int*>(from);
    for_each<32>(static_cast<long>(bytes / sizeof(int)), Copy{target, source});
  }

  /// Enlarges a block of device memory to at least `bytes`; its content is lost if it grows.
  void grow(void*& memory, std::size_t& size, std::size_t bytes) const {
    if (bytes <= size) return;
    if (memory) {
      wait();
      cudaFree(std::exchange(memory, nullptr));
    }
    size = 0;
    memory = allocate(bytes);
    size = bytes;
  }

  /// Calls a function of the library CUB twice, f(memory, bytes): the first call computes the temporary memory needed,
  /// the second executes the algorithm.
  template <class F>
  void with_scratch(F f) const {
    std::size_t bytes = 0;
    check_cuda(f(nullptr, bytes));
    Branch& branch = branches_[branch_];
    grow(branch.scratch, branch.scratch_size, bytes);
    check_cuda(f(branch.scratch, bytes));
  }

  static constexpr std::size_t pinned_size = 1 << 16;
  mutable cudaStream_t stream_ = nullptr, second_stream_ = nullptr;
  cudaStream_t recorder_ = nullptr;
  cudaEvent_t fork_ = nullptr, join_ = nullptr;
  bool starts_early_ = false;  // True if kernels may be loaded before preceding ones have finished
  void* pinned_ = nullptr;
  /// Stream and temporary memory of one call of f in for_each_concurrently(). The first element of `branches_` serves
  /// all other work.
  struct Branch {
    cudaStream_t stream = nullptr;
    cudaEvent_t end = nullptr;
    void *scratch = nullptr, *sorted = nullptr;
    std::size_t scratch_size = 0, sorted_size = 0;
  };
  mutable std::vector<Branch> branches_ = std::vector<Branch>(1);
  mutable int branch_ = 0;
  static constexpr long most_sums = 1024;
  static constexpr std::size_t sums_size = most_sums * 16 * sizeof(double);
  void* sums_ = nullptr;  // Sums of blocks, followed by the number of finished blocks
  int* more_ = nullptr;   // Last value given to RepeatCondition if the host evaluates loops; stored behind the sums
  bool host_decides_ = cuda_loops_on_host();
};

}  // namespace lichtenberg::parallel
