// Dipoles, given and induced, and sums over pairs alone.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/screened.hpp"
#include "solvers/periodic/short_range.hpp"
#include "tests/message.hpp"
#include "tests/periodic_sources.hpp"

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using std::numbers::pi;

namespace {

parallel::Team& alone = parallel::Team::single();

/// A row of `n` grains that touch (diameter 1) and goes on for ever; other rows are so far away that their field, which
/// falls as exp(-2 pi distance), is none.
Crowd chain(int n) {
  Crowd crowd{.lengths = {7, 7, double(n)}, .charge = std::vector<double>(n)};
  for (int i = 0; i < n; ++i)
    for (const double x : {0.0, 0.0, double(i)}) crowd.position.push_back(x);
  return crowd;
}

}  // namespace

TEST_CASE("x") {
  const Crowd lone = Crowd{.lengths = {1, 1, 1}, .position = {.1, .2, .3}, .charge = {0}, .dipole = {.3, -.4, .5}};
  const Response r = by_ewald(lone);
  for (int k = 0; k < 3; ++k) MESSAGE("own field " << r.field[k] - 4 * pi / 3 * lone.dipole[k]);

  for (const int n : {1, 3}) {
    const Crowd row = chain(n);
    Ewald ewald(1e-14);
    const DipoleField field_of = field_by(ewald, row, {}, alone);
    const double slope = 4 * 1.2020569031595942;
    MESSAGE("largest " << largest_polarizability(field_of, n) * slope - 1);
    std::vector<double> e(3 * n);
    for (int i = 0; i < n; ++i) e[3 * i + 2] = 1;
    for (const double a : {.005, .075, .12}) {
      std::vector<double> mu(3 * n);
      const int count = solve_dipoles(field_of, e, a, 1e-12, mu);
      MESSAGE("chain " << n << " " << a << " " << count << " " << mu[2] * (1 - a * slope) / a - 1);
    }
    MESSAGE(message_of([&] {
      std::vector<double> mu(3 * n);
      solve_dipoles(field_of, e, .21, 1e-12, mu);
    }));
  }
  Crowd fcc = lattice(std::sqrt(2), {{0, 0, 0}, {0, .5, .5}, {.5, 0, .5}, {.5, .5, 0}}, {0, 0, 0, 0});
  Ewald ewald(1e-14);
  MESSAGE("fcc " << largest_polarizability(field_by(ewald, fcc, {}, alone), 4) * 4 * pi * std::sqrt(2) / 3 - 1);

  // Energy and forces
  Crowd crowd = random_crowd(8, {4, 4.5, 5}, 0.9, false, 8);
  for (const DipoleSum variant :
       {DipoleSum::ewald, DipoleSum::mixed_consistent, DipoleSum::minimum_image, DipoleSum::source}) {
    const InducedDipoles induced(ewald, variant, .075, 1e-13);
    Response at;
    std::vector<double> mu;
    const int count = induced.evaluate(crowd, {}, alone, mu, at);
    double worst = 0;
    for (int k = 0; k < 24; ++k) {
      const double slope = -energy_slope(crowd.position[k], 2e-3, [&] {
        Response response;
        std::vector<double> start = mu;
        induced.evaluate(crowd, {}, alone, start, response);
        return response.energy;
      });
      worst = std::max(worst, std::abs(slope - at.force[k]));
    }
    double uneven = 0;
    for (int k = 0; k < 24; ++k) uneven = std::max(uneven, std::abs(mu[k] - .075 * at.field[k]));
    MESSAGE(int(variant) << " " << count << " energy " << at.energy << " slope error " << worst << " of "
                         << largest(at.force) << " mu-A e " << uneven << " cc " << by_ewald(crowd).energy);
  }
}
