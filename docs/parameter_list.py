"""A directive that lists the parameters of a problem in a table, from their records: ``.. parameters:: rod``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sphinx.application

    from floquetrod.parameter import Parameter

COLUMNS = "name", "symbol", "unit", "default", "limits", "option", "known to", "without effect on"


def row(parameter: Parameter) -> list[str]:
    """Return the cells of a parameter, in the order of the columns."""
    from floquetrod.parameter import NAMES, REQUIRED

    usual = parameter.default
    default = "" if usual is REQUIRED else f"``{usual:.6g}``" if isinstance(usual, float) else f"``{usual!r}``"
    limits = parameter.range_in_words or (f"{parameter.least:.6g} to {parameter.largest:.6g}" if parameter.kind else "")
    option = parameter.option and f"``--{(parameter.option.name or parameter.name).replace('_', '-')}``"
    known, none = (
        "all" if len(subsystems) == len(NAMES) else ", ".join(name for name in NAMES if name in subsystems)
        for subsystems in (parameter.known_to, parameter.without_effect_on)
    )
    unit = parameter.unit if parameter.kind else ""
    return [f"``{parameter.name}``", parameter.symbol, unit, default, limits, option or "", known, none]


def table(kind: str) -> list[str]:
    """Return the lines of the table of the parameters of a "rod", a "load" or a "tool"."""
    from floquetrod.rod.loads.load import LOAD
    from floquetrod.rod.loads.tool import TOOL
    from floquetrod.rod.model.parameters import ROD

    parameters = {"rod": ROD, "load": LOAD, "tool": TOOL}[kind]
    lines = [".. list-table::", "   :header-rows: 1", ""]
    for cells in (COLUMNS, *map(row, parameters.values())):
        lines += [f"   {'* -' if not i else '  -'} {cell}".rstrip() for i, cell in enumerate(cells)]
    return lines


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Register the directive; what it is made of comes with Sphinx, which the table above does without."""
    from docutils import nodes
    from docutils.parsers.rst import Directive
    from docutils.statemachine import StringList

    class Parameters(Directive):
        """The parameters of the problem that is its argument."""

        required_arguments = 1

        def run(self) -> list[nodes.Node]:
            """Return the table."""
            node = nodes.section()
            node.document = self.state.document
            self.state.nested_parse(StringList(table(self.arguments[0]), source=__file__), self.content_offset, node)
            return node.children

    app.add_directive("parameters", Parameters)
    return {"parallel_read_safe": True}
