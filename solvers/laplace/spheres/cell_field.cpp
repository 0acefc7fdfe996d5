#include "solvers/laplace/spheres/cell_field.hpp"

#include <algorithm>

namespace lichtenberg::laplace::spheres {

CellField::CellField(std::shared_ptr<const CellConvolution> convolution, const Cells& cells,
                     const std::vector<Site>& targets, const std::vector<Site>& sources)
    : convolution_(std::move(convolution)),
      targets_(targets),
      sources_(sources),
      target_start_(starts(targets)),
      source_start_(starts(sources)),
      cells_(cells.cells()) {
  up_ = batches(cells, sources);
  down_ = batches(cells, targets);
  translation_ = translation_up_to(convolution_->degree());
}

std::vector<CellField::Batch> CellField::batches(const Cells& cells, const std::vector<Site>& sites) const {
  std::vector<Member> members;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const auto at = cells.indices(sites[i].centre);
    members.push_back({static_cast<int>(i), cells.number(at), std::min(sites[i].degree, convolution_->degree()),
                       sites[i].centre - cells.centre(at)});
  }
  std::stable_sort(members.begin(), members.end(),
                   [](const Member& a, const Member& b) { return a.degree < b.degree; });
  std::vector<Batch> result;
  for (const Member& member : members) {
    if (result.empty() || result.back().count == lanes || result.back().degree != member.degree) {
      result.push_back({member.degree});
      for (int k = 0; k < lanes; ++k) result.back().directions.set(k, {0, 0, 1});
    }
    Batch& batch = result.back();
    const double length = norm(member.displacement);
    if (length > 0) batch.directions.set(batch.count, member.displacement);
    batch.length[batch.count] = length / convolution_->unit();
    batch.member[batch.count++] = member;
  }
  return result;
}

void CellField::gather(const double* multipoles, std::vector<double>& in_cells, parallel::Team& team) const {
  const int all = harmonics(convolution_->degree());
  moved_.resize(up_.size() * all);
  team.for_each(static_cast<int>(up_.size()), [&](int b) {
    move_to_cells(up_[b], multipoles, moved_.data() + static_cast<std::ptrdiff_t>(b) * all);
  });
  for (std::size_t b = 0; b < up_.size(); ++b)
    for (int k = 0; k < up_[b].count; ++k)
      for (int h = 0; h < all; ++h)
        in_cells[static_cast<std::ptrdiff_t>(h) * cells_ + up_[b].member[k].cell] += moved_[b * all + h][k];
}

void CellField::move_to_cells(const Batch& batch, const double* multipoles, Lanes* value) const {
  const int degree = convolution_->degree(), all = harmonics(degree);
  std::vector<Lanes> scratch(all);
  std::fill_n(value, all, Lanes{});
  for (int k = 0; k < batch.count; ++k) {
    const Member& member = batch.member[k];
    const double ratio = sources_[member.site].radius / convolution_->unit();
    double power = ratio;
    for (int l = 0; l <= batch.degree; ++l, power *= ratio)
      for (int m = -l; m <= l; ++m) value[at(l, m)][k] = power * multipoles[source_start_[member.site] + at(l, m)];
  }
  translation_->shift(batch.directions, {batch.length, true, batch.degree, degree}, value, scratch.data());
}

void CellField::spread(const std::vector<double>& in_cells, double* local, parallel::Team& team) const {
  team.for_each(static_cast<int>(down_.size()), [&](int b) { move_from_cells(down_[b], in_cells, local); });
}

void CellField::move_from_cells(const Batch& batch, const std::vector<double>& in_cells, double* local) const {
  const int degree = convolution_->degree(), all = harmonics(degree);
  std::vector<Lanes> value(all), scratch(all);
  for (int k = 0; k < batch.count; ++k)
    for (int h = 0; h < all; ++h)
      value[h][k] = in_cells[static_cast<std::ptrdiff_t>(h) * cells_ + batch.member[k].cell];
  translation_->shift(batch.directions, {batch.length, false, degree, batch.degree}, value.data(), scratch.data());
  for (int k = 0; k < batch.count; ++k) {
    const Member& member = batch.member[k];
    const double ratio = targets_[member.site].radius / convolution_->unit();
    double power = 1;
    for (int l = 0; l <= batch.degree; ++l, power *= ratio)
      for (int m = -l; m <= l; ++m) local[target_start_[member.site] + at(l, m)] += power * value[at(l, m)][k];
  }
}

void CellField::add(const double* multipoles, double* local, parallel::Team& team) const {
  up_values_.assign(static_cast<std::size_t>(harmonics(convolution_->degree())) * cells_, 0.0);
  down_values_.resize(up_values_.size());
  gather(multipoles, up_values_, team);
  convolution_->apply(up_values_, down_values_, team);
  spread(down_values_, local, team);
}

}  // namespace lichtenberg::laplace::spheres
