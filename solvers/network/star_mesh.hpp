#pragma once

#include "solvers/parallel/team.hpp"

namespace lichtenberg::network {

/// Eliminates the first `stars` nodes of a dense network of m nodes by star-mesh transformations: g_ij += g_ki g_kj /
/// s_k with s_k = sum_j g_kj (elimination.hpp). `g`: [m, m], column-major, with conductances (S) below the diagonal.
/// Column k is overwritten by the conductances of node k at its elimination, with their sum s_k on the diagonal. The
/// last m - stars columns become the remaining mesh. Diagonal entries and those above are not conductances; they are
/// overwritten. Results have identical bits for any number of threads of `team`.
void eliminate_stars(double* g, int m, int stars, parallel::Team& team);

}  // namespace lichtenberg::network
