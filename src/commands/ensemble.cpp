#include "src/commands/ensemble.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/interruption.hpp"
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
  std::string scene, folder, conductors;
  std::vector<std::string> vary;
  int seeds = 1, jobs = 0;
  bool json = false, quiet = false;
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
  Variation seeds{"seed", {}};
  for (int k = 0; k < count; ++k) seeds.values.push_back(std::to_string(first + static_cast<std::uint64_t>(k)));
  return seeds;
}

std::vector<Variation> variations_of(const Arguments& request) {
  std::vector<Variation> variations;
  if (!request.conductors.empty()) variations.push_back({"population.count", listed_values(request.conductors)});
  for (const std::string& written : request.vary) variations.push_back(read_variation(written));
  if (request.seeds != 1) variations.push_back(seeds_from(read_scene(request.scene).seed, request.seeds));
  for (const Variation& variation : variations)
    if (std::ranges::count(variations, variation.key, &Variation::key) > 1)
      throw InputError(fmt::format("{} is varied twice: list all its values in one place", variation.key));
  return variations;
}

/// Holds a folder for one ensemble at a time. The processes of the members inherit the lock: a folder in which one
/// still runs is taken.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder)
      : file_(open((fs::path(folder) / ".lock").c_str(), O_RDWR | O_CREAT, 0666)) {
    if (file_ < 0) throw InputError(fmt::format("{} cannot be written ({})", folder, std::strerror(errno)));
    if (flock(file_, LOCK_EX | LOCK_NB) != 0)
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
  if (!fs::is_directory(folder))
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
      fmt::print(stderr, "lichtenberg: {} failed: {}\n", member.name, member.sentence);
}

void write_summary(const std::string& folder, const nlohmann::ordered_json& json) {
  const std::string text = json.dump(1) + "\n";
  write_atomically((fs::path(folder) / "ensemble.json").string(), std::as_bytes(std::span(text)));
}

void report(const Arguments& request, const std::vector<Member>& members) {
  const ensemble::Summary summary = ensemble::summarize(members);
  const nlohmann::ordered_json json = ensemble::to_json(request.scene, members, summary);
  write_summary(request.folder, json);
  if (request.json) return fmt::print("{}\n", json.dump(1));
  fmt::print("{}/ensemble.json and the result files beside it hold {} of {} runs of {}\n", request.folder,
             count(members, MemberState::finished), members.size(), request.scene);
  ensemble::print(summary);
}

void run_ensemble(Arguments request) {
  if (parallel::process_count() > 1)
    throw InputError("ensemble runs processes of its own, one a member: leave mpirun out");
  if (request.folder.empty()) request.folder = fs::path(request.scene).stem().string() + "-ensemble";
  const int jobs = request.jobs > 0 ? request.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<Member> members = ensemble::make_members(request.scene, variations_of(request), request.folder);
  refuse_hopeless(members);
  make_folder(request.folder);
  const FolderLock lock(request.folder);
  for (Member& member : members) {
    if (member.state == MemberState::failed)
      ensemble::write_scene(request.folder, member);  // its sentence names a line of it
    if (member.state == MemberState::waiting) ensemble::inspect(request.folder, member);
  }
  report_failures(members);
  ensemble::run_members(request.folder, members, jobs, request.quiet);
  report(request, members);
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
       {"--out", &request->folder,
        "folder of the result files, one a member, of their scenes and of ensemble.json; what is "
        "finished there is not run again (default: the scene's name with -ensemble)"},
       {"--jobs", &request->jobs, "members that run at the same time (default: one a core)", {.positive = true}},
       {"--json", &request->json, "print what ensemble.json holds in place of the table"},
       {"--quiet", &request->quiet, "show no progress"}},
      [request] { run_ensemble(*request); }};
}

}  // namespace lichtenberg
