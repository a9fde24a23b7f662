"""Configuration of the Sphinx documentation: make docs."""

import hashlib
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "docs" / "_ext")]

from percuss._version import __version__  # noqa: E402

project = "percuss"
author = "The percuss developers"
copyright = "2026, The percuss developers"
version = release = __version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx-mathjax-offline",  # formulas are there without a network
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "reference",
]
source_suffix = {".md": "myst-nb", ".rst": "restructuredtext"}
exclude_patterns = ["gallery", "auto_gallery/*.ipynb"]  # auto_gallery/*.rst are made from gallery/*.py

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Pages with code cells run in a kernel of this interpreter, which knows `!percuss …` by docs/_ext/cells.py and nothing
# of the user's IPython. What ran is kept until the page or the package changes.
SOURCES = sorted(path for path in (ROOT / "src").rglob("*") if path.suffix in (".py", ".toml"))
DIGEST = hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()[:16]
PROFILE = ROOT / "build" / "ipython" / "profile_default"
PROFILE.mkdir(parents=True, exist_ok=True)
(PROFILE / "ipython_kernel_config.py").write_text(
    'get_config().InteractiveShellApp.extensions = ["cells"]\nget_config().Application.log_level = "ERROR"\n'
)
os.environ["IPYTHONDIR"] = str(PROFILE.parent)
os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT / "docs" / "_ext"), os.environ.get("PYTHONPATH", "")])
os.environ["MATPLOTLIBRC"] = str(ROOT / "docs" / "matplotlibrc")
nb_execution_mode = "cache"
nb_execution_cache_path = str(ROOT / "build" / "notebooks" / DIGEST)
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_execution_timeout = 600  # s for a cell; the first simulation compiles the kernels
nb_merge_streams = True

# The gallery draws a script again when it or the package has changed.
GALLERY_DIGEST = ROOT / "build" / "gallery.digest"
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "within_subsection_order": "FileNameSortKey",
    "run_stale_examples": not GALLERY_DIGEST.is_file() or GALLERY_DIGEST.read_text() != DIGEST,
    "abort_on_example_error": True,
    "reset_modules": ("matplotlib", "cells.reset_style"),
    "image_srcset": ["2x"],
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
}

copybutton_selector = "div:not(.no-copybutton) > div.highlight > pre"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_google_docstring = False
napoleon_numpy_docstring = True
napoleon_use_rtype = False

html_theme = "pydata_sphinx_theme"
html_title = f"percuss {release}"
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
}
html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["percuss.css"]


def escape_bars(_app, _what, _name, _obj, _options, lines):
    """Let |x| in a docstring be a modulus, where reStructuredText would look for a substitution."""
    for i, line in enumerate(lines):
        if "|" in line and "`" not in line and not line.lstrip().startswith((">>>", "...")):
            lines[i] = line.replace("|", "\\|")


def note_digest(_app, error):
    """Remember what the gallery was drawn with."""
    if error is None:
        GALLERY_DIGEST.write_text(DIGEST)


def setup(app):
    app.connect("build-finished", note_digest)
    app.connect("autodoc-process-docstring", escape_bars)
