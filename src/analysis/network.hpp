#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/geometry/shape.hpp"
#include "src/analysis/edge.hpp"
#include "src/model/frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Ground of a contact network: all bodies that collect charge, which are the electrode sides of the plane box and the
/// electrodes inside it. They are one node of the network.
struct Ground {
  Vec2 size;                   ///< m, size of the box
  std::array<bool, 4> side{};  ///< left, right, bottom, top
  std::vector<Shape> bodies;
};

/// Returns the electrodes and electrode sides of a scene as the ground.
Ground ground_of(const Scene& scene);

/// Returns the smallest surface-to-surface gap (m) between the disk and the ground; infinite without electrodes and
/// electrode sides.
double gap(const Disk& disk, const Ground& ground);

constexpr int to_ground = -1;    ///< replaces a conductor's index: the ground
constexpr int unconnected = -2;  ///< replaces a successor: no path to the ground

/// Finds all contacts by the criterion D 7.1: the surface-to-surface gap is less than `contact_gap` (m). Returns them
/// as edges in ascending order (`to_ground` is the ground). The dissertation D requires centres closer than 3R, which
/// for equal radii is a contact gap of R. The list of closed contacts that a run stores is more accurate, because it
/// includes hysteresis.
std::vector<Edge> contacts(std::span<const Vec2> position, std::span<const double> radius, double contact_gap,
                           const Ground& ground);

/// Undirected graph G of contacts between conductors, and with the ground.
struct ContactGraph {
  std::vector<std::vector<int>> neighbours;  ///< for each conductor, the conductors in contact with it
  std::vector<bool> grounded;                ///< true: in contact with the ground
};

/// Makes the contact graph of the conductors 0 ... conductors - 1 from a list of contacts, whose second index may be
/// `to_ground`.
ContactGraph contact_graph(int conductors, std::span<const Edge> contacts);

/// Finds the direct successor of each conductor on its path to ground: its index, `to_ground` or `unconnected`. The
/// successors form the anti-arborescence A, a tree directed to the ground as root (D 7.2). Conductors in contact with
/// the ground have it as successor. In each following round, a conductor without a successor takes a conductor in
/// contact with it that got one in an earlier round. Of several it takes the nearest by centre distance, of equally
/// near ones the first. Conductors that no round reaches stay `unconnected`.
std::vector<int> successors(const ContactGraph& graph, std::span<const Vec3> position);
/// Finds the direct successor of each conductor on its path to ground, for positions in the plane.
std::vector<int> successors(const ContactGraph& graph, std::span<const Vec2> position);

/// Degree distribution of the conductors that are connected to the ground, which form the tree A of successors() (D
/// 7.2-7.5).
struct DegreeDistribution {
  int connected = 0;  ///< M, number of conductors in A
  int grounded = 0;   ///< number of conductors in contact with the ground
  /// Number of independent loops: contacts in excess of M, the number in a tree with the ground as its root
  int loops = 0;
  std::vector<int> number;  ///< Delta_j (D 7.3): number of conductors of degree j

  int endpoints() const { return number.size() > 1 ? number[1] : 0; }  ///< Delta_1
  int branch_points() const;                                           ///< sum of Delta_j over j > 2
  double fraction(int degree) const;                                   ///< f_j = Delta_j / M (D 7.4); 0 if M = 0
  double branching() const;  ///< B (D 7.5): fraction of branch points; 0 if M = 0
};

/// Computes the degree distribution of the conductors with a path to the ground. A conductor's degree is the number of
/// its contacts with other conductors, plus one if it is in contact with the ground. `successor`: result of
/// successors().
///
/// The M conductors have M + loops contacts, `grounded` of them with the ground. A contact between conductors adds 1 to
/// two degrees, a contact with the ground to one degree. This gives D 7.7 for any network as
///
///   sum_j (j - 2) f_j + (grounded - 2 loops) / M = 0.
DegreeDistribution degree_distribution(const ContactGraph& graph, std::span<const int> successor);

/// Residuals of the relations D 7.6-7.9 between the fractions f_j of conductors of degree j: each is 0 if the relation
/// holds.
///
/// Relations without the suffix `_printed` hold for every network. They have c = (2 loops - grounded) / M in place of
/// -1 / N (D 7.7), and include degrees above 4. M is the number of conductors with a path to the ground, N the number
/// of all conductors. Relations with the suffix are those of the dissertation D. D 7.7 holds for a tree of all N
/// conductors with one contact to the ground. D 7.8 and 7.9 need c = 0, which such a tree approaches for large N. D 7.9
/// also requires that no degree exceeds 4.
struct DegreeRelations {
  double normalization = 0;        ///< sum_j f_j - 1 (7.6)
  double branches = 0;             ///< sum_j (j - 2) f_j - c
  double branches_printed = 0;     ///< sum_j (j - 2) f_j + 1 / N (7.7)
  double mean_degree = 0;          ///< sum_j j f_j - 2 - c
  double mean_degree_printed = 0;  ///< sum_j j f_j - 2 (7.8)
  double f3 = 0;                   ///< f_3 - (2 B - f_1 - c + sum_{j > 4} (j - 4) f_j)
  double f3_printed = 0;           ///< f_3 - (2 B - f_1) (7.9)
  double f4 = 0;                   ///< f_4 - (f_1 - B + c - sum_{j > 4} (j - 3) f_j)
  double f4_printed = 0;           ///< f_4 - (f_1 - B) (7.9)
};

/// Computes the residuals of the relations between the fractions of conductors of each degree. `conductors`: N,
/// including conductors without a path to the ground. All residuals are zero if no conductor has such a path.
DegreeRelations degree_relations(const DegreeDistribution& degrees, int conductors);

/// Contact network of conductors at one instant, as recorded by a run and shown in pictures.
struct ContactNetwork {
  std::vector<Edge> contacts;
  std::vector<int> successor;  ///< see successors()
  DegreeDistribution degrees;
};

/// Makes a contact network from its contacts and the conductors' centres (m): computes the successors and the degree
/// distribution.
ContactNetwork network(std::vector<Edge> contacts, std::span<const Vec3> position);
/// Makes a contact network from its contacts and the conductors' centres (m) in the plane.
ContactNetwork network(std::vector<Edge> contacts, std::span<const Vec2> position);

/// Adds the columns of a contact network to a frame: the contacts (a list), the successors, and the numbers of
/// connected conductors, endpoints and branch points.
void add_columns(const ContactNetwork& network, Frame& frame);

}  // namespace lichtenberg::analysis
