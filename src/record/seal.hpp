#pragma once

#include <cstdint>
#include <optional>

#include "src/record/atomic_file.hpp"
#include "src/record/pages.hpp"

namespace lichtenberg {

/// Checksum that follows the last HDF5 byte of a result file or a segment, where HDF5 does not read: number of bytes
/// and their CRC-32. ResultFile verifies it before HDF5 reads any byte. If another program changes the file, the seal
/// is lost or no longer matches.
struct Seal {
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  friend bool operator==(const Seal&, const Seal&) = default;
};

/// Writes the seal (number of bytes and CRC-32) after the first `bytes` bytes of the file, and returns it.
Seal seal(NewFile& file, std::uint64_t bytes);

/// Verifies the seal at the end of a file and returns it; empty if there is none, because another program has written
/// the file. Throws hdf5::Error if the bytes do not match the seal, or if the HDF5 bytes end early or other bytes
/// follow them. Throws std::system_error if the file cannot be read.
std::optional<Seal> checked_seal(const OpenFile& file);

/// Writes an HDF5 file from memory to `path`, with its seal, through a NewFile. `check`: see NewFile::publish.
void write_sealed(
    const std::string& path, const hdf5::Pages& pages, const std::function<void()>& check = [] {});

}  // namespace lichtenberg
