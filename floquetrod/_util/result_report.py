"""Reports of results: a headline, lines with labels and a table, for the terminal, a notebook or a file."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

from floquetrod._util.interchange import by_keys

WIDTH = 8
"""Width of the labels."""


class Table(NamedTuple):
    """Columns, each with its title and its alignment and least width as in ``">10"``, and rows of their texts."""

    columns: Sequence[tuple[str, str]]
    rows: Sequence[Sequence[str]]
    rest: str = ""  # a line about the rows left out

    def __str__(self) -> str:
        """Return the lines, the titles first."""
        titles, layout = zip(*self.columns, strict=True)
        rows = (titles, *self.rows) if any(titles) else self.rows
        widest = [max(map(len, column)) for column in zip(*rows, strict=True)]
        wide = [f"{each[:1]}{max(int(each[1:] or 0), width)}" for each, width in zip(layout, widest, strict=True)]
        lines = ["  ".join(map(format, row, wide)).rstrip() for row in rows]
        return "\n".join([*lines, *filter(None, [self.rest])])

    def html(self) -> str:
        """Return the table for a notebook."""
        from html import escape

        head = "".join(heading(title) for title, _ in self.columns)
        rows = (f"<tr>{''.join(f'<td>{escape(cell.strip())}</td>' for cell in row)}</tr>" for row in self.rows)
        return f"<table><tr>{head}</tr>{''.join(rows)}</table>{escape(self.rest.strip())}"


def heading(text: str) -> str:
    """Return a heading of a table in HTML; without a text a plain cell, which is not read out as a heading."""
    from html import escape

    return f"<th>{escape(text)}</th>" if text.strip() else "<td></td>"


@dataclass(frozen=True)
class Report:
    """The report of a result.

    Attributes
    ----------
    headline : str
        The answer.
    lines : sequence of (str, str)
        Labels and texts; a line without a label continues the one before it.
    table : Table or None
    rest : Report or None
        A report to be read after it.
    assumptions : sequence of str
        What the answer rests on; in the text and the table only `with_assumptions`, in a notebook folded away.
    """

    headline: str
    lines: Sequence[tuple[str, str]] = ()
    table: Table | None = None
    rest: Report | None = None
    assumptions: Sequence[str] = ()

    def with_lines(self, lines: Sequence[tuple[str, str]], before: str | None = None) -> Report:
        """Return the report with more lines, ``before`` the one with this label or after all of them."""
        labels = [label for label, _ in self.lines]
        index = labels.index(before) if before in labels else len(labels)
        return replace(self, lines=[*self.lines[:index], *lines, *self.lines[index:]])

    def with_assumptions(self) -> Report:
        """Return the report with a line for each assumption."""
        assumed = [("" if i else "assumed", text) for i, text in enumerate(self.assumptions)]
        rest = None if self.rest is None else self.rest.with_assumptions()
        return replace(self, lines=[*self.lines, *assumed], rest=rest, assumptions=())

    def __str__(self) -> str:
        """Return the report as text."""
        lines = "\n".join(f"{label:<{WIDTH}}  {text}" for label, text in self.lines)
        table = "" if self.table is None else str(self.table)
        head = "\n\n".join(filter(None, [self.headline, lines]))
        rest = "" if self.rest is None else f"\n\n{self.rest}"
        return ("\n\n" if lines else "\n").join(filter(None, [head, table])) + rest

    def _repr_html_(self) -> str:
        """Return the report as a small table for a notebook."""
        from html import escape

        rows = "".join(f"<tr>{heading(label)}<td>{escape(text)}</td></tr>" for label, text in self.lines)
        fragments = [
            f"<p><strong>{escape(self.headline)}</strong></p>" if self.headline else "",
            f"<table>{rows}</table>" if rows else "",
        ]
        fragments += [] if self.table is None else [self.table.html()]
        if self.assumptions:
            items = "".join(f"<li>{escape(text)}</li>" for text in self.assumptions)
            fragments.append(f"<details><summary>assumptions</summary><ul>{items}</ul></details>")
        return "".join(fragments) + ("" if self.rest is None else self.rest._repr_html_())


class ShownInNotebook:
    """A value that a notebook shows as a report."""

    @abstractmethod
    def _at_hand(self) -> Report:
        """Return the report that a notebook shows unasked, which must not take long."""

    def _repr_html_(self) -> str:
        """Return the report as a small table for a notebook."""
        return self._at_hand()._repr_html_()


class Reported(ShownInNotebook):
    """A result with a `report` in lines and tables, which notebooks show, and with ``as_dict()`` in numbers."""

    _keys: ClassVar[str]
    """Keys of `as_dict`, as for `floquetrod._util.interchange.by_keys`, where it has attributes alone."""

    @abstractmethod
    def report(self) -> Report:
        """Return the result in words."""

    def as_dict(self) -> dict[str, Any]:
        """Return the result as numbers for JSON, units in the keys; None for infinite and unknown numbers.

        Returns
        -------
        dict of str
            Numbers, texts and lists by name.
        """
        return by_keys(self, self._keys)

    def _at_hand(self) -> Report:
        """Return the report that a notebook shows unasked, which must not take long."""
        return self.report()


class Printed(Reported):
    """A result whose report is printed, with its headline as repr."""

    def __str__(self) -> str:
        return str(self.report())

    def __repr__(self) -> str:
        """Return the headline in brackets."""
        return f"<{self.report().headline}>"


def number(value: Any) -> float | None:
    """Return ``value``, or None where JSON has no number for it: infinite means never, or not within reach."""
    return value if math.isfinite(value) else None
