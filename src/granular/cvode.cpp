#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"
#include "src/granular/integrator.hpp"
#include "src/granular/pair_state.hpp"

namespace lichtenberg::granular {
namespace {

/// Integrator with error control: CVODE's Adams formulas from one contact event to the next. Contact events are the
/// onset, the end of the contact force, and the end of the overlap. The independent variable is the square root of the
/// time since the last onset, in which contact forces are smooth. Charges are exchanged at events.
class Cvode final : public GasIntegrator {
 public:
  double longest_step(Gas& gas, Instant&) const override { return gas.scene().mechanics.step; }

  Instant step(Gas& gas, Instant now, double end, Want) override {
    const double begin = gas.time(), half = 0.5 * (end - begin);
    gas.drive(now, begin, half);
    for (Progress progress{begin}; gas.time() < end;) {
      progress.check(gas, end - begin);
      visit_spheres(gas.bodies(), [&]<int d>(const Spheres<d>&) { Segment<d>(gas).advance(end); });
      now = {};
      gas.exchange_charges(now);
    }
    now = gas.instant();
    gas.drive(now, begin + half, half);
    return now;
  }

 private:
  /// Counts segments between contact events, to detect events that repeat without an advance of time.
  struct Progress {
    double since;  ///< t0, time at the last check, or the start of the step
    int segments = 0;

    /// Throws Failure if time has hardly advanced since the last check.
    void check(const Gas& gas, double step) {
      constexpr int many = 10000;
      constexpr double hardly = 1e-3;  // of a step
      if (++segments % many != 0) return;
      if (!(gas.time() - since > hardly * step))
        throw Failure(
            fmt::format("{}: time does not advance beyond t = {:.9g} t0: contacts have begun or ended {} times there; "
                        "mechanics.integrator = \"multirate\" has no such events",
                        gas.scene().path, gas.time(), many));
      since = gas.time();
    }
  };

  /// Time integration between two contact events. The variables are displacements, momenta, and the energy dissipated
  /// by contacts.
  template <int d>
  class Segment {
   public:
    explicit Segment(Gas& gas) : gas_(gas), start_(gas.bodies()), begin_(gas.time()), origin_(begin_) {
      const Vec3 lengths = start_.box.lengths;
      opening_gap_ =
          8 * std::numeric_limits<double>::epsilon() * std::max({lengths.x, lengths.y, d == 3 ? lengths.z : 0});
      for (const GrainContact& contact : gas.contacts()) touching_.push_back(contact.pair);
      if (!gas.contacts().empty()) origin_ = std::ranges::max(gas.contacts(), {}, &GrainContact::since).since;
      for (int i = 0; i < start_.size(); ++i)
        for (int j = i + 1; j < start_.size(); ++j)
          if (!std::ranges::binary_search(touching_, Pair{i, j})) separate_.push_back({i, j});
    }

    void advance(double end) {
      const std::size_t n = start_.momentum.size();
      std::vector<double> y(n);
      constexpr double nothing = 1e-12;  // t0, too short for CVODE
      if (end - begin_ < nothing) {
        gas_.move(y, end);
        return gas_.note(step_contacts(-1), begin_, 0);
      }
      y.insert(y.end(), start_.momentum.begin(), start_.momentum.end());
      y.push_back(0);
      const double tolerance = gas_.scene().mechanics.relative_tolerance;  // of a step, in each component
      const Ode ode{.rates = [&](double sigma, auto now, auto rate) { rates(sigma, now, rate); },
                    .absolute = std::vector<double>(y.size(), tolerance),
                    .relative = tolerance,
                    .falls = events()};
      const OdeEnd found = integrate(ode, std::sqrt(begin_ - origin_), std::sqrt(end - origin_), y);
      const double time = found.event < 0 ? end : origin_ + found.time * found.time;
      put(y, time);
      gas_.note(step_contacts(found.event), begin_, y.back());
    }

   private:
    /// Sets positions and momenta of the gas to those of the variables y at `time` (t0).
    void put(std::span<const double> y, double time) {
      Bodies& b = gas_.model().bodies;
      const std::size_t n = b.momentum.size();
      b.position = start_.position, b.image = start_.image;
      gas_.move(y.first(n), time);
      std::ranges::copy(y.subspan(n, n), b.momentum.begin());
    }

    void rates(double sigma, std::span<const double> y, std::span<double> rate) {
      put(y, origin_ + sigma * sigma);
      const Bodies& b = gas_.bodies();
      const ContactLoad load = gas_.contact_load(touching_);
      const std::size_t n = b.momentum.size();
      std::vector<double> smooth = gas_.smooth_forces();
      smooth.resize(n);
      for (std::size_t k = 0; k < n; ++k) {
        rate[k] = 2 * sigma * b.momentum[k] / b.mass[k / d];
        rate[n + k] = 2 * sigma * (load.force[k] + smooth[k]);
      }
      rate[2 * n] = 2 * sigma * load.dissipation;
    }

    /// Returns the event functions, which fall through zero: onset for separate pairs, and end of the overlap and of
    /// the force for contacts. A contact whose force is zero except for rounding gets no event at the end of the force,
    /// which would repeat without end.
    std::vector<Ode::Value> events() const {
      std::vector<Ode::Value> falls;
      for (const Pair pair : separate_)
        falls.push_back([this, pair](double, auto y) { return -overlap(pair, at(pair, y)); });
      for (const Pair pair : touching_)
        falls.push_back([this, pair](double, auto y) { return overlap(pair, at(pair, y)) + opening_gap_; });
      constexpr double rounding = 1e-9;
      const Spheres<d> grains = spheres<d>(start_);
      for (const Pair pair : touching_)
        if (const auto [elastic, slope, force] = normal_force(pair, pair_state(start_, grains, pair));
            force >= rounding * elastic + 4 * opening_gap_ * slope)
          falls.push_back([this, pair](double, auto y) {
            // Just after onset rounding may put the overlap below 0, where the force is exactly 0.
            return normal_force(pair, at(pair, y)).unclamped + std::numeric_limits<double>::min();
          });
      return falls;
    }

    PairState<d> at(Pair pair, std::span<const double> y) const {
      const auto [i, j] = pair;
      const auto momentum = y.subspan(y.size() / 2);
      return {separation(spheres<d>(start_), pair) + vector_of<d>(y, j) - vector_of<d>(y, i),
              vector_of<d>(momentum, j) / start_.mass[j] - vector_of<d>(momentum, i) / start_.mass[i]};
    }
    double overlap(Pair pair, const PairState<d>& state) const { return reach(start_, pair) - norm(state.separation); }
    struct NormalForce {
      double elastic = 0, slope = 0, unclamped = 0;
    };
    NormalForce normal_force(Pair pair, const PairState<d>& state) const {
      return std::visit(
          [&](const auto& law) -> NormalForce {
            const ContactParts parts =
                law.parts(overlap(pair, state), law.scale(start_.radius[pair.i], start_.radius[pair.j]));
            return {parts.elastic, parts.elastic_slope, parts.elastic + parts.damping * closing(state)};
          },
          gas_.law());
    }

    /// Returns the contacts of the segment, which the event of index `event` ended (negative: none). CVODE reports only
    /// one of several simultaneous events, so all pairs are tested.
    std::vector<StepContact> step_contacts(int event) const {
      const Spheres<d> grains = spheres<d>(gas_.bodies());
      std::vector<StepContact> found;
      for (std::size_t k = 0; k < touching_.size(); ++k) {
        const PairState<d> state = pair_state(gas_.bodies(), grains, touching_[k]);
        const bool released =
            event == static_cast<int>(separate_.size() + k) || overlap(touching_[k], state) < -opening_gap_;
        found.push_back({gas_.contacts()[k], false, !released});
      }
      for (std::size_t k = 0; k < separate_.size(); ++k) {
        const PairState<d> state = pair_state(gas_.bodies(), grains, separate_[k]);
        if (event == static_cast<int>(k) || (overlap(separate_[k], state) > 0 && closing(state) > 0))
          found.push_back({{separate_[k], gas_.time(), closing(state)}, true, true});
      }
      std::ranges::sort(found, {}, [](const StepContact& contact) { return contact.contact.pair; });
      return found;
    }

    Gas& gas_;
    Bodies start_;
    double begin_, origin_;
    double opening_gap_ = 0;  ///< d0, gap at which a contact ends: above the rounding of positions, which would make
                              ///< slow grains touch and part without end
    std::vector<Pair> touching_, separate_;
  };
};

}  // namespace

std::unique_ptr<GasIntegrator> make_cvode() { return std::make_unique<Cvode>(); }

}  // namespace lichtenberg::granular
