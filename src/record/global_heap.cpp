#include "src/record/global_heap.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "src/record/hdf5.hpp"

namespace lichtenberg::hdf5 {
namespace {

constexpr std::string_view signature("GCOL\1\0\0\0", 8);  // with version 1 and three reserved bytes
constexpr std::uint64_t header = 16;                      // B, header of a collection and of each object

[[noreturn]] void refuse() { throw Error("a collection of texts in it is broken"); }

std::uint64_t number_at(const OpenFile& file, std::uint64_t offset, std::size_t width) {
  std::uint64_t number = 0;
  file.read(offset, std::as_writable_bytes(std::span(&number, 1)).first(width));
  return number;
}

/// Returns the number of bytes from the header of the object at `offset` to the next object.
std::uint64_t object_length(const OpenFile& file, std::uint64_t offset) {
  const std::uint64_t index = number_at(file, offset, 2), size = number_at(file, offset + 8, 8);
  if (index == 0) return size;  // the size of free space includes its header
  const std::uint64_t padded = (size + 7) / 8 * 8;
  return padded < size ? 0 : header + padded;
}

void check_collection(const OpenFile& file, std::uint64_t begin) {
  const std::uint64_t available = file.size() - begin;
  if (available < header) refuse();
  const std::uint64_t size = number_at(file, begin + 8, 8);
  if (size > available) refuse();
  for (std::uint64_t at = header; at + header <= size;) {
    const std::uint64_t length = object_length(file, begin + at);
    if (length == 0 || length > size - at) refuse();
    at += length;
  }
}

}  // namespace

void check_global_heaps(const OpenFile& file) {
  constexpr std::uint64_t block = 1 << 20;
  std::vector<char> bytes;
  for (std::uint64_t begin = 0; begin + signature.size() <= file.size(); begin += block) {
    // The last bytes of a block are read again with the next block, because a signature may begin in them.
    bytes.resize(std::min(block + signature.size() - 1, file.size() - begin));
    file.read(begin, std::as_writable_bytes(std::span(bytes)));
    const std::string_view text(bytes.data(), bytes.size());
    for (std::size_t at = 0; (at = text.find(signature, at)) != text.npos; ++at) check_collection(file, begin + at);
  }
}

}  // namespace lichtenberg::hdf5
