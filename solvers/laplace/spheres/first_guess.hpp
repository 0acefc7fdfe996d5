#pragma once

#include <deque>
#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// A solution of a similar scene.
struct Past {
  std::vector<Site> sites;
  std::vector<double> x;             ///< sqrt(R) a, harmonics of all sites
  std::vector<double> potential;     ///< V, of each site
  std::vector<double> wall;          ///< V, what the sides' potentials make at its centre
  std::vector<double> difference{};  ///< V, across each coupling
};

/// The last ones, the latest first.
using History = std::deque<Past>;
constexpr std::size_t longest_history = 4;

/// Spheres whose charges together are given: those of a floating group, or of all fixed ones where nothing takes what
/// is left.
struct Given {
  std::vector<int> spheres;
  double charge = 0;  ///< Q / (4 pi eps), the sum of R a_00
  double weight = 0;  ///< sum of radii
};

/// What a solution is wanted for: places, charges and potentials.
struct Wanted {
  const std::vector<Site>& sites;
  const std::vector<Given>& given;
  std::vector<int> group;     ///< of each site: sites of one group are to have one potential
  std::vector<double> fixed;  ///< V, of each site whose potential is fixed; else not a number
  std::vector<double> wall;   ///< as in Past
};

/// How much of each past solution makes the best guess: x is linear in charges and potentials and smooth in positions,
/// so that the mixture is chosen whose charges, potentials and displacements are nearest to those wanted, and whose
/// potentials differ least within groups. No time is needed, and a step that was taken back is as good as any.
/// `noise`: error of each past x, over its length; mixtures that would magnify it are not taken. All have as many sites
/// as are wanted.
std::vector<double> mixture(const History& history, const Wanted& wanted, double noise);

}  // namespace lichtenberg::laplace::spheres
