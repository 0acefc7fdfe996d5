#pragma once

#include <memory>

#include "src/effects/device_pair.hpp"
#include "src/model/pair_effect.hpp"
#include "tests/extension/yukawa_law.hpp"
#include "tests/grains.hpp"

namespace lichtenberg {

struct YukawaOptions {
  YukawaLaw law;
  static const EffectKind& kind();
};

inline const YukawaLaw& law_in(const Scene& scene) { return scene.effects.find<YukawaOptions>()->law; }

inline const EffectKind& YukawaOptions::kind() {
  static const EffectKind kind = {
      .name = "yukawa",
      .description = "charges repel each other behind a screen",
      .options = YukawaOptions{},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .make =
          [](const Scene& scene) {
            return std::make_unique<PairEffect<YukawaLaw>>(YukawaOptions::kind(), law_in(scene), scene);
          },
      .steps = {.force_length = [](const Scene& scene) { return law_in(scene).screen; },
                .contact_attraction =
                    [](const Scene& scene) { return ContactAttraction{.by_charge = law_in(scene).bare(1).force}; }},
      .device =
          [](const Scene& scene, effects::DeviceForces& forces) {
            effects::add_pair_law_with_kernels(scene, law_in(scene), forces);
          }};
  return kind;
}

/// Charges of 1 and -1 at random positions; contacts are elastic.
inline Scene yukawa_gas() {
  Scene scene = grains::cube(8);
  scene.mechanics.step = 0.01;
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 0});
  scene.effects.add(YukawaOptions{});
  grains::add_gas(scene, 60, 6.9, 1);
  grains::charge_alternately(scene, 1);
  return scene;
}

}  // namespace lichtenberg
