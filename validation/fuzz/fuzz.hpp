#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

/// Fuzzing in process: a seed determines the cases; a child process tries and checks them in order.
namespace lichtenberg::fuzz {

/// Random choices of one case, the same on each machine.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t number) : engine_(seed * 0x9e3779b97f4a7c15u + number) {}
  /// Returns a number from 0 to `count` - 1; 0 if `count` is 0.
  std::size_t below(std::size_t count) { return count > 0 ? engine_() % count : 0; }
  bool chance(double probability) { return static_cast<double>(engine_() >> 11) * 0x1p-53 < probability; }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  template <class List>
  const auto& of(const List& list) {
    return list[below(std::size(list))];
  }

 private:
  std::mt19937_64 engine_;
};

/// Files of one case, by name: the first is the scene or the result.
struct File {
  std::string name, bytes;
};
using Input = std::vector<File>;

/// Exception for a broken rule.
struct Fault {
  std::string what;
};

/// A kind of input, with the functions that draw and try it.
struct Target {
  /// Returns the input of a case.
  std::function<Input(Dice& dice)> draw;
  /// Gives the input, whose files are in the current folder, to the library. Returns a name of the outcome. Throws the
  /// library's exceptions, and Fault.
  std::function<std::string(const Input& input, Dice& dice)> attempt;
  /// HDF5 may crash on the input, which the commands expect: they read in a child process (read_in_child()).
  bool hdf5_may_crash = false;
};
/// Scene texts: parse, explain, solve, start of a run.
Target scenes();
/// Scene texts of random gases: explain, run.
Target gases();
/// Bytes of results: readers. Records the intact results in the current folder.
Target results();

/// Writes the files of an input to the current folder.
void write_files(const Input& input);

struct Request {
  std::uint64_t seed = 1, first = 0, cases = 1000;
  std::string keep;  ///< folder for the inputs that break a rule, or that `draw` writes; empty: none
};
/// Tries the cases in child processes, prints the broken rules and a summary. Returns the number of broken rules.
std::uint64_t supervise(const Target& target, const Request& request);

/// Returns true if the present case has taken its processor time. It must then end, as after a request to stop.
bool out_of_time();

/// Text that the present case has written to standard output and standard error so far.
struct Printed {
  std::string out, err;
};
Printed printed();
/// Throws Fault if the text contains NaN as a number.
void check_no_nan(const std::string& text);

/// Processor time that std::clock() gains at each call. Estimates by trial runs (src/commands/cost.cpp) then stop after
/// some calls, the same on each machine.
inline constexpr double clock_gain = 0.25;  // s

}  // namespace lichtenberg::fuzz
