#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "solvers/error.hpp"
#include "src/commands/scratch_folder.hpp"
#include "src/commands/work_precision_charges.hpp"

namespace lichtenberg::work_precision {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_data(const fs::path& path, const ChargedSubject& subject) {
  const Vec3 lengths = subject.bodies.box.lengths;
  const std::vector<double>& position = subject.bodies.position;
  const std::vector<double>& charge = subject.bodies.charge;
  fmt::ostream out = fmt::output_file(path.string());
  out.print("grains\n\n{} atoms\n1 atom types\n", charge.size());
  for (int k = 0; k < 3; ++k) out.print("0 {0:.17g} {1}lo {1}hi\n", lengths[k], "xyz"[k]);
  out.print("\nMasses\n\n1 1\n\nAtoms # charge\n\n");
  for (std::size_t i = 0; i < charge.size(); ++i)
    out.print("{} 1 {:.17g} {:.17g} {:.17g} {:.17g}\n", i + 1, charge[i], position[3 * i], position[3 * i + 1],
              position[3 * i + 2]);
}

/// Nothing moves, so that each step is an evaluation and no list is made anew.
std::string commands(double accuracy, double cutoff, int steps) {
  return fmt::format(R"(units lj
atom_style charge
read_data data
pair_style coul/long {}
pair_coeff * *
kspace_style pppm {}
neighbor 0.3 bin
dump forces all custom 1000000 forces id fx fy fz
dump_modify forces sort id format float %.17g
run {}
)",
                     cutoff, accuracy, steps);
}

class LammpsTrial : public Trial {
 public:
  LammpsTrial(const ChargedSubject& subject, double accuracy, double cutoff) : subject_(subject) {
    if (std::system("command -v lmp >/dev/null 2>&1") != 0)
      throw InputError("LAMMPS is not installed: there is no command `lmp` (Debian's package lammps)");
    write_data(folder_.file("data"), subject);
    fmt::output_file(folder_.file("in")).print("{}", commands(accuracy, cutoff, steps()));
  }

  void run() override {
    const std::string line =
        fmt::format("cd '{}' && OMP_NUM_THREADS=1 lmp -in in -log none >out 2>&1 </dev/null", folder_.path());
    const bool done = std::system(line.c_str()) == 0;
    std::smatch found;
    const std::string out = text_of(folder_.file("out"));
    if (!done || !std::regex_search(out, found, std::regex(R"(Loop time of (\S+) on[^]*?([0-9.]+)% CPU use)")))
      throw Failure("LAMMPS did not get through it");
    seconds_ = std::stod(found[1]) * std::stod(found[2]) / 100 / steps();
  }

  std::vector<double> errors() const override { return subject_.errors(forces()); }
  std::int64_t work() const override { return 0; }
  std::optional<double> own_seconds() const override { return seconds_; }
  bool is_elsewhere() const override { return true; }

 private:
  /// Enough for its timer, which knows milliseconds.
  int steps() const { return std::max(3, 50000 / subject_.bodies.size()); }

  /// Nine lines that say what follows, then id and force.
  std::vector<double> forces() const {
    std::ifstream file(folder_.file("forces"));
    std::string line;
    for (int k = 0; k < 9; ++k) std::getline(file, line);
    std::vector<double> force(3 * static_cast<std::size_t>(subject_.bodies.size()), NAN);
    std::size_t id = 0;
    for (std::size_t k = 0; 3 * k < force.size() && file >> id; ++k)
      file >> force[3 * k] >> force[3 * k + 1] >> force[3 * k + 2];
    return force;
  }

  const ChargedSubject& subject_;
  ScratchFolder folder_;
  double seconds_ = 0;
};

}  // namespace

std::unique_ptr<Trial> make_lammps_trial(const ChargedSubject& subject, double accuracy, double cutoff) {
  return std::make_unique<LammpsTrial>(subject, accuracy, cutoff);
}

}  // namespace lichtenberg::work_precision
