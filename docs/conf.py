"""How Sphinx builds the site from these pages: `make docs`."""

import os
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "tvclin"
author = "The tvclin authors"
copyright = "The tvclin authors"
exclude_patterns = ["_build"]
highlight_language = "none"  # what is Python says so; drawings and shells are plain
templates_path = ["templates"]
html_sidebars = {"**": ["all-pages.html"]}
html_static_path = ["static"]
html_css_files = ["site.css"]

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
]

# Math in the pages is written as GitHub reads it, and anchors are named as GitHub names them.
myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 4

nb_execution_mode = "off"  # notebooks are stored with their outputs: `make notebooks`

autosummary_generate = True
autosummary_imported_members = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
default_role = "autolink"
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "pydata_sphinx_theme"
html_title = "tvclin"
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_theme_options: dict[str, Any] = {
    "navbar_center": [],
    "secondary_sidebar_items": ["page-toc"],
    "show_prev_next": True,
    "show_toc_level": 2,
}

# Links into the pages of other packages need the network, which a build must not.
if os.environ.get("TVCLIN_DOCS_ONLINE"):
    extensions.append("sphinx.ext.intersphinx")
    intersphinx_mapping = {
        "python": ("https://docs.python.org/3", None),
        "numpy": ("https://numpy.org/doc/stable", None),
        "scipy": ("https://docs.scipy.org/doc/scipy", None),
        "control": ("https://python-control.readthedocs.io/en/stable", None),
    }


def setup(app: Any) -> None:
    """Have the pages that are made of other files written before Sphinx looks for pages."""
    import pages

    app.connect("config-inited", lambda *_: pages.write(HERE / "_generated"))
    app.connect("source-read", lambda _, name, text: pages.for_the_site(name, text))
