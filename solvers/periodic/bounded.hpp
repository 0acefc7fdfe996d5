#pragma once

#include <array>
#include <memory>
#include <vector>

#include "solvers/periodic/accuracy.hpp"

// Coulomb sums in boxes with sides that are not periodic.
namespace lichtenberg::periodic {

/// Condition for the field at a side of a box. open: space goes on beyond it. grounded: a conducting plane of potential
/// 0.
enum class Side { periodic, open, grounded };

/// Box with conditions at its sides, in the order of side_names. An axis is periodic on both sides or on none.
struct Enclosure {
  Vec3 lengths;
  std::array<Side, 6> sides{};
  /// True: the box has no sides. All axes are open, and `lengths` is 0.
  bool unbounded = false;

  /// Returns true if all axes are periodic.
  bool is_periodic() const;
  /// Returns the number of copies of each charge: itself and its images in grounded sides, without periodic ones.
  int copies() const;
  /// Returns the requirements on the mesh of all copies: number of charges, extents of the box and open axes of `own`
  /// are replaced. `extents`: of the charges along open axes of an unbounded box.
  MeshRequest request(MeshRequest own, Vec3 extents = {}) const;
};

/// Coulomb sum of charges and dipoles in an enclosure by a particle mesh. Grounded sides are image charges: two of them
/// on an axis make it periodic with twice its length, and opposite mirror images. Along open axes the Green's function
/// of the mesh ends beyond the charges (OpenAxes). Both are exact, apart from the error of the mesh.
///
/// In an unbounded box the mesh follows the extents of the charges, rounded up by at most 9 %. Its parameters depend on
/// the present extents only. Positions are scaled to the longest extent where no other length enters the choice, so
/// that a growing cloud keeps its mesh. Few charges are summed pair by pair.
class BoundedSum : public Sum {
 public:
  /// Number of charges up to which a sum over all pairs of an unbounded box takes less time than a mesh.
  static constexpr int few = 30;

  /// Makes a sum. `request`: accuracy and contact distance, with the enclosure's number of charges. `choice`: mesh of a
  /// box with sides, from choose_bounded_mesh(); not used without sides.
  BoundedSum(const MeshRequest& request, const Enclosure& enclosure, const MeshChoice& choice);

  double cutoff() const override { return 0; }
  /// Computes potentials, fields, forces and energy. The lengths of `sources` and `pairs` are not used. The energy of
  /// charges next to grounded sides is that of their field in the box. Throws Failure for charges beyond a side.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;
  void forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
              std::vector<double>& force) override;
  void dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                    std::span<double> field) override;
  SumSeconds seconds() const override;

 private:
  /// Sum for some extents of an unbounded box, in the unit of their shape; all 0 for one with sides.
  struct Sized {
    Vec3 extents;
    bool by_pairs;
    Vec3 lengths;  ///< Box of the sum
    std::unique_ptr<Sum> sum;
  };
  Sized& sized_for(const Sources& sources);
  const Sources& with_images(const Sources& sources, Vec3 lengths);
  const Sources& in_unit(const Sources& sources, Vec3 lengths);

  MeshRequest request_;
  Enclosure enclosure_;
  std::vector<Sized> sized_;  ///< The latest sums
  double unit_ = 1;           ///< Unit of length of the latest sum
  SumSeconds earlier_;        ///< Times of sums that are no longer in sized_
  std::vector<double> position_, charge_, dipole_;
  Sources all_;
};

/// Chooses the mesh of a BoundedSum, with the error measured at the positions of `sources` in a box with sides, and
/// estimated without sides. Throws InputError if no mesh reaches the accuracy, as in a box that is thinner than a pair
/// of charges.
MeshChoice choose_bounded_mesh(const MeshRequest& request, const Enclosure& enclosure, const Sources& sources,
                               parallel::Team& team = parallel::Team::single());

/// Chooses the mesh of charges with these extents in an unbounded enclosure, without a measurement of its error. It
/// is made for half of the requested error: estimates for random positions can be wrong by a factor of two in clusters.
/// Throws the exceptions of choose_quick_mesh().
MeshChoice choose_cloud_mesh(const Vec3& extents, const MeshRequest& request, const Enclosure& enclosure);

/// Returns the smallest of the lengths 2^(n/8) that is not below this one; 0 for 0.
double rounded_up(double length);

/// Appends the images of the sources in the grounded sides of an enclosure to positions, charges and dipoles.
void append_images(const Enclosure& enclosure, std::vector<double>& position, std::vector<double>& charge,
                   std::vector<double>& dipole);

}  // namespace lichtenberg::periodic
