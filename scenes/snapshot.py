#!/usr/bin/python3
"""Writes a frame of a result file as a scene of the field only: each conductor at its position with its charge.

    snapshot.py FILE.h5 FRAME > SCENE.toml

Conductors that were electrically connected become one group; those connected to an electrode are fixed at its
potential. Contacts themselves are not stored, because they depend on earlier frames (hysteresis). Domain, medium,
electrodes and grid are those of the run.
"""

import argparse
import sys

import h5py
import numpy as np

KEPT = ("[domain]", "[medium]", "[[electrode]]", "[effects.floating_conductors]", "[field]")
GROUNDED = -1


def tables(text):
    """Returns the scene's tables unchanged, each as a list of lines."""
    result = [[]]
    for line in text.splitlines():
        if line.startswith("["):
            result.append([])
        result[-1].append(line)
    return result


def kept_tables(text):
    return "\n\n".join("\n".join(table).strip() for table in tables(text) if table and table[0].startswith(KEPT))


def wires(group, charge, potential):
    """Returns the scene's [[group]]s, and the name of each conductor's group; None for a conductor of its own."""
    text, name = "", [None] * len(group)
    for identity in np.unique(group):
        members = np.flatnonzero(group == identity)
        if identity == GROUNDED:
            if np.ptp(potential[members]) > 0:
                sys.exit("snapshot.py: conductors are connected to electrodes of different potential")
            title, value = "grounded", f"potential = {potential[members[0]]:g}"
        elif len(members) > 1:
            title, value = f"group {identity}", f"charge = {charge[members].sum():.4e}"
        else:
            continue
        text += f'\n[[group]]\nname = "{title}"\n{value}\n'
        for i in members:
            name[i] = title
    return text, name


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="result file of a run (.h5)")
    parser.add_argument("frame", type=int, help="index of the frame, from 0")
    request = parser.parse_args()
    with h5py.File(request.file) as file:
        text = file["scene/text"][()].decode()
        conductors = file["particles/conductors"]
        frames = len(conductors["position/time"])
        if not 0 <= request.frame < frames:
            sys.exit(f"snapshot.py: frame {request.frame} is not in {request.file}: it has frames 0 to {frames - 1}")
        position, charge, potential, group = (
            conductors[f"{name}/value"][request.frame] for name in ("position", "charge", "potential", "group")
        )
        radius = conductors["radius"][:]
    groups, name = wires(group, charge, potential)
    print(kept_tables(text))
    print(groups, end="")
    for (x, y, _), r, q, wire in zip(position, radius, charge, name):
        own = f"charge = {q:.4e}" if wire is None else f'group = "{wire}"'
        print(f"\n[[conductor]]\nposition = [{x:.7f}, {y:.7f}]\nradius = {r:g}\n{own}")


if __name__ == "__main__":
    main()
