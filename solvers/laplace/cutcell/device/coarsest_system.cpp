#include "solvers/laplace/cutcell/device/coarsest_system.hpp"

#include <algorithm>

#include "solvers/error.hpp"

namespace lichtenberg::laplace::device {

namespace {

using Entries = std::vector<SparseFactors::Entry>;

/// Lower triangle.
void couple(Entries& entries, int a, int b, double conductance) {
  if (a >= 0 && b >= 0) entries.push_back({std::max(a, b), std::min(a, b), -conductance});
}

void couple_cells(const CoarsestArrays& arrays, const std::vector<int>& of_slot, Entries& entries) {
  const Layout& at = arrays.layout;
  for (int j = 0; j < at.ny; ++j)
    for (int i = 0; i < at.nx; ++i) {
      const std::ptrdiff_t slot = at(i, j);
      if (i + 1 < at.nx)
        couple(entries, of_slot[slot], of_slot[at(i + 1, j)], arrays.east.empty() ? 1.0f : arrays.east[slot]);
      if (j + 1 < at.ny)
        couple(entries, of_slot[slot], of_slot[at(i, j + 1)], arrays.north.empty() ? 1.0f : arrays.north[slot]);
    }
}

}  // namespace

CoarsestSystem::CoarsestSystem(const CoarsestArrays& arrays, bool pin) : groups_(arrays.group_diagonal.size()) {
  Entries entries;
  std::vector<int> of_slot(arrays.inverse_diagonal.size(), -1), of_group(groups_, -1);
  const auto add = [&](int name, double diagonal) {
    const int index = static_cast<int>(unknown_.size());
    entries.push_back({index, index, diagonal});
    unknown_.push_back(name);
    return index;
  };
  for (std::size_t slot = 0; slot < of_slot.size(); ++slot)
    if (arrays.inverse_diagonal[slot] > 0)
      of_slot[slot] = add(static_cast<int>(slot), 1.0 / arrays.inverse_diagonal[slot]);
  for (std::size_t g = 0; g < groups_; ++g)
    if (arrays.group_diagonal[g] > 0) of_group[g] = add(-1 - static_cast<int>(g), arrays.group_diagonal[g]);
  if (pin && !unknown_.empty()) {
    // Twice the last one's diagonal.
    const int last = static_cast<int>(unknown_.size()) - 1;
    entries.push_back({last, last, entries[last].value});
  }
  couple_cells(arrays, of_slot, entries);
  for (std::size_t m = 0; m < arrays.link_slot.size(); ++m)
    couple(entries, of_slot[arrays.link_slot[m]], of_group[arrays.link_group[m]], arrays.conductance[m]);
  for (const auto& [own, other, conductance] : arrays.direct_links)
    if (own < other) couple(entries, of_group[own], of_group[other], conductance);
  factors_ = SparseFactors(static_cast<int>(unknown_.size()), entries);
  if (!factors_.are_positive())
    throw Failure(
        "field solver: the Cholesky factorization of the coarsest grid failed (a conductor without any link?)");
}

void CoarsestSystem::solve(const std::vector<float>& f, const std::vector<float>& charge, std::vector<float>& v,
                           std::vector<float>& phi) const {
  std::vector<double> rhs(unknown_.size());
  for (std::size_t a = 0; a < unknown_.size(); ++a)
    rhs[a] = unknown_[a] >= 0 ? f[unknown_[a]] : charge[-1 - unknown_[a]];
  const std::vector<double> x = factors_.solve(rhs);
  for (std::size_t a = 0; a < unknown_.size(); ++a)
    (unknown_[a] >= 0 ? v[unknown_[a]] : phi[-1 - unknown_[a]]) = static_cast<float>(x[a]);
}

}  // namespace lichtenberg::laplace::device
