"""A directive that lists every method of the registry for a kind of problem: ``.. methods:: systems``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sphinx.application


def described(kind: str) -> list[str]:
    """Return lines that document the methods for "equations", "systems" or "delays"."""
    from floquetrod.floquet.problems import KINDS
    from floquetrod.floquet.registry import methods_for

    (prefix,) = (row.prefix for row in KINDS if row.field == kind)
    folder = "floquetrod.methods." if kind == "equations" else "floquetrod.floquet.methods."
    names = [method.name for method in methods_for(kind)]
    return [f".. autofunction:: {folder}{name if kind == 'equations' else f'{prefix}{name}.{name}'}" for name in names]


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Register the directive; what it is made of comes with Sphinx, which the list above does without."""
    from docutils import nodes
    from docutils.parsers.rst import Directive
    from docutils.statemachine import StringList

    class Methods(Directive):
        """The methods of the registry for the kind of problem that is its argument."""

        required_arguments = 1

        def run(self) -> list[nodes.Node]:
            """Return the documentation of each."""
            node = nodes.section()
            node.document = self.state.document
            lines = StringList(described(self.arguments[0]), source=__file__)
            self.state.nested_parse(lines, self.content_offset, node)
            return node.children

    app.add_directive("methods", Methods)
    return {"parallel_read_safe": True}
