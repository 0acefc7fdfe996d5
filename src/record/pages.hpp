#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>

#define OMPI_SKIP_MPICXX 1  // a parallel hdf5.h includes mpi.h: leave out its C++ classes, a library of their own
#include <hdf5.h>

namespace lichtenberg::hdf5 {

/// The bytes that HDF5 takes for a file.
class Bytes {
 public:
  virtual ~Bytes() = default;
  virtual std::uint64_t size() const = 0;
  virtual void resize(std::uint64_t size) = 0;
  /// Beyond the end, zeros.
  virtual void read(std::uint64_t offset, std::span<std::byte> bytes) const = 0;
  virtual void write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
};

/// The bytes of a file in memory. What nobody wrote reads as zeros and takes no memory: HDF5 may lay out datasets of
/// any size in it, whose bytes go to the disk by another way.
class Pages : public Bytes {
 public:
  std::uint64_t size() const override { return size_; }
  void resize(std::uint64_t size) override { size_ = size; }
  void read(std::uint64_t offset, std::span<std::byte> bytes) const override;
  void write(std::uint64_t offset, std::span<const std::byte> bytes) override;
  /// All that was written, in pieces in ascending order.
  void for_each(const std::function<void(std::uint64_t offset, std::span<const std::byte> bytes)>& visit) const;

 private:
  std::uint64_t size_ = 0;
  struct Page;
  std::map<std::uint64_t, std::shared_ptr<Page>> pages_;  ///< by number; copies share what none of them has changed
};

/// H5Fcreate and H5Fopen on these bytes. An exception of theirs is an error of HDF5's.
hid_t create_file(const std::shared_ptr<Bytes>& bytes);
hid_t open_file(const std::shared_ptr<Bytes>& bytes, unsigned flags);

}  // namespace lichtenberg::hdf5
