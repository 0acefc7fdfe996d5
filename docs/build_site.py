#!/usr/bin/env python3
"""Builds the site of docs/ with Sphinx, without a network. Exits with 1 after a warning or a broken link.

    build_site.py PROGRAM FOLDER [--fast]

FOLDER/html is the site. FOLDER/source is a copy of docs/ with the generated pages. --fast leaves the tutorials as
Markdown; otherwise sphinx-gallery executes them. The site has the C++ library if Doxygen and Breathe are installed.
"""
import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
import urllib.parse
from html.parser import HTMLParser
from pathlib import Path

import reference
import tutorial_scripts

DOXYGEN = """
INPUT = {headers}
OUTPUT_DIRECTORY = "{folder}"
STRIP_FROM_PATH = "{home}"
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
GENERATE_HTML = NO
GENERATE_LATEX = NO
HAVE_DOT = NO
JAVADOC_AUTOBRIEF = YES
EXTRACT_ALL = YES
QUIET = YES
WARNINGS = NO
WARN_IF_DOC_ERROR = NO
WARN_IF_INCOMPLETE_DOC = NO
"""

DOCS = Path(__file__).resolve().parent
HOME = DOCS.parent


class Page(HTMLParser):
    """Collects the targets of links and the anchors of a page."""

    def __init__(self, path):
        super().__init__()
        self.targets, self.anchors = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.targets.append(value)
            elif name in ("id", "name") and value:
                self.anchors.add(value)


def broken_links(site):
    """Returns a message for each link of the site to a file or an anchor that does not exist."""
    pages = {path.resolve(): Page(path) for path in sorted(site.rglob("*.html"))}
    messages = []
    for path, page in pages.items():
        for target in page.targets:
            parts = urllib.parse.urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            file = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            file = file / "index.html" if file.is_dir() else file
            anchor = urllib.parse.unquote(parts.fragment)
            if not file.exists():
                messages.append(f"{path.relative_to(site)}: no file {target}")
            elif anchor and file in pages and anchor not in pages[file].anchors:
                messages.append(f"{path.relative_to(site)}: no anchor {target}")
    return messages


def read_headers(folder):
    """Writes the docstrings of the headers that the reference shows as XML; Breathe reads all of the XML for each entity. Returns its folder, or an empty text without Doxygen and Breathe."""
    if not shutil.which("doxygen") or not importlib.util.find_spec("breathe"):
        return ""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    headers = " ".join(f'"{header}"' for header in reference.cpp_headers())
    configuration = DOXYGEN.format(home=HOME, folder=folder, headers=headers)
    subprocess.run(["doxygen", "-"], input=configuration, text=True, check=True)
    return folder / "xml"


def build(program, folder, fast=False):
    """Writes the site into folder/html and returns the exit status of Sphinx. Throws ValueError for a folder of the
    source, because older files in `folder` are removed."""
    if folder.resolve().is_relative_to(DOCS.resolve()) or HOME.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{folder} is part of the source: name another folder for the site")
    source = folder / "source"
    for old in (source, folder / "html", folder / "tutorials"):
        shutil.rmtree(old, ignore_errors=True)
    shutil.copytree(DOCS, source, ignore=shutil.ignore_patterns("__pycache__", "*.json"))
    reference.write_all(program, source / "reference")
    environment = {**os.environ, "LICHTENBERG": str(Path(program).resolve()), "LICHTENBERG_TUTORIALS": "",
                   "LICHTENBERG_VERSION": reference.version_of(program),
                   "LICHTENBERG_DOXYGEN_XML": str(read_headers(folder / "doxygen")),
                   "PYTHONPATH": os.pathsep.join([str(HOME / "python"), str(DOCS)]), "MPLBACKEND": "Agg"}
    if not fast:
        tutorial_scripts.write_scripts(source / "tutorials", folder / "tutorials", program, HOME)
        environment["LICHTENBERG_TUTORIALS"] = str(folder / "tutorials")
    command = [sys.executable, "-B", "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    command += ["-d", folder / "doctrees", source, folder / "html"]
    return subprocess.run(command, env=environment, check=False).returncode


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="path of the program lichtenberg")
    parser.add_argument("folder", type=Path, help="folder of the site and of intermediate files")
    parser.add_argument("--fast", action="store_true", help="leave the tutorials as Markdown, without execution")
    request = parser.parse_args()
    folder = request.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    status = build(request.program, folder, request.fast)
    messages = broken_links(folder / "html")
    print("\n".join(messages), file=sys.stderr, end="\n" if messages else "")
    return 1 if status or messages else 0


if __name__ == "__main__":
    sys.exit(main())
