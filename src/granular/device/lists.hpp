#pragma once

// Sorted grains and neighbour tables of a gas: candidate pairs of contacts, near charges, partners of pair laws. Each
// entry of the table of candidate pairs stores the data of a contact.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "solvers/periodic/device/dipoles.hpp"
#include "src/granular/device/state.hpp"

namespace lichtenberg::granular::device {

/// Returns the edge lengths (d0) of the cells of the neighbour search for n grains without Coulomb forces. `lengths`:
/// box lengths (d0). Cells are larger in a very dilute gas, so that memory and time are proportional to the number of
/// grains.
inline Vec3 contact_cell_edges(Vec3 lengths, int n) {
  const Vec3 shortest{1, 1, 0.5};
  const double cells = lengths.x * lengths.y * lengths.z / (shortest.x * shortest.y * shortest.z);
  const double most = 64.0 * n + 4096;
  return std::max(1.0, std::cbrt(cells / most)) * shortest;
}

/// Neighbour lists of a gas on an executor (CPU or CUDA device). The lists are candidate pairs of contacts with the
/// data of the contacts, near charges of Coulomb sums, and partners of pair force laws. Sorts the grains by search
/// cells.
template <class Executor>
class GasLists {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  using Sums = std::optional<ChargeSums<Executor>>;
  using Dipoles = std::optional<periodic::device::InducedDipolesOn<Executor>>;
  /// Pointers and sizes of the lists with which kernels were recorded. Kernels must be recorded again if any of these
  /// changes.
  struct Kernels {
    std::vector<const void*> arrays;
    std::size_t capacity = 0;
    int columns = 0, partner_columns = 0, reach_columns = 0;
    double skin = 0;

    bool operator==(const Kernels&) const = default;
  };

  explicit GasLists(GasState<Executor>& state)
      : run_(state.run),
        state_(&state),
        cells_(*run_, state.search_lengths, cell_edges(state)),
        table_(*run_),
        partners_(*run_),
        in_reach_(*run_) {
    sorted_index_.resize(state.n);
    for (const DevicePartForm& part : state.options.parts) reach_ = std::max(reach_, part.reach);
  }

  /// Returns the skin (d0) of the neighbour lists; 0 if there are no lists. Lists are valid until a grain has moved by
  /// more than half of the skin.
  double skin() const { return skin_; }
  /// Returns the neighbour table of near charges (Coulomb sum). It has all partners of each grain within the cutoff,
  /// and some beyond it.
  TableView partners() const { return near_charges_; }
  /// Returns the neighbour table of the pair force laws. It has all partners of each grain within the largest cutoff of
  /// the laws, and some beyond it.
  TableView in_reach() const { return in_reach_.view(); }
  /// Returns the number of entries of the table of candidate pairs. The arrays of candidate and of active pairs have
  /// this length.
  long entries() const { return static_cast<long>(near_.size()); }

  /// Divides new search lengths of the gas into cells.
  void divide() { cells_ = CellGrid<Executor>(*run_, state_->search_lengths, cell_edges(*state_)); }

  /// Sorts the grains and rebuilds the neighbour lists. `travel`: bound on displacements in the next step (d0), from
  /// which the skin follows. The contacts and the data of `sums` and `dipoles` are kept.
  void arrange(double travel, Sums& sums, Dipoles& dipoles) {
    GasState<Executor>& gas = *state_;
    // Keeps a skin of up to twice the present need, because recorded kernels contain it.
    const double skin = skin_for(std::max(travel, least_travel));
    if (!(skin <= skin_ && skin_ <= 2 * skin)) skin_ = 1.2 * skin;
    if (sums) sums->resize_results(gas.n);
    if (loaded_) gas.join(sums ? sums->field_at_source() : nullptr);
    sort_cells();
    if (loaded_) list_open();
    if (gas.share.is_divided()) divide_grains(sums);
    gas.permute(cells_.order(), sums ? sums->field_at_source() : nullptr);
    if (dipoles) dipoles->permute(cells_.order());
    build(sums);
    resize_contacts();
    take_open();
  }

  /// Returns the sorted order of the grains in device memory, as in CellGrid.
  const int* order() const { return cells_.order(); }

  /// Loads the present contacts (begun and not ended) from a checkpoint, and discards the neighbour lists.
  void load(const Checkpoint& checkpoint) {
    const auto& pairs = integers(checkpoint, "contact_pairs");
    const auto& touches = lichtenberg::reals(checkpoint, "contact_touches", pairs.size() / 3 * 2);
    std::vector<OpenContact> open;
    for (std::size_t k = 0; 3 * k < pairs.size(); ++k)
      open.push_back({static_cast<int>(pairs[3 * k]), static_cast<int>(pairs[3 * k + 1]), touches[2 * k],
                      touches[2 * k + 1], pairs[3 * k + 2] != 0});
    open_.upload(open);
    if (is_rough()) open_spring_.upload(springs_in(checkpoint, open.size()));
    loaded_ = false;
    skin_ = 0;
  }
  /// Returns the present contacts (begun and not ended) in device memory, in any order.
  const Array<OpenContact>& contacts() const {
    if (loaded_) list_open();
    return open_;
  }

  /// Returns the elongations of the springs of the contacts, in their order, on the host.
  std::vector<Vec3> springs() const { return open_spring_.download(); }

  ContactsView view() const {
    ContactsView view = contacts_.view;
    view.table = table_.view(), view.near = near_.data();
    return view;
  }
  Kernels kernels() const {
    const TableView table = table_.view(), partners = near_charges_, in_reach = in_reach_.view();
    const ContactsView c = view();
    return {
        {table.start,    table.partner, partners.start, partners.partner, in_reach.start, in_reach.partner, c.since,
         c.impact_speed, c.alone,       c.owner,        c.near,           c.active,       c.state,          c.scale,
         c.force,        c.halfway,     c.first,        c.next,           c.onset,        c.spring,         c.rough},
        near_.capacity(),
        table.columns,
        partners.columns,
        in_reach.columns,
        skin_};
  }

  // Public because nvcc requires it of functions with kernels.

  void sort_cells() {
    const Vec3* position = state_->view().position;
    const Vec3 units_per_length = state_->units_per_length();
    cells_.sort(state_->n,
                [=] LICHTENBERG_HOST_DEVICE(int i) { return fixed_point_position(position[i], units_per_length); });
  }
  /// Builds the neighbour tables for the sorted grains.
  void build(Sums& sums) {
    const GasState<Executor>& gas = *state_;
    const CompactGrain* compact = gas.view().compact;
    const auto position_of = [=] LICHTENBERG_HOST_DEVICE(int s) { return compact[s].at; };
    const ShareOfGrains& share = gas.share.range();
    table_.build(share.rows, cells_.view(), gas.search_lengths, 2 * gas.largest_radius + skin_, position_of, true);
    state_->share.find_entries(table_.view());
    if (reach_ > 0) in_reach_.build(gas.n, cells_.view(), gas.search_lengths, reach_ + skin_, position_of);
    if (!sums) return;
    sums->arrange(share.own, cells_.view(), 0.5 * skin_, position_of);
    if (sums->has_images())
      near_charges_ = sums->image_partners();
    else
      partners_.build(share.own, cells_.view(), gas.search_lengths, sums->cutoff() + skin_, position_of),
          near_charges_ = partners_.view();
  }
  /// Allocates the arrays for the entries of the table of candidate pairs and for active pairs. Sets the owner of each
  /// entry.
  void resize_contacts() {
    const std::size_t entries = table_.entries();
    ContactsView& c = contacts_.view;
    near_.resize(entries);
    contacts_.resize(entries, c.since, c.impact_speed, c.alone, c.owner, c.active);
    if (is_rough())
      contacts_.resize(entries, c.spring, c.rough);
    else
      contacts_.resize(entries, c.state, c.scale, c.force, c.halfway, c.first);
    contacts_.resize(2 * entries, c.next);
    if (state_->exchanges_in_order()) contacts_.resize(entries, c.onset);
    const TableView table = table_.view();
    int* owner = c.owner;
    run_->for_each(state_->n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      for (int e = table.begin(s); e < table.end(s); ++e) owner[e] = s;
    });
  }
  /// Copies the present contacts from the entries of the table to open_, in any order.
  void list_open() const {
    open_count_.resize(1);
    open_count_.zero();
    open_.resize(table_.entries());
    int* count = open_count_.data();
    OpenContact* open = open_.data();
    if (is_rough()) open_spring_.resize(table_.entries());
    Vec3* spring = open_spring_.data();
    const ContactsView c = view();
    const int* number = state_->view().number;
    const RingRange own = state_->share.range().own;
    const long entries = static_cast<long>(table_.entries());
    run_->select(
        entries, [=] LICHTENBERG_HOST_DEVICE() { return static_cast<int>(entries); }, count,
        [=] LICHTENBERG_HOST_DEVICE(int e) { return c.since[e] >= 0 && own.contains(c.owner[e]); },
        [=] LICHTENBERG_HOST_DEVICE(int index, int e) {
          const int i = number[c.owner[e]], j = number[c.table.partner[e]];
          open[index] = {i < j ? i : j, i < j ? j : i, c.since[e], c.impact_speed[e], c.alone[e]};
          if (spring) spring[index] = c.spring[e];
        });
    int all = 0;
    run_->to_host(&all, count, sizeof(int));
    open_.resize(all);
    if (is_rough()) open_spring_.resize(all);
    state_->share.join(open_, spare_open_);
  }
  /// Copies the present contacts from open_ to the entries of the new table.
  void take_open() {
    int* sorted_index = sorted_index_.data();
    const int* number = state_->view().number;
    run_->for_each(state_->n, [=] LICHTENBERG_HOST_DEVICE(int s) { sorted_index[number[s]] = s; });
    const ContactsView c = view();
    run_->fill(c.since, 0xff, table_.entries() * sizeof(double));  // NaN: no contact
    const OpenContact* open = open_.data();
    const Vec3* spring = open_spring_.data();
    run_->for_each(static_cast<long>(open_.size()), [=] LICHTENBERG_HOST_DEVICE(int k) {
      const int i = sorted_index[open[k].i], j = sorted_index[open[k].j], s = i < j ? i : j, other = i < j ? j : i;
      for (int e = c.table.begin(s); e < c.table.end(s); ++e) {
        if (c.table.partner[e] != other) continue;
        c.since[e] = open[k].since, c.impact_speed[e] = open[k].impact_speed, c.alone[e] = open[k].alone;
        if (spring) c.spring[e] = spring[k];
      }
    });
    loaded_ = true;
  }

 private:
  static constexpr double least_travel = 0.02;  ///< smallest `travel` (d0) from which a skin is chosen

  /// Returns the skin (d0) of least cost for a bound `travel` (d0) on displacements in a step. Lists that take a time L
  /// to build are valid for about skin / travel steps, because `travel` is twice the path of the fastest grain. A skin
  /// adds a * skin to the time of a step. The total time is least at sqrt(L travel / a); L / a is taken as 8 d0.
  /// Lists are valid for at least about two steps.
  static double skin_for(double travel) { return std::max(2.8 * std::sqrt(travel), 3 * travel); }

  bool is_rough() const { return state_->options.rough; }
  /// Returns the elongations of the springs of `count` contacts in a checkpoint; 0 if it has none.
  static std::vector<Vec3> springs_in(const Checkpoint& checkpoint, std::size_t count) {
    std::vector<Vec3> springs(count);
    const auto saved = checkpoint.reals.find("surface_springs");
    if (saved == checkpoint.reals.end() || saved->second.size() != 3 * count) return springs;
    const double* of = saved->second.data();
    for (std::size_t k = 0; k < count; ++k) springs[k] = {of[3 * k], of[3 * k + 1], of[3 * k + 2]};
    return springs;
  }

  /// Divides the grains among ranks, in the order of rank 0. A substep of a grain depends on those up to
  /// contacts_in_substep contacts away. Before the next sorting, grains in contact are at most `contact` apart in the
  /// present positions.
  void divide_grains(const Sums& sums) {
    cells_.share_order();
    const double contact = 2 * state_->largest_radius + skin_,
                 layer = state_->search_lengths.x / cells_.view().cells[0];
    const auto layers = [&](double length) { return static_cast<int>(std::ceil(length / layer)); };
    const int rows = layers(contacts_in_substep * contact);
    state_->share.divide(cells_.layer_starts(), rows,
                         std::max(rows + layers(contact), layers(sums ? sums->cutoff() + skin_ : 0)));
  }
  static Vec3 cell_edges(const GasState<Executor>& state) {
    if (state.options.tables) return periodic::device::cell_edges(*state.options.tables, 0.6);
    return contact_cell_edges(state.search_lengths, state.n);
  }

  const Executor* run_;
  GasState<Executor>* state_;
  double skin_ = 0;
  bool loaded_ = false;  ///< true: the table has the open contacts; false: only open_ has them
  CellGrid<Executor> cells_;
  NeighbourTable<Executor> table_, partners_;  ///< candidate pairs; near charges without images
  TableView near_charges_;                     ///< near charges; with images those of the sum
  NeighbourTable<Executor> in_reach_;          ///< partners of pair laws
  double reach_ = 0;                           ///< d0, largest cutoff of these laws

  // Data per entry of table_; also the capacity for candidate and active pairs.
  parallel::Arrays<ContactsView, Executor> contacts_{*run_};  ///< except the table and the candidate pairs
  Array<NearPair> near_{*run_};

  mutable Array<OpenContact> open_{*run_}, spare_open_{*run_};
  mutable Array<Vec3> open_spring_{*run_};  ///< of these contacts; empty for smooth grains
  mutable Array<int> open_count_{*run_};
  Array<int> sorted_index_{*run_};  ///< [N], sorted index by number
};

}  // namespace lichtenberg::granular::device
