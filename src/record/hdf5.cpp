#include "src/record/hdf5.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "src/record/global_heap.hpp"

namespace lichtenberg::hdf5 {
namespace {

/// Disables HDF5's printing of its error stack, which becomes an exception instead.
void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle text_type(size_t size) {
  Handle type(H5Tcopy(H5T_C_S1));
  check(H5Tset_size(type, size));
  if (size == H5T_VARIABLE) check(H5Tset_cset(type, H5T_CSET_UTF8));
  return type;
}

/// Returns the product of the lengths. Throws Error if memory cannot hold as many numbers.
hsize_t product(const Shape& shape) {
  constexpr hsize_t most = PTRDIFF_MAX / sizeof(double);
  hsize_t numbers = 1;
  for (const hsize_t length : shape) {
    if (length > 0 && numbers > most / length) throw Error("a dataset is larger than memory can be");
    numbers *= length;
  }
  return numbers;
}

void write_attribute(hid_t object, const std::string& name, hid_t type, const Shape& shape, const void* values) {
  if (check(H5Aexists(object, name.c_str())) > 0) check(H5Adelete(object, name.c_str()));
  const Handle space = dataspace(shape);
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT));
  check(H5Awrite(attribute, type, values));
}

void put_unit(hid_t dataset, const std::string& unit) {
  if (!unit.empty()) put_attribute(dataset, "unit", unit);
}

/// Returns the existing dataset if it has this shape, otherwise a new one.
Handle dataset_for(hid_t parent, const std::string& name, hid_t type, const Shape& wanted, const std::string& unit) {
  if (exists(parent, name)) {
    if (shape(parent, name) == wanted) return Handle(H5Dopen2(parent, name.c_str(), H5P_DEFAULT));
    check(H5Ldelete(parent, name.c_str(), H5P_DEFAULT));
  }
  const Handle space = dataspace(wanted);
  Handle dataset(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  put_unit(dataset, unit);
  return dataset;
}

/// A file on the disk, read only.
class FileBytes : public Bytes {
 public:
  explicit FileBytes(std::shared_ptr<const OpenFile> file) : file_(std::move(file)) {}
  std::uint64_t size() const override { return file_->size(); }
  void resize(std::uint64_t) override {}
  void read(std::uint64_t offset, std::span<std::byte> bytes) const override {
    const std::uint64_t there = std::min<std::uint64_t>(bytes.size(), offset < size() ? size() - offset : 0);
    file_->read(offset, bytes.first(there));
    std::ranges::fill(bytes.subspan(there), std::byte{0});
  }
  void write(std::uint64_t, std::span<const std::byte>) override { throw Error("the file is open to be read only"); }

 private:
  std::shared_ptr<const OpenFile> file_;
};

/// Stores the first message of the error stack. The traversal begins at the innermost call, whose message names the
/// cause.
herr_t keep_first_message(unsigned, const H5E_error2_t* entry, void* message) {
  auto& text = *static_cast<std::string*>(message);
  if (text.empty() && entry->desc != nullptr) text = entry->desc;
  return 0;
}

Handle open_dataset(hid_t parent, const std::string& name) {
  if (!exists(parent, name)) throw Error(name + " is missing");
  return Handle(H5Dopen2(parent, name.c_str(), H5P_DEFAULT));
}

Shape dataset_shape(hid_t dataset) {
  const Handle space(H5Dget_space(dataset));
  Shape result(static_cast<size_t>(check(H5Sget_simple_extent_ndims(space))));
  check(H5Sget_simple_extent_dims(space, result.data(), nullptr));
  return result;
}

/// Checks that an attribute or dataset has one element of the wanted class. HDF5 would otherwise read beyond the memory
/// of one element. Throws Error.
void check_single(hid_t space, hid_t type, H5T_class_t wanted, const std::string& name) {
  if (H5Tget_class(type) != wanted || H5Sget_simple_extent_npoints(space) != 1)
    throw Error(fmt::format("{} is not one {}", name, wanted == H5T_STRING ? "text" : "whole number"));
}

void check_attribute(hid_t attribute, H5T_class_t wanted, const std::string& name) {
  check_single(Handle(H5Aget_space(attribute)), Handle(H5Aget_type(attribute)), wanted, name);
}

/// Throws Error for a shape that a dataset's stored bytes cannot fill, before memory is allocated for it.
void check_bytes(hid_t dataset, const Shape& shape, const std::string& name) {
  constexpr hsize_t expansion = 1032;  // deflate's largest (zlib, "Maximum Expansion Factor")
  constexpr hsize_t few =
      1u << 23;  // any machine has memory for this; the size of a chunked dataset takes time to determine
  if (product(shape) < few) return;
  const Handle creation(H5Dget_create_plist(dataset)), type(H5Dget_type(dataset));
  if (H5Pget_layout(creation) == H5D_VIRTUAL) return;  // virtual datasets store their bytes in other files
  if (product(shape) / expansion > H5Dget_storage_size(dataset) / std::max<hsize_t>(H5Tget_size(type), 1))
    throw Error(name + " has more numbers than bytes that hold them");
}

/// Copies a text that HDF5 has allocated and frees HDF5's memory.
std::string taken(char* value) {
  const std::string text = value == nullptr ? "" : value;
  H5free_memory(value);
  return text;
}

}  // namespace

void throw_error_stack() {
  std::string message;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first_message, &message);
  throw Error(message.empty() ? "HDF5 gave no reason" : message);
}

Handle dataspace(const Shape& shape) {
  if (shape.empty()) return Handle(H5Screate(H5S_SCALAR));
  return Handle(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr));
}

bool is_hdf5(const OpenFile& file) {
  constexpr std::array<unsigned char, 8> signature{0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  std::array<unsigned char, 8> first{};
  if (file.size() < first.size()) return false;
  file.read(0, std::as_writable_bytes(std::span(first)));
  return first == signature;
}

Handle create_in_memory(const std::shared_ptr<Pages>& pages) {
  silence();
  *pages = {};
  return Handle(create_file(pages));
}

Handle open_in_memory(const std::shared_ptr<Pages>& pages) {
  silence();
  return Handle(open_file(pages, H5F_ACC_RDWR));
}

Pages pages_of(const OpenFile& file) {
  constexpr std::uint64_t block = 1u << 20;
  Pages pages;
  std::vector<std::byte> bytes;
  for (std::uint64_t offset = 0; offset < file.size(); offset += block) {
    bytes.resize(std::min(block, file.size() - offset));
    file.read(offset, bytes);
    pages.write(offset, bytes);
  }
  return pages;
}

Handle load(const std::string& path) { return open_in_memory(std::make_shared<Pages>(pages_of(OpenFile(path)))); }

Handle open(const std::shared_ptr<const OpenFile>& file) {
  silence();
  check_global_heaps(*file);
  return Handle(open_file(std::make_shared<FileBytes>(file), H5F_ACC_RDONLY));
}

std::vector<std::byte> image(const Handle& file) {
  check(H5Fflush(file, H5F_SCOPE_GLOBAL));
  std::vector<std::byte> bytes(static_cast<size_t>(check(H5Fget_file_image(file, nullptr, 0))));
  check(H5Fget_file_image(file, bytes.data(), bytes.size()));
  return bytes;
}

Handle open_group(hid_t parent, const std::string& path) {
  if (exists(parent, path)) return Handle(H5Gopen2(parent, path.c_str(), H5P_DEFAULT));
  const Handle creation(H5Pcreate(H5P_LINK_CREATE));
  check(H5Pset_create_intermediate_group(creation, 1));
  return Handle(H5Gcreate2(parent, path.c_str(), creation, H5P_DEFAULT, H5P_DEFAULT));
}

bool exists(hid_t parent, const std::string& path) {
  // HDF5 requires every parent group to exist before it tests the last link.
  for (size_t slash = path.find('/', 1); slash != std::string::npos; slash = path.find('/', slash + 1))
    if (check(H5Lexists(parent, path.substr(0, slash).c_str(), H5P_DEFAULT)) == 0) return false;
  return check(H5Lexists(parent, path.c_str(), H5P_DEFAULT)) > 0;
}

bool is_group(hid_t parent, const std::string& path) {
  const Handle object(H5Oopen(parent, path.c_str(), H5P_DEFAULT));
  return H5Iget_type(object) == H5I_GROUP;
}

std::vector<std::string> names(hid_t group) {
  std::vector<std::string> result;
  const auto keep = [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(name);
    return 0;
  };
  check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, keep, &result));
  return result;
}

void put_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Handle type = text_type(H5T_VARIABLE);
  const char* value = text.c_str();
  write_attribute(object, name, type, {}, &value);
}

void put_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
  const Handle type = text_type(H5T_VARIABLE);
  std::vector<const char*> values;
  for (const std::string& text : texts) values.push_back(text.c_str());
  write_attribute(object, name, type, {values.size()}, values.data());
}

std::string text(hid_t object, const std::string& name) {
  if (check(H5Aexists(object, name.c_str())) == 0) return "";
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT)), type = text_type(H5T_VARIABLE);
  check_attribute(attribute, H5T_STRING, name);
  char* value = nullptr;
  check(H5Aread(attribute, type, &value));
  return taken(value);
}

std::vector<std::string> text_attribute(hid_t object, const std::string& name) {
  if (check(H5Aexists(object, name.c_str())) == 0) return {};
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT)), space(H5Aget_space(attribute));
  const Handle type = text_type(H5T_VARIABLE), stored(H5Aget_type(attribute));
  constexpr hssize_t most = 1 << 20;
  const hssize_t count = check(H5Sget_simple_extent_npoints(space));
  if (H5Tget_class(stored) != H5T_STRING || count > most) throw Error(name + " is no list of texts");
  std::vector<char*> values(static_cast<std::size_t>(count), nullptr);
  check(H5Aread(attribute, type, values.data()));
  std::vector<std::string> texts;
  for (char* value : values) texts.push_back(taken(value));
  return texts;
}

void copy_attributes(hid_t from, hid_t to) {
  const int count = check(H5Aget_num_attrs(from));
  for (int k = 0; k < count; ++k) {
    const Handle old(
        H5Aopen_by_idx(from, ".", H5_INDEX_NAME, H5_ITER_INC, static_cast<hsize_t>(k), H5P_DEFAULT, H5P_DEFAULT));
    const Handle type(H5Aget_type(old)), space(H5Aget_space(old));
    std::string name(static_cast<std::size_t>(check(H5Aget_name(old, 0, nullptr))), '\0');
    check(H5Aget_name(old, name.size() + 1, name.data()));
    std::vector<std::byte> values(static_cast<std::size_t>(check(H5Sget_simple_extent_npoints(space))) *
                                  H5Tget_size(type));
    check(H5Aread(old, type, values.data()));
    const Handle copy(H5Acreate2(to, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT));
    const herr_t written = H5Awrite(copy, type, values.data());
    check(H5Dvlen_reclaim(type, space, H5P_DEFAULT, values.data()));
    check(written);
  }
}

std::optional<int> integer_attribute(hid_t object, const std::string& name) {
  if (check(H5Aexists(object, name.c_str())) == 0) return {};
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT));
  check_attribute(attribute, H5T_INTEGER, name);
  int value = 0;
  check(H5Aread(attribute, H5T_NATIVE_INT, &value));
  return value;
}

void put_fixed_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Handle type = text_type(text.size());
  write_attribute(object, name, type, {}, text.data());
}

template <class Number>
void put_attribute(hid_t object, const std::string& name, std::span<const Number> numbers, const Shape& shape) {
  write_attribute(object, name, native<Number>(), shape, numbers.data());
}

template <class Number>
void put(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
         const std::string& unit) {
  const Handle dataset = dataset_for(parent, name, native<Number>(), shape, unit);
  check(H5Dwrite(dataset, native<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
}

template <class Number>
void put_compressed(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
                    const Compression& stored, const std::string& unit) {
  const auto& [chunk, type] = stored;
  constexpr unsigned fastest = 1;  // deflate level
  if (exists(parent, name)) check(H5Ldelete(parent, name.c_str(), H5P_DEFAULT));
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE)), space = dataspace(shape);
  check(H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data()));
  check(H5Pset_shuffle(creation));
  check(H5Pset_deflate(creation, fastest));
  const Handle dataset(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT));
  put_attribute(dataset, "unit", unit);
  check(H5Dwrite(dataset, native<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
}

void put_text(hid_t parent, const std::string& name, const std::string& text) {
  const Handle type = text_type(H5T_VARIABLE);
  const Handle dataset = dataset_for(parent, name, type, {}, "");
  const char* value = text.c_str();
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value));
}

template <class Number>
std::vector<Number> get(hid_t parent, const std::string& name) {
  const Handle dataset = open_dataset(parent, name);
  const Shape wanted = dataset_shape(dataset);
  check_bytes(dataset, wanted, name);
  std::vector<Number> numbers(product(wanted));
  check(H5Dread(dataset, native<Number>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
  return numbers;
}

template <class Number>
std::vector<Number> get_rows(hid_t parent, const std::string& name, hsize_t first, hsize_t count) {
  const Handle dataset = open_dataset(parent, name);
  Shape wanted = dataset_shape(dataset), start(wanted.size(), 0);
  if (wanted.empty() || count > wanted[0] || first > wanted[0] - count)
    throw Error(name + (!wanted.empty() && wanted[0] == 0 ? " is empty" : " has fewer rows than frames"));
  check_bytes(dataset, wanted, name);
  start[0] = first;
  wanted[0] = count;
  std::vector<Number> numbers(product(wanted));
  const Handle source(H5Dget_space(dataset)), target = dataspace(wanted);
  check(H5Sselect_hyperslab(source, H5S_SELECT_SET, start.data(), nullptr, wanted.data(), nullptr));
  check(H5Dread(dataset, native<Number>(), target, source, H5P_DEFAULT, numbers.data()));
  return numbers;
}

std::string get_text(hid_t parent, const std::string& name) {
  const Handle dataset = open_dataset(parent, name), type = text_type(H5T_VARIABLE);
  check_single(Handle(H5Dget_space(dataset)), Handle(H5Dget_type(dataset)), H5T_STRING, name);
  char* value = nullptr;
  check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value));
  return taken(value);
}

Shape shape(hid_t parent, const std::string& name) { return dataset_shape(open_dataset(parent, name)); }

hsize_t row_count(hid_t parent, const std::string& name) {
  const Shape lengths = shape(parent, name);
  if (lengths.empty()) throw Error(name + " has no rows");
  return lengths.front();
}

#define FOR_NUMBER(Number)                                                                                           \
  template void put_attribute(hid_t, const std::string&, std::span<const Number>, const Shape&);                     \
  template void put(hid_t, const std::string&, std::span<const Number>, const Shape&, const std::string&);           \
  template void put_compressed(hid_t, const std::string&, std::span<const Number>, const Shape&, const Compression&, \
                               const std::string&);                                                                  \
  template std::vector<Number> get(hid_t, const std::string&);                                                       \
  template std::vector<Number> get_rows(hid_t, const std::string&, hsize_t, hsize_t);
FOR_NUMBER(double)
FOR_NUMBER(std::int32_t)
FOR_NUMBER(std::int64_t)
FOR_NUMBER(std::uint64_t)
#undef FOR_NUMBER

}  // namespace lichtenberg::hdf5
