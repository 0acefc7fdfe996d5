// Finite elements on a field of spheres, by other programs.
#include <fmt/format.h>
#include <fmt/os.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "solvers/error.hpp"
#include "src/commands/scratch_folder.hpp"
#include "src/commands/work_precision_spheres.hpp"

namespace lichtenberg::work_precision {
namespace {

using laplace::SphereProblem;

constexpr int sphere_label = 10;  ///< of the first; sides have 1 to 6

double smallest_radius(const SphereProblem& problem) {
  return std::ranges::min(problem.spheres, {}, &laplace::Sphere::radius).radius;
}

void check_for_meshes(const SphereProblem& problem) {
  for (const char* command : {"FreeFem++", "gmsh"})
    if (std::system(fmt::format("command -v {} >/dev/null 2>&1", command).c_str()) != 0)
      throw InputError(fmt::format("there is no command `{}` (Debian's packages freefem and gmsh)", command));
  constexpr std::size_t most = 12;
  if (problem.spheres.empty() || problem.spheres.size() > most)
    throw InputError(fmt::format("1 to {} spheres are meshed, not {}", most, problem.spheres.size()));
  if (problem.free_space || problem.box.any_periodic())
    throw InputError("meshes have insulating and electrode sides only");
  if (!problem.has_ground()) throw InputError("an insulated box has no level for the finite elements");
  if (std::ranges::any_of(problem.spheres, [](const laplace::Sphere& s) { return !s.is_conductor(); }))
    throw InputError("dielectric spheres are not meshed");
}

/// For Gmsh: the box without the spheres, lengths in smallest radii, edges `size` long at the spheres.
std::string geometry(const SphereProblem& problem, double size) {
  const double unit = smallest_radius(problem);
  const Vec3 box = problem.box.lengths / unit;
  std::string text =
      fmt::format("SetFactory(\"OpenCASCADE\");\nBox(1) = {{0, 0, 0, {}, {}, {}}};\n", box.x, box.y, box.z);
  const std::size_t n = problem.spheres.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 c = problem.spheres[i].centre / unit;
    text += fmt::format("Sphere({}) = {{{}, {}, {}, {}}};\n", i + 2, c.x, c.y, c.z, problem.spheres[i].radius / unit);
  }
  text += fmt::format(
      "BooleanDifference(100) = {{ Volume{{1}}; Delete; }}{{ Volume{{2:{}}}; Delete; }};\nPhysical Volume(1) = "
      "{{100}};\n",
      n + 1);
  const auto surface_in = [&](int label, Vec3 low, Vec3 high) {
    text += fmt::format(
        "s{0}() = Surface In BoundingBox{{{1}, {2}, {3}, {4}, {5}, {6}}};\nPhysical Surface({0}) = {{s{0}()}};\n",
        label, low.x, low.y, low.z, high.x, high.y, high.z);
  };
  const Vec3 slack{1e-3, 1e-3, 1e-3};
  for (int side = 0; side < 6; ++side) {
    Vec3 low, high = box;
    (side % 2 == 0 ? high : low)[side / 2] = side % 2 == 0 ? 0 : box[side / 2];
    surface_in(1 + side, low - slack, high + slack);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 c = problem.spheres[i].centre / unit, reach = problem.spheres[i].radius / unit * Vec3{1, 1, 1} + slack;
    const int label = sphere_label + static_cast<int>(i);
    surface_in(label, c - reach, c + reach);
    text += fmt::format("MeshSize{{ PointsOf{{ Surface{{s{}()}}; }} }} = {};\n", label, size);
  }
  return text +
         fmt::format("Mesh.MeshSizeMax = {};\nMesh.MeshSizeFromCurvature = {:.0f};\nMesh.SaveElementTagType = 2;\n",
                     6 * size, 2 * std::numbers::pi / size);
}

/// For FreeFEM: the fields of each group at 1 and all else at 0, and of the sides at their potentials with all groups
/// at 0; then integrals of products of two gradients, over all and, with the normal, over each sphere.
std::string program(const SphereProblem& problem) {
  const std::size_t groups = problem.groups.size(), spheres = problem.spheres.size();
  std::string conditions;
  for (std::size_t i = 0; i < spheres; ++i)
    conditions += fmt::format(" + on({}, u = (j == {}))", sphere_label + i, problem.spheres[i].group);
  for (int side = 0; side < 6; ++side)
    if (problem.box.sides[side] == Boundary::electrode)
      conditions += fmt::format(" + on({}, u = (j == {}) * {:.17g})", 1 + side, groups, problem.side_potential[side]);
  return fmt::format(R"(mesh3 Th = readmesh3("box.mesh");
fespace Vh(Th, P2);
real before = clock();
Vh[int] field({0});
int j = 0;
Vh u, v;
problem laplace(u, v, solver = CG, eps = 1e-20) = int3d(Th)(dx(u)*dx(v) + dy(u)*dy(v) + dz(u)*dz(v)){1};
for (j = 0; j < {0}; ++j) {{ u = 0; laplace; field[j] = u; }}
ofstream out("integrals");
out.precision(17);
for (int a = 0; a < {0}; ++a) for (int b = 0; b < {0}; ++b)
  out << int3d(Th)(dx(field[a])*dx(field[b]) + dy(field[a])*dy(field[b]) + dz(field[a])*dz(field[b])) << endl;
for (int i = {2}; i < {2} + {3}; ++i) for (int a = 0; a < {0}; ++a) for (int b = 0; b < {0}; ++b) {{
  Vh product = dx(field[a])*dx(field[b]) + dy(field[a])*dy(field[b]) + dz(field[a])*dz(field[b]);
  out << int2d(Th, i)(product*N.x) << " " << int2d(Th, i)(product*N.y) << " " << int2d(Th, i)(product*N.z) << endl;
}}
out << clock() - before << endl;
)",
                     groups + 1, conditions, sphere_label, spheres);
}

class FreefemTrial : public Trial {
 public:
  FreefemTrial(const SphereSubject& subject, double size) : subject_(subject) {
    check_for_meshes(subject.problem);
    fmt::output_file(folder_.file("box.geo")).print("{}", geometry(subject.problem, size));
    fmt::output_file(folder_.file("field.edp")).print("{}", program(subject.problem));
    if (!call("gmsh -3 -format mesh -o box.mesh box.geo")) throw Failure("Gmsh made no mesh of the spheres");
  }

  void run() override {
    if (!call("FreeFem++ -nw -v 0 field.edp")) throw Failure("FreeFEM did not get through it");
    read();
  }
  std::vector<double> errors() const override { return subject_.errors(answer_); }
  std::int64_t work() const override { return 0; }
  std::optional<double> own_seconds() const override { return seconds_; }
  bool is_elsewhere() const override { return true; }

 private:
  bool call(const std::string& command) const {
    return std::system(
               fmt::format("cd '{}' && OMP_NUM_THREADS=1 {} >out 2>&1 </dev/null", folder_.path(), command).c_str()) ==
           0;
  }

  /// Potentials from the groups' charges and potentials, then charges and forces, whose integrals are eps V^2 whatever
  /// the unit of length.
  void read() {
    const SphereProblem& problem = subject_.problem;
    const auto n = static_cast<Eigen::Index>(problem.groups.size());
    std::ifstream file(folder_.file("integrals"));
    Eigen::MatrixXd products(n + 1, n + 1);
    for (Eigen::Index a = 0; a <= n; ++a)
      for (Eigen::Index b = 0; b <= n; ++b) file >> products(a, b);
    const double scale = problem.permittivity * smallest_radius(problem);
    Eigen::MatrixXd matrix = products.topLeftCorner(n, n);
    Eigen::VectorXd right(n), potential(n + 1);
    for (Eigen::Index g = 0; g < n; ++g) {
      const laplace::Group& group = problem.groups[g];
      right[g] = group.floating ? group.charge / scale - products(g, n) : group.potential;
      if (!group.floating) matrix.row(g) = Eigen::VectorXd::Unit(n, g);
    }
    potential << matrix.fullPivLu().solve(right), 1;
    answer_ = {};
    answer_.potential.assign(potential.begin(), potential.begin() + n);
    std::vector<int> members(n);
    for (const laplace::Sphere& sphere : problem.spheres) ++members[sphere.group];
    const Eigen::VectorXd charge = scale * (products * potential);
    for (const laplace::Sphere& sphere : problem.spheres)
      answer_.charge.push_back(members[sphere.group] == 1 ? charge[sphere.group] : NAN);
    for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
      Vec3 force;
      for (Eigen::Index a = 0; a <= n; ++a)
        for (Eigen::Index b = 0; b <= n; ++b)
          for (int k = 0; k < 3; ++k) {
            double integral = 0;
            file >> integral;
            force[k] -= 0.5 * problem.permittivity * potential[a] * potential[b] * integral;
          }
      answer_.force.push_back(force);
    }
    if (!(file >> seconds_)) throw Failure("FreeFEM's results are not complete");
  }

  const SphereSubject& subject_;
  ScratchFolder folder_;
  SphereAnswer answer_;
  double seconds_ = 0;
};

}  // namespace

std::unique_ptr<Trial> make_freefem_trial(const SphereSubject& subject, double size) {
  return std::make_unique<FreefemTrial>(subject, size);
}

}  // namespace lichtenberg::work_precision
