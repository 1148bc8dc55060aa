"""How Sphinx makes the site: nothing of it is loaded from another host, and it needs no server.

`make site` builds it and adds the pages that are made from the code (deltactl/reference/site.py).
"""

from importlib.metadata import version as installed

project = "deltactl"
author = copyright = "The deltactl authors"
version = release = installed("deltactl")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_heading_anchors = 4
exclude_patterns = ["*.ipynb", "notebooks/*.ipynb"]
autodoc_typehints = "none"  # the signature of a class of data repeats what its attributes say
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
napoleon_google_docstring = False
html_theme = "furo"
html_title = f"deltactl {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_show_search_summary = False  # it fetches pages, which a browser refuses for files
default_role = "code"
