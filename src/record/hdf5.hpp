#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/record/atomic_file.hpp"
#include "src/record/pages.hpp"

/// Wrapper of the HDF5 C API with identifiers that close themselves and errors that are exceptions.
///
/// Files are built in memory and written to disk by NewFile. HDF5 1.10 crashes, when a file is closed or the program
/// ends, after a write that failed for lack of space. Therefore HDF5 never writes to the disk itself, and it locks no
/// file.
namespace lichtenberg::hdf5 {

/// Exception of a failed HDF5 call or of a file with invalid contents. For a failed call `what()` is the innermost
/// message of HDF5's error stack.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws Error with the innermost message of HDF5's error stack.
[[noreturn]] void throw_error_stack();

/// Returns an HDF5 call's result, or throws Error if it is negative.
template <class Result>
Result check(Result result) {
  if (result < 0) throw_error_stack();
  return result;
}

/// Owner of one HDF5 identifier (file, group, dataset, attribute, dataspace, datatype or property list), which it
/// closes.
class Handle {
 public:
  /// Takes over an identifier. Throws Error if `id` is the result of a failed call.
  explicit Handle(hid_t id) : id_(check(id)) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
};

/// Returns true if the file begins with the HDF5 signature.
bool is_hdf5(const OpenFile& file);
/// Creates an empty HDF5 file in memory and returns its handle. Earlier contents of `pages` are discarded; it contains
/// the bytes of the file once the handle is closed.
Handle create_in_memory(const std::shared_ptr<Pages>& pages = std::make_shared<Pages>());
/// Opens the HDF5 file with the bytes `pages` for reading and writing. The bytes are complete once the handle is
/// closed.
Handle open_in_memory(const std::shared_ptr<Pages>& pages);
/// Opens a copy in memory of the file at `path`. Changes to it never reach the disk.
Handle load(const std::string& path);
/// Reads all bytes of a file on the disk into memory.
Pages pages_of(const OpenFile& file);
/// Opens a file on the disk for reading; it stays open as long as the handle. The function uses no file name and no
/// lock. Throws Error for files on which HDF5 would not return (check_global_heaps).
Handle open(const std::shared_ptr<const OpenFile>& file);
/// Returns the bytes that an open file in memory would have on disk.
std::vector<std::byte> image(const Handle& file);

/// Opens the group at `path` below `parent`. Creates it and all missing parents if it does not exist.
Handle open_group(hid_t parent, const std::string& path);
/// Returns true if an object exists at `path` below `parent`.
bool exists(hid_t parent, const std::string& path);
/// Returns true if the object at `path` below `parent` is a group. Throws Error if there is no object.
bool is_group(hid_t parent, const std::string& path);
/// Returns the names of the objects in a group, in alphabetical order.
std::vector<std::string> names(hid_t group);

/// Lengths of an array's dimensions, the last index fastest; empty for a single value.
using Shape = std::vector<hsize_t>;
/// Creates the HDF5 dataspace of arrays of this shape; an empty shape is that of a single value.
Handle dataspace(const Shape& shape);

/// Returns HDF5's type identifier of a number in memory.
template <class Number>
hid_t native() {
  if constexpr (std::is_same_v<Number, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<Number, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<Number, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<Number, std::uint64_t>) return H5T_NATIVE_UINT64;
}

// Attributes. Text is UTF-8 of variable length, as h5py and the readers of H5MD expect it.
void put_attribute(hid_t object, const std::string& name, const std::string& text);
void put_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);
/// Writes an attribute with a text of fixed length, as readers of VTKHDF expect it.
void put_fixed_attribute(hid_t object, const std::string& name, const std::string& text);
template <class Number>
void put_attribute(hid_t object, const std::string& name, std::span<const Number> numbers, const Shape& shape);
template <class Number>
requires std::is_arithmetic_v<Number>
void put_attribute(hid_t object, const std::string& name, Number number) {
  put_attribute(object, name, std::span<const Number>(&number, 1), {});
}
/// Copies all attributes of an object to another object, which may be in another file.
void copy_attributes(hid_t from, hid_t to);
/// Returns the integer of the attribute `name`; empty if there is no attribute of this name. Throws Error if it is no
/// single integer.
std::optional<int> integer_attribute(hid_t object, const std::string& name);
/// Returns the text of the attribute `name`; an empty text if there is no attribute of this name. Throws Error if it is
/// no single text.
std::string text(hid_t object, const std::string& name);
/// Returns the list of texts of the attribute `name`; empty if there is no attribute of this name. Throws Error if it
/// is no list of texts.
std::vector<std::string> text_attribute(hid_t object, const std::string& name);

/// Writes a dataset with an attribute `unit`; an empty unit writes none. A dataset of the same name and shape is
/// overwritten in place, which keeps the file from growing, and keeps its unit. A dataset of another shape is replaced.
template <class Number>
void put(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
         const std::string& unit);
/// Storage of a compressed dataset: shape of its chunks, and type of its numbers.
struct Compression {
  Shape chunk;
  hid_t type;  ///< type of the numbers in the file: H5T_IEEE_F32LE, say
};
/// Writes a dataset that is compressed in chunks (deflate after a byte shuffle). It replaces an existing dataset.
template <class Number>
void put_compressed(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
                    const Compression& stored, const std::string& unit);
/// Writes a single number as a dataset with a unit.
template <class Number>
requires std::is_arithmetic_v<Number>
void put(hid_t parent, const std::string& name, Number number, const std::string& unit) {
  put(parent, name, std::span<const Number>(&number, 1), {}, unit);
}
/// Writes a text as a dataset of one value.
void put_text(hid_t parent, const std::string& name, const std::string& text);

/// Reads all numbers of a dataset, the last index fastest. Numbers of another stored type are converted. Throws Error
/// if the dataset is missing or damaged.
template <class Number>
std::vector<Number> get(hid_t parent, const std::string& name);
/// Reads `count` rows of a dataset (elements of its first dimension) from row `first`, converted as in get(). Throws
/// Error if the dataset has fewer rows.
template <class Number>
std::vector<Number> get_rows(hid_t parent, const std::string& name, hsize_t first, hsize_t count);
/// Reads the text of a dataset. Throws Error if it is missing or no single text.
std::string get_text(hid_t parent, const std::string& name);
/// Returns the shape of a dataset. Throws Error if it is missing.
Shape shape(hid_t parent, const std::string& name);
/// Returns the number of rows of a dataset (elements of its first dimension). Throws Error if it is missing or has no
/// dimension.
hsize_t row_count(hid_t parent, const std::string& name);
/// Returns the only one of the numbers read from `name`. Throws Error if they are none or several.
template <class Number>
Number single(const std::vector<Number>& numbers, const std::string& name) {
  if (numbers.size() != 1)
    throw Error(name + " has " + std::to_string(numbers.size()) + " numbers where there should be one");
  return numbers.front();
}

}  // namespace lichtenberg::hdf5
