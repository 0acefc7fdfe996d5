// Measures the computation of a packing's resistance from positions: times of contacts, network, set-up and solve, and
// peak memory. Methods: this program's elimination (the resistance alone, or with all potentials and currents) and
// multigrid; CHOLMOD on the same matrix with AMD and METIS ordering. `network_scipy.py` adds SciPy.
//
//   benchmark_network [--sizes 10000,100000,1000000] [--methods elimination,currents] [--threads 1] [--repeats 3]
//
// Times of parts are processor times of all threads, which other programs affect little; `wall` is the elapsed time.

#include <cholmod.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <random>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/network/build.hpp"
#include "solvers/network/components.hpp"
#include "solvers/network/conduction.hpp"
#include "solvers/network/multigrid.hpp"
#include "solvers/network/resistor.hpp"
#include "src/version.hpp"

using namespace lichtenberg;
using namespace lichtenberg::network;

namespace {

/// Returns disks with 8 % spread in radius on a jittered triangular lattice, in random order. About a sixth of the
/// lattice's contacts are missing.
ParticlePacking jittered_lattice(int n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> fraction(-1, 1);
  const int across = static_cast<int>(std::lround(std::sqrt(n * std::sqrt(0.75)))), rows = n / across;
  const double row = std::sqrt(0.75);
  ParticlePacking packing{
      .walls = {{"bottom", {0, -0.45, 0}, {0, 1, 0}}, {"top", {0, (rows - 1) * row + 0.45, 0}, {0, -1, 0}}}};
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < across; ++x)
      packing.position.push_back({x + 0.5 * (y % 2) + 0.03 * fraction(random), y * row + 0.03 * fraction(random), 0});
  std::shuffle(packing.position.begin(), packing.position.end(), random);
  for (int i = 0; i < packing.size(); ++i) packing.radius.push_back(0.518 * (1 + 0.04 * fraction(random)));
  return packing;
}

/// Processor time (s) since the last call.
class Clock {
 public:
  double lap() {
    const std::clock_t now = std::clock();
    return static_cast<double>(now - std::exchange(last_, now)) / CLOCKS_PER_SEC;
  }

 private:
  std::clock_t last_ = std::clock();
};

struct Cost {
  double contacts = 0, network = 0, setup = 0, solve = 0, resistance = 0, wall = 0;
  double nodes = 0, links = 0;
  double total() const { return contacts + network + setup + solve; }
};

/// Returns the network without floating components, which make the matrix singular.
Network joined(const Network& network, int& low, int& high) {
  const Components pieces = components(network);
  std::vector<int> number(network.nodes, -1);
  Network result;
  for (int n = 0; n < network.nodes; ++n)
    if (pieces.of[n] == pieces.of[low]) {
      number[n] = result.nodes++;
      result.position.push_back(network.position[n]);
    }
  for (const Link& link : network.links)
    if (number[link.a] >= 0) result.links.push_back({number[link.a], number[link.b], link.conductance});
  low = number[low];
  high = number[high];
  return result;
}

void by_multigrid(const Network& net, int low, int high, Cost& cost) {
  Clock clock;
  const MultigridSolution solution = solve_by_multigrid(net, low, high, 1, 1e-10);
  if (!solution.converged) throw Failure("the multigrid did not converge");
  double power = 0;
  for (const Link& link : net.links)
    power += link.conductance * std::pow(solution.potential[link.a] - solution.potential[link.b], 2);
  cost.resistance = 1 / power;
  cost.solve = clock.lap();
}

/// Solves with CHOLMOD for the nodes other than `low`, with a unit current into `high`: v_high = R I.
void by_cholmod(const Network& net, int low, int high, bool metis, Cost& cost) {
  Clock clock;
  cholmod_common common;
  cholmod_start(&common);
  common.nmethods = 1;
  common.method[0].ordering = metis ? CHOLMOD_METIS : CHOLMOD_AMD;
  common.postorder = 1;
  const auto number = [&](int n) { return n < low ? n : n - 1; };
  cholmod_triplet* triplets =
      cholmod_allocate_triplet(net.nodes - 1, net.nodes - 1, 3 * net.links.size(), 1, CHOLMOD_REAL, &common);
  int* row = static_cast<int*>(triplets->i);
  int* column = static_cast<int*>(triplets->j);
  double* value = static_cast<double*>(triplets->x);
  const auto add = [&](int i, int j, double g) {
    const auto k = triplets->nnz++;
    row[k] = std::min(i, j);
    column[k] = std::max(i, j);
    value[k] = g;
  };
  for (const Link& link : net.links) {
    if (link.a != low) add(number(link.a), number(link.a), link.conductance);
    if (link.b != low) add(number(link.b), number(link.b), link.conductance);
    if (link.a != low && link.b != low) add(number(link.a), number(link.b), -link.conductance);
  }
  cholmod_sparse* matrix = cholmod_triplet_to_sparse(triplets, 0, &common);
  cholmod_free_triplet(&triplets, &common);
  cholmod_factor* factor = cholmod_analyze(matrix, &common);
  cost.setup += clock.lap();
  cholmod_factorize(matrix, factor, &common);
  cholmod_dense* fed = cholmod_zeros(net.nodes - 1, 1, CHOLMOD_REAL, &common);
  static_cast<double*>(fed->x)[number(high)] = 1;
  cholmod_dense* potential = cholmod_solve(CHOLMOD_A, factor, fed, &common);
  cost.resistance = static_cast<double*>(potential->x)[number(high)];
  cost.solve = clock.lap();
}

struct Request {
  std::string kind, method, save;
  int threads = 1;
};

void store(const Network& network, int low, int high, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  const std::int64_t header[] = {network.nodes, static_cast<std::int64_t>(network.links.size()), low, high};
  file.write(reinterpret_cast<const char*>(header), sizeof header);
  file.write(reinterpret_cast<const char*>(network.links.data()),
             static_cast<std::streamsize>(network.links.size() * sizeof(Link)));
}

/// Solves by a method that needs a connected network.
void solve_joined(PackingNetwork& net, const Request& request, Cost& cost) {
  Clock clock;
  int low = net.electrode[0], high = net.electrode[1];
  const Network whole = joined(net.network, low, high);
  net.network = {};
  cost.setup = clock.lap();
  if (request.method == "multigrid") by_multigrid(whole, low, high, cost);
  if (request.method == "cholmod-amd") by_cholmod(whole, low, high, false, cost);
  if (request.method == "cholmod-metis") by_cholmod(whole, low, high, true, cost);
  if (request.method == "multigrid" && !request.save.empty()) store(whole, low, high, request.save);
}

Cost measure(const ParticlePacking& packing, const Request& request) {
  Cost cost;
  parallel::Team team(request.threads);
  const auto began = std::chrono::steady_clock::now();
  Clock clock;
  PackingNetwork net;
  {
    const Contacts contacts = find_contacts(packing, team);
    cost.contacts = clock.lap();
    const ResistorModel& model = resistor_model("length");
    const Parameters parameters{.resistance_per_length = 1};
    const std::vector<PackingElectrode> electrodes = {{true, 0}, {true, 1}};
    net = request.kind == "particle" ? particle_network(packing, contacts, model, parameters, electrodes, team)
                                     : contact_network(packing, contacts, model, parameters, electrodes);
    cost.network = clock.lap();
  }
  cost.nodes = net.network.nodes;
  cost.links = static_cast<double>(net.network.links.size());
  const int low = net.electrode[0], high = net.electrode[1];
  if (request.method == "elimination") {
    cost.resistance = 1 / conductance_between(net.network, low, high, team);
    cost.solve = clock.lap();
  } else if (request.method == "currents") {
    cost.resistance = conduct(net.network, low, high, {.method = Method::elimination, .team = &team}).resistance;
    cost.solve = clock.lap();
  } else {
    solve_joined(net, request, cost);
  }
  cost.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return cost;
}

/// Measures in a child process, whose peak memory is then known.
Cost in_child(const ParticlePacking& packing, const Request& request, double& mebibytes) {
  int pipes[2];
  if (pipe(pipes) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    const Cost cost = measure(packing, request);
    _exit(write(pipes[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
  }
  Cost cost;
  close(pipes[1]);
  const bool read_all = read(pipes[0], &cost, sizeof cost) == sizeof cost;
  close(pipes[0]);
  rusage usage;
  wait4(child, nullptr, 0, &usage);
  mebibytes = usage.ru_maxrss / 1024.0;
  if (!read_all) cost.resistance = NAN;
  return cost;
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

/// Measures the methods, each in the order of the list. The ratio is over the first method of CHOLMOD in it.
void compare(const ParticlePacking& packing, const std::vector<std::string>& methods, int repeats, Request request) {
  double cholmod = NAN;
  for (const std::string& method : methods) {
    request.method = method;
    Cost best;
    double mebibytes = 0;
    for (int k = 0; k < repeats; ++k) {
      const Cost cost = in_child(packing, request, mebibytes);
      if (k == 0 || cost.total() < best.total()) best = cost;
    }
    if (std::isnan(cholmod) && method.starts_with("cholmod")) cholmod = best.setup + best.solve;
    if (method == methods.front()) {
      fmt::print("\n{} particles, {}-centred: {:.0f} nodes, {:.0f} resistors\n", packing.size(), request.kind,
                 best.nodes, best.links);
      fmt::print("{:<16}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>8}{:>10}{:>20}\n", "", "contacts", "network", "set-up",
                 "solve", "total", "wall", "ratio", "MiB", "R");
    }
    fmt::print("{:<16}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>8.2f}{:>10.0f}{:>20.14f}\n", method,
               best.contacts, best.network, best.setup, best.solve, best.total(), best.wall,
               cholmod / (best.setup + best.solve), mebibytes, best.resistance);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Cost of the resistance of a packing");
  std::vector<int> sizes = {10000, 100000, 1000000};
  std::uint64_t seed = 1;
  int repeats = 3;
  Request request;
  std::string folder;
  const std::vector<std::string> all = {"cholmod-amd", "cholmod-metis", "elimination", "currents", "multigrid"};
  std::vector<std::string> methods = all;
  program.add_option("--sizes", sizes, "particles")->delimiter(',');
  program.add_option("--methods", methods, "methods to measure")->delimiter(',')->check(CLI::IsMember(all));
  program.add_option("--threads", request.threads, "of contacts, particle-centred networks and elimination")
      ->check(CLI::PositiveNumber);
  program.add_option("--seed", seed, "of the packings");
  program.add_option("--repeats", repeats, "of each measurement, the fastest counts")->check(CLI::PositiveNumber);
  program.add_option("--save", folder, "folder to leave the networks of multigrid in, for network_scipy.py");
  CLI11_PARSE(program, argc, argv);
  if (!folder.empty() && std::ranges::find(methods, "multigrid") == methods.end()) {
    fmt::print(stderr, "--save stores networks of multigrid, which --methods excludes\n");
    return 2;
  }
  double load[1] = {0};
  getloadavg(load, 1);
  const Version version = lichtenberg_version();
  fmt::print("{}, load {:.1f}; lichtenberg {}, {}\n", processor(), load[0], version.commit, version.compiler);
  fmt::print("seconds from positions to the resistance; ratio: CHOLMOD over it, set-up and solve\n");
  for (const int n : sizes) {
    const ParticlePacking packing = jittered_lattice(n, seed);
    for (const std::string kind : {"particle", "contact"}) {
      if (kind == "contact" && n > 300000) continue;  // has 2.7 times the nodes and four times the resistors
      request.kind = kind;
      request.save = folder.empty() ? "" : fmt::format("{}/{}-{}.network", folder, kind, n);
      compare(packing, methods, repeats, request);
    }
  }
}
