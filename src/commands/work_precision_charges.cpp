#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/bounded.hpp"
#include "solvers/periodic/device/device.hpp"
#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/mesh.hpp"
#include "solvers/periodic/short_range.hpp"
#include "solvers/periodic/sum.hpp"
#include "solvers/random.hpp"
#include "src/commands/work_precision.hpp"
#include "src/effects/coulomb_sum.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/model/bodies.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::work_precision {
namespace {

/// Charges at a scene's initial positions, with reference forces.
struct ChargedSubject {
  Bodies bodies;
  periodic::Enclosure enclosure;
  std::optional<effects::InducedDipolesOptions> dipoles;
  std::vector<int> sample;       ///< grains with compared forces
  periodic::Response reference;  ///< forces on the sample
  double rms_force = 0;

  periodic::Sources sources() const { return {bodies.box.lengths, bodies.position, bodies.charge}; }
  /// Returns the smallest grain diameter.
  double diameter() const { return 2 * *std::ranges::min_element(bodies.radius); }
  /// Returns half of the shortest side.
  double half_box() const { return 0.5 * std::min({bodies.box.lengths.x, bodies.box.lengths.y, bodies.box.lengths.z}); }
  /// Returns the rms and the largest error of these forces ([3 N]), relative to the rms force.
  std::vector<double> errors(const std::vector<double>& force) const;
};

using MakeSum = std::function<std::unique_ptr<periodic::Sum>()>;

/// Evaluates all forces once, with given pairs.
class SumTrial : public Trial {
 public:
  SumTrial(const ChargedSubject& subject, std::unique_ptr<periodic::Sum> sum)
      : subject_(subject), sum_(std::move(sum)) {
    if (sum_->cutoff() > 0) pairs_ = pairs_closer_than(subject.bodies, sum_->cutoff() - subject.diameter());
  }

  void run() override {
    const double start = seconds_of_thread();
    evaluate();
    seconds_ = seconds_of_thread() - start;
  }
  std::vector<double> errors() const override { return subject_.errors(response_.force); }
  std::int64_t work() const override { return static_cast<std::int64_t>(pairs_.size()); }
  std::optional<double> measured_seconds() const override { return seconds_; }
  const std::vector<double>& forces() const { return response_.force; }

 protected:
  virtual void evaluate() { sum_->evaluate(subject_.sources(), pairs_, parallel::Team::single(), response_); }

  const ChargedSubject& subject_;
  std::unique_ptr<periodic::Sum> sum_;
  std::vector<Pair> pairs_;
  periodic::Response response_;

 private:
  double seconds_ = 0;
};

/// Evaluates the same with induced dipoles, from a zero initial guess.
class DipolesTrial final : public SumTrial {
 public:
  DipolesTrial(const ChargedSubject& subject, std::unique_ptr<periodic::Sum> far, periodic::DipoleSum variant,
               double tolerance)
      : SumTrial(subject, std::move(far)),
        induced_(*sum_, variant, subject.dipoles->polarizability, tolerance, subject.dipoles->each) {}

 private:
  void evaluate() override {
    std::vector<double> dipole;
    induced_.evaluate(subject_.sources(), pairs_, parallel::Team::single(), dipole, response_);
  }

  periodic::InducedDipoles induced_;
};

/// Evaluates forces on a device, timed by its own clock, without lists and transfers.
class DeviceTrial final : public Trial {
 public:
  DeviceTrial(const ChargedSubject& subject, const periodic::MeshChoice& choice)
      : subject_(subject), sum_(periodic::device::make_cuda_mesh(choice.mesh, choice.cloud())) {}

  void run() override {
    constexpr double skin = 0.5;  // d0; lists then hold for several steps
    constexpr int repeats = 10;
    seconds_ = sum_->profile(subject_.sources(), skin, repeats).forces;
    sum_->evaluate(subject_.sources(), {}, parallel::Team::single(), response_);
  }
  std::vector<double> errors() const override { return subject_.errors(response_.force); }
  std::int64_t work() const override { return 0; }
  std::optional<double> measured_seconds() const override { return seconds_; }
  bool uses_other_memory() const override { return true; }

 private:
  const ChargedSubject& subject_;
  std::unique_ptr<periodic::device::DeviceMesh> sum_;
  periodic::Response response_;
  double seconds_ = 0;
};

/// Returns a candidate for a sum of this accuracy; induced dipoles have the same accuracy.
Candidate candidate(const ChargedSubject& subject, Settings settings, double cost, double accuracy, MakeSum make) {
  return {std::move(settings), cost, [&subject, accuracy, make = std::move(make)]() -> std::unique_ptr<Trial> {
            if (!subject.dipoles) return std::make_unique<SumTrial>(subject, make());
            return std::make_unique<DipolesTrial>(subject, make(), periodic::DipoleSum::ewald, accuracy);
          }};
}

double cost_of_mesh(double accuracy) { return std::pow(2 - std::log10(accuracy), 3); }

/// Returns true if the charges have no dipoles and no periodic images. Two grounded sides on an axis make images
/// periodic.
bool has_exact_pairs(const ChargedSubject& subject) {
  for (int k = 0; k < 3; ++k) {
    const periodic::Side lower = subject.enclosure.sides[2 * k], upper = subject.enclosure.sides[2 * k + 1];
    if (lower != periodic::Side::open && upper != periodic::Side::open) return false;
  }
  return !subject.dipoles;
}

constexpr double accuracies[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8};

periodic::MeshRequest request_for(const ChargedSubject& subject, double accuracy) {
  return {.accuracy = accuracy,
          .charges = subject.bodies.size(),
          .lengths = subject.bodies.box.lengths,
          .contact = subject.diameter(),
          .polarizability = subject.dipoles ? std::optional(subject.dipoles->polarizability) : std::nullopt};
}

/// Makes the sum of a run on a mesh with these requirements.
std::unique_ptr<periodic::Sum> make_mesh(const ChargedSubject& subject, const periodic::MeshRequest& request) {
  if (subject.enclosure.is_periodic()) return periodic::make_mesh_sum(periodic::choose_quick_mesh(request));
  const periodic::MeshChoice choice = periodic::choose_bounded_mesh(request, subject.enclosure, subject.sources());
  return std::make_unique<periodic::BoundedSum>(request, subject.enclosure, choice);
}

std::unique_ptr<periodic::Sum> quick_mesh(const ChargedSubject& subject, double accuracy) {
  return make_mesh(subject, request_for(subject, accuracy));
}

/// Differences of a mesh from that of runs.
struct MeshVariant {
  bool gauss = false, splines = false, only_double = false;
};

Method mesh(const ChargedSubject& subject, std::string name, std::string description, const MeshVariant& mesh_variant) {
  Method method{std::move(name), std::move(description), {}};
  const bool against_mesh = !subject.enclosure.is_periodic() && !has_exact_pairs(subject);
  for (const double accuracy : accuracies) {
    if (against_mesh && accuracy < 1e-7) break;  // The reference is a mesh at 1e-8
    method.candidates.push_back(
        candidate(subject, {{"accuracy", accuracy}}, cost_of_mesh(accuracy), accuracy, [=, &subject] {
          periodic::MeshRequest request = request_for(subject, accuracy);
          request.gauss = mesh_variant.gauss;
          request.splines = mesh_variant.splines;
          request.only_double = mesh_variant.only_double;
          return make_mesh(subject, request);
        }));
  }
  return method;
}

/// Returns the mesh method on a device. It has single precision for charges only, and splines; other parameters are as
/// in a run.
Method mesh_on_device(const ChargedSubject& subject) {
  Method method{"mesh-cuda", "the same mesh on a CUDA device, by the device's clock", {}};
  for (const double accuracy : accuracies)
    if (accuracy >= periodic::finest_single)
      method.candidates.push_back({{{"accuracy", accuracy}}, cost_of_mesh(accuracy), [=, &subject] {
                                     periodic::MeshRequest request = request_for(subject, accuracy);
                                     request.only_double = true;
                                     return std::make_unique<DeviceTrial>(subject,
                                                                          periodic::choose_quick_mesh(request));
                                   }});
  return method;
}

Method ewald(const ChargedSubject& subject) {
  Method method{"ewald", "Ewald's sums term by term", {}};
  for (int decade = 1; decade <= 13; decade += 2) {
    const double tolerance = std::pow(10, -decade);
    method.candidates.push_back(candidate(subject, {{"tolerance", tolerance}}, std::pow(decade + 1, 1.5), tolerance,
                                          [=] { return std::make_unique<periodic::Ewald>(tolerance); }));
  }
  return method;
}

Method minimum_image(const ChargedSubject& subject) {
  return {"minimum-image",
          "the nearest image of each other charge, without an error bound",
          {candidate(subject, {{"reach / L", 1}}, 1, 0,
                     [] { return std::make_unique<periodic::MinimumImage>(periodic::MinimumImage::Reach::box); })}};
}

/// Returns the methods for boxes with sides that are not periodic.
std::vector<Method> open_methods(const ChargedSubject& subject) {
  return {
      mesh(subject, "mesh", "the sum of a run: near pairs, the rest on a mesh, for empty space and grounded sides", {}),
      mesh(subject, "mesh-splines", "the mesh with B-splines in place of prolate windows", {.splines = true}),
      mesh(subject, "mesh-double", "the mesh in double precision throughout, with B-splines", {.only_double = true})};
}

Method shifted_force(const ChargedSubject& subject) {
  Method method{"shifted-force", "pairs within a cut-off, shifted to vanish there, without an error bound", {}};
  for (const double cutoff : {3.0, 5.0, 7.0, 10.0})
    if (cutoff <= subject.half_box())
      method.candidates.push_back(candidate(subject, {{"cutoff", cutoff}}, std::pow(cutoff, 3), 0,
                                            [=] { return std::make_unique<periodic::ShiftedForce>(cutoff); }));
  return method;
}

/// Returns a variant with charges on the mesh and dipoles by nearest images.
Method dipole_variant(const ChargedSubject& subject, periodic::DipoleSum variant) {
  Method method{"dipoles-" + std::string(name_of(variant)), "nearest images where induced_dipoles.sum has them", {}};
  for (const double accuracy : {1e-2, 1e-3, 1e-4})
    method.candidates.push_back({{{"accuracy", accuracy}}, cost_of_mesh(accuracy), [=, &subject] {
                                   return std::make_unique<DipolesTrial>(subject, quick_mesh(subject, accuracy),
                                                                         variant, accuracy);
                                 }});
  return method;
}

std::vector<Method> all_methods(const ChargedSubject& subject) {
  if (!subject.enclosure.is_periodic()) return open_methods(subject);
  const std::string to = "with the parameters chosen by an accuracy";
  Method quick = mesh(subject, "mesh", "the sum of a run: near pairs, the rest on a mesh, " + to, {});
  Method gauss = mesh(subject, "mesh-gauss", "the same with Ewald's splitting", {.gauss = true});
  if (subject.dipoles)
    return {quick,
            gauss,
            ewald(subject),
            dipole_variant(subject, periodic::DipoleSum::mixed_consistent),
            dipole_variant(subject, periodic::DipoleSum::minimum_image),
            dipole_variant(subject, periodic::DipoleSum::source)};
  return {
      quick,
      gauss,
      mesh(subject, "mesh-splines", "the mesh with B-splines in place of prolate windows", {.splines = true}),
      mesh(subject, "mesh-splines-gauss", "the same with Ewald's splitting", {.gauss = true, .splines = true}),
      mesh(subject, "mesh-double", "the mesh in double precision throughout, with B-splines", {.only_double = true}),
      mesh(subject, "mesh-double-gauss", "the same with Ewald's splitting", {.gauss = true, .only_double = true}),
      mesh_on_device(subject),
      ewald(subject),
      minimum_image(subject),
      shifted_force(subject)};
}

/// Sets Gaussian charges with zero mean if the scene has none.
void add_charges(ChargedSubject& subject, std::uint64_t seed) {
  std::vector<double>& q = subject.bodies.charge;
  if (std::ranges::any_of(q, [](double charge) { return charge != 0; })) return;
  for (std::size_t i = 0; i < q.size(); ++i)
    q[i] = Random({.seed = seed, .purpose = RandomPurpose::population, .i = i, .count = 1}).normal();
  const double mean = std::accumulate(q.begin(), q.end(), 0.0) / static_cast<double>(q.size());
  for (double& charge : q) charge -= mean;
}

ChargedSubject make_subject(const Scene& scene) {
  ChargedSubject subject{.bodies = make_bodies(scene), .enclosure = effects::enclosure_of(scene.domain)};
  if (const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>()) subject.dipoles = *dipoles;
  subject.bodies.charge = initial_charges(scene);
  add_charges(subject, scene.seed);
  constexpr int most = 200;  // number of compared forces; their sum takes as long as Ewald sums of thousands of grains
  const int n = subject.bodies.size(), count = std::min(n, most);
  for (int s = 0; s < count; ++s) subject.sample.push_back(static_cast<int>(static_cast<std::int64_t>(s) * n / count));
  return subject;
}

double rms(const std::vector<double>& force) {
  double sum = 0;
  for (const double f : force) sum += f * f;
  return std::sqrt(3 * sum / static_cast<double>(force.size()));
}

std::vector<double> sample_forces(const ChargedSubject& subject, const std::vector<double>& force) {
  std::vector<double> chosen;
  for (const int i : subject.sample) chosen.insert(chosen.end(), &force[3 * i], &force[3 * i] + 3);
  return chosen;
}

/// Returns forces by Ewald sums, balanced for the sample.
std::vector<double> exact_forces(const ChargedSubject& subject, double tolerance) {
  const double balance = std::pow(2.0 * subject.sample.size() / subject.bodies.size(), 1.0 / 6);
  const periodic::Splitting balanced = periodic::splitting_for(subject.sources(), tolerance);
  const periodic::Splitting splitting =
      periodic::splitting_for(subject.sources(), tolerance, balanced.alpha * std::min(balance, 1.0));
  periodic::Response response;
  periodic::Ewald(splitting).evaluate_at(subject.sample, subject.sources(), parallel::Team::single(), response);
  return response.force;
}

/// Returns true if Ewald sums with dipoles take at most a minute. Dipoles need the fields at all grains.
bool is_small(const ChargedSubject& subject) { return subject.bodies.size() <= 2000; }

std::vector<double> exact_forces_with_dipoles(const ChargedSubject& subject, double tolerance) {
  std::unique_ptr<periodic::Sum> far = std::make_unique<periodic::Ewald>(tolerance);
  if (!is_small(subject)) far = quick_mesh(subject, std::max(tolerance, 1e-8));
  DipolesTrial trial(subject, std::move(far), periodic::DipoleSum::ewald, tolerance);
  trial.run();
  return sample_forces(subject, trial.forces());
}

/// Returns forces on the sample by all pairs of charges and images.
std::vector<double> forces_by_pairs(const ChargedSubject& subject) {
  std::vector<double> position = subject.bodies.position, charge = subject.bodies.charge, no_dipoles;
  periodic::append_images(subject.enclosure, position, charge, no_dipoles);
  std::vector<double> force;
  for (const int i : subject.sample) {
    Vec3 sum;
    for (std::size_t j = 0; j < charge.size(); ++j) {
      if (j == static_cast<std::size_t>(i)) continue;
      Vec3 d;
      for (int k = 0; k < 3; ++k) d[k] = position[3 * i + k] - position[3 * j + k];
      const double r = std::hypot(d.x, d.y, d.z);
      for (int k = 0; k < 3; ++k) sum[k] += charge[i] * charge[j] * d[k] / (r * r * r);
    }
    force.insert(force.end(), {sum.x, sum.y, sum.z});
  }
  return force;
}

/// Returns forces on the sample by a mesh in double precision.
std::vector<double> forces_by_mesh(const ChargedSubject& subject, double accuracy) {
  periodic::MeshRequest request = request_for(subject, accuracy);
  request.only_double = true;
  const std::unique_ptr<Trial> trial =
      candidate(subject, {}, 0, accuracy, [&] { return make_mesh(subject, request); }).make();
  trial->run();
  return sample_forces(subject, dynamic_cast<const SumTrial&>(*trial).forces());
}

/// Computes the reference. The change at a much lower accuracy bounds its error; sums of
/// all pairs have rounding errors only.
void find_reference(ChargedSubject& subject, Diagram& diagram) {
  std::vector<double> looser;
  if (!subject.enclosure.is_periodic()) {
    const bool by_pairs = has_exact_pairs(subject);
    subject.reference.force = by_pairs ? forces_by_pairs(subject) : forces_by_mesh(subject, 1e-8);
    looser = by_pairs ? subject.reference.force : forces_by_mesh(subject, 1e-7);
    diagram.reference = by_pairs ? "all pairs of charges and images" : "the mesh in double precision at accuracy 1e-8";
  } else if (subject.dipoles) {
    subject.reference.force = exact_forces_with_dipoles(subject, 1e-10);
    looser = exact_forces_with_dipoles(subject, 1e-7);
    diagram.reference = is_small(subject) ? "Ewald's sums and dipoles at tolerance 1e-10"
                                          : "the mesh at accuracy 1e-8, dipoles at tolerance 1e-10";
  } else {
    subject.reference.force = exact_forces(subject, 1e-13);
    looser = exact_forces(subject, 1e-9);
    diagram.reference = "Ewald's sums at tolerance 1e-13";
  }
  subject.rms_force = rms(subject.reference.force);
  double largest = 0, squares = 0;
  for (std::size_t k = 0; k < looser.size(); ++k) {
    const double deviation = looser[k] - subject.reference.force[k];
    squares += deviation * deviation;
    largest = std::max(largest, std::abs(deviation));
  }
  diagram.reference_errors = {std::sqrt(3 * squares / static_cast<double>(looser.size())) / subject.rms_force,
                              largest / subject.rms_force};
}

std::vector<double> ChargedSubject::errors(const std::vector<double>& force) const {
  if (force.size() != bodies.position.size())
    throw InputError("the answer of a method that sums Coulomb forces needs three force components per charge");
  double squares = 0, largest = 0;
  for (std::size_t s = 0; s < sample.size(); ++s) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += std::pow(force[3 * sample[s] + k] - reference.force[3 * s + k], 2);
    squares += square;
    largest = std::max(largest, square);
  }
  return {std::sqrt(squares / static_cast<double>(sample.size())) / rms_force, std::sqrt(largest) / rms_force};
}

}  // namespace

void sweep_charges(const Scene& scene, const Request& request) {
  if (!scene.effects.has("coulomb"))
    throw InputError(scene.path +
                     ": work-precision compares methods to sum the forces of charges, but the scene has no "
                     "effects.coulomb; with --time it compares integrators");
  if (scene.dimension() != 3) throw InputError(scene.path + ": work-precision compares sums of charges in space only");
  if (!request.sizes.empty())
    throw InputError("--sizes is for conductors: the meshes of charges follow from their accuracy");
  if (scene.conductors.size() < 2)
    throw InputError(scene.path + ": a single charge has no force, and errors are relative to forces");
  if (const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>(); dipoles && dipoles->degree > 1)
    throw InputError(fmt::format(
        "{}: effects.induced_dipoles.degree = {} is not allowed in work-precision, which compares sums of charges and "
        "dipoles: 1 is allowed",
        scene.path, dipoles->degree));
  ChargedSubject subject = make_subject(scene);
  const std::vector<Method> methods = choose(all_methods(subject), request);
  Diagram diagram{.title = fmt::format("forces of {} charges{} at the initial positions", subject.bodies.size(),
                                       subject.dipoles ? " and the dipoles that they induce" : ""),
                  .quantities = {"rms force", "largest force"},
                  .measure = "root mean square and largest error of a force, over the rms force",
                  .work = "pairs",
                  .clock = "time of one core"};
  request.begin();
  find_reference(subject, diagram);
  diagram.subject = [&]() -> nlohmann::ordered_json {
    const Vec3 box = subject.bodies.box.lengths;
    return {{"lengths", {box.x, box.y, box.z}},
            {"periodic", subject.enclosure.is_periodic()},
            {"position", subject.bodies.position},
            {"charge", subject.bodies.charge}};
  };
  diagram.errors = [&](const nlohmann::ordered_json& answer) {
    return subject.errors(answer.at("force").get<std::vector<double>>());
  };
  request.serve(diagram, methods);
}

}  // namespace lichtenberg::work_precision
