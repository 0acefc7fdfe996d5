#include "solvers/laplace/spheres/image_charges.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace lichtenberg::laplace::spheres {
namespace {

/// Multipoles and image charges of one sphere of a pair.
struct Images {
  std::vector<double> multipoles;
  std::vector<AxialCharge> charges;

  void add(double position, double charge, double radius) {
    charges.push_back({position, charge});
    double term = charge / radius;
    for (double& value : multipoles) value += term, term *= position / radius;
  }
};

/// Adds image charges for one sphere at potential 1 and the other at 0.
void add_images(double first, double second, double distance, double accuracy, Images& on_first, Images& on_second) {
  double charge = first, position = 0, own = first, other = second;
  Images *here = &on_first, *there = &on_second;
  for (here->add(position, charge, own); std::abs(charge) > accuracy * first; here->add(position, charge, own)) {
    const double away = distance - position;
    charge *= -other / away;
    position = other * other / away;
    std::swap(here, there);
    std::swap(own, other);
  }
}

}  // namespace

std::array<PairSolution, 2> pair_solution(double radius, double other, double gap, int degree, double accuracy) {
  const double distance = gap + radius + other;
  const Images none{std::vector<double>(degree + 1), {}};
  std::array<Images, 2> first{none, none}, second{none, none};  // Either sphere at potential 1
  add_images(radius, other, distance, accuracy, first[0], first[1]);
  add_images(other, radius, distance, accuracy, second[1], second[0]);
  const auto charge = [&](const std::array<Images, 2>& of) {
    return radius * of[0].multipoles[0] + other * of[1].multipoles[0];
  };
  const double a = charge(first), b = charge(second);
  const double potential = b / (a + b);  // Potential of the first sphere; that of the second is lower by 1
  std::array<PairSolution, 2> result;
  for (int k = 0; k < 2; ++k) {
    result[k].multipoles.resize(degree + 1);
    result[k].potential = potential - k;
    for (int l = 0; l <= degree; ++l)
      result[k].multipoles[l] = potential * first[k].multipoles[l] + (potential - 1) * second[k].multipoles[l];
    for (const auto [position, charge] : first[k].charges) result[k].charges.push_back({position, potential * charge});
    for (const auto [position, charge] : second[k].charges)
      result[k].charges.push_back({position, (potential - 1) * charge});
  }
  return result;
}

std::vector<AxialCharge> condensed(const std::vector<AxialCharge>& charges, double radius) {
  constexpr int nodes = 20;
  std::map<int, std::vector<AxialCharge>> panels;
  for (const AxialCharge& one : charges) panels[static_cast<int>(-std::log2(1 - one.position / radius))].push_back(one);
  std::vector<AxialCharge> result;
  for (const auto& [panel, members] : panels) {
    if (members.size() <= nodes) {
      result.insert(result.end(), members.begin(), members.end());
      continue;
    }
    const double width = std::exp2(-panel - 2) * radius, centre = radius - 3 * width;  // From 4 to 2 widths below it
    std::array<double, nodes> moment{};  // Integrals of Chebyshev polynomials
    for (const AxialCharge& one : members) {
      const double u = (one.position - centre) / width;
      double value = 1, next = u;
      for (double& sum : moment) {
        sum += one.charge * value;
        value = std::exchange(next, 2 * u * next - value);
      }
    }
    for (int node = 0; node < nodes; ++node) {
      const double angle = std::numbers::pi * (node + 0.5) / nodes;
      double charge = moment[0];
      for (int k = 1; k < nodes; ++k) charge += 2 * moment[k] * std::cos(k * angle);
      result.push_back({centre + width * std::cos(angle), charge / nodes});
    }
  }
  return result;
}

}  // namespace lichtenberg::laplace::spheres
