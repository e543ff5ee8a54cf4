"""How the site is built: every page executed, warnings made errors by `make docs`, nothing fetched when it is read."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path

import sphinx
from pygments.formatters import HtmlFormatter
from pygments.lexers.special import TextLexer
from pygments.token import Name, Punctuation
from sphinx.highlighting import PygmentsBridge

import floquetrod

sys.path.append(str(Path(__file__).parent))  # where Sphinx finds gallery_order and our extensions

import executed

HERE = Path(__file__).parent
project = "floquetrod"
author = "The floquetrod developers"
project_copyright = author
smartquotes = False  # the primes of A'' are no quotation marks
version = release = floquetrod.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
    "command_pages",
    "executed",
    "formulas",
    "kernels",
    "links",
    "method_list",
    "name_index",
    "parameter_list",
    "parameters",
    "search_excerpts",
    "source_pages",
]
exclude_patterns = ["_build", "gallery/*.ipynb", "pages", "paper"]  # for download, forges, a journal

# --- look -------------------------------------------------------------------------------------------------------------
# Furo: one column that fits a phone, light and dark, search on the spot, no fonts or scripts from elsewhere.
html_theme = "furo"
html_title = f"floquetrod {version}"
html_theme_options = {"footer_icons": [], "top_of_page_buttons": []}
html_copy_source = False
html_show_sourcelink = False
html_domain_indices = False  # a list of modules, which the reference is already
html_use_index = False  # a page of all names, which nothing links to: the search finds them


def mathjax() -> Path:
    """Return the one file that renders all mathematics (as SVG, so that it needs no fonts either)."""
    for file in metadata.files("sphinx-mathjax-offline") or ():
        if file.name == "tex-svg-full.js":
            return Path(str(file.locate()))
    raise FileNotFoundError("sphinx-mathjax-offline holds no tex-svg-full.js; install the docs extra: .[docs]")


html_static_path = [str(mathjax()), "copy.js", "custom.css", "search_excerpts.js", "names.js"]
html_search_scorer = str(HERE / "search_order.js")
html_css_files = ["custom.css"]
html_js_files = [("names.js", {"defer": "defer"}), ("copy.js", {"defer": "defer"})]
mathjax_path = "tex-svg-full.js"
mathjax3_config = {"svg": {"fontCache": "global"}, "options": {"enableMenu": False}}

# --- pages that execute -----------------------------------------------------------------------------------------------
myst_enable_extensions = ["dollarmath", "amsmath", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_cache_path = executed.cache()  # which has nothing that another package computed
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_in_temp = True
nb_merge_streams = True
nb_number_source_lines = False
nb_code_prompt_show = (
    "Show the computation"  # of cells tagged hide-input: derivations are folded, their results are not
)
nb_code_prompt_hide = "Hide the computation"

# --- reference --------------------------------------------------------------------------------------------------------
default_role = "py:obj"  # `Rod` in a docstring is a link where there is something to link to
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings name the types, in words
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

# --- gallery ----------------------------------------------------------------------------------------------------------
sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "examples"),
    "gallery_dirs": "gallery",
    "within_subsection_order": "gallery_order.GalleryOrder",
    "filename_pattern": r"\.py$",
    "run_stale_examples": executed.are_examples_stale(),  # an example unchanged is not a package unchanged
    "abort_on_example_error": True,
    "only_warn_on_example_error": False,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "matplotlib_animations": False,
    "image_scrapers": ("thumbnails.scraper",),
    "thumbnail_size": (600, 420),
}


class LightFormatter(HtmlFormatter):
    """Code in HTML without marks on what has no colour of its own, which halves it: pages stay small."""

    def _get_css_class(self, ttype: object) -> str:
        return "" if ttype in (Name, Punctuation) else super()._get_css_class(ttype)


PygmentsBridge.html_formatter = LightFormatter


def setup(app: sphinx.application.Sphinx) -> None:
    """Let the drawing of the layers be shown as it is."""
    app.add_lexer("layers", TextLexer)
