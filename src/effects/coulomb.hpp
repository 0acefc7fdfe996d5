#pragma once

#include <memory>
#include <optional>

#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/sum.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Methods to sum Coulomb forces in a periodic box. `mesh`: near pairs and a particle mesh. `ewald`: direct Ewald sum.
/// `minimum_image`: nearest images of pairs only. `shifted_force`: pairs up to a cutoff, with a shifted force.
enum class CoulombSum { mesh, ewald, minimum_image, shifted_force };

}  // namespace lichtenberg::effects

namespace lichtenberg {
template <>
inline constexpr Named<effects::CoulombSum> values_named<effects::CoulombSum>[] = {
    {effects::CoulombSum::mesh, "mesh"},
    {effects::CoulombSum::ewald, "ewald"},
    {effects::CoulombSum::minimum_image, "minimum-image"},
    {effects::CoulombSum::shifted_force, "shifted-force"}};
}  // namespace lichtenberg

namespace lichtenberg::effects {

/// Parameters of the Coulomb forces between grains: coupling constant, method of the sum and its accuracy or numerical
/// parameters. Reduced units.
struct CoulombOptions {
  double strength = 1;  ///< coupling constant K of the energy K q_i q_j / r
  CoulombSum sum = CoulombSum::mesh;
  double accuracy = 1e-4;        ///< for mesh and ewald: rms error of the forces over the rms force
  std::optional<double> cutoff;  ///< cutoff distance of near pairs (d0), for mesh and shifted_force
  std::optional<double> alpha;   ///< Ewald's splitting parameter (1/d0), for mesh
  std::optional<int> mesh;       ///< number of mesh points along the longest side
  std::optional<int> order;      ///< order of the windows that spread charges to the mesh
  double damping = 0;            ///< alpha of the damped interaction erfc(alpha r) / r (1/d0), for shifted_force

  static const EffectKind& kind();
};

/// Effect of Coulomb forces between the charges of grains in a periodic box, by the sum that the scene selects
/// (CoulombSum). Includes induced dipoles if the scene has effects.induced_dipoles. Units are reduced; energies (m0
/// v0^2) are proportional to the coupling constant K.
class Coulomb : public Effect {
 public:
  explicit Coulomb(const Scene& scene);
  ~Coulomb() override;

  const EffectKind& kind() const override { return CoulombOptions::kind(); }
  Needs needs() const override;
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;
  void save(Checkpoint& checkpoint) const override;
  bool saves_exactly() const override;
  void restore(const Checkpoint& checkpoint) override;
  std::map<std::string, double> seconds() const override;
  std::vector<std::string> warnings() const override;
  void add_columns(const State& state, Frame& frame) const override;
  void summarize(const State& state, Summary& summary) const override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg::effects
