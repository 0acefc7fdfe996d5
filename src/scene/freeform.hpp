#pragma once

#include <memory>
#include <string>

#include "solvers/geometry/closed_curve.hpp"
#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Returns true if the electrode's shape is a closed curve: polygon, ellipse or curve.
bool is_freeform(const ElectrodeDraft& electrode);

/// Makes the surface of a polygon, ellipse or curve. Throws InputError for one that is open, crosses or touches itself,
/// encloses no area or is too small for its rounded corners. Throws InputError for one that lies outside the domain, is
/// hollow without reaching into the domain, or is thinner than a cell of the field's grid.
std::shared_ptr<const ClosedCurve> make_freeform(const Draft& draft, const ElectrodeDraft& electrode,
                                                 const std::string& name);

// Overloads that return true if two bodies touch.

bool touch(const Freeform& a, const Disk& b);
bool touch(const Freeform& a, const Bar& b);
bool touch(const Freeform& a, const Ring& b);
bool touch(const Freeform& a, const Freeform& b);

/// Checks that the field method supports closed curves. Throws InputError if it does not.
void check_freeforms(const Draft& draft, const std::vector<Electrode>& electrodes);

}  // namespace lichtenberg
