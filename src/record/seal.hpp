#pragma once

#include <cstdint>
#include <optional>

#include "src/record/atomic_file.hpp"
#include "src/record/pages.hpp"

namespace lichtenberg {

/// What stands behind the last byte of HDF5's in every file of ours, where HDF5 does not look: how many bytes there are
/// and their CRC-32. Readers of ours check it before HDF5 sees a byte; another program that changes the file drops it.
struct Seal {
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  friend bool operator==(const Seal&, const Seal&) = default;
};

/// Puts the seal behind the first `bytes` of the file.
Seal seal(NewFile& file, std::uint64_t bytes);

/// The seal at the end of a file; none: another program has written it. Throws hdf5::Error if the bytes are not those
/// that were sealed, or if bytes follow HDF5's that are no seal.
std::optional<Seal> checked_seal(const OpenFile& file);

/// Writes a file of HDF5's with its seal. `check` as for NewFile::publish.
void write_sealed(
    const std::string& path, const hdf5::Pages& pages, const std::function<void()>& check = [] {});

}  // namespace lichtenberg
