#pragma once

#include "src/scene/schema.hpp"

/// The tables that schema() lists, each with its keys; of this room alone.
namespace lichtenberg::tables {

inline constexpr Range positive{.low = 0, .low_itself = false};
inline constexpr Range not_negative{.low = 0};
inline constexpr Range accuracy{.low = 0, .high = 1, .low_itself = false, .high_itself = false};

Table top();
Table domain();
Table medium();
Table material();
Table electrode();
Table wall();
Table conductor();
Table group();
Table population();

Table effects();
Table floating_conductors();
Table current_source();
Table stokes_drag();
Table hertz_contact();
Table wall_contact();
Table contact_discharge();
Table leakage();
Table contact_resistance();
Table contact_potential();

Table minimize();
Table field();
Table mechanics();
Table network();
Table output();
Table stop();

}  // namespace lichtenberg::tables
