#!/usr/bin/python3
"""Makes a page with a picture and the command of each scene. Runs all scenes, some shortened, and draws the results.

    scenes/gallery.py [FOLDER] [--only NAME,NAME]      writes FOLDER/index.html (default: gallery)

Uses the program of build/, or the one that LICHTENBERG names. Results are stored with the pictures; existing ones are
not computed again.
"""
import argparse
import html
import os
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROGRAM = os.environ.get("LICHTENBERG", str(HERE.parent / "build/lichtenberg"))
SHORTER = {  # reduced settings, so that the page needs at most an hour of one core
    "large-dendrite": ["population.count=600", "stop.time=1"],
    "huge-dendrite": ["population.count=600", "field.cells=1024", "stop.time=0.5"],
    "granular-gas-full": ["stop.time=8"],
    "neutral-gas": ["stop.time=30"],
}
SOLVED = ["two-disks", "dendrite-snapshot"]
PLOTTED = {"shuttle": ["--series"], "pair": ["--frame=0"], "pair-3d": ["--series"], "approach": ["--colour=charge"], "two-grains": ["--series"]}

PAGE = """<!doctype html>
<meta charset="utf-8">
<title>Scenes of lichtenberg</title>
<style>
  body {{ font: 15px system-ui, sans-serif; max-width: 1100px; margin: 2em auto; }}
  main {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(320px, 1fr)); gap: 2em; }}
  img {{ width: 100%; }}
  code {{ font-size: 12px; overflow-wrap: anywhere; }}
</style>
<h1>Scenes of lichtenberg</h1>
<main>
{figures}
</main>
"""
FIGURE = """<figure><a href="{picture}"><img src="{picture}" alt="{name}"></a>
<figcaption><b>{name}</b>: {words}<br><code>{command}</code></figcaption></figure>"""


def rows():
    """Returns [(name, description)] of the README's table."""
    table = (HERE / "README.md").read_text()
    return re.findall(r"^\| `([a-z0-9-]+)\.toml` \| (.*?)(?: \(`[^)]*\))? \|$", table, re.MULTILINE)


def call(*words):
    subprocess.run([PROGRAM, *map(str, words)], check=True, stdout=subprocess.DEVNULL)


def make(name, folder):
    """Draws the scene into the folder. Returns the command."""
    scene, picture, result = HERE / f"{name}.toml", folder / f"{name}.png", folder / f"{name}.h5"
    if name in SOLVED:
        call("solve", scene, "--out", picture, "--overwrite")
        return f"lichtenberg solve scenes/{name}.toml --out {name}.png"
    settings = [f"--set={setting}" for setting in SHORTER.get(name, [])]
    if not result.exists():
        call("run", scene, "--out", result, "--quiet", "--set=output.picture=false", *settings)
    call("plot", result, "--out", picture, "--overwrite", *PLOTTED.get(name, []))
    words = ["lichtenberg run", f"scenes/{name}.toml", *(word.replace("=", " ", 1) for word in settings)]
    drawn = f"; lichtenberg plot {name}.h5 {' '.join(PLOTTED[name])}" if name in PLOTTED else ""
    return " ".join(words) + drawn


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="gallery")
    parser.add_argument("--only", help="names of scenes, separated by commas")
    request = parser.parse_args()
    folder = Path(request.folder)
    folder.mkdir(exist_ok=True)
    chosen = request.only.split(",") if request.only else [name for name, _ in rows()]
    figures = []
    for name, words in rows():
        if name not in chosen:
            continue
        print(name, file=sys.stderr, flush=True)
        try:
            command = make(name, folder)
        except subprocess.CalledProcessError:  # which has said why
            print(f"{name} is left out", file=sys.stderr)
            continue
        parts = {"name": name, "words": html.escape(words), "command": html.escape(command), "picture": f"{name}.png"}
        figures.append(FIGURE.format(**parts))
    (folder / "index.html").write_text(PAGE.format(figures="\n".join(figures)))
    return 0 if len(figures) == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main())
