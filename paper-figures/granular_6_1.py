#!/usr/bin/python3
"""Figure G 6.1: growth rates of a charged gas against wave number, restitution .7, R from 0 to .9."""

from figures import claim, save_claims
from gases import parse_arguments
from modes import draw, grows_at, largest_critical, modes

NUMBERS = (0, 5e-4, 1e-3, 2e-3, 0.01, 0.9)  # G has six between 0 and .9 without their values
SMALL = 0.06  # k l_0


def main():
    arguments = parse_arguments(__doc__)
    tables = {r: modes(arguments.program, 0.7, r)[0]["modes"] for r in NUMBERS}
    draw("granular_6_1", [(f"R = {r:g}", table) for r, table in tables.items()])
    neutral, charged = (largest_critical(arguments.program, 0.7, r) for r in (0, 0.9))
    grows = {kind: [r for r in NUMBERS[1:] if grows_at(tables[r], kind, SMALL)] for kind in ("heat", "sound")}
    words = {kind: ", ".join(f"{r:g}" for r in grows[kind]) or "none" for kind in grows}
    save_claims("granular_6_1", [
        claim("R = 0: heat grows up to k l_0", "G 6.1 a", "about .16 (read off)", f"{neutral:.4f}",
              "agrees by eye" if abs(neutral - 0.16) < 0.01 else "differs"),
        claim(f"at k l_0 = {SMALL:g}: which modes grow", "G 6.1", "heat, fading as R rises; at .9 the two sound modes alone",
              f"heat at R = {words['heat']}; sound at {words['sound']}",
              "agrees" if 0.9 in grows["sound"] and 0.9 not in grows["heat"] else "differs"),
        claim("R = .9: largest k l_0 that grows", "G 6.1 f", "larger than neutral", f"{charged:.4f}, neutral {neutral:.4f}",
              "agrees" if charged > neutral else "differs"),
        claim("charged sound as k -> 0", "G 6.1", "grows (drawn)", "at zeta*/8 whatever R", "of the units",
              "velocities are measured in a thermal speed that falls")])


if __name__ == "__main__":
    main()
