#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace lichtenberg::parallel {

inline constexpr std::size_t huge_page = std::size_t{2} << 20;  ///< Bytes per huge page of x86-64 and most others

/// Requests huge pages from the operating system for memory that has not been written yet. Only pages that lie
/// completely within the `bytes` from `memory` are affected. The system may ignore the request. No effect on systems
/// other than Linux.
inline void request_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  const auto from = (reinterpret_cast<std::uintptr_t>(memory) + huge_page - 1) / huge_page * huge_page;
  const auto to = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / huge_page * huge_page;
  if (from < to) madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);
#endif
}

/// Resizes a vector. If it needs new memory and the values fill at least half of a huge page, requests huge pages for
/// this memory. The new memory then includes a reserve, so that a small increase does not move all values. Meant for
/// data that are kept between solves, because the system clears huge pages at each allocation.
template <class T>
void resize_in_huge_pages(std::vector<T>& values, std::size_t size) {
  if (values.capacity() < size && size * sizeof(T) >= huge_page / 2) {
    std::vector<T> larger;
    larger.reserve(size + size / 64 + huge_page / sizeof(T));
    request_huge_pages(larger.data(), larger.capacity() * sizeof(T));
    larger.assign(values.begin(), values.end());
    values = std::move(larger);
  }
  values.resize(size);
}

}  // namespace lichtenberg::parallel
