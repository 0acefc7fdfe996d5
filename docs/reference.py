#!/usr/bin/env python3
"""Writes the generated pages of the reference. Usage: reference.py PROGRAM FOLDER.

Pages of scene tables and commands follow from the help of the program. Pages of the libraries follow from docstrings.
The file EXAMPLES has an example of each command, which this script runs.
"""
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from functools import cache
from pathlib import Path

HOME = Path(__file__).resolve().parents[1]
SCOPE = next((HOME / "docs").glob("what-*.md"))
EXAMPLES = HOME / "docs/reference/commands.toml"
# Kinds of scene that read a table. A table of the page SCOPE has those of effects.
ALL_KINDS = "conductors, packings, grains"
KINDS = {"(top of the file)": ALL_KINDS, "[domain]": ALL_KINDS, "[medium]": "conductors", "[material]": "conductors",
         "[[electrode]]": "conductors", "[[circuit]]": "conductors", "[[wall]]": "packings",
         "[[conductor]]": ALL_KINDS, "[[group]]": "conductors", "[[population]]": ALL_KINDS,
         "[units]": "grains", "[[equilibration]]": "grains", "[effects]": ALL_KINDS,
         "[compression]": "packings", "[minimize]": "packings", "[field]": "conductors", "[mechanics]": "conductors, grains",
         "[network]": "packings", "[output]": ALL_KINDS, "[stop]": "conductors, grains"}
TYPES = re.compile(r'(?:one of "|a number|an integer|true or false|a text|two numbers|a (?:non-empty )?list|'
                   r'two corners|"periodic", )')
CPP_PAGES = {  # by page: title, and the entities by directive of Breathe in the order of the page
    "field": ("Fields of conductors", {
        "struct": ["laplace::LaplaceProblem", "laplace::Side", "laplace::Group", "laplace::Body", "laplace::Coupling",
                   "laplace::LaplaceSolution", "laplace::Field", "laplace::CutCellOptions", "laplace::MultipoleOptions",
                   "laplace::AccuracyRequest", "laplace::Choice", "laplace::AccurateSolution", "laplace::SphereProblem",
                   "laplace::SphereSolution", "Disk", "Bar", "Ring"],
        "class": ["laplace::LaplaceSolver", "laplace::CutCellSolver", "laplace::MultipoleSolver",
                  "laplace::SphereSolver"],
        "function": ["laplace::solve_to_accuracy(const LaplaceProblem &, const AccuracyRequest &)"]}),
    "periodic": ("Sums over charges in a periodic box", {
        "struct": ["periodic::Sources", "periodic::Response", "periodic::FieldSample", "periodic::Multipole",
                   "periodic::MeshRequest"],
        "class": ["periodic::Sum", "periodic::MeshSum", "periodic::Ewald", "periodic::MinimumImage",
                  "periodic::ShiftedForce", "periodic::InducedDipoles"]}),
    "network": ("Resistor networks", {
        "struct": ["network::ParticlePacking", "network::ResistorModel", "network::Parameters",
                   "network::PackingNetwork", "network::Network", "network::Link", "network::ConductionOptions",
                   "network::Conduction"],
        "function": ["network::particle_network", "network::contact_network", "network::conduct"]}),
    "numerics": ("Minimizers, integration, neighbours, errors", {
        "class": ["minimize::Objective", "minimize::SmoothObjective", "minimize::Minimizer", "minimize::Lbfgs",
                  "minimize::NewtonCg", "minimize::Fire", "minimize::GradientDescent"],
        "struct": ["Ode", "OdeEnd", "Box", "InputError", "Failure"]}),
    "simulation": ("Scenes and runs", {
        "struct": ["Scene", "Bodies", "EffectKind", "FieldMethodKind", "Frame"],
        "class": ["Effect", "Motion"],
        "function": ["read_scene(const std::string &, const std::vector<Setting> &)"]}),
}
PYTHON_NAMES = {  # by directive of autodoc, in the order of the page
    "load": "autofunction",
    "run": "autofunction",
    "solve": "autofunction",
    "conductors": "autofunction",
    "compile_effect": "autofunction",
    "Scene": "autoclass",
    "Run": "autoclass",
    "Result": "autoclass",
    "Frame": "autoclass",
    "Array": "autoclass",
    "InputError": "autoexception",
    "Failure": "autoexception",
}


def help_of(program, *words):
    return subprocess.run([program, "help", *words], capture_output=True, text=True, check=True).stdout


def version_of(program):
    """Returns the version of the program without its commit."""
    return subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]


def escaped(text):
    """Escapes characters that Markdown would interpret, except for code in backticks."""
    parts = re.split(r"(`[^`]+`)", text)
    return "".join(part if k % 2 else re.sub(r"([\\`*_\[\]<>|$~{}#])", r"\\\1", part) for k, part in enumerate(parts))


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


def properties(values):
    """Divides the description of a key's values into type, unit, range and default. Parts that do not apply are "-"."""
    kind, _, default = re.sub(r"; (required[^;]*)", r"; default: \1", values).partition("; default: ")
    default = default or "-"
    if kind.startswith("one of"):
        return "text", "-", kind.removeprefix("one of "), default
    if "{" in kind:  # a side of the domain
        return "text or table", "V", kind.removesuffix(" in V"), default
    limits = "(?:at least|at most|greater|less|not empty|without).*"
    found = re.fullmatch(rf"(.*?(?:\[.*\])?)(?: in ([^,]+?))?(?:, ({limits}))?", kind)
    return found[1], found[2] or "-", found[3] or "-", default


def example_of(header):
    """Returns the name of a shipped scene with this table, and the lines of the table; empty without one."""
    best = "", ""
    start = r"^title" if header.startswith("(") else rf"^{re.escape(header)}"
    for path in sorted((HOME / "scenes").glob("*.toml")):
        for found in re.finditer(rf"{start}[^\n]*\n(?:[^\n\[][^\n]*\n)*", path.read_text(), re.MULTILINE):
            lines = found.group().rstrip().split("\n")
            if len(lines) > best[1].count("\n") + 1 or not best[1]:
                best = path.name, "\n".join(lines)
    return best


@cache
def kinds_of_effects():
    """Returns the kinds of scene by effect, from the table of effects of the page SCOPE."""
    text = SCOPE.read_text()
    return dict(re.findall(r"^\| ?`([a-z_]+)` ?\| ?((?:conductors|packings|grains)(?:, (?:conductors|packings|grains))*) ?\|", text, re.MULTILINE))


def kinds_of(header):
    """Returns the kinds of scene that read a table. Throws RuntimeError for a table without an entry."""
    name = header.strip("[]")
    effect = name.removeprefix("effects.")
    kinds = KINDS.get(header, "") if effect == name else kinds_of_effects().get(effect, "")
    if not kinds:
        raise RuntimeError(f"{header} has no kinds of scene: add them to KINDS or to the table of effects in {SCOPE}")
    return kinds


def occurrence(header, keys):
    """Returns how often a scene may have the table."""
    if header.startswith("[["):
        return "any number of times"
    required = any(properties(values)[3] == "required" for _, _, values in keys)
    return "once, with its required keys" if required else "at most once"


def file_name(header):
    return "top" if header.startswith("(") else header.strip("[]").replace(".", "-")


def full_name(header, key):
    return key if header.startswith("(") else f"{header.strip('[]')}.{key}"


def related(text, own, names):
    """Returns links to the tables and keys that a text names, except for `own`. `names` has the address by name."""
    found = dict.fromkeys(word.rstrip(".") for word in re.findall(r"[a-z][a-z_]*(?:\.[a-z_]+)*", text))
    targets = {word: names[word] for word in found if names.get(word, own) != own}
    return [f"[`{word}`]({target})" for word, target in targets.items()]


def names_of(tables):
    """Returns the address of each table and key by its unique names: `field.cells`, and `coulomb` of an effect."""
    names = {}
    for header, _, keys in tables:
        page, path = f"{file_name(header)}.md", header.strip("[]")
        if path.startswith("effects."):
            names |= {path: page, path.removeprefix("effects."): page}
        names |= {full_name(header, key): f"{page}#{key}" for key, _, _ in keys if not header.startswith("(")}
    return names


def section_of_key(header, name, meaning, values, names):
    """Returns the lines about a key: its meaning, a table of its properties, and related keys."""
    kind, unit, allowed, default = map(escaped, properties(values))
    lines = ["", f"## {name}", "", escaped(meaning), "",
             "| type | unit | range | default |", "|---|---|---|---|", f"| {kind} | {unit} | {allowed} | {default} |"]
    links = related(f"{meaning} {values}", f"{file_name(header)}.md#{name}", names)
    return lines + (["", f"Related: {', '.join(links)}."] if links else [])


def page_of_table(header, description, keys, names):
    lines = [f"# {escaped(header)}", "", escaped(description), "",
             f"Kinds of scene: {kinds_of(header)}. The table may occur {occurrence(header, keys)}."]
    links = related(description, f"{file_name(header)}.md", names)
    lines += ["", f"Related: {', '.join(links)}."] if links else []
    scene, example = example_of(header)
    if example:
        lines += ["", f"In `scenes/{scene}`:", "", "```toml", example, "```"]
    for name, meaning, values in keys:
        lines += section_of_key(header, name, meaning, values, names)
    return "\n".join(lines) + "\n"


def write_scene_reference(program, folder):
    folder.mkdir(parents=True, exist_ok=True)
    text = help_of(program, "scene")
    tables = tables_of(text)
    lines = ["# Scene reference", "", escaped(" ".join(text.split("\n\n")[0].split())), ""]
    lines += ["| table | contents | kinds of scene |", "|---|---|---|"]
    names = names_of(tables)
    for header, description, keys in tables:
        (folder / f"{file_name(header)}.md").write_text(page_of_table(header, description, keys, names))
        lines.append(f"| [{escaped(header)}]({file_name(header)}.md) | {escaped(description)} | {kinds_of(header)} |")
    (folder / "index.md").write_text("\n".join(lines) + "\n")


def commands_of(text):
    """Returns [(command, description)] of the output of `help`."""
    section = text.split("ommands:", 1)[1]
    return re.findall(r"^  ([a-z][a-z-]*)\s+(\S.*)$", section, re.MULTILINE)


def output_of(program, words, folder):
    """Returns the output of a command in a folder. Throws RuntimeError if the command fails."""
    environment = {**os.environ, "LICHTENBERG": str(Path(program).resolve())}
    ended = subprocess.run(f"'{Path(program).resolve()}' {words}", shell=True, cwd=folder, env=environment, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if ended.returncode:
        raise RuntimeError(f"`lichtenberg {words}` ended with status {ended.returncode}:\n{ended.stdout}")
    return ended.stdout.rstrip()


def example_section(program, example, folder):
    """Returns the lines of an example: commands before it, its output, and the meaning of each column. Throws
    RuntimeError if the output lacks a column."""
    for words in example.get("before", []):
        output_of(program, words, folder)
    output = output_of(program, example["run"], folder)
    missing = [name for name, _ in example["columns"] if name not in output]
    if missing:
        raise RuntimeError(f"the output of `lichtenberg {example['run']}` lacks {', '.join(missing)}:\n{output}")
    shown = output.split("\n")
    largest = example.get("lines", len(shown))
    commands = "\n".join(f"./lichtenberg {words}" for words in [*example.get("before", []), example["run"]])
    before = ["", "`seedling.h5` is the result of the example of [run](run.md)."] if "seedling.h5" in commands else []
    title = "The last command prints:" if example.get("before") else "The command prints:"
    rest = ["..."] if largest < len(shown) else []
    return ["", "## Example", *before, "", "```text", commands, "```", "", title, "", "```text", *shown[:largest], *rest, "```", "",
            "| output | meaning |", "|---|---|", *(f"| `{name}` | {meaning} |" for name, meaning in example["columns"])]


def write_commands(program, folder):
    folder.mkdir(parents=True, exist_ok=True)
    examples = tomllib.loads(EXAMPLES.read_text())
    lines = ["# Commands", "", "| command | purpose |", "|---|---|"]
    with tempfile.TemporaryDirectory(prefix="lichtenberg-reference-") as work:
        (Path(work) / "scenes").symlink_to(HOME / "scenes")
        for name, description in commands_of(help_of(program)):
            page = [f"# {name}", "", escaped(description), "", "```text", help_of(program, name).strip(), "```"]
            if name not in examples:
                raise RuntimeError(f"{EXAMPLES} has no example of the command {name}")
            page += example_section(program, examples[name], work)
            (folder / f"{name}.md").write_text("\n".join(page) + "\n")
            lines.append(f"| [{name}]({name}.md) | {escaped(description)} |")
    (folder / "index.md").write_text("\n".join(lines) + "\n")


def write_python(folder):
    """Writes the page of the Python package, which autodoc fills from the docstrings."""
    example = "[Solve and run from Python](../how-to/solve-in-python.md) has examples."
    lines = ["# Python package", "", f"{example} `import lichtenberg` provides these names.", ""]
    for name, directive in PYTHON_NAMES.items():
        options = ["   :members:", "   :special-members: __getitem__, __len__"] if directive == "autoclass" else []
        lines += [f"## {name}", "", "```{eval-rst}", f".. {directive}:: lichtenberg.{name}", *options, "```", ""]
    (folder / "python.md").write_text("\n".join(lines))


def cpp_headers():
    """Returns the headers of the library that define or use an entity of CPP_PAGES."""
    defined = []
    for _, entities in CPP_PAGES.values():
        for directive, names in entities.items():
            for name in names:
                own = name.partition("(")[0].rpartition("::")[2]
                defined.append(rf"\b{own}\(" if directive == "function" else rf"\b(class|struct) {own}\b[^;]*{{")
    pattern = re.compile("|".join(defined))
    found = [path for folder in ("solvers", "src") for path in sorted((HOME / folder).rglob("*.hpp"))]
    return [path for path in found if "commands" not in path.parts and pattern.search(path.read_text(encoding="utf-8"))]


def write_cpp(folder):
    """Writes the pages of the C++ library, which Breathe fills from the docstrings."""
    folder.mkdir(parents=True, exist_ok=True)
    text = ("The pages have the main types and functions, of namespace `lichtenberg`. "
            "[C++ library](../../how-to/cpp-library.md) shows a program that uses them.")
    index = ["# C++ library", "", text, "", "| page | contents |", "|---|---|"]
    for page, (title, entities) in CPP_PAGES.items():
        lines = [f"# {title}", ""]
        for directive, names in entities.items():
            options = [] if directive == "function" else [":members:", ":undoc-members:"]
            for name in names:
                lines += [f"## {name.partition('(')[0]}", ""]
                lines += [f"```{{doxygen{directive}}} lichtenberg::{name}", *options, "```", ""]
        (folder / f"{page}.md").write_text("\n".join(lines))
        shown = [name.partition("(")[0].rpartition("::")[2] for names in entities.values() for name in names]
        contents = ", ".join(f"`{name}`" for name in shown)
        index.append(f"| [{title}]({page}.md) | {contents} |")
    (folder / "index.md").write_text("\n".join(index) + "\n")


def write_all(program, folder):
    """Writes all generated pages of the reference."""
    write_scene_reference(program, folder / "scene")
    write_commands(program, folder / "commands")
    write_python(folder)
    write_cpp(folder / "cpp")


def main():
    write_all(sys.argv[1], Path(sys.argv[2]))


if __name__ == "__main__":
    main()
