#pragma once

#include <string>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Refuses charge that has nowhere to go. With nothing at a given potential no field line can leave the
/// box: by Gauss's law the charges must cancel. Behind resistors a supply takes what is fed, but no charge that is
/// there at the first instant. `source`: the table that feeds charge, "effects.current_source", say; empty if nothing
/// does.
void check_ground(const Draft& draft, const Scene& scene, const std::string& source);

}  // namespace lichtenberg
