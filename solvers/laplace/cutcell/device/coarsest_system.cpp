#include "solvers/laplace/cutcell/device/coarsest_system.hpp"

#include <algorithm>

namespace lichtenberg::laplace::device {

SparseSystem assemble(const CoarsestArrays& arrays, bool pin) {
  SparseSystem system;
  std::vector<std::vector<SparseSystem::Entry>> rows;
  std::vector<int> slot_number(arrays.inverse_diagonal.size(), -1), group_number(arrays.group_diagonal.size(), -1);
  const auto add = [&](double diagonal) {
    const int index = static_cast<int>(rows.size());
    rows.push_back({{index, diagonal}});
    return index;
  };
  for (std::size_t slot = 0; slot < slot_number.size(); ++slot) {
    if (!(arrays.inverse_diagonal[slot] > 0)) continue;
    slot_number[slot] = add(1.0 / arrays.inverse_diagonal[slot]);
    system.slot.push_back(static_cast<std::ptrdiff_t>(slot));
  }
  for (std::size_t g = 0; g < group_number.size(); ++g) {
    if (!(arrays.group_diagonal[g] > 0)) continue;
    group_number[g] = add(arrays.group_diagonal[g]);
    system.group.push_back(static_cast<int>(g));
  }
  if (pin && !rows.empty()) rows.back().front().value *= 2;
  const auto couple = [&](int a, int b, double conductance) {
    if (a >= 0 && b >= 0) rows[std::max(a, b)].push_back({std::min(a, b), -conductance});
  };
  const Layout& at = arrays.layout;
  for (int j = 0; j < at.ny; ++j)
    for (int i = 0; i < at.nx; ++i) {
      const std::ptrdiff_t slot = at(i, j);
      const auto face = [&](const std::vector<float>& conductance) {
        return conductance.empty() ? 1.0f : conductance[slot];
      };
      if (i + 1 < at.nx) couple(slot_number[slot], slot_number[at(i + 1, j)], face(arrays.east));
      if (j + 1 < at.ny) couple(slot_number[slot], slot_number[at(i, j + 1)], face(arrays.north));
    }
  for (std::size_t m = 0; m < arrays.link_slot.size(); ++m)
    couple(slot_number[arrays.link_slot[m]], group_number[arrays.link_group[m]], arrays.conductance[m]);
  for (const auto& [own, other, conductance] : arrays.direct_links)
    if (own < other) couple(group_number[own], group_number[other], conductance);
  for (std::vector<SparseSystem::Entry>& row : rows) system.append(row);
  return system;
}

}  // namespace lichtenberg::laplace::device
