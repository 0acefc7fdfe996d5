#!/usr/bin/python3
"""Figure 7.3: endpoints against the number of conductors, in stationary states and in growing trees.

Top: Delta_1 of each run against N, with the published 0.252 N (D 7.11). Bottom: Delta_1(t) of the largest runs against
the size M(t) of the tree (D 7.13).
"""

from counts import draw


def main():
    draw("figure_7_3", __doc__.splitlines()[0], "endpoints", r"\Delta_1", 0.252, ("D 7.11", "D 7.13"))


if __name__ == "__main__":
    main()
