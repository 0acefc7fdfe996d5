#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "solvers/geometry/shape.hpp"
#include "src/analysis/edge.hpp"
#include "src/model/frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// All that drains charge: the box's sides that are electrodes, and the electrodes inside it. One node of the network.
struct Ground {
  Vec2 size;                   ///< m, of the box
  std::array<bool, 4> side{};  ///< left, right, bottom, top
  std::vector<Shape> bodies;
};

Ground ground_of(const Scene& scene);

/// Smallest surface-to-surface gap between the disk and the ground (m); infinite without any ground.
double gap(const Disk& disk, const Ground& ground);

constexpr int to_ground = -1;    ///< in place of a conductor's index: the ground
constexpr int unconnected = -2;  ///< in place of a successor: no path to the ground

/// All contacts as edges (`to_ground` is the ground), in ascending order, by the criterion D 7.1: those whose
/// surface-to-surface gap is less than `contact_gap` (m). D asks for centres closer than 3R, which for equal radii is a
/// contact gap of R. A run also remembers which contacts it made; its own list is the better one.
std::vector<Edge> contacts(std::span<const Vec2> position, std::span<const double> radius, double contact_gap,
                           const Ground& ground);

/// The undirected network G of contacts.
struct ContactGraph {
  std::vector<std::vector<int>> neighbours;  ///< of each conductor: the conductors in contact with it
  std::vector<bool> grounded;                ///< in contact with the ground
};

ContactGraph contact_graph(int conductors, std::span<const Edge> contacts);

/// Direct successors, the anti-arborescence A rooted at the ground (D 7.2): conductors in contact with the ground have
/// it as successor; then, round by round, each conductor without one takes the nearest (centre to centre; of equally
/// near ones the first) of those in contact with it that had a successor when the round began.
/// Returns for each conductor the index of its successor, `to_ground` or `unconnected`.
std::vector<int> successors(const ContactGraph& graph, std::span<const Vec3> position);
std::vector<int> successors(const ContactGraph& graph, std::span<const Vec2> position);

/// Degrees of the conductors that are in A (D 7.2-7.5).
struct DegreeDistribution {
  int connected = 0;        ///< M, the conductors in A
  int grounded = 0;         ///< those in contact with the ground
  int loops = 0;            ///< contacts beyond the M that a tree with the ground as its root has
  std::vector<int> number;  ///< Delta_j (D 7.3): conductors of degree j

  int endpoints() const { return number.size() > 1 ? number[1] : 0; }  ///< Delta_1
  int branch_points() const;                                           ///< sum of Delta_j over j > 2
  double fraction(int degree) const;                                   ///< f_j = Delta_j / M (D 7.4); 0 if M = 0
  double branching() const;                                            ///< B (D 7.5); 0 if M = 0
};

/// A conductor's degree counts its contacts with other conductors, and the ground as one more: D's sum (7.2) starts at
/// node 0, and only so does (7.7) hold. Every contact adds 1 to the degrees at both its ends, a contact with the ground
/// to one; with M + loops contacts, `grounded` of them with the ground, that gives (7.7) for any network as
///   sum_j (j - 2) f_j + (grounded - 2 loops) / M = 0.
DegreeDistribution degree_distribution(const ContactGraph& graph, std::span<const int> successor);

/// What is left over of D's relations between the fractions f_j (7.6-7.9): each is 0 where the relation holds.
///
/// Those without `printed` hold for every network, with c = (2 loops - grounded) / M for D's -1 / N (7.7) and with
/// degrees above 4. D's own need c = 0, which many conductors in a tree on one foot approach, and 7.9 no degree
/// above 4.
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

/// `conductors`: N, those without a way to the ground among them. All zero if M = 0.
DegreeRelations degree_relations(const DegreeDistribution& degrees, int conductors);

/// The network at one instant: what a run records and a picture shows.
struct ContactNetwork {
  std::vector<Edge> contacts;
  std::vector<int> successor;  ///< see successors()
  DegreeDistribution degrees;
};

/// Successors and degrees in one go.
ContactNetwork network(std::vector<Edge> contacts, std::span<const Vec3> position);
ContactNetwork network(std::vector<Edge> contacts, std::span<const Vec2> position);

/// Its contacts (a list), the successors and the counts of connected conductors, endpoints and branch points.
void add_columns(const ContactNetwork& network, Frame& frame);

}  // namespace lichtenberg::analysis
