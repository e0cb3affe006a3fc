"""How Sphinx builds these pages: ``make docs``."""

import bpns

project = "BPNS"
author = "The BPNS developers"
copyright = "2026, the BPNS developers"
version = release = bpns.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = "BPNS"
exclude_patterns = ["_build"]
myst_heading_anchors = 3
autodoc_typehints = "none"
autodoc_member_order = "bysource"
nitpicky = False
