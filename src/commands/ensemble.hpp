#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/analysis/statistics.hpp"
#include "src/scene/vary.hpp"

namespace lichtenberg::ensemble {

/// A key of the scene, and the values that it takes over the ensemble, each as a scene file has it.
struct Variation {
  std::string key;
  std::vector<std::string> values;
};

enum class MemberState {
  waiting,  ///< to be run, from its start or from the checkpoint in its file
  running,
  finished,  ///< its file holds the whole run
  stopped,   ///< interrupted: its file, if there is one, holds a checkpoint
  failed     ///< Member::sentence says why
};

/// One scene of the ensemble.
struct Member {
  std::string name;               ///< of its files, without the suffix: "count-64_seed-1"
  std::vector<Setting> settings;  ///< in the order of the variations
  std::string text;               ///< the scene
  double cost = 1;                ///< time that it is expected to take, in a unit of the ensemble's own
  MemberState state = MemberState::waiting;
  std::string sentence;
  std::map<std::string, double> quantities;  ///< of a finished one
  std::vector<std::string> warnings;         ///< of a finished one: lichtenberg::Summary::warnings
};

/// The product of the variations of a scene with some keys `set`, the last varying fastest. Throws InputError for keys
/// and values that no scene has. Members whose scenes are impossible have failed already.
std::vector<Member> make_members(const std::string& scene_path, const std::vector<Setting>& set,
                                 const std::vector<Variation>& variations, const std::string& folder);

/// What the first line of a member's scene file ends with.
constexpr std::string_view member_mark = "as a member of an ensemble (`lichtenberg ensemble`)";

/// Paths of a member's files.
std::string scene_file(const std::string& folder, const Member& member);
std::string result_file(const std::string& folder, const Member& member);

/// Writes the member's scene, for whoever wants to look at it or run it alone. A file that no ensemble wrote stays:
/// then the member has failed, and the answer is false. Throws Failure if the disk is full.
bool write_scene(const std::string& folder, Member& member);

/// Looks at what the member's result file holds: finished, to be run or resumed, or failed because it is of another
/// scene or damaged. A finished one gets its quantities.
void inspect(const std::string& folder, Member& member);

/// Runs the waiting members, `jobs` at a time, each in a process of its own, on this device (`run --device`; empty:
/// that of its scene); the most expensive first. Returns early, with all processes ended at their checkpoints, if the
/// program is interrupted.
void run_members(const std::string& folder, std::vector<Member>& members, int jobs, const std::string& device,
                 bool quiet);

/// Members that differ in nothing but their seed.
struct Point {
  std::vector<Setting> settings;                         ///< all but the seed
  int runs = 0;                                          ///< finished members
  std::map<std::string, analysis::Estimate> quantities;  ///< means over them
};

/// A count that is proportional to the number of conductors, by all members that differ in seed and conductors only.
struct Proportion {
  std::vector<Setting> settings;  ///< all but the seed and the conductors
  std::string quantity;           ///< the count
  analysis::Estimate slope;
};

struct Summary {
  std::vector<Point> points;            ///< of at least one finished member
  std::vector<Proportion> proportions;  ///< of at least two numbers of conductors
};

Summary summarize(const std::vector<Member>& members);

void print(const Summary& summary);
nlohmann::ordered_json to_json(const std::string& scene_path, const std::vector<Member>& members,
                               const Summary& summary);

}  // namespace lichtenberg::ensemble
