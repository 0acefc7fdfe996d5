#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#define OMPI_SKIP_MPICXX 1  // hdf5.h includes mpi.h: leave out its C++ classes, which need a library of their own
#include <hdf5.h>

namespace lichtenberg::hdf5 {

/// The bytes of a file in memory. What nobody wrote reads as zeros and takes no memory: HDF5 may lay out datasets of
/// any size in it, whose bytes go to the disk by another way.
class Pages {
 public:
  std::uint64_t size() const { return size_; }
  void resize(std::uint64_t size) { size_ = size; }
  /// Beyond the end, zeros.
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  /// All that was written, in pieces in ascending order.
  void for_each(const std::function<void(std::uint64_t offset, std::span<const std::byte> bytes)>& visit) const;

 private:
  std::uint64_t size_ = 0;
  std::map<std::uint64_t, std::vector<std::byte>> pages_;  ///< by number
};

/// A property list by which H5Fcreate and H5Fopen work on these bytes, whatever the name; to be closed by the caller.
hid_t access_to(const std::shared_ptr<Pages>& pages);

}  // namespace lichtenberg::hdf5
