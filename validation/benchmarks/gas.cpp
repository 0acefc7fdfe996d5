// Times the parts of the steps of a charged gas, and measures the error of its forces for random positions and for
// clusters. gas_lammps.py compares with LAMMPS.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>

#include "solvers/periodic/ewald.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/model/model.hpp"
#include "validation/benchmarks/machine.hpp"

using namespace lichtenberg;

namespace {

struct Options {
  std::vector<int> sizes{1000, 8516, 50016};
  std::vector<double> accuracies{1e-3, 1e-4, 1e-6};
  int threads = 1;
  double step = 0.005, temperature = 1;
  int every = 1;  // contact substeps per evaluation of charges' forces
  bool exchange = false;
  int steps = 20, repeats = 5;
  int sample = 300;   // number of grains whose force is compared with Ewald sums
  double filled = 1;  // part of the box that contains the grains
};

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Returns a gas of G's density in a part of the box. `accuracy` 0: without forces of charges.
Scene scene(int grains, double accuracy, const Options& options) {
  std::string text = "[units]\n[domain]\n";
  const double length = 70 * std::cbrt(grains / 50016.0);
  text += fmt::format("size = [{0}, {0}, {0}]\n", length);
  for (const auto side : side_names) text += fmt::format("{} = \"periodic\"\n", side);
  for (const int charge : {1, -1})
    text += fmt::format("[[population]]\ncount = {}\ncharge = {}\ntemperature = {}\n", grains / 2, charge,
                        options.temperature);
  text += "[effects.viscoelastic_contact]\nstiffness = 278.6\ndamping = 27.7\n";
  if (accuracy > 0) text += fmt::format("[effects.coulomb]\ncoupling_constant = 1\naccuracy = {}\n", accuracy);
  // The exchange is so weak that charges stay nearly constant.
  if (accuracy > 0 && options.exchange) text += "[effects.charge_exchange]\ntransfer_prefactor = 1e-9\n";
  // The shortest possible contact lasts .147, at twice the speed of the fastest of 5e4 grains.
  text += fmt::format("[mechanics]\ncontact_substeps = {}\nthreads = {}\n",
                      std::max(1, static_cast<int>(std::lround(0.147 / options.step))), options.threads);
  if (accuracy > 0) text += fmt::format("step = {}\n", options.every * options.step);
  text += "[stop]\ntime = 1e6\n[output]\nevery = 1e6\npicture = false\n";
  Scene gas = parse_scene(text, "gas.toml");
  gas.domain.size = std::cbrt(1 / options.filled) * gas.domain.size;
  return gas;
}

/// Arranges the grains in balls of about a hundred touching grains, with shuffled charges.
void gather(Bodies& bodies) {
  constexpr double spacing = 1.02, radius2 = 10.5;
  std::vector<Vec3> ball;
  for (int x = -3; x <= 3; ++x)
    for (int y = -3; y <= 3; ++y)
      for (int z = -3; z <= 3; ++z)
        if (x * x + y * y + z * z < radius2) ball.push_back({spacing * x, spacing * y, spacing * z});
  const double length = bodies.box.lengths.x;
  const int balls = static_cast<int>(bodies.size() / ball.size()) + 1;
  const int along = static_cast<int>(std::ceil(std::cbrt(balls)));
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> shift(0, std::max(0.0, length / along - 8));
  std::vector<Vec3> positions;
  for (int n = 0; static_cast<int>(positions.size()) < bodies.size(); ++n) {
    const Vec3 corner = length / along * Vec3{1.0 * (n % along), 1.0 * (n / along % along), 1.0 * (n / along / along)};
    const Vec3 centre = corner + Vec3{shift(random), shift(random), shift(random)};
    for (const Vec3 offset : ball) positions.push_back(centre + offset);
  }
  std::shuffle(positions.begin(), positions.end(), random);
  for (int i = 0; i < bodies.size(); ++i)
    for (int k = 0; k < 3; ++k) bodies.position[3 * i + k] = positions[i][k];
  wrap(bodies);
}

/// Returns the rms force error over the rms of the exact forces, for a sample of grains.
double force_error(const Scene& gas_scene, bool clustered, const Options& options) {
  Model model = effects::make_model(gas_scene);
  if (clustered) gather(model.bodies);
  parallel::Team team(std::max(options.threads, 2));
  const auto coulomb = std::ranges::find(model.effects, "coulomb", [](const auto& e) { return e->name(); });
  std::vector<Pair> pairs;
  if (const auto range = (*coulomb)->needs().neighbour_range) pairs = pairs_closer_than(model.bodies, *range, team);
  std::vector<double> force(model.bodies.position.size());
  (*coulomb)->add_forces({0, model.bodies, pairs, team}, force);
  std::vector<int> sample;
  const int n = model.bodies.size(), count = std::min(options.sample, n);
  for (int s = 0; s < count; ++s) sample.push_back(static_cast<int>(static_cast<long>(s) * n / count));
  const periodic::Sources sources{model.bodies.box.lengths, model.bodies.position, model.bodies.charge};
  periodic::Response exact;
  periodic::Ewald(periodic::splitting_for(sources, 1e-9)).evaluate_at(sample, sources, team, exact);
  double error = 0, size = 0;
  for (int s = 0; s < count; ++s)
    for (int k = 0; k < 3; ++k) {
      error += std::pow(force[3 * sample[s] + k] - exact.force[3 * s + k], 2);
      size += std::pow(exact.force[3 * s + k], 2);
    }
  return std::sqrt(error / size);
}

using Seconds = std::map<std::string, double>;

Seconds operator-(Seconds a, const Seconds& b) {
  for (auto& [name, value] : a) value -= b.at(name);
  return a;
}

/// Returns milliseconds per step by part, as wall time and as time of all processors, of the fastest repeat.
Seconds stretch(GranularMotion& motion, const Options& options) {
  const double length = options.step * options.steps;
  motion.advance_to(motion.time() + length, {});  // builds lists and plans
  Seconds best;
  double least = INFINITY;
  for (int k = 0; k < options.repeats; ++k) {
    const Seconds before = motion.seconds();
    const double start = seconds_now();
    const std::clock_t start_of_processors = std::clock();
    motion.advance_to(motion.time() + length, {});
    const double processors = static_cast<double>(std::clock() - start_of_processors) / CLOCKS_PER_SEC;
    if (processors >= least) continue;
    least = processors;
    best = motion.seconds() - before;
    best["all"] = seconds_now() - start;
    best["processors"] = processors;
  }
  for (auto& [name, value] : best) value *= 1e3 / options.steps;
  return best;
}

void measure(int grains, double accuracy, const Options& options) {
  const Scene gas_scene = scene(grains, accuracy, options);
  const double start = seconds_now();
  GranularMotion motion(gas_scene);
  const double setup = 1e3 * (seconds_now() - start);
  Seconds parts = stretch(motion, options);
  fmt::print("{:>7} {:>7} {:>7} {:>9.2f} {:>7.2f} {:>7.2f} {:>9.2f} {:>7.2f} {:>7.2f} {:>8.2f} {:>8.2f} {:>8.0f}",
             grains, accuracy > 0 ? fmt::format("{:.0e}", accuracy) : "-", options.threads, parts["contacts"],
             parts["near"], parts["mesh"], parts["exchange"], parts["lists"], parts["other"] + parts["forces"],
             parts["all"], parts["processors"], setup);
  if (accuracy > 0 && options.sample > 0)
    fmt::print(" {:>9.1e} {:>9.1e}", force_error(gas_scene, false, options), force_error(gas_scene, true, options));
  fmt::print("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App program("Steps of a charged granular gas, timed by part.");
  program.add_option("--sizes", options.sizes)->delimiter(',');
  program.add_option("--accuracies", options.accuracies, "0: contacts alone")->delimiter(',');
  program.add_option("--threads", options.threads);
  program.add_option("--step", options.step);
  program.add_option("--temperature", options.temperature);
  program.add_option("--every", options.every, "steps of contacts from one force of charges to the next");
  program.add_flag("--exchange", options.exchange, "charges move: two evaluations of forces a step");
  program.add_option("--steps", options.steps, "a stretch, of contacts");
  program.add_option("--repeats", options.repeats, "stretches, of which the fastest counts");
  program.add_option("--filled", options.filled, "part of the box that contains the grains: 1 or one cluster");
  program.add_option("--sample", options.sample, "grains whose force is compared with Ewald's; 0: none");
  CLI11_PARSE(program, argc, argv);
  fmt::print("{}\nms a step of {} at T = {}; set-up in ms; errors: relative rms errors of forces\n",
             benchmarks::machine(), options.step, options.temperature);
  fmt::print("{:>7} {:>7} {:>7} {:>9} {:>7} {:>7} {:>9} {:>7} {:>7} {:>8} {:>8} {:>8} {:>9} {:>9}\n", "grains", "asked",
             "threads", "contacts", "near", "mesh", "exchange", "lists", "rest", "all", "CPU", "set-up", "random",
             "clusters");
  for (const int size : options.sizes)
    for (const double accuracy : options.accuracies) measure(size, accuracy, options);
}
