#include "src/commands/ensemble.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/atomic_file.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace {

namespace fs = std::filesystem;
using ensemble::Member;
using ensemble::MemberState;
using ensemble::Variation;

struct Arguments {
  std::string scene, folder, conductors, share, device;
  std::vector<std::string> vary, settings;
  int seeds = 1, jobs = 0;
  JsonTarget json;
  bool quiet = false;
};

Variation read_variation(const std::string& written) {
  const std::size_t equals = written.find('=');
  if (equals == std::string::npos)
    throw InputError(
        fmt::format("--vary {}: a key and its values are wanted, as in "
                    "--vary effects.contact_discharge.gap=0.4e-3,0.775e-3",
                    written));
  std::string key = written.substr(0, equals);
  while (key.ends_with(' ')) key.pop_back();
  return {key, listed_values(written.substr(equals + 1))};
}

/// From the scene's own seed upward.
Variation seeds_from(std::uint64_t first, int count) {
  constexpr int most = 100'000;
  if (count > most) throw InputError(fmt::format("--seeds {} is not allowed: it must be at most {}", count, most));
  Variation seeds{"seed", {}};
  for (int k = 0; k < count; ++k) seeds.values.push_back(std::to_string(first + static_cast<std::uint64_t>(k)));
  return seeds;
}

std::vector<Variation> variations_of(const Arguments& request) {
  std::vector<Variation> variations;
  if (!request.conductors.empty()) variations.push_back({"population.count", listed_values(request.conductors)});
  for (const std::string& written : request.vary) variations.push_back(read_variation(written));
  if (request.seeds != 1)
    variations.push_back(seeds_from(read_scene(request.scene, settings_of(request.settings)).seed, request.seeds));
  for (const Variation& variation : variations)
    if (std::ranges::count(variations, variation.key, &Variation::key) > 1)
      throw InputError(fmt::format("{} is varied twice: list all its values in one place", variation.key));
  return variations;
}

/// "3/8": the third of eight shares of the members, which every eighth of them belongs to.
struct Share {
  int number = 1, of = 1;

  bool is_all() const { return of == 1; }
  /// Of the member at this place among all.
  bool has(std::size_t member) const { return static_cast<int>(member % static_cast<std::size_t>(of)) == number - 1; }
};

Share read_share(const std::string& written) {
  Share share;
  if (written.empty()) return share;
  const char* end = written.data() + written.size();
  const auto number = std::from_chars(written.data(), end, share.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, end, share.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != end || share.number < 1 || share.of < share.number)
    throw InputError(
        fmt::format("--share {}: a number from 1 on and how many shares there are, as in --share 3/8", written));
  return share;
}

std::vector<Member> members_of(std::vector<Member> all, const Share& share) {
  std::vector<Member> members;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (share.has(k)) members.push_back(std::move(all[k]));
  return members;
}

/// Holds a folder for one ensemble at a time, or for its shares, each once. The processes of the members inherit the
/// lock: a folder in which one still runs is taken.
class FolderLock {
 public:
  FolderLock(const std::string& folder, const std::string& name, int kind)
      : file_(open((fs::path(folder) / name).c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK, 0666)) {
    if (file_ < 0) throw InputError(fmt::format("{} cannot be written ({})", folder, std::strerror(errno)));
    if (flock(file_, kind | LOCK_NB) != 0)
      throw InputError(
          fmt::format("another ensemble is at work in {}: wait for it, or name another folder with --out", folder));
  }
  ~FolderLock() { close(file_); }
  FolderLock(const FolderLock&) = delete;

 private:
  int file_;
};

void make_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (std::error_code unknown; !fs::is_directory(folder, unknown))
    throw InputError(fmt::format("--out {}: this folder cannot be made ({})", folder,
                                 error ? error.message() : "a file of this name exists"));
}

int count(const std::vector<Member>& members, MemberState state) {
  return static_cast<int>(std::ranges::count(members, state, &Member::state));
}

/// An ensemble of which no member can be run is a mistake in the command, not in a member.
void refuse_hopeless(const std::vector<Member>& members) {
  if (count(members, MemberState::failed) == static_cast<int>(members.size()))
    throw InputError(fmt::format("no member of this ensemble is possible; of the first, {}: {}", members.front().name,
                                 members.front().sentence));
}

void report_failures(const std::vector<Member>& members) {
  for (const Member& member : members)
    if (member.state == MemberState::failed)
      fmt::print(stderr, "lichtenberg: {} failed: {}\n", printable(member.name), printable(member.sentence));
}

/// Whether a table holds members that are none of these: that of another sweep, which must not be lost.
bool holds_others(const std::string& table, const std::vector<Member>& members) {
  std::error_code error;
  if (!fs::is_regular_file(table, error)) return true;
  std::ifstream file(table);
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object() || !json.contains("members") || !json["members"].is_array()) return true;
  return std::ranges::any_of(json["members"], [&](const nlohmann::json& member) {
    const std::string name = member.is_object() ? member.value("name", "") : "";
    return std::ranges::find(members, name, &Member::name) == members.end();
  });
}

/// "ensemble.json", or "ensemble-2.json" and so on beside the tables of other sweeps.
std::string table_of(const std::string& folder, const std::vector<Member>& members) {
  for (int number = 1;; ++number) {
    const std::string name = number == 1 ? "ensemble.json" : fmt::format("ensemble-{}.json", number);
    const std::string table = (fs::path(folder) / name).string();
    std::error_code error;
    if (!fs::exists(table, error) || !holds_others(table, members)) return table;
  }
}

/// Warnings of all members, each with the member's name. Up to the first ": " a warning says what is wrong.
std::vector<std::string> warnings_of(const std::vector<Member>& members) {
  std::vector<std::string> all;
  for (const Member& member : members)
    for (const std::string& warning : member.warnings) all.push_back(fmt::format("{}: {}", member.name, warning));
  return all;
}

void report(const Arguments& request, const std::vector<Member>& members, const Share& share) {
  const ensemble::Summary summary = ensemble::summarize(members);
  const nlohmann::ordered_json json = ensemble::to_json(request.scene, members, summary);
  std::string what = request.folder;
  if (share.is_all()) {
    what = table_of(request.folder, members);
    const std::string text = json.dump(1) + "\n";
    write_atomically(what, std::as_bytes(std::span(text)));
  }
  print_warnings(warnings_of(members));
  request.json.put(json, 1);
  if (request.json.printed()) return;
  fmt::print("{} {} {} of {} runs of {}{}\n", printable(what),
             share.is_all() ? "and the result files beside it hold" : "holds", count(members, MemberState::finished),
             members.size(), printable(request.scene),
             share.is_all() ? ""
                            : fmt::format(", share {} of {}: once all shares are done, the same command without "
                                          "--share makes their table",
                                          share.number, share.of));
  ensemble::print(summary);
}

void run_ensemble(Arguments request) {
  if (!request.json.printed()) output_is_optional();
  if (parallel::process_count() > 1)
    throw InputError("ensemble runs processes of its own, one a member: leave mpirun out");
  if (request.folder.empty()) request.folder = fs::path(request.scene).stem().string() + "-ensemble";
  const int jobs = request.jobs > 0 ? request.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<Member> members =
      ensemble::make_members(request.scene, settings_of(request.settings), variations_of(request), request.folder);
  refuse_hopeless(members);
  const std::string json = request.json.file();  // of this sweep, the same command may write it again
  check_outputs({json}, {request.scene}, !json.empty() && !holds_others(json, members));
  const Share share = read_share(request.share);
  members = members_of(std::move(members), share);
  make_folder(request.folder);
  const FolderLock lock(request.folder, ".lock", share.is_all() ? LOCK_EX : LOCK_SH);
  std::optional<FolderLock> own;
  if (!share.is_all()) own.emplace(request.folder, fmt::format(".lock-{}-of-{}", share.number, share.of), LOCK_EX);
  for (Member& member : members) {
    if (member.state == MemberState::failed)
      ensemble::write_scene(request.folder, member);  // its sentence names a line of it
    if (member.state == MemberState::waiting) ensemble::inspect(request.folder, member);
  }
  report_failures(members);
  ensemble::run_members(request.folder, members, jobs, request.device, request.quiet);
  report(request, members, share);
  if (Interruption::requested()) {
    fmt::print(stderr, "lichtenberg: stopped; the same command goes on from there\n");
    Interruption::obey();
  }
  if (const int failed = count(members, MemberState::failed); failed > 0)
    throw Failure(fmt::format("{} of {} members failed, for the reasons above", failed, members.size()));
}

}  // namespace

Command ensemble_command() {
  auto request = std::make_shared<Arguments>();
  return {
      "ensemble",
      "Runs, or goes on with, a scene in many variants on all cores: means with confidence intervals",
      {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
       {"--conductors", &request->conductors,
        "numbers of conductors, as in 64,100,144: short for --vary population.count=..."},
       {"--seeds", &request->seeds, "how many seeds, from the scene's upward, for each variant", {.positive = true}},
       {"--vary",
        &request->vary,
        "KEY=VALUE,VALUE,...: values that a key of the scene takes, as in "
        "effects.contact_discharge.gap=0.4e-3,0.8e-3 or electrode[0].radius=1e-3,2e-3; again for another "
        "key: all combinations are run",
        {.repeated = true}},
       set_argument(request->settings),
       {"--out", &request->folder,
        "folder of the result files, one a member, of their scenes and of ensemble.json (ensemble-2.json beside that "
        "of "
        "another sweep); what is finished there is not run again (default: the scene's name with -ensemble)"},
       device_argument(request->device),
       {"--jobs", &request->jobs, "members that run at the same time (default: one a core)", {.positive = true}},
       {"--share", &request->share,
        "K/N: run the Kth of N shares of the members only, as in 3/8, so that N machines on one file system work side "
        "by side; the same command without it makes the table"},
       json_argument(request->json, "what ensemble.json in the folder holds as well"),
       {"--quiet", &request->quiet, "show no progress"}},
      [request] { run_ensemble(*request); }};
}

}  // namespace lichtenberg
