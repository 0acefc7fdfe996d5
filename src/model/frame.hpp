#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "solvers/geometry/vec2.hpp"

namespace lichtenberg {

/// What holds conductors at a potential - an electrode, a side of the domain that is one, a wire held from outside -
/// and what has passed through it.
struct TerminalReading {
  std::string name;
  double potential = 0;  ///< V
  double drained = 0;    ///< C, from the conductors to it since the start
};

/// What a run shows of itself at one instant: the recorder writes it, analysis and plots read it.
struct Frame {
  double time = 0;                ///< s; of a relaxation to rest: the number of the iteration
  std::vector<Vec2> position;     ///< m
  std::vector<double> z;          ///< m; empty in two dimensions
  std::vector<Vec2> velocity;     ///< m/s
  std::vector<Vec2> force;        ///< N, electric
  std::vector<double> charge;     ///< C; empty in a neutral scene
  std::vector<double> potential;  ///< V; empty in a neutral scene
  std::vector<int> group;  ///< smallest index of the conductors in electrical contact; -1: connected to an electrode
  double energy = 0;       ///< J, of the field; of a relaxation: of the contacts
  std::optional<double> largest_force;  ///< N, net, on a particle, of a relaxation
  double charge_held = 0;               ///< C, on the conductors
  double charge_fed = 0;                ///< C, by the source since the start
  double charge_drained = 0;            ///< C, to the electrodes since the start: the sum over terminals
  std::vector<TerminalReading> terminals;
  std::int64_t field_solves = 0;
  std::int64_t iterations = 0;  ///< of the linear solver, all solves together
};

/// All that a run needs to go on from an instant as if it had never stopped, as named arrays.
struct Checkpoint {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
};

}  // namespace lichtenberg
