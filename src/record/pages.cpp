#include "src/record/pages.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <exception>
#include <new>

namespace lichtenberg::hdf5 {
namespace {

constexpr std::uint64_t page_bytes = 1u << 20;

/// Calls `visit(number of the page, first byte in it, bytes in it, bytes before)` for each page of a range.
template <class Visit>
void for_pages(std::uint64_t offset, std::uint64_t bytes, Visit visit) {
  for (std::uint64_t done = 0; done < bytes;) {
    const std::uint64_t number = (offset + done) / page_bytes, first = (offset + done) % page_bytes;
    const std::uint64_t here = std::min(bytes - done, page_bytes - first);
    visit(number, first, here, done);
    done += here;
  }
}

/// State of an open file in the HDF5 driver; it must begin with HDF5's part.
struct Driver {
  H5FD_t common;
  std::shared_ptr<Bytes> bytes;
  haddr_t end = 0;  ///< end of the range that HDF5 has allocated
};

Driver& of(H5FD_t* file) { return *reinterpret_cast<Driver*>(file); }
const Driver& of(const H5FD_t* file) { return *reinterpret_cast<const Driver*>(file); }

/// Converts an exception to the error status of an HDF5 call.
template <class Work>
herr_t guarded(Work work) {
  try {
    work();
    return 0;
  } catch (const std::exception&) {
    return -1;
  }
}

H5FD_t* open_bytes(const char*, unsigned, hid_t access, haddr_t) {
  const auto* bytes = static_cast<const std::shared_ptr<Bytes>* const*>(H5Pget_driver_info(access));
  if (bytes == nullptr) return nullptr;
  auto* driver = new Driver{};
  driver->bytes = **bytes;
  return &driver->common;
}

herr_t close_bytes(H5FD_t* file) {
  delete &of(file);
  return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).end; }

herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  of(file).end = end;
  return 0;
}

haddr_t written(const H5FD_t* file, H5FD_mem_t) { return of(file).bytes->size(); }

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, size_t bytes, void* to) {
  return guarded([&] { of(file).bytes->read(offset, {static_cast<std::byte*>(to), bytes}); });
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, size_t bytes, const void* from) {
  return guarded([&] { of(file).bytes->write(offset, {static_cast<const std::byte*>(from), bytes}); });
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  return guarded([&] { of(file).bytes->resize(of(file).end); });
}

hid_t driver() {
  static H5FD_class_t functions{};
#ifdef H5FD_CLASS_VERSION  // HDF5 1.14
  functions.version = H5FD_CLASS_VERSION;
  functions.value = 511;  // of the range for drivers that are not registered with The HDF Group
#endif
  functions.name = "lichtenberg_bytes";
  functions.maxaddr = HADDR_MAX / 2;
  functions.fc_degree = H5F_CLOSE_WEAK;
  functions.fapl_size = sizeof(const std::shared_ptr<Bytes>*);
  functions.open = open_bytes;
  functions.close = close_bytes;
  functions.query = query;
  functions.get_eoa = allocated;
  functions.set_eoa = allocate;
  functions.get_eof = written;
  functions.read = read_bytes;
  functions.write = write_bytes;
  functions.truncate = truncate;
  std::fill(std::begin(functions.fl_map), std::end(functions.fl_map), H5FD_MEM_DEFAULT);
  static const hid_t id = H5FDregister(&functions);
  return id;
}

/// Returns the result of `use` with a property list for these bytes, which is valid during the call.
template <class Use>
hid_t with_access(const std::shared_ptr<Bytes>& bytes, Use use) {
  const std::shared_ptr<Bytes>* driver_info = &bytes;
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (access < 0) return H5I_INVALID_HID;
  const hid_t file = H5Pset_driver(access, driver(), &driver_info) < 0 ? H5I_INVALID_HID : use(access);
  H5Pclose(access);
  return file;
}

}  // namespace

/// Memory of a page, mapped directly from the kernel, zeroed and unmapped. Files alternate with arrays of any size, so
/// that an allocator would keep fragmented memory.
struct Pages::Page {
  std::byte* bytes;

  Page() {
    void* mapping = mmap(nullptr, page_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapping == MAP_FAILED) throw std::bad_alloc();
    bytes = static_cast<std::byte*>(mapping);
  }
  Page(const Page& other) : Page() { std::copy_n(other.bytes, page_bytes, bytes); }
  Page& operator=(const Page&) = delete;
  ~Page() { munmap(bytes, page_bytes); }
};

void Pages::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  for_pages(offset, bytes.size(), [&](auto number, auto first, auto here, auto done) {
    const auto page = pages_.find(number);
    if (page == pages_.end())
      std::fill_n(bytes.begin() + done, here, std::byte{0});
    else
      std::copy_n(page->second->bytes + first, here, bytes.begin() + done);
  });
}

void Pages::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  size_ = std::max(size_, offset + bytes.size());
  for_pages(offset, bytes.size(), [&](auto number, auto first, auto here, auto done) {
    std::shared_ptr<Page>& page = pages_[number];
    if (!page) page = std::make_shared<Page>();
    if (page.use_count() > 1) page = std::make_shared<Page>(*page);
    std::copy_n(bytes.begin() + done, here, page->bytes + first);
  });
}

void Pages::for_each(const std::function<void(std::uint64_t, std::span<const std::byte>)>& visit) const {
  for (const auto& [number, page] : pages_)
    if (const std::uint64_t offset = number * page_bytes; offset < size_)
      visit(offset, {page->bytes, std::min(page_bytes, size_ - offset)});
}

hid_t create_file(const std::shared_ptr<Bytes>& bytes) {
  return with_access(bytes, [](hid_t access) { return H5Fcreate("new file", H5F_ACC_TRUNC, H5P_DEFAULT, access); });
}

hid_t open_file(const std::shared_ptr<Bytes>& bytes, unsigned flags) {
  return with_access(bytes, [&](hid_t access) { return H5Fopen("file", flags, access); });
}

}  // namespace lichtenberg::hdf5
