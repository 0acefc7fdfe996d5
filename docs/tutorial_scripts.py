"""Conversion of the tutorials to scripts of sphinx-gallery, which executes them when the site is built.

A page becomes a Python script. Prose becomes comments in reStructuredText, and commands and Python blocks become code.
A TOML block is written to the file that its first line names.
"""
import posixpath
import re
from pathlib import Path

FIRST_CELL = (Path(__file__).parent / "tutorial_shell.py").read_text()
FAILS = "fails:"  # end of the paragraph before a command that the program refuses
COMMAND = re.compile(r"    (?:\./lichtenberg .*|  .*)$")  # or the continuation of one


def script_name(page):
    """Returns the name of the page of a tutorial on the site, which is that of its script."""
    return page.replace("-", "_")


def linked(match, folder):
    """Converts a link: to a page as a role, to an address as a link, to another file as its text."""
    text, target = match[1], match[2]
    if re.match(r"https?:", target):
        return f"`{text} <{target}>`__"
    page = posixpath.normpath(posixpath.join(folder, target.partition("#")[0]))
    if page.endswith(".md") and not page.startswith(".."):
        page = page.removesuffix(".md")
        return f":doc:`{text} </{script_name(page) if page.startswith(folder) else page}>`"
    return f"``{text}``"


def inline(text, folder):
    """Converts code, formulas, links and characters with a meaning in reStructuredText."""
    parts = re.split(r"(`[^`]+`|\$[^$]+\$|\[[^\]]+\]\([^)\s]+\))", text)
    converted = []
    for k, part in enumerate(parts):
        if k % 2 == 0:
            converted.append(re.sub(r"([\\_|])", r"\\\1", part))
        elif part.startswith("`"):
            converted.append(f"`{part}`")
        elif part.startswith("$"):
            converted.append(f":math:`{part.strip('$')}`")
        else:
            converted.append(linked(re.fullmatch(r"\[([^\]]+)\]\(([^)]+)\)", part), folder))
    # A role or literal must be separated from a following letter.
    return "".join(f"{part}\\ " if k % 2 and re.match(r"\w", (parts[k + 1 :] or [""])[0]) else part
                   for k, part in enumerate(converted))


def table(lines, folder):
    """Returns a list-table of the lines of a Markdown table."""
    rows = [[cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line.strip()[1:-1])] for line in lines]
    result = [".. list-table::", "   :header-rows: 1", ""]
    for row in rows[:1] + rows[2:]:
        for k, cell in enumerate(row):
            result.append(f"   {'* -' if k == 0 else '  -'} {inline(cell, folder)}".rstrip())
    return result


def blocks(text):
    """Yields (kind, lines) of a page: "heading", "command", "table", "prose", or the language of a fenced block."""
    lines = iter([*text.split("\n"), ""])
    kind, block = "", []
    for line in lines:
        fence = re.match(r"```(\w*)", line)
        if fence:
            if block:
                yield kind, block
            inner = []
            for inside in lines:
                if inside.startswith("```"):
                    break
                inner.append(inside)
            yield fence[1] or "text", inner
            kind, block = "", []
            continue
        new = ("" if not line.strip() else "heading" if line.startswith("#") else "command" if COMMAND.match(line)
               else "table" if line.startswith("|") else "prose")
        if new != kind and block:
            yield kind, block
            block = []
        kind = new
        if new:
            block.append(line)


def comment(lines):
    """Returns lines as the comment of a text block of sphinx-gallery."""
    return [f"# {line}".rstrip() for line in lines]


def shell_calls(lines, status):
    """Returns the calls of shell() for the indented commands."""
    joined = re.sub(r"\\\n\s*", "", "\n".join(line.strip() for line in lines))
    return [f"shell({command!r}{status and f', status={status}' or ''})" for command in joined.split("\n")]


def file_call(lines):
    """Returns the code that writes a TOML block to its file."""
    name = lines[0].removeprefix("# ").strip()
    return [f'Path("{name}").write_text(r"""', *lines, '""")']


def restructured(text, folder):
    """Returns the page as lines of reStructuredText, without execution."""
    lines = []
    for kind, block in blocks(text):
        lines += prose_of(kind, block, folder) or [".. code-block:: none", "", *(f"   {line}" for line in block)]
        lines.append("")
    return lines


def prose_of(kind, block, folder):
    """Returns a block that is not executed in reStructuredText; none for code."""
    if kind == "heading":
        marks, title = block[0].split(" ", 1)
        return [inline(title, folder), ("=", "-", "~")[len(marks) - 1] * len(title) * 2]
    if kind == "table":
        return table(block, folder)
    if kind == "prose":
        return inline("\n".join(block), folder).split("\n")
    return []


def script(text, folder):
    """Returns the script of a page."""
    head, code, waiting, last = [], [], [], ""
    for kind, block in blocks(text):
        prose = prose_of(kind, block, folder)
        if prose:
            waiting += [*prose, ""]
            last = block[-1]
            continue
        if not head:  # the text before the first code is the docstring of the script
            head, waiting = waiting, []
            code += ["", *FIRST_CELL.rstrip().split("\n"), ""]
        code += ["", "# %%", *comment(waiting)]
        waiting = []
        if kind == "command":
            code += shell_calls(block, 2 if last.endswith(FAILS) else 0)
        elif kind == "toml":
            code += file_call(block)
        elif kind == "python":
            code += block
        else:
            code += ["# .. code-block:: none", "#", *comment(f"   {line}" for line in block)]
    if waiting:
        code += ["", "# %%", *comment(waiting)]
    return "\n".join(['r"""', *head, '"""', *code]) + "\n"


def write_scripts(pages, scripts, program, home):
    """Writes a script for each tutorial and the introduction of the gallery. Removes the Markdown pages.

    Commands start in the folder of the scripts, which therefore has links to the program and the scenes.
    """
    scripts.mkdir(parents=True)
    (scripts / "lichtenberg").symlink_to(Path(program).resolve())
    (scripts / "scenes").mkdir()  # without the README.md of scenes/, which would make it a gallery
    for scene in (home / "scenes").glob("*.toml"):
        (scripts / "scenes" / scene.name).symlink_to(scene)
    for page in sorted(pages.glob("*.md")):
        if page.name == "index.md":
            (scripts / "README.txt").write_text("\n".join(restructured(page.read_text(), pages.name)) + "\n")
        else:
            (scripts / f"{script_name(page.stem)}.py").write_text(script(page.read_text(), pages.name))
        page.unlink()


class Order:
    """Sort key of sphinx-gallery: the order of the links in the introduction."""

    def __init__(self, folder):
        self.text = (Path(folder) / "README.txt").read_text()

    def __call__(self, name):
        return self.text.find(f"/{name.removesuffix('.py')}>")


class NewPictures:
    """Scraper of sphinx-gallery that shows the PNG files that a block has written."""

    def __repr__(self):
        return "NewPictures"

    def __call__(self, _block, block_vars, gallery_conf):
        from shutil import copyfile

        from sphinx_gallery.scrapers import figure_rst

        folder = Path(block_vars["src_file"]).parent
        shown = block_vars["example_globals"].setdefault("_shown_pictures", set())
        started = Path(block_vars["target_file"]).stat().st_mtime_ns
        files = [path for path in folder.glob("*.png") if path not in shown and path.stat().st_mtime_ns > started]
        names = []
        for path in sorted(files, key=lambda path: path.stat().st_mtime_ns):
            shown.add(path)
            names.append(next(block_vars["image_path_iterator"]))
            copyfile(path, names[-1])
        return figure_rst(names, gallery_conf["src_dir"])
