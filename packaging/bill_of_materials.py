#!/usr/bin/env python3
"""Writes the software bill of materials of a program (CycloneDX 1.5, JSON), and checks the licences.

Components are the packages of cmake/debian-packages.txt, those of the Python packages of pyproject.toml, and those of the shared
libraries that the program names. Versions and licences are those of this Debian machine (field License of
/usr/share/doc/PACKAGE/copyright). Exit status 1: a licence is not in the list of licences that permit distribution of the program
together with the component."""
import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COPYRIGHTS = Path("/usr/share/doc")
# Not part of a distributed program, so that any free licence will do.
TOOLS = {"cmake", "doctest-dev", "g++", "git", "ninja-build", "pkg-config", "pkgconf"}
# SPDX's identifier of a licence that permits distribution under the GPL 3, by the name in Debian's files. None: SPDX has none.
ALLOWED = {
    "apache-2.0": "Apache-2.0", "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause", "bsd-3-clause-intel": "BSD-3-Clause",
    "bsd-3-clause-llns-additional-notice": "BSD-3-Clause", "bsd-3-clause-smu": "BSD-3-Clause",
    "bsd-3-clause-uc-additional-notice": "BSD-3-Clause", "bsl-1.0": "BSL-1.0", "boost software license": "BSL-1.0", "cc0-1.0": "CC0-1.0",
    "expat": "MIT", "expat with embedded exception": "MIT", "gpl-2+": "GPL-2.0-or-later", "gpl-3+": "GPL-3.0-or-later", "isc": "ISC",
    "lgpl-2+": "LGPL-2.0-or-later", "lgpl-2.1+": "LGPL-2.1-or-later", "lgpl-3+": "LGPL-3.0-or-later", "mit": "MIT", "mpl-2": "MPL-2.0",
    "mpl-2.0": "MPL-2.0", "permissive": None, "permissive-2": None, "psf": "PSF-2.0", "python": "PSF-2.0", "public-domain": None, "stream": None,
    "u-of-i-bsd-like": "NCSA", "zlib": "Zlib",
}  # fmt: skip
# Sources of packages whose copyright file has no such fields, or those of a package without content: licence, and the words of the file that state it.
BY_WORDS = {
    "boost-defaults": ("BSL-1.0", "does not contain the actual Boost distribution"),
    "gcc": ("GPL-3.0-or-later WITH GCC-exception-3.1", "GCC Runtime Library Exception"),
    "glibc": ("LGPL-2.1-or-later", "GNU Lesser General Public"),
    "matplotlib": ("PSF-2.0", "PSF"),
    "numpy": ("BSD-3-Clause", "Redistribution and use in source and binary forms"),
    "openmpi": ("BSD-3-Clause", "Redistribution and use in source and binary forms"),
}


class Refused(Exception):
    """A licence is unknown or not allowed."""


def fields(package):
    """Returns version and source of an installed Debian package."""
    words = ["dpkg-query", "-W", "-f", "${Version}\t${source:Package}", package]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise Refused(f"{package} is not installed, so that its licence is unknown")
    return ended.stdout.splitlines()[0].split("\t")


def stated_licences(text):
    """Returns the licences of the upstream files that a copyright file in Debian's format states; empty for other formats."""
    found = set()
    if not text.lstrip().startswith("Format"):
        return found
    for paragraph in re.split(r"\n\s*\n", text):
        files = re.search(r"^Files:(.*?)(?=^\S)", paragraph, re.MULTILINE | re.DOTALL)
        licence = re.search(r"^License:[ \t]*(\S.*)$", paragraph, re.MULTILINE)
        if files and licence and not all(name.startswith("debian/") for name in files[1].split()):
            found.add(licence[1].strip())
    return found


def allowed(package, name):
    """Returns SPDX's identifier for one of Debian's names, or the name. One allowed part of "A or B" is enough, of "A and B" all are needed."""
    parts = [part for part in re.split(r"\s+or\s+|-OR-", name) if all(key in ALLOWED for key in re.split(r"\s+and\s+", part.lower()))]
    if not parts:
        raise Refused(f'{package} has files under the licence "{name}", which is not in the list of allowed licences in {Path(__file__).name}')
    return ALLOWED.get(parts[0].lower()) or parts[0]


def licences_of(package, source, tool):
    """Returns the sorted licences of a Debian package. Those of tools are not checked."""
    text = (COPYRIGHTS / package / "copyright").read_text(encoding="utf-8", errors="replace")
    for start, (licence, words) in BY_WORDS.items():
        if source.startswith(start):
            if not tool and words.lower() not in " ".join(text.split()).lower():
                raise Refused(f'the copyright file of {package} no longer has the words "{words}"')
            return [licence]
    names = stated_licences(text)
    if not names and not tool:
        raise Refused(f"the copyright file of {package} states no licence in a field")
    return sorted({name if tool else allowed(package, name) for name in names})


def component(kind, name, version, licences, use):
    def entry(licence):
        if " WITH " in licence:
            return {"expression": licence}
        return {"license": {"id" if licence in ALLOWED.values() else "name": licence}}

    return {
        "type": "library", "bom-ref": f"{kind}:{name}", "name": name, "version": version, "purl": f"pkg:{kind}/{name}@{version}",
        "scope": "excluded" if use == "tool" else "required", "licenses": [entry(licence) for licence in licences],
        "properties": [{"name": "lichtenberg:use", "value": use}],
    }  # fmt: skip


def use_of(entry):
    return entry["properties"][0]["value"]


def debian_component(package, use):
    version, source = fields(package)
    return component("deb/debian", package, version, licences_of(package, source, use == "tool"), use)


def declared_packages():
    """Returns the packages of the two lists, each with its use."""
    text = (ROOT / "cmake/debian-packages.txt").read_text(encoding="utf-8")
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    needed = re.search(r"^dependencies = \[(.*?)\]", project, re.MULTILINE | re.DOTALL)[1]
    names = {*re.sub("#.*", "", text).split(), *(f"python3-{name}" for name in re.findall(r'"([\w-]+)', needed))}
    return [(name, "tool" if name in TOOLS else "run" if name.startswith("python3-") else "build") for name in names]


def linked_packages(program):
    """Returns the packages of the shared libraries that the program names, without those that these load."""
    needed = re.findall(r"NEEDED\s+(\S+)", subprocess.run(["objdump", "-p", program], capture_output=True, text=True, check=True).stdout)
    paths = dict(re.findall(r"(\S+) => (\S+)", subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout))
    packages = set()
    for path in (Path(paths[name]).resolve() for name in needed if name in paths):
        names = {str(path), str(path).removeprefix("/usr")}  # dpkg may have the path without /usr, from before the merge of the two
        owner = subprocess.run(["dpkg-query", "-S", *names], capture_output=True, text=True, check=False).stdout
        if not owner:
            raise Refused(f"{path} belongs to no Debian package, so that its licence is unknown")
        packages.add(owner.split(":")[0])
    return [(name, "linked") for name in sorted(packages)]


def bill(program):
    """Returns the bill of materials. Throws Refused for a licence that is unknown or not allowed."""
    packages = dict(declared_packages()) | dict(linked_packages(program))
    components = [debian_component(name, use) for name, use in sorted(packages.items())]
    copyleft = [entry["name"] for entry in components if use_of(entry) == "linked" and '"id": "GPL' in json.dumps(entry["licenses"])]
    number = re.search(r"^project\(lichtenberg VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.MULTILINE)[1]
    return {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {
            "component": {"type": "application", "bom-ref": "lichtenberg", "name": "lichtenberg", "version": number, "licenses": [{"license": {"id": "BSD-3-Clause"}}]},
            "properties": [{"name": "lichtenberg:licence-of-binaries", "value": "GPL-3.0-or-later, because of " + ", ".join(copyleft)}],
        },
        "components": components,
        "dependencies": [{"ref": "lichtenberg", "dependsOn": [entry["bom-ref"] for entry in components]}],
    }  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "build/lichtenberg", help="program (default: build/lichtenberg)")
    parser.add_argument("--out", type=Path, help="file (default: standard output)")
    request = parser.parse_args()
    try:
        text = json.dumps(bill(request.program), indent=1) + "\n"
    except (Refused, OSError, subprocess.CalledProcessError) as error:
        print(f"bill_of_materials: {error}", file=sys.stderr)
        return 1
    if request.out:
        request.out.write_text(text, encoding="utf-8")
    else:
        print(text, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
