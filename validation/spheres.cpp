// Compares with the reference solutions in data/reference-spheres (at least 12.6 digits, independent methods; see their
// README): potentials, charges, forces, dipoles, energy, capacitances, and potential and field at probes.
//
//   spheres         at an accuracy of 1e-10; seconds
//   spheres long    also at other accuracies

#include "tests/sphere_references.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace spheres_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;
using namespace lichtenberg::sphere_references;

namespace {

void compare(Report& report, const SphereReference& reference, double accuracy) {
  const SphereErrors e = errors_of(reference, accuracy);
  const std::string note = fmt::format("degree {}, {} iterations, {:.4f} s", e.degree, e.iterations,
                                       e.seconds.setup + e.seconds.solve + e.seconds.forces);
  report.section(fmt::format("{}: {}", reference.name, note));
  report.at_most("potentials", e.potential, accuracy);
  report.at_most("charges", e.charge, accuracy);
  report.at_most("forces", e.force, accuracy);
  report.at_most("dipoles", e.dipole, accuracy);
  report.at_most("energy", e.energy, accuracy);
  report.at_most("capacitances", e.capacitance, accuracy);
  report.at_most("potential at probes", e.probe_potential, accuracy);
  report.at_most("field at probes", e.probe_field, accuracy);
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Reference solutions of conducting spheres; errors over the largest of a kind");
  const std::vector<SphereReference> cases = read_all_spheres();
  for (const SphereReference& reference : cases) compare(report, reference, 1e-10);
  if (long_run_requested(argc, argv))
    for (const double accuracy : {1e-3, 1e-6})
      for (const SphereReference& reference : cases) compare(report, reference, accuracy);
  return report.exit_status();
}

const lichtenberg::validation::Program program("spheres", validate);

}  // namespace spheres_validation
