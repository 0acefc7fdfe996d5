#include "src/granular/note.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/stopwatch.hpp"

namespace lichtenberg::granular {
namespace {

/// Columns of a time series, with one row for each note (observables of one instant).
class Columns {
 public:
  explicit Columns(std::span<const Note> notes) : notes_(notes) {}

  template <class Of>
  void real(std::string name, std::string unit, Of of) {
    add<double>(std::move(name), std::move(unit), of);
  }
  template <class Of>
  void whole(std::string name, Of of) {
    add<std::int64_t>(std::move(name), "1", of);
  }
  std::vector<Column> take() { return std::move(columns_); }

 private:
  template <class Number, class Of>
  void add(std::string name, std::string unit, Of of) {
    std::vector<Number> values;
    for (const Note& note : notes_) values.push_back(of(note));
    columns_.push_back({std::move(name), std::move(unit), Column::Of::list, 0, std::move(values)});
  }

  std::span<const Note> notes_;
  std::vector<Column> columns_;
};

constexpr const char* energy_unit = "m0 v0^2";

void add_state(Columns& columns) {
  columns.real("temperature", energy_unit, [](const Note& n) { return n.gas.temperature.total; });
  columns.real("local_temperature", energy_unit, [](const Note& n) { return n.gas.temperature.local; });
  columns.real("mean_charge_magnitude", "q0", [](const Note& n) { return n.gas.charge.magnitude; });
  columns.real("mean_square_charge", "q0^2", [](const Note& n) { return n.gas.charge.square; });
  columns.whole("contacts", [](const Note& n) { return n.contacts; });
  columns.whole("collisions", [](const Note& n) { return n.collisions; });
}

void add_energies(Columns& columns, std::span<const Note> notes) {
  columns.real("kinetic_energy", energy_unit, [](const Note& n) { return n.energy.kinetic; });
  if (!notes.empty() && notes.front().energy.rotational)
    columns.real("rotational_energy", energy_unit, [](const Note& n) { return *n.energy.rotational; });
  columns.real("contact_energy", energy_unit, [](const Note& n) { return n.energy.contact; });
  columns.real("potential_energy", energy_unit, [](const Note& n) { return n.energy.potential; });
  columns.real("dissipated_energy", energy_unit, [](const Note& n) { return n.energy.dissipated; });
  columns.real("exchanged_energy", energy_unit, [](const Note& n) { return n.energy.exchanged; });
  columns.real("driven_energy", energy_unit, [](const Note& n) { return n.energy.driven; });
}

void add_clusters(Columns& columns) {
  columns.whole("clusters", [](const Note& n) { return n.gas.contact.number; });
  columns.whole("largest_cluster", [](const Note& n) { return n.gas.contact.largest; });
  columns.real("mean_aggregate", "1", [](const Note& n) { return n.gas.contact.aggregate; });
  columns.whole("density_clusters", [](const Note& n) { return static_cast<std::int64_t>(n.gas.density.size.size()); });
  columns.real("density_cluster_size", "1", [](const Note& n) { return n.gas.density.mean_size(); });
}

void add_expectations(Columns& columns, const HomogeneousGas& theory) {
  columns.real("haff_temperature", energy_unit, [](const Note& n) { return n.expected->temperature; });
  columns.real("expected_collisions", "1", [](const Note& n) { return n.expected->collisions; });
  if (theory.charge_square())
    columns.real("expected_square_charge", "q0^2", [](const Note& n) { return *n.expected->charge_square; });
}

}  // namespace

double Note::temperature() const {
  return std::isnan(gas.temperature.local) ? gas.temperature.total : gas.temperature.local;
}

std::vector<Pair> pairs_in_contact(const Gas& gas) {
  std::vector<Pair> pairs;
  for (const GrainContact& contact : gas.contacts()) pairs.push_back(contact.pair);
  return pairs;
}

namespace {

/// Returns the bodies with positions, momenta and charges of a snapshot; masses, radii and box are those of `like`.
Bodies bodies_of(const device::Snapshot& snapshot, const Bodies& like) {
  const std::size_t n = snapshot.grains.size();
  Bodies bodies = like;
  bodies.position.resize(3 * n);
  bodies.momentum.resize(3 * n);
  if (snapshot.charged) bodies.charge.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const device::GrainRecord& grain = snapshot.grains[i];
    for (int k = 0; k < 3; ++k) {
      bodies.position[3 * i + k] = grain.position[k];
      bodies.momentum[3 * i + k] = grain.momentum[k];
    }
    if (snapshot.charged) bodies.charge[i] = grain.charge;
  }
  bodies.angular_velocity.clear();
  if (snapshot.rough && snapshot.rough->rotates)
    for (const device::RoughRecord& grain : snapshot.rough->grains)
      bodies.angular_velocity.insert(bodies.angular_velocity.end(), {grain.spin.x, grain.spin.y, grain.spin.z});
  return bodies;
}

std::vector<GrainContact> contacts_of(const device::Snapshot& snapshot) {
  std::vector<GrainContact> contacts;
  for (const device::OpenContact& c : snapshot.contacts)
    contacts.push_back({{c.i, c.j}, c.since, c.impact_speed, c.alone != 0});
  return contacts;
}

/// Returns the elastic and adhesive energy of the contacts of rough grains.
double rough_energy(const device::Snapshot& snapshot, const Bodies& bodies, const LawsOfContacts& laws,
                    std::vector<GrainContact> contacts) {
  Checkpoint saved;
  device::store_contacts(snapshot, saved);
  const auto motion = make_rough_motion(laws.normal, *laws.surface, bodies.dimension);
  motion->begin(bodies);
  motion->restore(saved);
  std::ranges::sort(contacts, {}, &GrainContact::pair);
  return motion->stored_energy(bodies, contacts);
}

}  // namespace

Note note_of(const device::Snapshot& snapshot, const Bodies& like, const LawsOfContacts& laws,
             const GasEnergy& before) {
  const Bodies bodies = bodies_of(snapshot, like);
  const std::vector<GrainContact> contacts = contacts_of(snapshot);
  std::vector<Pair> pairs;
  for (const GrainContact& contact : contacts) pairs.push_back(contact.pair);
  Note note{.time = snapshot.time, .energy = before};
  note.energy.kinetic = kinetic_energy(bodies);
  if (!bodies.inertia.empty()) note.energy.rotational = rotational_energy(bodies);
  note.energy.contact =
      snapshot.rough ? rough_energy(snapshot, bodies, laws, contacts) : stored_energy(laws.normal, bodies, contacts);
  note.energy.potential = snapshot.potential;
  note.energy.dissipated = snapshot.dissipated;
  note.energy.exchanged = snapshot.exchanged;
  note.energy.driven = snapshot.driven;
  note.gas = analysis::gas_state(bodies, pairs);
  note.contacts = static_cast<std::int64_t>(pairs.size());
  note.collisions = snapshot.count.collisions;
  return note;
}

void expect(Note& note, const Gas& gas, HomogeneousGas& theory) {
  theory.follow(gas, note.time, note.temperature());
  note.expected = {theory.temperature(), theory.collisions(), theory.charge_square()};
}

Note take_note(Gas& gas, std::optional<HomogeneousGas>& theory, double& analysis_seconds,
               std::optional<double> potential) {
  Note note{.time = gas.time(), .energy = gas.energy(potential)};
  const Stopwatch stopwatch(analysis_seconds);
  note.gas = analysis::gas_state(gas.bodies(), pairs_in_contact(gas));
  note.contacts = static_cast<std::int64_t>(gas.contacts().size());
  note.collisions = gas.collisions;
  if (theory) expect(note, gas, *theory);
  return note;
}

ColumnGroup columns_of(std::span<const Note> notes, const std::optional<HomogeneousGas>& theory) {
  Columns columns(notes);
  columns.real("time", "t0", [](const Note& n) { return n.time; });
  add_state(columns);
  add_energies(columns, notes);
  add_clusters(columns);
  if (theory) add_expectations(columns, *theory);
  return {"gas", columns.take()};
}

}  // namespace lichtenberg::granular
