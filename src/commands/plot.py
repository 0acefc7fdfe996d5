#!/usr/bin/python3
"""Draws a frame of a result file, of conductors or of a packing.

    plot.py FILE [--frame N] [--out PICTURE]

Exit status 2 and one sentence for input that cannot be used.
"""
import argparse
import sys
from pathlib import Path

import drawing
import plot_packing


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", help="result file of a run (.h5)")
    parser.add_argument("--frame", type=int, help="index of the frame, from 0 (default: the last)")
    parser.add_argument("--out", help="picture to write (default: FILE with .png)")
    request = parser.parse_args()

    def work():
        snapshot = drawing.read(request.file, request.frame)
        is_packing = plot_packing.is_packing(request.file)
        figure = plot_packing.draw(request.file, request.frame) if is_packing else drawing.draw(snapshot)
        drawing.save(figure, request.out or Path(request.file).with_suffix(".png"))

    return drawing.report(request.file, work)


if __name__ == "__main__":
    sys.exit(main())
