#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>

// A parallel hdf5.h includes mpi.h, whose C++ classes would need a separate library.
#define OMPI_SKIP_MPICXX 1
#include <hdf5.h>

namespace lichtenberg::hdf5 {

/// Interface of the bytes of a file that HDF5 reads and writes.
class Bytes {
 public:
  virtual ~Bytes() = default;
  virtual std::uint64_t size() const = 0;
  virtual void resize(std::uint64_t size) = 0;
  /// Reads bytes at an offset (bytes); bytes beyond the end are zeros.
  virtual void read(std::uint64_t offset, std::span<std::byte> bytes) const = 0;
  /// Writes bytes at an offset (bytes).
  virtual void write(std::uint64_t offset, std::span<const std::byte> bytes) = 0;
};

/// Bytes of a file in memory, in pages of 1 MiB. Pages without written bytes read as zeros and take no memory. HDF5 can
/// therefore allocate large datasets in the file, while other functions write their numbers directly to the disk.
class Pages : public Bytes {
 public:
  std::uint64_t size() const override { return size_; }
  void resize(std::uint64_t size) override { size_ = size; }
  void read(std::uint64_t offset, std::span<std::byte> bytes) const override;
  void write(std::uint64_t offset, std::span<const std::byte> bytes) override;
  /// Calls visit(offset, bytes) for each page that has been written, in ascending order.
  void for_each(const std::function<void(std::uint64_t offset, std::span<const std::byte> bytes)>& visit) const;

 private:
  std::uint64_t size_ = 0;
  struct Page;
  /// Pages by number; copies of this object share pages that neither has changed
  std::map<std::uint64_t, std::shared_ptr<Page>> pages_;
};

/// Creates an HDF5 file in these bytes (H5Fcreate). Exceptions of `bytes` become HDF5 errors.
hid_t create_file(const std::shared_ptr<Bytes>& bytes);
/// Opens the HDF5 file in these bytes (H5Fopen with its flags). Exceptions of `bytes` become HDF5 errors.
hid_t open_file(const std::shared_ptr<Bytes>& bytes, unsigned flags);

}  // namespace lichtenberg::hdf5
