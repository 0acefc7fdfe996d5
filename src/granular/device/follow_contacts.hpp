#pragma once

// All steps of contacts of an outer step, one after the other on all of a device.

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/gas_parts.hpp"

namespace lichtenberg::granular::device {

/// What goes with a grain beside its place, and is put right where its flight ends.
struct Landing {
  Box<3> box;
  Vec3 turns_a_length;
  TurnsAround* image;
  Charged* charges;

  LICHTENBERG_HOST_DEVICE void operator()(int s, int axis, double& place) const {
    Vec3 p{axis == 0 ? place : 0, axis == 1 ? place : 0, axis == 2 ? place : 0};
    Image<3> around{};
    box.wrap(p, around);
    place = p.x + p.y + p.z;
    component(image[s], axis) += around[0] + around[1] + around[2];
    component(charges[s].at, axis) = turns(place, turns_a_length[axis]);
  }
};

/// An outer step's contacts: forces at its start, the pairs that may matter within it, all steps of contacts, and what
/// the last has left.
template <class Law>
struct FollowContacts {
  ContactSteps<Law> steps;
  ForceView force;
  Landing land;

  template <class Grid>
  LICHTENBERG_HOST_DEVICE void operator()(const Grid& grid) const {
    const int count = steps.parameters->steps, grains = steps.grains.count;
    grid.each(grains, [&](int s) { steps.enter(s, force(s)); });
    const int entries = steps.contacts.table.end(grains - 1);
    const auto list = [&](int place, int e) { steps.list_near(place, e); };
    grid.select(entries, &steps.found->pairs, [&](int e) { return steps.is_open(e); }, list);
    grid.select(entries, &steps.found->pairs, [&](int e) { return !steps.is_open(e) && steps.is_near(e); }, list);
    const int pairs = steps.found->pairs;
    for (int step = 0; step < count; ++step) {
      grid.each(pairs, [&](int k) { steps.look(k, step); });
      grid.each(pairs, [&](int k) { steps.push_halfway(k); });
      grid.each(pairs, [&](int k) { steps.integrate(k, step); });
      grid.each(3 * grains, [&](int k) {
        steps.move(k, step, [&](int s, int axis, double& place) {
          if (step == count - 1) land(s, axis, place);
        });
      });
    }
    grid.largest(pairs, &steps.found->impact2, [&](int k) { return steps.impact2(k); });
  }
};

}  // namespace lichtenberg::granular::device
