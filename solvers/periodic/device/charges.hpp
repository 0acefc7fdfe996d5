#pragma once

// Periodic sums on an executor: order of their near and mesh parts.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/periodic/device/device.hpp"
#include "solvers/periodic/device/images.hpp"
#include "solvers/periodic/device/mesh.hpp"

namespace lichtenberg::periodic::device {

/// Returns the power of two that scales charges of magnitude up to `largest` to at most 1; 1 if `largest` is 0.
LICHTENBERG_HOST_DEVICE inline double charge_scale(double largest) {
  return largest > 0 ? std::ldexp(1.0, -std::ilogb(largest) - 1) : 1;
}

/// Periodic Coulomb sum of charges (and dipoles) in device memory: fields, potentials and energy by near part and mesh,
/// and with dipoles also forces. The caller sorts the charges by cells and scales them to at most 1. Results have
/// identical bits for any order of the charges.
template <class Executor>
class ChargeSums {
 public:
  /// Prepares sums with the given tables; `run` must outlive this object.
  ChargeSums(const Executor& run, const MeshTables& tables)
      : run_(&run), tables_(tables), mesh_(run, tables), field_at_source_(run), force_(run), totals_(run) {
    totals_.resize(1);
    if (tables.mirrors.copies() > 1) images_.emplace(run, tables);
  }

  double cutoff() const { return tables_.cutoff; }          ///< Cut-off of the near part (length)
  double background() const { return tables_.background; }  ///< Potential of the background per total charge
  Vec3 lengths() const { return tables_.mesh.lengths; }     ///< Edges of the box
  /// Returns true if grounded sides add image charges. The sum then finds pairs of charges itself, and ignores lists.
  bool has_images() const { return images_.has_value(); }
  /// Returns these pairs, for has_images().
  TableView image_partners() const { return images_->partners(); }
  MeshPart<Executor>& mesh() { return mesh_; }
  const MeshTables& tables() const { return tables_; }

  /// Allocates memory for the results of n charges, set to 0 if n has changed.
  void resize_results(int n) {
    if (n != n_) {
      field_at_source_.resize(n);
      force_.resize(n);
      field_at_source_.zero(),
          force_.zero();  // Grains are sorted together with these arrays before the first evaluation
    }
    n_ = n;
  }
  /// Prepares sums for n charges that are sorted by `cells` and move by at most `moved` (length) before the next
  /// sorting. at(s) returns the position of charge s. `own`: charges of this rank. It spreads them and computes the
  /// fields at them.
  template <class At>
  void arrange(const RingRange& own, const CellsView& cells, double moved, At at) {
    const int n = own.size;
    own_ = own;
    resize_results(n);
    if (images_) images_->arrange(n, cutoff() + 2 * moved, at);
    images_ ? mesh_.arrange(RingRange::whole(images_->size()), images_->cells(), moved)
            : mesh_.arrange(own, cells, moved);
  }
  /// Computes the fields of charges and, if `potentials` is true, potentials and energy, which are incomplete
  /// otherwise. `partners`: neighbour list; partners beyond the cut-off do not change the result.
  void evaluate(const PointCharge* charges, const TableView& partners, bool potentials) {
    if (!images_)
      return sum({own_.count, partners, charges, nullptr, field_at_source_.data(), nullptr, own_.first}, potentials);
    images_->fill(charges);
    sum({images_->size(), images_->partners(), images_->charges(), nullptr, images_->field(), nullptr}, potentials);
    images_->take(field_at_source_.data(), totals_.data());
  }
  /// Computes the fields of charges, as evaluate(), without images.
  void sum(const NearArrays& of, bool potentials) {
    // Spreading occupies the whole device; transforms do not, so the near part runs concurrently with them.
    run_->run_concurrently(
        [&] {
          mesh_.template spread<Kind::charges>(of.charges);
          mesh_.solve();
        },
        [&] {
          totals_.zero();
          compute_near<Kind::charges>(*run_, tables_.near, of, potentials);
        });
    mesh_.template gather<Kind::charges>({of.charges, nullptr, of.field_at_source, nullptr}, totals_.data());
    run_->sum_over_ranks(reinterpret_cast<double*>(totals_.data()), sizeof(Totals) / sizeof(double));
  }
  /// Computes fields, potentials, energy and forces of charges with dipoles (`moments`).
  void evaluate(const PointCharge* charges, const Moment* moments, const TableView& partners) {
    run_->run_concurrently(
        [&] {
          mesh_.template spread<Kind::multipoles>(charges, moments);
          mesh_.solve();
        },
        [&] {
          totals_.zero();
          compute_near<Kind::multipoles>(*run_, tables_.multipoles,
                                         {n_, partners, charges, moments, field_at_source_.data(), force_.data()});
        });
    mesh_.template gather<Kind::multipoles>({charges, moments, field_at_source_.data(), force_.data()}, totals_.data());
  }
  /// Computes the field of the dipoles alone at each other's positions; overwrites `field`.
  void dipole_field(const PointCharge* charges, const Moment* moments, const TableView& partners, FieldSample* field) {
    run_->run_concurrently(
        [&] {
          mesh_.template spread<Kind::dipoles>(charges, moments);
          mesh_.solve();
        },
        [&] { near_dipole_field(charges, moments, partners, field); });
    mesh_.template gather<Kind::dipoles>({charges, moments, field, nullptr}, nullptr);
  }
  /// Computes the near part of the dipoles' field alone, without the mesh; overwrites `field`.
  void near_dipole_field(const PointCharge* charges, const Moment* moments, const TableView& partners,
                         FieldSample* field) {
    compute_near<Kind::dipoles>(*run_, tables_.multipoles, {n_, partners, charges, moments, field, nullptr});
  }
  /// Returns the fields and potentials at the sources, in device memory.
  FieldSample* field_at_source() const { return field_at_source_.data(); }
  /// Returns the forces on charges with dipoles, in device memory, after an evaluation with dipoles. The component
  /// `potential` contains the weight of the source for the correction of the net force. The caller subtracts
  /// (net force) * weight / Totals::square from each force. Totals::square is the sum of the weights.
  FieldSample* force() const { return force_.data(); }
  /// Returns the sums over all charges, in device memory.
  const Totals* totals() const { return totals_.data(); }
  Totals* totals_to_change() const { return totals_.data(); }
  std::vector<FieldSample> download_fields() const { return field_at_source_.download(); }
  std::vector<FieldSample> download_force() const { return force_.download(); }
  Totals download_totals() const { return totals_.download().front(); }

 private:
  const Executor* run_;
  MeshTables tables_;
  MeshPart<Executor> mesh_;
  std::optional<ImageCharges<Executor>> images_;
  int n_ = 0;
  RingRange own_;
  parallel::Array<FieldSample, Executor> field_at_source_, force_;
  parallel::Array<Totals, Executor> totals_;
};

/// Implementation of DeviceMesh on an executor: copies positions and charges to the device, computes the sums there,
/// and copies the results back.
template <class Executor>
class DeviceMeshOn final : public DeviceMesh {
 public:
  DeviceMeshOn(std::unique_ptr<Executor> run, const MeshTables& tables)
      : run_(std::move(run)),
        sums_(*run_, tables),
        cells_(*run_, tables.mesh.lengths, cell_edges(tables, 0)),
        table_(*run_),
        unsorted_(*run_),
        charges_(*run_),
        unsorted_moments_(*run_),
        moments_(*run_) {}

  void evaluate(const Sources& sources, std::span<const Pair>, parallel::Team&, Response& response) override {
    arrange(sources, 0);
    const bool dipoles = !sources.dipole.empty();
    if (dipoles)
      sums_.evaluate(charges_.data(), moments_.data(), table_.view());
    else
      sums_.evaluate(charges_.data(), table_.view(), true);
    const std::vector<FieldSample> field_at_source = sums_.download_fields(), force = sums_.download_force();
    const Totals totals = sums_.download_totals();
    const std::vector<int> order = downloaded_order(sources.size());
    const double back = 1 / scale_, square = totals.square > 0 ? totals.square : 1;
    const Vec3 off{totals.x / square, totals.y / square, totals.z / square};
    const double background = sums_.background() * totals.charge;
    const std::size_t n = order.size();
    response.potential.resize(n);
    response.field.resize(3 * n);
    response.force.resize(3 * n);
    for (std::size_t s = 0; s < n; ++s) {
      const int i = order[s];
      const double charge = scale_ * sources.charge[i],
                   field[3] = {field_at_source[s].x, field_at_source[s].y, field_at_source[s].z},
                   net_force[3] = {force[s].x, force[s].y, force[s].z};
      response.potential[i] = back * (field_at_source[s].potential + background);
      for (int k = 0; k < 3; ++k) {
        response.field[3 * i + k] = back * field[k];
        response.force[3 * i + k] =
            back * back *
            (dipoles ? net_force[k] - force[s].potential * off[k] : charge * (field[k] - charge * off[k]));
      }
    }
    response.energy = back * back * (totals.energy + 0.5 * background * totals.charge);
    if (!std::isfinite(response.energy))
      throw InputError("the energy of the charges is not finite: two of them have the same position");
  }

  void dipole_field(const Sources& sources, std::span<const Pair>, parallel::Team&, std::span<double> field) override {
    arrange(sources, 0);
    parallel::Array<FieldSample, Executor> found(*run_);
    found.resize(sources.size());
    sums_.dipole_field(charges_.data(), moments_.data(), table_.view(), found.data());
    const std::vector<FieldSample> field_at_source = found.download();
    const std::vector<int> order = downloaded_order(sources.size());
    for (std::size_t s = 0; s < order.size(); ++s) {
      const double of[3] = {field_at_source[s].x, field_at_source[s].y, field_at_source[s].z};
      for (int k = 0; k < 3; ++k) field[3 * order[s] + k] = of[k] / scale_;
    }
  }

  Profile profile(const Sources& sources, double skin, int repeats) override {
    if (sums_.has_images()) throw InputError("Times of sums with grounded sides are not measured.");
    Profile profile;
    const auto timed = [&](auto&& work) {
      work();
      return run_->seconds([&] {
        for (int k = 0; k < repeats; ++k) work();
      }) / repeats;
    };
    profile.lists = timed([&] { arrange(sources, skin); });
    profile.partners = static_cast<double>(table_.entries()) / sources.size();
    const MeshTables& tables = sums_.tables();
    const int n = sources.size();
    parallel::Array<FieldSample, Executor> field_at_source(*run_);
    field_at_source.resize(n);
    parallel::Array<Totals, Executor> totals(*run_);
    totals.resize(1);
    profile.near = timed([&] {
      compute_near<Kind::charges>(*run_, tables.near,
                                  {n, table_.view(), charges_.data(), nullptr, field_at_source.data(), nullptr}, false);
    });
    profile.spread = timed([&] { sums_.mesh().template spread<Kind::charges>(charges_.data()); });
    profile.transforms = timed([&] { sums_.mesh().solve(); });
    profile.gather = timed([&] {
      sums_.mesh().template gather<Kind::charges>({charges_.data(), nullptr, field_at_source.data(), nullptr},
                                                  totals.data());
    });
    typename Executor::Recording forces, potentials;
    profile.forces = timed([&] { run_->run(forces, [&] { sums_.evaluate(charges_.data(), table_.view(), false); }); });
    profile.with_potentials =
        timed([&] { run_->run(potentials, [&] { sums_.evaluate(charges_.data(), table_.view(), true); }); });
    return profile;
  }

  /// Copies the sources to the device, sorts them by cells, and makes the neighbour list. Its range is the cut-off plus
  /// `skin`, or half of the shortest edge of the box if that is shorter. Public because nvcc requires this of functions
  /// that contain kernels.
  void arrange(const Sources& sources, double skin) {
    require_consistent(sources);
    const Vec3 lengths = sums_.lengths();
    if (sources.lengths != lengths) throw InputError("The box is not the one that the mesh was made for.");
    const int n = sources.size();
    upload(sources);
    charges_.resize(n);
    const PointCharge* from = unsorted_.data();
    const Moment* unsorted_moments = sources.dipole.empty() ? nullptr : unsorted_moments_.data();
    if (unsorted_moments) moments_.resize(n);
    PointCharge* to = charges_.data();
    Moment* moments = moments_.data();
    cells_.sort(n, [=] LICHTENBERG_HOST_DEVICE(int i) { return from[i].at; });
    const int* order = cells_.order();
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      to[s] = from[order[s]];
      if (unsorted_moments) moments[s] = unsorted_moments[order[s]];
    });
    const double half = 0.5 * sources.shortest_length();
    table_.build(n, cells_.view(), lengths, std::min(sums_.cutoff() + skin, half),
                 [=] LICHTENBERG_HOST_DEVICE(int s) { return to[s].at; });
    sums_.arrange(RingRange::whole(n), cells_.view(), skin / 2,
                  [=] LICHTENBERG_HOST_DEVICE(int s) { return to[s].at; });
  }

 private:
  /// Copies the sources to the device, scaled by a power of two so that no charge, and no component of a dipole in
  /// these units, exceeds 1.
  void upload(const Sources& sources) {
    if (!sources.dipole.empty() && sums_.has_images())
      throw InputError("There are no dipoles between grounded sides on a device.");
    if (!sources.dipole.empty() && sums_.tables().multipoles.kernels.terms == 0)
      throw InputError("Dipoles on a device need splines of order 5 at least, and an accuracy of 1e-6 at most.");
    const int n = sources.size();
    const Vec3 lengths = sums_.lengths();
    double largest = 0;
    for (const double q : sources.charge) largest = std::max(largest, std::abs(q));
    for (const double m : sources.dipole) largest = std::max(largest, std::abs(m));
    scale_ = charge_scale(largest);
    std::vector<PointCharge> charged(n);
    for (int i = 0; i < n; ++i)
      charged[i] = {{fixed_point_coordinate(sources.position[3 * i], units_per_box / lengths.x),
                     fixed_point_coordinate(sources.position[3 * i + 1], units_per_box / lengths.y),
                     fixed_point_coordinate(sources.position[3 * i + 2], units_per_box / lengths.z)},
                    static_cast<float>(scale_ * sources.charge[i])};
    unsorted_.upload(charged);
    if (sources.dipole.empty()) return;
    std::vector<Moment> moments(n);
    const auto scaled = [&](int k) { return static_cast<float>(scale_ * sources.dipole[k]); };
    for (int i = 0; i < n; ++i) moments[i] = {scaled(3 * i), scaled(3 * i + 1), scaled(3 * i + 2)};
    unsorted_moments_.upload(moments);
  }
  std::vector<int> downloaded_order(int n) const {
    std::vector<int> order(n);
    run_->to_host(order.data(), cells_.order(), order.size() * sizeof(int));
    return order;
  }

  std::unique_ptr<Executor> run_;
  ChargeSums<Executor> sums_;
  CellGrid<Executor> cells_;
  NeighbourTable<Executor> table_;
  parallel::Array<PointCharge, Executor> unsorted_, charges_;
  parallel::Array<Moment, Executor> unsorted_moments_, moments_;
  double scale_ = 1;
};

}  // namespace lichtenberg::periodic::device
