"""The broken wire (scenes/broken-wire.toml) at several transverse voltages: the runs that figures 4.6 to 4.8 share."""

import os
import re
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np

from figures import SOURCE, kept_run

# m: distance of the electrodes, distance of the transverse electrodes, radius; number of spheres
LENGTH, DISTANCE, RADIUS, N = 40e-3, 20e-3, 0.775e-3, 25
VOLTAGE = 18e3
# V: s. Near the critical voltage the wire breaks slowly.
RUNS = {1e3: 0.4, 2e3: 0.4, 4e3: 0.4, 6e3: 0.5, 8e3: 0.6, 9e3: 0.8, 10e3: 0.8, 11e3: 0.8, 12e3: 0.8, 14e3: 0.6,
        16e3: 0.6, 20e3: 0.5}
LATE = 0.3  # fraction of a run, at its end, over which values are averaged


class Wire:
    """Run: times (s), positions along and across the wire (m, frames x conductors), charge from left to right (C)."""

    def __init__(self, volts, path):
        self.volts = volts
        with h5py.File(path) as file:
            position = file["particles/conductors/position/value"][:]
            terminals = file["observables/charge_drained_by_terminal"]
            drained = terminals["value"][:]
            every = float(re.search(r"^every = ([0-9.e-]+)", file["scene/text"][()].decode(), re.M).group(1))
        self.time = every * np.arange(len(position))
        self.along = position[:, :, 0] - 1e-3  # the electrodes have a radius of 1 mm
        self.across = position[:, :, 1] - DISTANCE / 2
        self.passed = 0.5 * (drained[:, 1] - drained[:, 0])
        self.late = self.time >= (1 - LATE) * self.time[-1]

    def shape(self):
        """Returns the mean position along and across the wire of each conductor late in the run (m)."""
        return self.along[self.late].mean(axis=0), self.across[self.late].mean(axis=0)

    def largest(self):
        """Returns the late mean of the largest displacement that is antisymmetric about the middle, like the force (m).
        """
        across = self.shape()[1]
        return np.abs(across - across[::-1]).max() / 2

    def resistance(self):
        """Returns 18 kV over the late mean current (Ohm); infinite without current."""
        time, passed = self.time[self.late], self.passed[self.late]
        current = (passed[-1] - passed[0]) / (time[-1] - time[0])
        return VOLTAGE / abs(current) if current else np.inf


def result(arguments, volts):
    """Returns the result file at this transverse voltage."""
    text = (SOURCE / "scenes" / "broken-wire.toml").read_text()
    for old, new in ((r"bottom = .*", f"bottom = {{ potential = {-volts / 2:g} }}"),
                     (r"top = .*", f"top = {{ potential = {volts / 2:g} }}"), (r"time = .*", f"time = {RUNS[volts]}")):
        text, found = re.subn(f"(?m)^{old}$", new, text)
        assert found == 1, old
    arguments.results.mkdir(parents=True, exist_ok=True)
    scene = arguments.results / f"broken-wire-{volts:g}.toml"
    scene.write_text(text)
    return kept_run(arguments.program, scene, scene.with_suffix(".h5"))


def wires(arguments, volts):
    """Returns the runs at these transverse voltages; uses all cores."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return [Wire(v, path) for v, path in zip(volts, pool.map(lambda v: result(arguments, v), volts))]
