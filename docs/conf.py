"""Configuration of Sphinx for the site that build_site.py builds from a copy of this folder."""
import os
import posixpath
import re
from pathlib import Path

from docutils import nodes

project = "lichtenberg"
author = "The lichtenberg developers"
version = release = os.environ.get("LICHTENBERG_VERSION", "")
extensions = ["myst_parser", "sphinx.ext.mathjax", "sphinx.ext.autodoc"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = []
html_theme = "furo"
html_title = "lichtenberg"
html_copy_source = False
html_show_copyright = False
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
highlight_language = "none"
smartquotes = False

# Formulas without a network: Debian's package libjs-mathjax (version 2).
LOCAL_MATHJAX = Path("/usr/share/javascript/mathjax/MathJax.js")
if LOCAL_MATHJAX.exists():
    myst_update_mathjax = False
    mathjax_path = f"file://{LOCAL_MATHJAX}?config=TeX-AMS-MML_HTMLorMML"
    mathjax_options = {"async": "async"}
    mathjax2_config = {"tex2jax": {"inlineMath": [["\\(", "\\)"]], "displayMath": [["\\[", "\\]"]]}}

# The Python library, from its docstrings.
autodoc_member_order = "bysource"
autodoc_typehints = "none"
default_role = "code"

# Tutorials, as scripts that sphinx-gallery executes (tutorial_scripts.py). Without them their Markdown is shown.
TUTORIALS = os.environ.get("LICHTENBERG_TUTORIALS", "")
if TUTORIALS:
    import tutorial_scripts

    extensions.append("sphinx_gallery.gen_gallery")
    sphinx_gallery_conf = {
        "examples_dirs": TUTORIALS,
        "gallery_dirs": "tutorials",
        "filename_pattern": "",
        "within_subsection_order": tutorial_scripts.Order,
        "image_scrapers": (tutorial_scripts.NewPictures(), "matplotlib"),
        "abort_on_example_error": False,
        "download_all_examples": False,
        "show_signature": False,
        "capture_repr": (),
        "show_memory": False,
    }

# The C++ library, if Doxygen has written its XML.
DOXYGEN_XML = os.environ.get("LICHTENBERG_DOXYGEN_XML", "")
if DOXYGEN_XML:
    extensions.append("breathe")
    breathe_projects = {project: DOXYGEN_XML}
    breathe_default_project = project
    cpp_id_attributes = ["LICHTENBERG_HOST_DEVICE"]
else:
    exclude_patterns.append("reference/cpp")


# Pages of the reference that only the site has (reference.py), and their subjects.
GENERATED = {
    "reference/scene/index": "each table and key of a scene",
    "reference/commands/index": "each command with its options and an example",
    "reference/python": "the Python package, from its docstrings",
    "reference/cpp/index": "the C++ library, from its docstrings",
}


def linked_pages(text, folder):
    """Returns the names of the pages of the site that a page in this folder links to, in their order."""
    targets = re.findall(r"\]\(([^)#\s]+)\.md(?:#[^)]*)?\)", text)
    names = [posixpath.normpath(posixpath.join(folder, target)) for target in targets]
    return list(dict.fromkeys(names))


def toctree(names):
    entries = "\n".join(f"/{name}" for name in names)
    return f"\n\n```{{toctree}}\n:hidden:\n\n{entries}\n```\n"


def generated_pages(app):
    """Returns the table of the pages that only the site has, in Markdown."""
    pages = [(name, subject) for name, subject in GENERATED.items() if name in app.env.found_docs]
    rows = "\n".join(f"| {subject} | [](/{name}.md) |" for name, subject in pages)
    return f"\n\n## Generated reference\n\n| subject | page |\n|---|---|\n{rows}\n"


def contents(app):
    """Returns the entries of the table of contents of each index page: the pages that it links to and no earlier index
    page has. The first index page also has all remaining pages."""
    source = Path(app.srcdir)
    found = sorted(app.env.found_docs)
    indexes = [name for name in found if posixpath.basename(name) == "index" and (source / f"{name}.md").exists()]
    indexes.sort(key=lambda name: (name.count("/"), name))
    taken, entries = {"index", *(name for name in found if TUTORIALS and re.match("tutorials/(?!index)", name))}, {}
    for name in indexes[1:]:
        links = linked_pages((source / f"{name}.md").read_text(), posixpath.dirname(name))
        own = [link for link in links if link.startswith(posixpath.dirname(name) + "/") and link != name]
        entries[name] = [link for link in own if link in found and link not in taken]
        taken.update(entries[name])
    listed = [*linked_pages((source / "index.md").read_text(), ""), *GENERATED]
    first = [link for link in listed if link in found and link not in taken]
    entries["index"] = first + [name for name in found if name not in taken and name not in first]
    return entries


def tutorial_page(link):
    """Returns the link to a page of sphinx-gallery instead of the Markdown of a tutorial."""
    folder, _, name = link[1].rpartition("/")
    return f"{folder}/{name.replace('-', '_')}.rst"


def add_contents(app, name, source):
    """Appends the table of contents to an index page, so that the files stay plain Markdown."""
    if TUTORIALS and (Path(app.srcdir) / f"{name}.md").exists():
        source[0] = re.sub(r"(\]\([^)\s]*tutorials/[\w-]+)\.md", tutorial_page, source[0])
    if posixpath.basename(name) == "index" and (Path(app.srcdir) / f"{name}.md").exists():
        names = contents(app).get(name, [])
        source[0] += generated_pages(app) if name == "index" else ""
        source[0] += toctree(names) if names else ""


def resolve_outside(_app, _environment, node, content):
    """Shows a link to a file outside of the site as its text."""
    target = node.get("reftarget", "")
    outside = target.startswith("../") or Path(target).suffix in (".toml", ".hpp", ".cpp", ".py", ".json", ".bib", ".cff")
    return nodes.literal(text=content.astext()) if outside else None


def format_parameters(_app, _kind, _name, _object, _options, lines):
    """Makes a list of the lines "NAME: meaning" of a docstring. An indented line continues the line before."""
    formatted = []
    for line in lines:
        is_item = bool(re.match(r"\w+: ", line))
        after = formatted[-1] if formatted else ""
        if line.startswith(" ") and after:
            formatted[-1] += f" {line.strip()}"
            continue
        if after and line and is_item != after.startswith("- "):
            formatted.append("")
        formatted.append(re.sub(r"(\w+): ", r"- `\1`: ", line, count=1) if is_item else line)
    lines[:] = formatted


def setup(app):
    app.connect("autodoc-process-docstring", format_parameters)
    app.connect("source-read", add_contents)
    app.connect("missing-reference", resolve_outside)
