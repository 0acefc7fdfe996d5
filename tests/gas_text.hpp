#pragma once

#include <fmt/format.h>

#include <string>

namespace lichtenberg {

/// Scene file of `count` grains at temperature 1 that exchange charge, in a periodic cube of the given edge.
inline std::string gas_text(int count, int edge, double time, double every, const std::string& more = "") {
  return fmt::format(R"(
title = "Few grains"
[units]
[domain]
size = [{1}, {1}, {1}]
left = "periodic"
right = "periodic"
bottom = "periodic"
top = "periodic"
front = "periodic"
back = "periodic"
[[population]]
count = {0}
temperature = 1
{4}[effects.viscoelastic_contact]
[effects.charge_exchange]
[effects.coulomb]
sum = "minimum-image"
[stop]
time = {2}
[output]
every = {3}
)",
                     count, edge, time, every, more);
}

}  // namespace lichtenberg
