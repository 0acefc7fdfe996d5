// Tests of files that obstruct a run's output, and of result files whose bytes mislead a reader.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "solvers/error.hpp"
#include "src/record/result.hpp"
#include "src/record/writer_lock.hpp"
#include "tests/many_frames.hpp"
#include "tests/source_folder.hpp"

namespace record_hostile_test {

using namespace lichtenberg;
using namespace lichtenberg::many_frames;

namespace {

const std::string diary = "my diary";

std::string file_name_of_partial(const std::string& path) { return fmt::format("{}.partial-{}", path, getpid()); }

/// Changes a result by h5py and gives it the checksum of its new bytes.
void change(const Folder& folder, const std::string& lines) {
  REQUIRE(python(folder, "import h5py, numpy, struct, zlib\nwith h5py.File('run.h5', 'r+') as f:\n  " + lines +
                             "\nb = open('run.h5', 'rb').read()\nopen('run.h5', 'ab').write("
                             "struct.pack('<8sQII', b'LICHTSUM', len(b), zlib.crc32(b), 0))") == 0);
}

}  // namespace

TEST_CASE("writer lock: a link, foreign file or pipe at its path is not replaced") {
  const Folder folder;
  folder.write("diary", diary);
  const fs::path lock = folder / "run.h5.lock";
  const auto refused = [&] {
    const std::string sentence = message_of([&] { WriterLock(folder / "run.h5"); });
    INFO(sentence);
    CHECK(contains(sentence, "run.h5.lock exists and is not replaced"));
    CHECK(text_of(folder / "diary") == diary);
    CHECK(fs::symlink_status(lock).type() != fs::file_type::not_found);
    fs::remove(lock);
  };
  fs::create_symlink(folder / "diary", lock);
  refused();
  fs::create_symlink(folder / "nowhere", lock);
  refused();
  CHECK_FALSE(fs::exists(folder / "nowhere"));
  fs::create_hard_link(folder / "diary", lock);
  refused();
  fs::copy(folder / "diary", lock);
  refused();
  REQUIRE(mkfifo(lock.c_str(), 0600) == 0);
  refused();
  fs::create_directory(lock);
  refused();
  folder.write("run.h5.lock", "process 1 on a machine that was switched off");
  CHECK(WriterLock::if_free(folder / "run.h5").has_value());
}

TEST_CASE("write_atomically: a symbolic link at its temporary name is not followed") {
  const Folder folder;
  folder.write("diary", diary);
  const std::string path = folder / "out", bytes = "whole";
  for (const char* target : {"diary", "nowhere"}) {
    fs::create_symlink(folder / target, file_name_of_partial(path));
    write_atomically(path, std::as_bytes(std::span(bytes)));
    CHECK(text_of(path) == bytes);
    CHECK(fs::symlink_status(path).type() == fs::file_type::regular);
  }
  CHECK(text_of(folder / "diary") == diary);
  CHECK_FALSE(fs::exists(folder / "nowhere"));
}

TEST_CASE("remove_partial_files: removes files run.h5.partial-PID, no others") {
  const Folder folder;
  for (const char* name : {"run.h5.partial-17", "run.h5.partial-", "run.h5.partial-notes", "run.h5.partial-17b"})
    folder.write(name, diary);
  fs::create_directory(folder / "run.h5.partial-18");
  remove_partial_files(folder / "run.h5");
  CHECK_FALSE(fs::exists(folder / "run.h5.partial-17"));
  for (const char* name : {"run.h5.partial-", "run.h5.partial-notes", "run.h5.partial-17b", "run.h5.partial-18"})
    CHECK(fs::exists(folder / name));
}

TEST_CASE("segments folder that is a link: refused, and its target stays") {
  const Folder folder, other;
  other.write("segment-000000.h5", diary);
  const std::string path = folder / "run.h5";
  fs::create_directory_symlink(other.path, segments_folder(path));
  CHECK(contains(message_of([&] { run(path, 11, false); }), "run.h5.frames exists and is not replaced"));
  remove_other_segments(path, {});
  CHECK(text_of(other / "segment-000000.h5") == diary);
  CHECK(fs::is_symlink(segments_folder(path)));
}

TEST_CASE("remove_other_segments: files of other names in the folder stay") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  fs::create_directory(segments_folder(path));
  for (const char* name : {"segment-notes.txt", "segment-1.h5", "segment-000001.h5.partial-mine"})
    std::ofstream(fs::path(segments_folder(path)) / name) << diary;
  for (const char* name : {"segment-000001.h5", "segment-000002.h5.partial-17"})
    std::ofstream(fs::path(segments_folder(path)) / name) << diary;
  remove_other_segments(path, {});
  for (const char* name : {"segment-notes.txt", "segment-1.h5", "segment-000001.h5.partial-mine"})
    CHECK(fs::exists(fs::path(segments_folder(path)) / name));
  for (const char* name : {"segment-000001.h5", "segment-000002.h5.partial-17"})
    CHECK_FALSE(fs::exists(fs::path(segments_folder(path)) / name));
}

TEST_CASE("result file checksum: damage and a missing end are refused") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  const std::string whole = text_of(path);
  const auto sentence_of = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    return message_of([&] { ResultFile(path, "read"); });
  };
  constexpr std::size_t footer = 24;
  for (std::size_t k = 0; k < 8; ++k) {
    std::string damaged = whole;
    damaged[whole.size() - footer + k] ^= 1;
    CHECK(contains(sentence_of(damaged), "the checksum at its end is damaged"));
  }
  CHECK(contains(sentence_of(whole.substr(0, whole.size() - 1)), "the checksum at its end is damaged"));
  CHECK(contains(sentence_of(whole + "x"), "the checksum at its end is damaged"));
  CHECK(contains(sentence_of(whole.substr(0, whole.size() - footer - 1)), "its end is missing"));
  CHECK(sentence_of(whole.substr(0, whole.size() - footer)).empty());  // Another program leaves the file in this state.
}

// Each of these files made HDF5 write beyond the given variable or request more memory than available.
TEST_CASE("hostile result files: types and lengths are checked before reading") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  for (const std::string lines :
       {"f.attrs['lichtenberg_result'] = numpy.arange(5000)", "f.attrs['lichtenberg_result'] = 'text'",
        "f['scene/text'][()]; del f['scene/text']; f['scene/text'] = numpy.array(['a'] * 5000, h5py.string_dtype())",
        "del f['scene/text']; f['scene/text'] = 1.0",
        "del f['particles/conductors/radius']; f.create_dataset('particles/conductors/radius', (2**60,), 'f8', "
        "chunks=(8,))",
        "del f['checkpoint/reals/mark']; f.create_dataset('checkpoint/reals/mark', (2**40,), 'f8', chunks=(8,))",
        "f['provenance/session-0'].attrs['version'] = numpy.array(['a'] * 1000, h5py.string_dtype())"}) {
    CAPTURE(lines);
    fs::remove(path);
    run(path, 3, false);
    change(folder, lines);
    const std::string sentence = message_of([&] { Recorder::resume(path, some_scene(), few); });
    CAPTURE(sentence);
    CHECK((contains(sentence, "run.h5 is damaged") || contains(sentence, "run.h5 was not written")));
  }
}

TEST_CASE("result with a radius of 0 or NaN or with excess numbers: refused") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  for (const std::string radius : {"0", "-1e-3", "numpy.nan"}) {
    fs::remove(path);
    run(path, 3, false);
    change(folder, "f['particles/conductors/radius'][0] = " + radius);
    CHECK(contains(message_of([&] { Result result(path); }), "a radius in it is"));
  }
  fs::remove(path);
  run(path, 3, false);
  change(folder,
         "del f['observables/energy/value']; f.create_dataset('observables/energy/value', (2**40,), 'f8', "
         "chunks=(8,))");
  CHECK(python(folder, fmt::format("import sys\nsys.path.insert(0, '{}/python')\nimport lichtenberg\ntry:\n"
                                   "  lichtenberg.load('run.h5').observables\nexcept lichtenberg.InputError as error:\n"
                                   "  sys.exit(0 if 'are stored' in str(error) else 1)\nsys.exit(2)",
                                   source_folder())) == 0);
}

// Found by validation/fuzz: each of these gave an error of a library, NaN in the output of analyse, or a read beyond an
// array.
TEST_CASE("hostile result files: sizes and texts that readers relied on are refused") {
  struct Change {
    std::string lines, sentence;
  };
  const auto replaced_by = [](const std::string& name, const std::string& value) {
    return fmt::format("del f['{0}']; f['{0}'] = {1}", name, value);
  };
  const Folder folder;
  const std::string path = folder / "run.h5";
  const auto refusal = [&](const Change& change_of_file, bool is_over, const std::function<void()>& read) {
    fs::remove(path);
    run(path, 3, is_over);
    change(folder, change_of_file.lines);
    const std::string sentence = message_of(read);
    CAPTURE(sentence);
    CHECK(contains(sentence, change_of_file.sentence));
  };
  for (const Change& changed : std::vector<Change>{
           {replaced_by("scene/text", "'title = [\\x01'"), "run.h5:/scene/text:1:10: not a TOML file"},
           {replaced_by("summary/energy", "numpy.zeros(0)"), "energy has 0 numbers where there should be one"},
           {replaced_by("particles/conductors/radius", "1.0"), "has no rows"}})
    refusal(changed, true, [&] { Recorder::resume(path, some_scene(), few); });
  for (const std::string number : {"1e200", "numpy.nan", "numpy.inf"})
    refusal({fmt::format("f['particles/conductors/position/value'][1] = {}", number), "position of frame 1 holds the number"},
            true, [&] { Result(path).frame(1); });
  const std::string time = "particles/conductors/position/time";
  refusal({fmt::format("f['{}'][1] = numpy.nan", time), "one finite time each"}, true, [&] { Result result(path); });
  refusal({replaced_by("network/contacts_end", "numpy.zeros((3, 0), 'i8')"), "contacts has no end in a frame"}, true,
          [&] {
            const ResultFile file(path, "read");
            file.list<std::int32_t>("contacts", file.rows<std::int64_t>("network/contacts_end"), 1);
          });
}

// HDF5 loops endlessly if the free space of a heap has the length 0.
TEST_CASE("hostile result file: text heap with free space of length 0 is refused") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  REQUIRE(python(folder,
                 "import struct, zlib\nb = bytearray(open('run.h5', 'rb').read()[:-24])\n"
                 "at = b.index(b'GCOL\\1\\0\\0\\0') + 16\nb[at : at + 64] = bytes(64)\n"
                 "b += struct.pack('<8sQII', b'LICHTSUM', len(b), zlib.crc32(b), 0)\n"
                 "open('run.h5', 'wb').write(b)") == 0);
  CHECK(contains(message_of([&] { ResultFile(path, "read"); }), "a collection of texts in it is broken"));
  CHECK(python(folder, fmt::format("import sys\nsys.path.insert(0, '{}/python')\nimport lichtenberg\ntry:\n"
                                   "  lichtenberg.load('run.h5')\nexcept lichtenberg.InputError as error:\n"
                                   "  sys.exit(0 if 'a collection of texts in it is broken' in str(error) else 1)\n"
                                   "sys.exit(2)",
                                   source_folder())) == 0);
}

}  // namespace record_hostile_test
