"""The warning of input that is allowed but probably a mistake."""

from __future__ import annotations

from floquetrod._util.arguments import Mention

SILENCE = Mention("", ' (silence with warnings.simplefilter("ignore", fr.PlausibilityWarning))')
"""The end of every warning; a terminal leaves it out."""


class PlausibilityWarning(UserWarning):
    """A number that is allowed, but is probably in another unit or of another kind than assumed."""


def is_typed(value: float) -> bool:
    """Return whether a number has four digits or fewer, as people type them."""
    return value == float(f"{value:.4g}")
