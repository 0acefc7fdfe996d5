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

/// The HDF5 C API with identifiers that close themselves and errors that are exceptions.
///
/// Files are built in memory and written to disk by NewFile: HDF5 1.10 crashes, when a file is closed or the program
/// ends, after a write that failed for lack of space, so it never writes to the disk itself. Nor does it lock a file.
namespace lichtenberg::hdf5 {

/// An HDF5 call failed; what() is the innermost message of HDF5's error stack.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] void throw_error_stack();

/// Hands an HDF5 call's result on, or throws Error if it is negative.
template <class Result>
Result check(Result result) {
  if (result < 0) throw_error_stack();
  return result;
}

/// Owns one identifier: file, group, dataset, attribute, dataspace, datatype or property list.
class Handle {
 public:
  /// Throws Error if `id` is what a failed call returned.
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

/// Whether the file begins as an HDF5 file does.
bool is_hdf5(const OpenFile& file);
/// A new, empty file in memory.
Handle create_in_memory(const std::shared_ptr<Pages>& pages = std::make_shared<Pages>());
/// The file whose bytes these are, to read and to write; they are whole once the handle is closed.
Handle open_in_memory(const std::shared_ptr<Pages>& pages);
/// A copy in memory of a file: changes to it never reach the disk.
Handle load(const std::string& path);
/// All bytes of a file on the disk.
Pages pages_of(const OpenFile& file);
/// A file on the disk, to read, which stays open as long as the handle. No name is looked up and no lock is taken.
/// Throws Error for what HDF5 would not return from (global_heap.hpp).
Handle open(const std::shared_ptr<const OpenFile>& file);
/// The bytes that a file in memory would have on disk.
std::vector<std::byte> image(const Handle& file);

/// The group at `path` below `parent`, made with all groups above it unless it exists.
Handle open_group(hid_t parent, const std::string& path);
/// Whether something stands at `path` below `parent`.
bool exists(hid_t parent, const std::string& path);
/// Whether that is a group.
bool is_group(hid_t parent, const std::string& path);
/// Names of what stands in a group, in alphabetical order.
std::vector<std::string> names(hid_t group);

using Shape = std::vector<hsize_t>;

/// HDF5's type of a number in memory.
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
/// An attribute whose text is of fixed length: what the readers of VTKHDF expect.
void put_fixed_attribute(hid_t object, const std::string& name, const std::string& text);
template <class Number>
void put_attribute(hid_t object, const std::string& name, std::span<const Number> numbers, const Shape& shape);
template <class Number>
requires std::is_arithmetic_v<Number>
void put_attribute(hid_t object, const std::string& name, Number number) {
  put_attribute(object, name, std::span<const Number>(&number, 1), {});
}
/// All attributes of an object, to one of any file.
void copy_attributes(hid_t from, hid_t to);
/// Empty if there is no attribute of this name.
std::optional<int> integer_attribute(hid_t object, const std::string& name);
/// A text, as put_attribute writes it; empty if there is no attribute of this name.
std::string text(hid_t object, const std::string& name);
/// A list of texts, as put_attribute writes it; empty if there is no attribute of this name.
std::vector<std::string> text_attribute(hid_t object, const std::string& name);

/// Writes a dataset: into the one of the same name if it has the same shape, which keeps the file from growing, or
/// instead of it. An empty unit writes no `unit` attribute.
template <class Number>
void put(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
         const std::string& unit);
struct Compression {
  Shape chunk;
  hid_t type;  ///< of the numbers in the file: H5T_IEEE_F32LE, say
};
/// The same, compressed chunk by chunk; always a new dataset.
template <class Number>
void put_compressed(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
                    const Compression& stored, const std::string& unit);
template <class Number>
requires std::is_arithmetic_v<Number>
void put(hid_t parent, const std::string& name, Number number, const std::string& unit) {
  put(parent, name, std::span<const Number>(&number, 1), {}, unit);
}
void put_text(hid_t parent, const std::string& name, const std::string& text);

/// All numbers of a dataset, the last index fastest, converted if they are stored as another type.
template <class Number>
std::vector<Number> get(hid_t parent, const std::string& name);
/// `count` rows of a dataset from `first` on, converted as in `get`. Throws Error if the dataset has not as many.
template <class Number>
std::vector<Number> get_rows(hid_t parent, const std::string& name, hsize_t first, hsize_t count);
std::string get_text(hid_t parent, const std::string& name);
Shape shape(hid_t parent, const std::string& name);

}  // namespace lichtenberg::hdf5
