#!/usr/bin/python3
"""Figure 7.4: branch points against the number of conductors, in stationary states and in growing trees.

Top: branch points of each run against N, with the published 0.237 N (D 7.12). Bottom: those of the largest runs while
they grow, against the size M(t) of the tree (D 7.14).
"""

from counts import draw


def main():
    draw("figure_7_4", __doc__.splitlines()[0], "branch_points", "B", 0.237, ("D 7.12", "D 7.14"))


if __name__ == "__main__":
    main()
