# SPDX-License-Identifier: Apache-2.0
"""The pages as a site with search: cmake --build --preset release --target docs.

The pages are read where they stand, and links, anchors and headings are those of a code host. The order and
the parts of the navigation are those of docs/README.md, docs/theory/README.md within its part."""
import pathlib
import re
import shutil

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

ROOT = pathlib.Path(__file__).resolve().parents[2]
CMAKE = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")

project = "sarblock"
author = "the sarblock authors"
release = re.search(r"project\(sarblock VERSION (\S+)", CMAKE).group(1)
root_doc = "README"
include_patterns = ["*.md", "docs/**.md", "datasets/**.md"]
extensions = ["myst_parser", *(["sphinx.ext.graphviz"] if shutil.which("dot") else [])]
graphviz_output_format = "svg"
myst_heading_anchors = 6
smartquotes = False
highlight_language = "none"
html_theme = "sphinx_rtd_theme"
html_title = f"sarblock {release}"
html_static_path = ["style.css"]
html_css_files = ["style.css"]
html_show_sphinx = False
html_show_sourcelink = False


def listed(page):
    """(title of the part, pages) of every part of an index page, in its order."""
    parts = re.split(r"^## +(?:\d+\. +)?", (ROOT / page).read_text(encoding="utf-8"), flags=re.M)
    folder = (ROOT / page).parent
    for part in parts:
        title = part.partition("\n")[0]
        found = re.findall(r"\]\(([\w./]+\.md)\)", part)
        yield title, [(folder / name).resolve().relative_to(ROOT).as_posix() for name in found]


def toctree(title, names, **options):
    lines = [f":{key.replace('_', '-')}: {value}" for key, value in options.items()]
    return "\n".join(["", "```{toctree}", ":hidden:", *([f":caption: {title}"] if title else []), *lines, "",
                      *(f"/{name.removesuffix('.md')}" for name in names), "```", ""])


def drawn(page):
    """The page with its diagrams (mermaid, arrows alone) for graphviz, where that is."""
    def graph(block):
        edges = re.findall(r"^ +(\w+) --> (\w+)$", block.group(1), flags=re.M)
        lines = [f"  {below} -> {above} [dir=back];" for above, below in edges]
        style = "  node [shape=box, fontname=\"sans-serif\", fontsize=11];"
        return "\n".join(["```{graphviz}", "digraph {", "  ranksep=0.3;", style, *lines, "}", "```"])

    return re.sub(r"```mermaid\nflowchart BT\n(.*?)```", graph, page, flags=re.S) if shutil.which("dot") else page


def add_navigation(app, name, source):
    source[0] = drawn(source[0])
    if name == "README":
        source[0] += toctree("", ["docs/README.md"])
        for title, names in list(listed("docs/README.md"))[1:]:
            source[0] += toctree(title, names, maxdepth=2)
    elif name == "docs/theory/README":
        source[0] += toctree("", [page for _, names in listed("docs/theory/README.md") for page in names
                                  if "theory" in page])
    elif name == "docs/studies/tradeoff":
        source[0] += toctree("", ["datasets/studies/tradeoff/tradeoff.md"])


def setup(app: Sphinx):
    app.add_lexer("csv", TextLexer)
    app.add_lexer("mermaid", TextLexer)  # a diagram on a code host, its source without graphviz
    app.connect("source-read", add_navigation)
