#pragma once

#include "src/scene/effect_kind.hpp"

/// Exports the effect kind of a file that Python compiles (lichtenberg.compile_effect). OPTIONS: the effect's struct of
/// options, with the static function kind().
#define LICHTENBERG_EFFECT(OPTIONS) \
  extern "C" const lichtenberg::EffectKind* lichtenberg_effect_kind() { return &OPTIONS::kind(); }
