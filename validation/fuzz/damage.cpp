#include "validation/fuzz/damage.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "src/record/hdf5.hpp"

namespace lichtenberg::fuzz {
namespace {

using hdf5::Handle;
constexpr std::size_t footer_size = 24;  ///< src/record/seal.cpp
constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();

std::string sealed(std::string bytes) {
  const std::uint64_t count = bytes.size();
  const auto crc =
      static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(count)));
  std::array<char, footer_size> footer{'L', 'I', 'C', 'H', 'T', 'S', 'U', 'M'};
  std::memcpy(footer.data() + 8, &count, sizeof count);
  std::memcpy(footer.data() + 16, &crc, sizeof crc);
  return bytes.append(footer.data(), footer.size());
}

bool is_sealed(const std::string& file) {
  return file.size() > footer_size && file.compare(file.size() - footer_size, 8, "LICHTSUM") == 0;
}

void flip_bits(std::string& bytes, std::size_t begin, std::size_t length, std::size_t count, Dice& dice) {
  for (; count > 0; --count) {
    const std::size_t at = begin + dice.below(length);
    if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8)));
  }
}

/// Flips bits close to a mark of HDF5's structures.
void flip_structure(std::string& bytes, Dice& dice) {
  static const std::array<std::string, 6> marks{"TREE", "HEAP", "SNOD", "GCOL", "OHDR", "\x89HDF"};
  const std::size_t from = dice.below(bytes.size());
  std::size_t at = std::string::npos;
  for (std::size_t k = 0; k < marks.size() && at == std::string::npos; ++k) at = bytes.find(dice.of(marks), from);
  flip_bits(bytes, at == std::string::npos ? 0 : at, 200, 1 + dice.below(4), dice);
}

void change_bytes(std::string& bytes, Dice& dice) {
  static const std::array<std::size_t, 5> lengths{8, 64, 512, 4096, std::string::npos};
  const std::size_t at = dice.below(bytes.size()), length = std::min(dice.of(lengths), bytes.size() - at);
  switch (dice.below(7)) {
    case 0:
      return flip_bits(bytes, 0, bytes.size(), 1 + dice.below(20), dice);
    case 1:
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), length, '\0');
      return;
    case 2:
      for (std::size_t k = at; k < std::min(bytes.size(), at + 256); ++k) bytes[k] = static_cast<char>(dice.below(256));
      return;
    case 3:
      return bytes.resize(at);
    case 4: {  // exchanges two blocks
      const std::string first = bytes.substr(at, length);
      const std::size_t other = dice.below(bytes.size() - first.size() + 1);
      const std::string second = bytes.substr(other, first.size());
      bytes.replace(at, first.size(), second);
      bytes.replace(other, first.size(), first);
      return;
    }
    default:
      return flip_structure(bytes, dice);
  }
}

// ---- Damages by HDF5 ----

void add_objects(hid_t group, const std::string& path, std::vector<std::string>& found) {
  for (const std::string& name : hdf5::names(group)) {
    found.push_back(path + name);
    if (hdf5::is_group(group, name)) add_objects(hdf5::open_group(group, name), path + name + "/", found);
  }
}

bool is_dataset(hid_t file, const std::string& name) { return !hdf5::is_group(file, name); }

/// Replaces an object by a dataset, which keeps its attributes.
void replace(hid_t file, const std::string& name, hid_t type, const hdf5::Shape& shape, bool chunked = false) {
  const Handle old(H5Oopen(file, name.c_str(), H5P_DEFAULT));
  hdf5::check(H5Ldelete(file, name.c_str(), H5P_DEFAULT));
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  const hdf5::Shape chunk(shape.size(), 4);
  if (chunked && !shape.empty()) hdf5::check(H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data()));
  const Handle space = hdf5::dataspace(shape);
  const Handle made(H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, properties, H5P_DEFAULT));
  hdf5::copy_attributes(old, made);
}

void other_type(hid_t file, const std::string& name, Dice& dice) {
  const Handle text(H5Tcopy(H5T_C_S1)), pair(H5Tcreate(H5T_COMPOUND, 16));
  hdf5::check(H5Tset_size(text, dice.chance(0.5) ? 5 : H5T_VARIABLE));
  hdf5::check(H5Tinsert(pair, "a", 0, H5T_NATIVE_DOUBLE));
  const std::array<hid_t, 7> types{H5T_STD_I8LE, H5T_STD_U64LE, H5T_IEEE_F32LE, H5T_IEEE_F64BE,
                                   text,         pair,          H5T_STD_I32LE};
  replace(file, name, dice.of(types), hdf5::shape(file, name));
}

void other_shape(hid_t file, const std::string& name, Dice& dice) {
  hdf5::Shape shape = hdf5::shape(file, name);
  const Handle old(H5Dopen2(file, name.c_str(), H5P_DEFAULT)), type(H5Dget_type(old));
  if (shape.empty()) shape = {1};
  hsize_t& length = shape[dice.below(shape.size())];
  const std::array<hsize_t, 5> lengths{0, 1, length + 1, 2 * length, length > 0 ? length - 1 : 0};
  length = dice.of(lengths);
  if (dice.chance(0.2)) shape.erase(shape.begin());
  if (dice.chance(0.2)) shape.push_back(2);
  replace(file, name, type, shape);
}

void huge_shape(hid_t file, const std::string& name, Dice& dice) {
  hdf5::Shape shape(std::max<std::size_t>(1, hdf5::shape(file, name).size()), 4);
  static const std::array<hsize_t, 3> lengths{1000000, 1000000000, hsize_t{1} << 56};
  shape[0] = dice.of(lengths);
  replace(file, name, H5T_NATIVE_DOUBLE, shape, true);
}

void strange_numbers(hid_t file, const std::string& name, Dice& dice) {
  static const std::array<double, 11> numbers{nan,  infinity, -infinity, 1e308, -1e308,      0.0,
                                              -1.0, 1e-320,   7.0,       1e6,   2147483648.0};
  std::vector<double> values = hdf5::get<double>(file, name);
  const double value = dice.of(numbers);
  if (dice.chance(0.5))
    std::ranges::fill(values, value);
  else if (!values.empty())
    values[dice.below(values.size())] = value;
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT));
  hdf5::check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
}

void strange_attribute(hid_t file, const std::string& name, Dice& dice) {
  const Handle object(H5Oopen(file, name.c_str(), H5P_DEFAULT));
  const int count = H5Aget_num_attrs(object);
  if (count <= 0) return;
  const Handle attribute(H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC,
                                        dice.below(static_cast<std::size_t>(count)), H5P_DEFAULT, H5P_DEFAULT));
  std::array<char, 256> key{};
  hdf5::check(H5Aget_name(attribute, key.size(), key.data()));
  hdf5::check(H5Adelete(object, key.data()));
  switch (dice.below(6)) {
    case 0:
      return hdf5::put_attribute(object, key.data(), 3.5);
    case 1:
      return hdf5::put_attribute(object, key.data(), std::int64_t{-1});
    case 2:
      return hdf5::put_attribute(object, key.data(), std::string(dice.below(3000), 'x'));
    case 3:
      return hdf5::put_attribute(object, key.data(), std::vector<std::string>{"a", "\xff\xfe", ""});
    case 4:
      return hdf5::put_attribute(object, key.data(), std::int64_t{1} << dice.below(62));
    default:
      return;
  }
}

void strange_link(hid_t file, const std::string& name, Dice& dice) {
  hdf5::check(H5Ldelete(file, name.c_str(), H5P_DEFAULT));
  switch (dice.below(5)) {
    case 0:
      hdf5::check(H5Lcreate_soft(("/" + name).c_str(), file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
      return;
    case 1:
      hdf5::check(H5Lcreate_hard(file, "/", file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
      return;
    case 2:
      hdf5::check(H5Lcreate_external("/dev/zero", "/x", file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT));
      return;
    case 3:
      hdf5::open_group(file, name);
      return;
    default:
      return;
  }
}

void number_for_group(hid_t file, const std::string& name) {
  hdf5::check(H5Ldelete(file, name.c_str(), H5P_DEFAULT));
  hdf5::put(file, name, 4.0, "1");
}

void strange_scene(hid_t file, Dice& dice) {
  std::string text = hdf5::get_text(file, "scene/text");
  const std::size_t at = dice.below(text.size() + 1);
  switch (dice.below(4)) {
    case 0:
      text.resize(at);
      break;
    case 1:
      text.insert(at, "\x01");
      break;
    case 2:
      text.clear();
      break;
    default:
      for (char& c : text)
        if (c >= '1' && c <= '9' && dice.chance(0.05)) c = static_cast<char>('0' + dice.below(10));
  }
  hdf5::check(H5Ldelete(file, "scene/text", H5P_DEFAULT));
  hdf5::put_text(file, "scene/text", text);
}

void change_object(hid_t file, Dice& dice) {
  std::vector<std::string> objects;
  add_objects(file, "", objects);
  const std::string name = dice.of(objects);
  if (dice.chance(0.08) && hdf5::exists(file, "scene/text")) return strange_scene(file, dice);
  const std::size_t kind = dice.below(is_dataset(file, name) ? 8 : 3);
  if (kind == 0) return strange_link(file, name, dice);
  if (!is_dataset(file, name) && dice.chance(0.3)) return number_for_group(file, name);
  if (kind <= 2) return strange_attribute(file, name, dice);
  if (kind == 3) return other_type(file, name, dice);
  if (kind == 4) return other_shape(file, name, dice);
  if (kind == 5) return huge_shape(file, name, dice);
  strange_numbers(file, name, dice);
}

std::string with_changed_object(const std::string& bytes, Dice& dice) {
  const auto pages = std::make_shared<hdf5::Pages>();
  pages->resize(bytes.size());
  pages->write(0, std::as_bytes(std::span(bytes)));
  try {
    change_object(hdf5::open_in_memory(pages), dice);
  } catch (const hdf5::Error&) {  // numbers cannot be written to a text, for example
  }
  std::string changed(pages->size(), '\0');
  pages->read(0, std::as_writable_bytes(std::span(changed)));
  return changed;
}

}  // namespace

std::string damaged(const std::string& file, Dice& dice) {
  if (dice.chance(0.04)) {  // as a file whose end was not written before the machine stopped
    static const std::array<std::size_t, 5> lengths{8, 24, 100, 5000, std::string::npos};
    const std::size_t length = std::min(dice.of(lengths), file.size() / 2);
    return file.substr(0, file.size() - length).append(length, '\0');
  }
  const bool was_sealed = is_sealed(file);
  std::string bytes = was_sealed ? file.substr(0, file.size() - footer_size) : file;
  if (dice.chance(0.55))
    bytes = with_changed_object(bytes, dice);
  else
    change_bytes(bytes, dice);
  if (bytes.empty() || dice.chance(0.05)) return bytes;
  if (was_sealed && dice.chance(0.06)) {
    std::string footer = file.substr(file.size() - footer_size);
    if (dice.chance(0.5)) flip_bits(footer, 0, 8, 1, dice);  // its mark
    return bytes + footer;
  }
  return was_sealed ? sealed(std::move(bytes)) : bytes;
}

}  // namespace lichtenberg::fuzz
