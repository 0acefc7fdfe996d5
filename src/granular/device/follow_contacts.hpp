#pragma once

// All contact substeps of an outer step in a single kernel of the whole device.

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/device/rough_steps.hpp"

namespace lichtenberg::granular::device {

/// Function of one grain: wraps its position into the periodic box, counts the periods, and updates the position for
/// Coulomb sums.
struct PositionWrap {
  Box<3> box;
  Vec3 units_per_length;

  LICHTENBERG_HOST_DEVICE void operator()(const GrainsView& grains, int s) const {
    Vec3 p = grains.position[s];
    ImageCount& image = grains.image[s];
    Image<3> around{image.x, image.y, image.z};
    box.wrap(p, around);
    grains.position[s] = p;
    image = {around[0], around[1], around[2]};
    grains.charged[s].at = fixed_point_position(p, units_per_length);
  }
};

/// Kernel of an outer step (from one evaluation of the smooth forces to the next). Lists the candidate pairs (in
/// contact, or may touch), then runs all contact substeps. It returns at once if no step has been chosen (*go is 0).
/// With several ranks a kernel runs one substep, because ranks exchange grains after each.
template <class Law>
struct FollowContacts {
  ContactSteps<Law> steps;
  PositionWrap wrap;
  const int* go;                     ///< 0: no step has been chosen
  int from = 0, to = 1'000'000'000;  ///< substeps from ... to - 1

  template <class Grid>
  LICHTENBERG_HOST_DEVICE void operator()(const Grid& grid) const {
    if (!*go) return;
    const int count = steps.parameters->steps;
    const GrainsView& all = steps.grains;
    const RingRange& own = steps.range.own;
    const int grains = steps.range.known.count, first = 3 * steps.range.known.first, numbers = 3 * all.count;
    if (from == 0)
      grid.select(
          steps.contacts.table.end(all.count - 1), &steps.results->pairs, [&](int e) { return steps.is_near(e); },
          [&](int index, int e) { steps.list_near(index, e); });
    const int pairs = steps.results->pairs, end = to < count ? to : count;
    for (int step = from; step < end; ++step) {
      grid.each_that(
          pairs, [&](int k) { return steps.is_due(k, step); }, [&](int k) { steps.activate_pair(k, step); });
      const int active = steps.results->active;
      grid.begin(3 * grains, [&](int k) { steps.clear(all.impulse, all.shift, around(first + k, numbers)); });
      grid.each(active, [&](int a) { steps.add_halfway_force(a); });
      // Integration takes long, but few threads. The other threads move grains without active pairs in the meantime.
      grid.begin_last(own.count, [&](int k) {
        const int s = own.first + k;
        if (!all.busy[s]) move(s, step == count - 1);
      });
      grid.each(active, [&](int a) { steps.integrate(a, step); });
      grid.begin(3 * grains, [&](int k) { steps.clear(all.force, all.halfway, around(first + k, numbers)); });
      grid.each(grains, [&](int k) {
        const int s = steps.range.known(k);
        if (all.busy[s]) own.contains(s) ? move(s, step == count - 1) : steps.leave(s);
        if (k == 0) steps.results->active = 0;
      });
    }
  }

 private:
  LICHTENBERG_HOST_DEVICE static int around(int k, int n) { return k < n ? k : k - n; }
  /// Moves grain s to the end of a substep, and wraps it into the box after the last substep.
  LICHTENBERG_HOST_DEVICE void move(int s, bool last) const {
    steps.move(s);
    if (last) wrap(steps.grains, s);
  }
};

/// Kernel of an outer step of rough grains, as FollowContacts. Without substeps it finds contacts only. If a contact
/// makes a grain faster than the assumed bound, candidate pairs are listed again with a larger one.
template <class Law>
struct FollowRough {
  RoughContactSteps<Law> steps;
  PositionWrap wrap;
  const int* go;  ///< 0: no step has been chosen

  template <class Grid>
  LICHTENBERG_HOST_DEVICE void operator()(const Grid& grid) const {
    if (!*go) return;
    const int count = steps.parameters->steps, grains = steps.grains.count;
    const double h = steps.parameters->inner;
    const bool walls = steps.rough.walls.any();
    double bound = count > 0 ? steps.bound_on_speeds() : 0;
    list_pairs(grid, static_cast<float>(2 * bound * h * count));
    if (count > 0) {
      if (walls) grid.begin(grains, [&](int s) { steps.begin_walls(s); });
      grid.each(steps.results->pairs, [&](int k) { steps.begin_pair(k); });
    }
    for (int step = 0; step < count; ++step) {
      grid.each(grains, [&](int s) { steps.move(s, step); });
      if (const double fastest2 = steps.results->too_fast2; fastest2 > bound * bound) {
        bound = 2 * std::sqrt(fastest2);
        grid.each(1, [&](int) { steps.results->pairs = 0; });
        list_pairs(grid, static_cast<float>(2 * bound * h * (count - step)));
      }
      const auto path = static_cast<float>(2 * bound * h);
      if (walls) grid.begin(grains, [&](int s) { steps.follow_walls(s, step); });
      grid.each_that(
          steps.results->pairs, [&](int k) { return steps.is_due(k, step); },
          [&](int k) { steps.follow_pair(k, step, path); });
    }
    grid.each(grains, [&](int s) {
      if (count > 0) steps.move(s, count), wrap(steps.grains, s);
      if (walls) steps.find_wall_impacts(s);
    });
  }

 private:
  /// Lists the pairs that are in contact, or whose gap is below `reach` (d0).
  template <class Grid>
  LICHTENBERG_HOST_DEVICE void list_pairs(const Grid& grid, float reach) const {
    grid.select(
        steps.contacts.table.end(steps.grains.count - 1), &steps.results->pairs,
        [&](int e) { return steps.is_near(e, reach); }, [&](int index, int e) { steps.list_near(index, e); });
  }
};

}  // namespace lichtenberg::granular::device
