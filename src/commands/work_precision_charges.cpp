#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/mesh.hpp"
#include "solvers/periodic/short_range.hpp"
#include "solvers/random.hpp"
#include "src/commands/work_precision.hpp"
#include "src/model/bodies.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::work_precision {
namespace {

/// Charges at the places of the scene's first instant, and the forces that they should feel.
struct ChargedSubject {
  Bodies bodies;
  std::vector<int> sample;       ///< of whom forces are compared
  periodic::Response reference;  ///< of the sample
  double rms_force = 0;

  periodic::Sources sources() const { return {bodies.box.lengths, bodies.position, bodies.charge}; }
  double diameter() const { return 2 * *std::ranges::min_element(bodies.radius); }
};

using MakeSum = std::function<std::unique_ptr<periodic::Sum>()>;

/// One evaluation of all forces, pairs being known.
class SumTrial : public Trial {
 public:
  SumTrial(const ChargedSubject& subject, const MakeSum& make) : subject_(subject), sum_(make()) {
    if (sum_->cutoff() > 0) pairs_ = pairs_closer_than(subject.bodies, sum_->cutoff() - subject.diameter());
  }

  void run() override { sum_->evaluate(subject_.sources(), pairs_, parallel::Team::single(), response_); }
  std::vector<double> errors() const override {
    double squares = 0, largest = 0;
    for (std::size_t s = 0; s < subject_.sample.size(); ++s) {
      double square = 0;
      for (int k = 0; k < 3; ++k) {
        const double off = response_.force[3 * subject_.sample[s] + k] - subject_.reference.force[3 * s + k];
        square += off * off;
      }
      squares += square;
      largest = std::max(largest, square);
    }
    const double n = static_cast<double>(subject_.sample.size());
    return {std::sqrt(squares / n) / subject_.rms_force, std::sqrt(largest) / subject_.rms_force};
  }
  std::int64_t work() const override { return static_cast<std::int64_t>(pairs_.size()); }

 private:
  const ChargedSubject& subject_;
  std::unique_ptr<periodic::Sum> sum_;
  std::vector<Pair> pairs_;
  periodic::Response response_;
};

Candidate candidate(const ChargedSubject& subject, Settings settings, double cost, MakeSum make) {
  return {std::move(settings), cost,
          [&subject, make = std::move(make)] { return std::make_unique<SumTrial>(subject, make); }};
}

Method mesh(const ChargedSubject& subject) {
  Method method{"mesh", "near pairs, all else on a mesh with the parameters that an accuracy asks for", {}};
  for (int decade = 1; decade <= 8; ++decade) {
    const double accuracy = std::pow(10, -decade);
    method.candidates.push_back(candidate(subject, {{"accuracy", accuracy}}, std::pow(decade + 2, 3), [=, &subject] {
      const int charges = subject.bodies.size();
      return periodic::make_mesh_sum(
          periodic::choose_quick_mesh({accuracy, charges, subject.bodies.box.lengths, subject.diameter()}), charges);
    }));
  }
  return method;
}

Method ewald(const ChargedSubject& subject) {
  Method method{"ewald", "Ewald's sums term by term", {}};
  for (int decade = 1; decade <= 13; decade += 2) {
    const double tolerance = std::pow(10, -decade);
    method.candidates.push_back(candidate(subject, {{"tolerance", tolerance}}, std::pow(decade + 1, 1.5),
                                          [=] { return std::make_unique<periodic::Ewald>(tolerance); }));
  }
  return method;
}

Method minimum_image(const ChargedSubject& subject) {
  return {"minimum-image",
          "the nearest image of each other charge, without a promise",
          {candidate(subject, {{"reach / L", 1}}, 1,
                     [] { return std::make_unique<periodic::MinimumImage>(periodic::MinimumImage::Reach::box); })}};
}

Method shifted_force(const ChargedSubject& subject) {
  Method method{"shifted-force", "pairs within a cut-off, shifted to end there, without a promise", {}};
  const Vec3 lengths = subject.bodies.box.lengths;
  const double half = 0.5 * std::min({lengths.x, lengths.y, lengths.z});
  for (const double cutoff : {3.0, 5.0, 7.0, 10.0})
    if (cutoff <= half)
      method.candidates.push_back(candidate(subject, {{"cutoff", cutoff}}, std::pow(cutoff, 3),
                                            [=] { return std::make_unique<periodic::ShiftedForce>(cutoff); }));
  return method;
}

std::vector<Method> all_methods(const ChargedSubject& subject) {
  return {mesh(subject), ewald(subject), minimum_image(subject), shifted_force(subject)};
}

/// Gaussian charges, where the scene has none yet.
void charge(ChargedSubject& subject, std::uint64_t seed) {
  std::vector<double>& q = subject.bodies.charge;
  if (std::ranges::any_of(q, [](double charge) { return charge != 0; })) return;
  for (std::size_t i = 0; i < q.size(); ++i)
    q[i] = Random({.seed = seed, .purpose = RandomPurpose::population, .i = i, .count = 1}).normal();
  const double mean = std::accumulate(q.begin(), q.end(), 0.0) / static_cast<double>(q.size());
  for (double& charge : q) charge -= mean;
}

ChargedSubject make_subject(const Scene& scene) {
  ChargedSubject subject{.bodies = make_bodies(scene)};
  subject.bodies.charge = initial_charges(scene);
  charge(subject, scene.seed);
  constexpr int most = 200;  // forces compared: their sum takes as long as the Ewald sums of thousands
  const int n = subject.bodies.size(), count = std::min(n, most);
  for (int s = 0; s < count; ++s) subject.sample.push_back(static_cast<int>(static_cast<std::int64_t>(s) * n / count));
  return subject;
}

double rms(const std::vector<double>& force) {
  double sum = 0;
  for (const double f : force) sum += f * f;
  return std::sqrt(3 * sum / static_cast<double>(force.size()));
}

/// By Ewald's sums; what a tolerance ten thousand times larger changes is more than their error.
void find_reference(ChargedSubject& subject, Diagram& diagram) {
  const double balance = std::pow(2.0 * subject.sample.size() / subject.bodies.size(), 1.0 / 6);
  const auto sum = [&](double tolerance) {
    const periodic::Splitting balanced = periodic::splitting_for(subject.sources(), tolerance);
    const periodic::Splitting splitting =
        periodic::splitting_for(subject.sources(), tolerance, balanced.alpha * std::min(balance, 1.0));
    periodic::Response response;
    periodic::Ewald(splitting).evaluate_at(subject.sample, subject.sources(), parallel::Team::single(), response);
    return response;
  };
  subject.reference = sum(1e-13);
  subject.rms_force = rms(subject.reference.force);
  const std::vector<double> looser = sum(1e-9).force;
  double largest = 0, squares = 0;
  for (std::size_t k = 0; k < looser.size(); ++k) {
    const double off = looser[k] - subject.reference.force[k];
    squares += off * off;
    largest = std::max(largest, std::abs(off));
  }
  diagram.reference_errors = {std::sqrt(3 * squares / static_cast<double>(looser.size())) / subject.rms_force,
                              largest / subject.rms_force};
  diagram.reference = "Ewald's sums at tolerance 1e-13";
}

}  // namespace

Diagram sweep_charges(const Scene& scene, const Request& request) {
  if (!scene.effects.has("coulomb"))
    throw InputError(scene.path +
                     ": work-precision compares ways to sum the forces of charges, and the scene has no "
                     "effects.coulomb; with --time it compares integrators");
  if (!request.sizes.empty())
    throw InputError("--sizes goes with conductors: the meshes of charges follow from their accuracy");
  ChargedSubject subject = make_subject(scene);
  choose(all_methods(subject), request.methods);  // names are checked before anything is computed
  Diagram diagram{
      .title = fmt::format("forces of {} charges at the places of the first instant", subject.bodies.size()),
      .quantities = {"rms force", "largest force"},
      .measure = "root mean square and largest error of a force, over the rms force",
      .work = "pairs"};
  if (request.progress) request.progress(0, 0, "reference", {});
  find_reference(subject, diagram);
  measure(choose(all_methods(subject), request.methods), request, diagram);
  return diagram;
}

}  // namespace lichtenberg::work_precision
