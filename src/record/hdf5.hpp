#pragma once

// A parallel HDF5 includes mpi.h: leave out its C++ classes, which need a library of their own.
#define OMPI_SKIP_MPICXX 1
#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// The HDF5 C API with identifiers that close themselves and errors that are exceptions.
///
/// Files are built in memory and written to disk by write_atomically: HDF5 1.10 crashes, when a file is closed or the
/// program ends, after a write that failed for lack of space, so it never writes to the disk itself.
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

/// Whether the file at `path` begins as an HDF5 file does.
bool is_hdf5(const std::string& path);
/// A new, empty file in memory.
Handle create_in_memory();
/// A copy in memory of the file at `path`: changes to it never reach the disk.
Handle load(const std::string& path);
/// The bytes that the file would have on disk.
std::vector<std::byte> image(const Handle& file);

/// The group at `path` below `parent`, made with all groups above it unless it exists.
Handle open_group(hid_t parent, const std::string& path);
/// Whether something stands at `path` below `parent`.
bool exists(hid_t parent, const std::string& path);
/// Names of what stands in a group, in alphabetical order.
std::vector<std::string> names(hid_t group);

using Shape = std::vector<hsize_t>;

// Attributes. Text is UTF-8 of variable length, as h5py and the readers of H5MD expect it.
void put_attribute(hid_t object, const std::string& name, const std::string& text);
void put_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);
/// The same of fixed length: what the readers of VTKHDF expect.
void put_fixed_attribute(hid_t object, const std::string& name, const std::string& text);
template <class Number>
void put_attribute(hid_t object, const std::string& name, std::span<const Number> numbers, const Shape& shape);
template <class Number>
requires std::is_arithmetic_v<Number>
void put_attribute(hid_t object, const std::string& name, Number number) {
  put_attribute(object, name, std::span<const Number>(&number, 1), {});
}
/// Empty if there is no attribute of this name.
std::optional<int> integer_attribute(hid_t object, const std::string& name);
/// A list of texts, as put_attribute writes it.
std::vector<std::string> text_attribute(hid_t object, const std::string& name);

/// Writes a dataset: into the one of the same name if it has the same shape, which keeps the file from growing, or
/// instead of it. An empty unit writes no `unit` attribute.
template <class Number>
void put(hid_t parent, const std::string& name, std::span<const Number> numbers, const Shape& shape,
         const std::string& unit);
template <class Number>
requires std::is_arithmetic_v<Number>
void put(hid_t parent, const std::string& name, Number number, const std::string& unit) {
  put(parent, name, std::span<const Number>(&number, 1), {}, unit);
}
void put_text(hid_t parent, const std::string& name, const std::string& text);

/// Adds one row to a dataset that grows along its first dimension; the first row creates it.
template <class Number>
void append(hid_t parent, const std::string& name, std::span<const Number> row, const Shape& shape,
            const std::string& unit);
template <class Number>
requires std::is_arithmetic_v<Number>
void append(hid_t parent, const std::string& name, Number number, const std::string& unit) {
  append(parent, name, std::span<const Number>(&number, 1), {}, unit);
}
/// Adds any number of short rows at once; `shape` is one row's.
template <class Number>
void append_rows(hid_t parent, const std::string& name, std::span<const Number> rows, const Shape& shape,
                 const std::string& unit);

/// All numbers of a dataset, the last index fastest, converted if they are stored as another type.
template <class Number>
std::vector<Number> get(hid_t parent, const std::string& name);
/// The same of `count` rows from `first` on. Throws Error if the dataset has not as many.
template <class Number>
std::vector<Number> get_rows(hid_t parent, const std::string& name, hsize_t first, hsize_t count);
std::string get_text(hid_t parent, const std::string& name);
Shape shape(hid_t parent, const std::string& name);

}  // namespace lichtenberg::hdf5
