#include "src/record/seal.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "src/record/hdf5.hpp"

namespace lichtenberg {
namespace {

constexpr std::array<char, 8> magic{'L', 'I', 'C', 'H', 'T', 'S', 'U', 'M'};

/// Layout of the seal in the file, with little-endian numbers.
struct Footer {
  std::array<char, 8> magic{};
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0, reserved = 0;
};
static_assert(sizeof(Footer) == 24 && std::endian::native == std::endian::little);

/// Returns the CRC-32 of the first `bytes` of a file, read in blocks.
template <class File>
std::uint32_t crc_of(const File& file, std::uint64_t bytes) {
  std::vector<std::byte> block(1u << 20);
  uLong crc = crc32(0, nullptr, 0);
  for (std::uint64_t offset = 0; offset < bytes; offset += block.size()) {
    block.resize(std::min<std::uint64_t>(block.size(), bytes - offset));
    file.read(offset, block);
    crc = crc32(crc, reinterpret_cast<const Bytef*>(block.data()), static_cast<uInt>(block.size()));
  }
  return static_cast<std::uint32_t>(crc);
}

/// Returns the end of the file according to HDF5's superblock; empty for versions that HDF5 1.10 does not write.
std::optional<std::uint64_t> end_of_hdf5(const OpenFile& file) {
  std::array<std::uint8_t, 52> head{};
  if (file.size() < head.size()) return {};
  file.read(0, std::as_writable_bytes(std::span(head)));
  constexpr std::size_t version_at = 8;  // HDF5 File Format Specification, II.A: the superblock
  constexpr std::array<std::size_t, 4> width_at{13, 13, 9, 9}, end_at{40, 44, 28, 28};  // indexed by version
  const std::uint8_t version = head[version_at];
  if (version >= width_at.size() || head[width_at[version]] != sizeof(std::uint64_t)) return {};
  std::uint64_t end = 0;
  std::memcpy(&end, head.data() + end_at[version], sizeof end);
  return end;
}

/// Throws hdf5::Error if bytes are missing or follow the HDF5 bytes. A program without knowledge of the seal writes
/// only the HDF5 bytes.
void check_unsealed(const OpenFile& file) {
  const std::optional<std::uint64_t> end = end_of_hdf5(file);
  if (!end || *end == file.size()) return;
  throw hdf5::Error(*end > file.size() ? "its end is missing" : "the checksum at its end is damaged");
}

}  // namespace

Seal seal(NewFile& file, std::uint64_t bytes) {
  const Footer footer{magic, bytes, crc_of(file, bytes), 0};
  file.write(bytes, std::as_bytes(std::span(&footer, 1)));
  return {footer.bytes, footer.crc};
}

std::optional<Seal> checked_seal(const OpenFile& file) {
  Footer footer;
  if (file.size() < sizeof footer) return {};
  file.read(file.size() - sizeof footer, std::as_writable_bytes(std::span(&footer, 1)));
  if (footer.magic != magic) {
    check_unsealed(file);
    return {};
  }
  if (footer.reserved != 0 || footer.bytes != file.size() - sizeof footer || footer.crc != crc_of(file, footer.bytes))
    throw hdf5::Error("its bytes are not those that were written: the checksum differs");
  return Seal{footer.bytes, footer.crc};
}

void write_sealed(const std::string& path, const hdf5::Pages& pages, const std::function<void()>& check) {
  NewFile file(path);
  pages.for_each([&](std::uint64_t offset, std::span<const std::byte> bytes) { file.write(offset, bytes); });
  seal(file, pages.size());
  file.publish(check);
}

}  // namespace lichtenberg
