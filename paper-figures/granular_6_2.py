#!/usr/bin/python3
"""Figure G 6.2: growth rates of a charged gas against wave number, R = .9, restitution from .8 to .3."""

from figures import claim, save_claims
from gases import parse_arguments
from modes import draw, largest_critical, modes

RESTITUTIONS = (0.8, 0.7, 0.6, 0.5, 0.4, 0.3)


def main():
    arguments = parse_arguments(__doc__)
    tables = {eps: modes(arguments.program, eps, 0.9)[0]["modes"] for eps in RESTITUTIONS}
    draw("granular_6_2", [(rf"$\epsilon$ = {eps:g}", table) for eps, table in tables.items()])
    ratios = {eps: largest_critical(arguments.program, eps, 0.9) / largest_critical(arguments.program, eps, 0)
              for eps in RESTITUTIONS}
    falls = all(ratios[a] > ratios[b] for a, b in zip(RESTITUTIONS, RESTITUTIONS[1:]))
    below = max((eps for eps in RESTITUTIONS if ratios[eps] < 1), default=None)
    ours = ", ".join(f"{ratios[eps]:.2f}" for eps in RESTITUTIONS)
    save_claims("granular_6_2", [
        claim("critical k, charged over neutral, restitution .8 ... .3", "G 6.2",
              "falls with dissipation, below 1 in the end", ours + (f"; below 1 from {below:g} on" if below else ""),
              "agrees" if falls and below else "differs")])


if __name__ == "__main__":
    main()
