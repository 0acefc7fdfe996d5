#pragma once

#include <memory>
#include <optional>

#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/sum.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Methods to sum the forces of charges in a periodic box.
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

struct CoulombOptions {
  double strength = 1;  ///< K
  CoulombSum sum = CoulombSum::mesh;
  double accuracy = 1e-4;        ///< mesh and ewald: rms error of a force over rms force
  std::optional<double> cutoff;  ///< d0, for mesh and shifted_force
  std::optional<double> alpha;   ///< 1/d0, for mesh
  std::optional<int> mesh;       ///< points along the longest side
  std::optional<int> order;      ///< order of the mesh's splines
  double damping = 0;            ///< 1/d0, for shifted_force

  static const EffectKind& kind();
};

/// Coulomb forces between the charges of grains and all their images, with the induced dipoles that the scene
/// specifies. Energies are in m0 v0^2: K times those of solvers/periodic.
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
