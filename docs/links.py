"""Links of docstrings: pages of the site, such as `theory/ranges`, and names of the package, however short.

help() shows both as they are written.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import sphinx.application

PAGE = re.compile(r"(?<!`)`((?:how_to|reference|start|theory)/\w+)`(?!`)")


def linked(text: str) -> str:
    """Return a line of a docstring with the names of pages as links, which Sphinx shows by their titles."""
    return PAGE.sub(r":doc:`/\1`", text)


def chosen(short: str, names: list[str]) -> str | None:
    """Return the documented name that a short one means: that of `floquetrod` itself, or the only one that ends so."""
    short = short.removeprefix("fr.")
    if f"floquetrod.{short}" in names:
        return f"floquetrod.{short}"
    ending = [name for name in names if name.endswith(f".{short}")]
    return ending[0] if len(ending) == 1 else None


def _linked(app: object, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    lines[:] = map(linked, lines)


def _named(app: sphinx.application.Sphinx, env: Any, node: Any, words: Any) -> Any:
    """Return a link for a name that Sphinx does not find: it looks in the module of the docstring only."""
    from sphinx.util.nodes import make_refnode

    is_type = node.get("reftype") == "class" and not node["reftarget"][0].isupper()  # "path" is no name, but a type
    if node.get("refdomain") != "py" or is_type:
        return None
    objects = env.domains.python_domain.objects
    name = chosen(node["reftarget"], list(objects))
    if name is None:
        return None
    entry = objects[name]
    return make_refnode(app.builder, node["refdoc"], entry.docname, entry.node_id, [words], name)


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Do so with what autodoc found, and with what Sphinx did not."""
    app.connect("autodoc-process-docstring", _linked)
    app.connect("missing-reference", _named)
    return {"parallel_read_safe": True}
