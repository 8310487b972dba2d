"""How the pages are built: `make docs`."""

import sys
from pathlib import Path

from sphinx.application import Sphinx

from geohue import __version__

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "geohue"
author = "the geohue developers"
release = version = __version__

extensions = [
    "mathml",
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
]
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"geohue {release}"
html_static_path = ["_static"]
html_css_files = ["geohue.css"]
html_copy_source = False
exclude_patterns = ["_build"]

myst_enable_extensions = ["dollarmath", "attrs_inline"]
myst_heading_anchors = 3

autosummary_generate = True
autosummary_ignore_module_all = False
autosummary_imported_members = True
templates_path = ["_templates"]
autodoc_typehints = "none"  # numpydoc's parameters have them
numpydoc_show_class_members = False

# Pictures are made from scenes that ship or are simulated.
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "examples",
    "filename_pattern": r"\.py$",
    "download_all_examples": False,
    "show_signature": False,
    "remove_config_comments": True,
    "min_reported_time": 1e9,
    "abort_on_example_error": True,
    "write_computation_times": False,
}
suppress_warnings = ["config.cache"]


def _measured(_app: Sphinx, docname: str, source: list[str]) -> None:
    """Show BENCHMARKS.md, which stands beside the README, among the pages."""
    if docname == "benchmarks":
        source[0] = (HERE.parent / "BENCHMARKS.md").read_text("utf-8").replace("](docs/", "](")
    up = "../" * docname.count("/")  # the studies are a folder further down
    source[0] = source[0].replace(f"]({up}../BENCHMARKS.md", f"]({up}benchmarks.md")


def setup(app: Sphinx) -> None:
    """Tell Sphinx of the page of figures."""
    app.connect("source-read", _measured)
