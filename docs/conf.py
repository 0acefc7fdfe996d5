"""Configuration of the site that `ninja docs` builds from a copy of this folder (cmake/docs.cmake)."""
import importlib.util
import os
import posixpath
import re
from pathlib import Path

from docutils import nodes

project = "lichtenberg"
author = "The lichtenberg developers"
version = release = os.environ.get("LICHTENBERG_VERSION", "")
extensions = ["myst_parser", "sphinx.ext.mathjax"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["conf.py"]
html_theme = "furo"
html_title = "lichtenberg"
html_copy_source = False
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
highlight_language = "none"

# Formulas without a network: Debian's package libjs-mathjax (version 2).
LOCAL_MATHJAX = Path("/usr/share/javascript/mathjax/MathJax.js")
if LOCAL_MATHJAX.exists():
    myst_update_mathjax = False
    mathjax_path = f"file://{LOCAL_MATHJAX}?config=TeX-AMS-MML_HTMLorMML"
    mathjax_options = {"async": "async"}
    mathjax2_config = {"tex2jax": {"inlineMath": [["\\(", "\\)"]], "displayMath": [["\\[", "\\]"]]}}

# The C++ library, if Doxygen has written its XML and Breathe is installed.
DOXYGEN_XML = os.environ.get("LICHTENBERG_DOXYGEN_XML", "")
if DOXYGEN_XML and importlib.util.find_spec("breathe"):
    extensions.append("breathe")
    breathe_projects = {project: DOXYGEN_XML}
    breathe_default_project = project
else:
    exclude_patterns.append("reference/cpp.md")


def linked_pages(text, folder):
    """Returns the names of the pages of the site that a page in this folder links to, in their order."""
    targets = re.findall(r"\]\(([^)#\s]+)\.md(?:#[^)]*)?\)", text)
    names = [posixpath.normpath(posixpath.join(folder, target)) for target in targets]
    return list(dict.fromkeys(names))


def toctree(names):
    entries = "\n".join(f"/{name}" for name in names)
    return f"\n\n```{{toctree}}\n:hidden:\n\n{entries}\n```\n"


def contents(app):
    """Returns the entries of the table of contents of each index page: the pages that it links to and no earlier index
    page has. The first index page also has all remaining pages."""
    source = Path(app.srcdir)
    found = sorted(app.env.found_docs)
    indexes = sorted((name for name in found if posixpath.basename(name) == "index"), key=lambda name: (name.count("/"), name))
    taken, entries = {"index"}, {}
    for name in indexes[1:]:
        links = linked_pages((source / f"{name}.md").read_text(), posixpath.dirname(name))
        own = [link for link in links if link.startswith(posixpath.dirname(name) + "/") and link != name]
        entries[name] = [link for link in own if link in found and link not in taken]
        taken.update(entries[name])
    first = [link for link in linked_pages((source / "index.md").read_text(), "") if link in found and link not in taken]
    entries["index"] = first + [name for name in found if name not in taken and name not in first]
    return entries


def add_contents(app, name, source):
    """Appends the table of contents to an index page, so that the files stay plain Markdown."""
    if posixpath.basename(name) == "index":
        names = contents(app).get(name, [])
        source[0] += toctree(names) if names else ""


def resolve_outside(_app, _environment, node, content):
    """Shows a link to a file outside of the site as its text."""
    target = node.get("reftarget", "")
    outside = target.startswith("../") or Path(target).suffix in (".toml", ".hpp", ".cpp", ".py", ".json", ".bib", ".cff")
    return nodes.literal(text=content.astext()) if outside else None


def setup(app):
    app.connect("source-read", add_contents)
    app.connect("missing-reference", resolve_outside)
