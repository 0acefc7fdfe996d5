#!/usr/bin/env python3
"""Writes the pages of the scene reference and of the commands from the help of the program.

    reference.py PROGRAM FOLDER
"""
import re
import subprocess
import sys
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
TYPES = re.compile(r'(?:one of "|a number|an integer|true or false|a text|two numbers|a list|two corners|"periodic", )')
CPP_TYPES = {  # by kind in Doxygen, in the order of the page
    "laplace::LaplaceProblem": "struct",
    "laplace::LaplaceSolution": "struct",
    "laplace::LaplaceSolver": "class",
    "laplace::CutCellSolver": "class",
    "laplace::CutCellOptions": "struct",
    "laplace::MultipoleSolver": "class",
    "laplace::MultipoleOptions": "struct",
    "laplace::SphereProblem": "struct",
    "laplace::SphereSolution": "struct",
    "laplace::SphereSolver": "class",
    "Scene": "struct",
    "Bodies": "struct",
    "Effect": "class",
    "EffectKind": "struct",
    "FieldMethodKind": "struct",
    "Motion": "class",
    "Frame": "struct",
}


def help_of(program, *words):
    return subprocess.run([program, "help", *words], capture_output=True, text=True, check=True).stdout


def escaped(text):
    """Escapes characters that Markdown would interpret."""
    return re.sub(r"([\\`*_\[\]<>|$~{}#])", r"\\\1", text)


def tables_of(text):
    """Returns [(header, help, [(key, description, values)])] of the output of `help scene`."""
    tables = []
    for block in re.split(r"\n\n", text)[1:]:
        header, *lines = block.strip("\n").split("\n")
        description, keys = [], []
        for line in lines:
            key = re.match(r"    (\S+)\s*(.*)$", line) if re.match(r"    \S", line) else None
            if key:
                keys.append((key.group(1), [key.group(2)] if key.group(2) else []))
            elif keys:
                keys[-1][1].append(line.strip())
            else:
                description.append(line.strip())
        tables.append((header, " ".join(description), [(name, *divided(words)) for name, words in keys]))
    return tables


def divided(lines):
    """Divides the lines of a key into its description and its type with the default."""
    for k in range(len(lines) - 1, -1, -1):
        if TYPES.match(lines[k]):
            return " ".join(lines[:k]), " ".join(lines[k:])
    return " ".join(lines), ""


def example_of(header):
    """Returns the name of a shipped scene with this table, and the lines of the table; empty without one."""
    for path in sorted((HOME / "scenes").glob("*.toml")):
        found = re.search(rf"^{re.escape(header)}[^\n]*\n(?:[^\n\[][^\n]*\n)*", path.read_text(), re.MULTILINE)
        if found and found.group().count("\n") > 1:
            return path.name, found.group().rstrip()
    return "", ""


def file_name(header):
    return "top" if header.startswith("(") else header.strip("[]").replace(".", "-")


def page_of_table(header, description, keys):
    lines = [f"# {escaped(header)}", "", escaped(description), ""]
    if keys:
        lines += ["| key | meaning | type; default |", "|---|---|---|"]
        lines += [f"| `{name}` | {escaped(meaning)} | {escaped(values)} |" for name, meaning, values in keys]
    scene, example = example_of(header)
    if example:
        lines += ["", f"In `scenes/{scene}`:", "", "```toml", example, "```"]
    return "\n".join(lines) + "\n"


def write_scene_reference(program, folder):
    folder.mkdir(parents=True, exist_ok=True)
    text = help_of(program, "scene")
    tables = tables_of(text)
    lines = ["# Scene reference", "", escaped(" ".join(text.split("\n\n")[0].split())), ""]
    lines += ["| table | contents |", "|---|---|"]
    for header, description, keys in tables:
        (folder / f"{file_name(header)}.md").write_text(page_of_table(header, description, keys))
        lines.append(f"| [{escaped(header)}]({file_name(header)}.md) | {escaped(description)} |")
    (folder / "index.md").write_text("\n".join(lines) + "\n")


def commands_of(text):
    """Returns [(command, description)] of the output of `help`."""
    section = text.split("ommands:", 1)[1]
    return re.findall(r"^  ([a-z][a-z-]*)\s+(\S.*)$", section, re.MULTILINE)


def write_commands(program, folder):
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["# Commands", "", "| command | purpose |", "|---|---|"]
    for name, description in commands_of(help_of(program)):
        page = f"# {name}\n\n{escaped(description)}\n\n```text\n{help_of(program, name).strip()}\n```\n"
        (folder / f"{name}.md").write_text(page)
        lines.append(f"| [{name}]({name}.md) | {escaped(description)} |")
    (folder / "index.md").write_text("\n".join(lines) + "\n")


def write_cpp(folder):
    """Writes the page of the main types of the C++ library, which Breathe fills from the docstrings."""
    lines = ["# C++ library", ""]
    for name, kind in CPP_TYPES.items():
        lines += [f"## {name}", "", f"```{{doxygen{kind}}} lichtenberg::{name}", ":members:", "```", ""]
    (folder / "cpp.md").write_text("\n".join(lines))


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    write_scene_reference(program, folder / "scene")
    write_commands(program, folder / "commands")
    write_cpp(folder)


if __name__ == "__main__":
    main()
