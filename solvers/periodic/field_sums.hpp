#pragma once

#include <numeric>

#include "solvers/compensated.hpp"
#include "solvers/periodic/screened.hpp"

// Accumulation and storage of fields and forces for the sums that treat one source after another.
namespace lichtenberg::periodic {

/// Accumulator of potential, field and force at a source by compensated sums.
struct CompensatedFieldSample {
  CompensatedSum potential;
  CompensatedVector field, force;

  CompensatedFieldSample& operator+=(const FieldSample& part) {
    potential += part.potential;
    field += part.field;
    force += part.force;
    return *this;
  }
  FieldSample total() const { return {potential.total(), field.total(), force.total()}; }
};

/// Sets the number of sources in the arrays of a response.
inline void resize(Response& response, int size) {
  response.potential.resize(size);
  response.field.resize(3 * size);
  response.force.resize(3 * size);
}

/// Stores potential, field and force at a source in a response.
inline void store(int index, const FieldSample& sample, Response& response) {
  response.potential[index] = sample.potential;
  for (int k = 0; k < 3; ++k) {
    response.field[3 * index + k] = sample.field[k];
    response.force[3 * index + k] = sample.force[k];
  }
}

/// Returns the indices of all sources: 0 ... N - 1.
inline std::vector<int> all_of(const Sources& sources) {
  std::vector<int> all(sources.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// Computes the energy 1/2 sum (charge * potential - dipole . field) over the sources in `sample`. `response` has one
/// entry for each source of the sample.
inline double energy_of(const Sources& sources, std::span<const int> sample, const Response& response) {
  CompensatedSum energy;
  for (std::size_t k = 0; k < sample.size(); ++k) {
    const Multipole on = multipole(sources, sample[k]);
    const Vec3 field{response.field[3 * k], response.field[3 * k + 1], response.field[3 * k + 2]};
    energy += 0.5 * (on.charge * response.potential[k] - dot(on.dipole, field));
  }
  return energy.total();
}

}  // namespace lichtenberg::periodic
