#!/usr/bin/python3
"""Draws a frame of a result file, of conductors, of a packing or of a gas of grains.

    plot.py FILE [--frame N] [--out PICTURE] [--colour charge|cluster]

Of a gas there are two pictures: the second, PICTURE with -series, has its course over time. The colour of its grains is
their charge, or the cluster that they are in.

Exit status 2 and one sentence for input that cannot be used.
"""
import argparse
import sys
from pathlib import Path

import drawing
import plot_gas
import plot_packing


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="result file of a run (.h5)")
    parser.add_argument("--frame", type=int, help="index of the frame, from 0 (default: the last)")
    parser.add_argument("--out", help="picture to write (default: FILE with .png)")
    parser.add_argument("--colour", choices=["charge", "cluster"], help="of grains (default: charge, unless all have the same)")
    request = parser.parse_args()

    def work():
        picture = request.out or Path(request.file).with_suffix(".png")
        if plot_gas.is_gas(request.file):
            return plot_gas.draw(request.file, request.frame, picture, request.colour)
        if request.colour:
            raise drawing.InputError(f"--colour is for gases of grains: {request.file} has none")
        snapshot = drawing.read(request.file, request.frame)
        is_packing = plot_packing.is_packing(request.file)
        figure = plot_packing.draw(request.file, request.frame) if is_packing else drawing.draw(snapshot)
        drawing.save(figure, picture)

    return drawing.report(request.file, work)


if __name__ == "__main__":
    sys.exit(main())
