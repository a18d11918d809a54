"""How the site is built: `make docs`. Nothing is fetched, and the pages fetch nothing."""

from __future__ import annotations

import sys
from pathlib import Path

import stiffkit

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "stiffkit"
author = "the authors of stiffkit"
copyright = author
version = release = stiffkit.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "rooms",
    "sphinx.ext.napoleon",
    "markdown",
    "mathml",
    "commands",
    "file_keys",
]
exclude_patterns = ["_ext", "_build", "**/.ipynb_checkpoints"]
suppress_warnings = ["misc.highlighting_failure"]

# Pages are plain Markdown, as code hosts show it; anchors are those that they give headings.
myst_heading_anchors = 4
myst_fence_as_directive = ["math"]

# Notebooks are stored without outputs and run here, so what the site shows is what they print.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_execution_in_temp = True
nb_merge_streams = True
# Would be scripts from a content network.
nb_ipywidgets_js: dict[str, dict[str, str]] = {}

default_role = "py:obj"
smartquotes = False
autodoc_default_options = {"members": True, "undoc-members": True, "member-order": "bysource"}
autodoc_class_signature = "separated"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("Array", "Mask", "Indices", "Integers", "Progress")}
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 80
python_use_unqualified_type_names = True
add_module_names = False
# Each page lists its names itself; in the tables of contents they would be thousands.
toc_object_entries = False

html_theme = "furo"
html_title = f"stiffkit {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False
html_math_renderer = "mathml"
