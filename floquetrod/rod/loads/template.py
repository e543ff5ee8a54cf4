"""A load as the template of others: mean, amplitude and frequency given by name take the place of its own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.rod.loads.load import QUANTITIES, AnyLoad, Load, Loads, LoadSource, Quantity, kind

Numbers = dict[Quantity, Any]
"""Mean, amplitude and frequency by name, each a number or an array, with or without a unit."""


def replaced(
    load: AnyLoad | None, mean: Any, amplitude: Any, frequency: Any, searched: Quantity | None = None
) -> tuple[Load, Numbers]:
    """Return the template, a sine where no load is given, and its quantities, each as given or else the load's own.

    Of ``searched``, the quantity that a search varies, no value may be given.  TypeError for a quantity that neither
    the load nor the caller gives, and ValueError for one that is searched and given.
    """
    template, given = kind(load), {"mean": mean, "amplitude": amplitude, "frequency": frequency}
    if searched is not None and given[searched] is not None:
        raise validate.wrong_value(searched, f"is the quantity that is searched; leave {searched} out")
    numbers: Numbers = {}
    for name in QUANTITIES:
        if name == searched:
            continue
        if load is None and given[name] is None:
            raise validate.wrong_type(
                name,
                "must be given where no load is, whose own it could be: give fr.AxialLoad(mean, amplitude, "
                "frequency), say, or each by name",
            )
        numbers[name] = getattr(template, name) if given[name] is None else given[name]
    return template, numbers


class ReplacedLoads(NamedTuple):
    """Arrays of loads, and their template; ``single`` is the one load where they have the shape (), else None."""

    template: Load
    loads: Loads
    single: AnyLoad | None


def replaced_loads(load: AnyLoad | None, mean: Any, amplitude: Any, frequency: Any) -> ReplacedLoads:
    """Return the loads that a template and quantities, which broadcast, describe; a record alone stays a record."""
    template, numbers = replaced(load, mean, amplitude, frequency)
    loads = Loads.of(**numbers)
    if load is not None and mean is None and amplitude is None and frequency is None:
        return ReplacedLoads(template, loads, load)
    return ReplacedLoads(template, loads, None if loads.shape else loads.as_single(template))


def require_one_load(name: str, value: Any) -> None:
    """Raise ValueError for an argument that is given for arrays of loads and is about one load."""
    if value is not None:
        raise validate.wrong_value(name, f"is for one load, got arrays of them; leave {name} out")


def require_no_record(load: AnyLoad | None, given: Iterable[Any]) -> None:
    """Raise ValueError for a verdict on a record itself, none of whose quantities is replaced, without its noise."""
    if isinstance(load, LoadSource) and all(value is None for value in given):
        raise validate.wrong_value(
            "load",
            "is a record, whose noise Rod.stability counts and a verdict over arrays does not; give its fitted load, "
            "record.load, or ask Rod.stability",
        )
