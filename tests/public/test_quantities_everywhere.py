"""Every public callable takes physical arguments with a unit, as texts and as quantities, and refuses wrong ones."""

from __future__ import annotations

import dataclasses
import functools
import importlib.util
import re
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import units
from floquetrod.units import units_of
from tests.fuzz.calls import Call, table
from tests.inside import GIVEN, LOAD, QUANTITIES
from tests.units.test_quantities import Measured

HAS_PINT = importlib.util.find_spec("pint") is not None

PHYSICAL = {
    **{name: parameter.kind for name, parameter in GIVEN.items() if parameter.kind},
    **{name: LOAD[name].kind for name in QUANTITIES},
    "growth_tolerance": "rate",
    "axial_damping": "rate",
    "far_force": "force",
    "push": "force",
    "stripper": "force",
    "wellhead_pressure": "pressure",
    "pressure_inside": "pressure",
    "tangential": "pressure",
    "radial": "pressure",
    "bottom": "length",
    "to": "length",
    "above_end": "length",
    "most": "length",
    "start": "length",
    "end": "length",
    "azimuth": "angle",
    "angle": "angle",
    "duration": "time",
    "time_step": "time",
    "seconds": "time",
    "t": "time",
    "time": "time",
    "force": "force",
    "speed": "speed",
    "speeds": "speed",
    "kick": "speed",
    "feed_speed": "speed",
    "mass": "mass",
    "natural_curvature": "curvature",
    "impact_speed": "speed",
    "distance": "length",
}
"""Kinds of physical arguments by name, of callables about rods, wells, tools and cutters."""

SPECIAL = {
    ("stability_map", "damping"): "rate",
    ("Rod.ranges", "bounds"): "force",
    ("Rod.ranges (amplitude)", "bounds"): "force",
    ("Rod.ranges (frequency)", "bounds"): "frequency",
    **{(f"Milling.{name}", "speed"): "frequency" for name in ("system", "stability", "lobes", "critical_depth")},
}
"""Those of some callables alone."""

OF_NAMES = ("over", "parameters", "rod")
"""Arguments that map names to values."""

ABOUT = (
    *(
        "AxialLoad",
        "AxialWave",
        "ForceRecord",
        "LockUp",
        "Milling",
        "Perturbation",
        "Rod",
        "RodStability",
        "Section",
        "Simulation",
    ),
    *("SimulationProblem", "StabilityIntervals", "ToolMode", "VibrationTool", "WellPath", "ensemble"),
    *("probability_of_instability", "probability_of_reach", "simulate", "stability_map", "simulation"),
)
"""Callables, or classes of methods, with physical arguments; all others are without units."""

WORDS = {
    "AxialLoad.hertz",
    "AxialWave.hertz",
}  # whose numbers are in Hz: tests/units/test_quantities.py
COLUMNS = {"ForceRecord.from_csv", "WellPath.from_csv"}  # whose arguments name columns

ARRAYS = {"Rod.is_stable", "Rod.verdicts", "Rod.growth_rate"}
ARRAYS |= {"Rod.critical_kick (arrays)"}
ARRAYS |= {
    "WellPath.position",
    "WellPath.curvature",
    "WellPath.inclination_at",
    "WellPath.azimuth_at",
    "ForceRecord.force",
}
ARRAYS |= {"Milling.cutting"}
"""Callables whose physical arguments may be arrays."""

SLOW = {"Rod.follow", "Rod.certify", "Rod.largest_safe_box", "probability_of_reach", "simulate"}
SLOW |= {"RodStability.margin", "RodStability.margin (coupled)", "RodStability.margins", "SimulationProblem.replace"}
SLOW |= {f"Rod.{name} (coupled)" for name in ("critical", "stability", "modes_needed")}
SLOW |= {"Rod.critical (coupled, amplitude)", "Rod.ranges (frequency)", "Rod.ranges (amplitude)"}
SLOW |= {"Rod.surface_weights", "probability_of_instability"}


def kind_of(name: str, argument: str) -> str | None:
    """Return the kind of a physical argument, None for one without unit."""
    plain = name.removesuffix(" (coupled)").removesuffix(" (arrays)")
    if (plain, argument) in SPECIAL:
        return SPECIAL[plain, argument]
    about = plain.partition(" ")[0].partition(".")[0]
    return PHYSICAL.get(argument) if about in ABOUT and plain not in COLUMNS else None


def changed(value: Any, change: Callable[[float], Any], *, last: bool = True) -> Any:
    """Return a value in which each number has been changed; a number of points at the end of a range stays."""
    if isinstance(value, bool | str) or value is None:
        return value
    if isinstance(value, int | float | np.number):
        return change(float(value))
    if isinstance(value, np.ndarray):
        return change(value)  # type: ignore[arg-type]
    if isinstance(value, Mapping):
        return {key: changed(each, change) for key, each in value.items()}
    if isinstance(value, list | tuple):
        if hasattr(value, "_fields") or type(value) not in (list, tuple):
            return value  # a result, such as a margin
        counted = isinstance(value, tuple) and len(value) == 3 and isinstance(value[2], int)
        return type(value)(
            each if counted and i == 2 and not last else changed(each, change) for i, each in enumerate(value)
        )
    return value


def si_name(kind: str) -> str:
    """Return the name of the SI unit of a kind as texts and pint have it."""
    return re.sub(r"(?<=[a-z])(\d)$", r"^\1", next(iter(units_of(kind))))


def given(name: str, call: Call, change: Callable[[Any, str], Any]) -> dict[str, Any] | None:
    """Return the arguments of a call with its physical numbers changed, None where it has none."""
    arguments = dict(call.arguments)
    for argument, value in call.arguments.items():
        if argument in OF_NAMES and isinstance(value, Mapping) and name.partition(".")[0] in ABOUT:
            arguments[argument] = {
                key: changed(each, lambda x, key=key: change(x, si_name(PHYSICAL[key]))) if key in PHYSICAL else each
                for key, each in value.items()
            }
        elif argument == "speeds" and isinstance(value, tuple):
            arguments[argument] = tuple((mode, change(speed, "m/s")) for mode, speed in value)
        elif (kind := kind_of(name, argument)) is not None:
            arguments[argument] = changed(value, lambda x, kind=kind: change(x, si_name(kind)), last=False)
    return None if repr(arguments) == repr(call.arguments) else arguments


def content(result: Any) -> Any:
    """Return what of a result must be the same."""
    if isinstance(result, fr.Simulation):
        return result.positions, result.time
    if isinstance(result, fr.ensembles.Runs):
        return {name: np.asarray(value) for name, (_, value, *_) in result.variables.items()}
    if dataclasses.is_dataclass(result) and hasattr(result, "as_dict"):
        return result.as_dict()  # numbers in SI; sentences are in the units of the question
    return result


def assert_same(one: Any, other: Any) -> None:
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other)
    elif isinstance(one, Mapping):
        assert one.keys() == other.keys()
        for key in one:
            assert_same(one[key], other[key])
    elif isinstance(one, tuple | list):
        assert len(one) == len(other)
        for pair in zip(one, other, strict=True):
            assert_same(*pair)
    else:
        assert repr(one) == repr(other)


def as_text(value: Any, unit: str) -> Any:
    if isinstance(value, np.ndarray):
        return [as_text(each, unit) for each in value.tolist()]
    return f"{value!r} {unit}"


@functools.cache
def quantities() -> list[Any]:
    """Return what makes a quantity of a number and a unit: our own, and pint's where it is installed."""
    if not HAS_PINT:
        return [Measured]
    import pint

    return [Measured, pint.UnitRegistry().Quantity]


@functools.cache
def with_units() -> list[str]:
    """Return the names of the calls with physical numbers; not at import, since the table runs most of the package."""
    return [name for name, call in table().items() if given(name, call, lambda x, unit: (x, unit)) is not None]


def test_the_table_knows_every_physical_argument() -> None:
    """A callable about rods whose numbers no unit is known of must be without them, by this list."""
    pure = {
        *("mean_at", "waveform", "noise", "harmonics", "teeth", "immersion", "damping_ratio", "seed", "mode", "modes"),
        *("highest", "segments", "frames", "friction", "poisson_ratio", "indentation", "contact_damping", "workers"),
        *("max_boxes", "steps", "longest", "accuracy", "samples", "confidence", "factor", "size", "noises", "x", "y"),
        "stiffness",
        "yield_share",
        *("sections", "bores"),
    }
    assert set(with_units()) >= SLOW | ARRAYS
    for name, call in table().items():
        plain = name.partition(" ")[0]
        if plain.partition(".")[0] not in ABOUT or plain in COLUMNS | WORDS:
            continue
        for argument, value in call.arguments.items():
            is_number = isinstance(value, int | float | np.ndarray | list | tuple) and not isinstance(value, bool)
            if is_number and argument not in pure and kind_of(name, argument) is None:
                assert all(isinstance(each, str) for each in np.ravel(value)), f"{name}: {argument}"  # type: ignore[arg-type]


@pytest.mark.parametrize("part", range(10))
def test_texts_and_quantities_mean_the_same_as_numbers_in_si(part: int) -> None:
    for name in [name for name in with_units() if name not in SLOW][part::10]:
        require_the_same_with_units(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SLOW))
def test_texts_and_quantities_mean_the_same_where_answers_take_long(name: str) -> None:
    require_the_same_with_units(name)


def require_the_same_with_units(name: str) -> None:
    """Require that a call answers the same with texts and quantities as with its numbers."""
    call = table()[name]
    if name in WORDS:
        call = Call(call.function, call.arguments | {"frequency": "24Hz"})
    if name.startswith(("Milling", "ToolMode")):  # whose texts become numbers first
        read = {key: kind for key in call.arguments if (kind := kind_of(name, key))}
        call = Call(call.function, {key: in_si(value, read.get(key)) for key, value in call.arguments.items()})
    expected = content(call.function(**call.arguments))
    for change in (as_text, *quantities()):
        arguments = given(name, call, change)
        assert arguments is not None
        assert_same(expected, content(call.function(**arguments)))


def in_si(value: Any, kind: str | None) -> Any:
    if kind is None:
        return value
    if isinstance(value, tuple):
        return (*(units.si(each, "it", kind) for each in value[:2]), *value[2:])
    return units.si(value, "it", kind)


@pytest.mark.parametrize("name", sorted(ARRAYS))
def test_arrays_of_quantities_mean_the_same_as_arrays(name: str) -> None:
    call = table()[name]
    scaled = np.array([1.0, 0.9, 0.7])
    numbers = given(name, call, lambda x, unit: x if unit == "1/s" else x * scaled)  # a tolerance is one number
    assert numbers is not None
    numbers = {key: value for key, value in numbers.items() if value is not None}
    expected = np.asarray(call.function(**numbers))
    assert 3 in expected.shape

    def each(convert: Callable[[float, str], Any], collect: Callable[[list[Any]], Any]) -> Callable[[Any, str], Any]:
        return lambda x, unit: (
            x if unit == "1/s" else collect([convert(value, unit) for value in (x * scaled).tolist()])
        )

    changes = [each(as_text, list), each(as_text, tuple), each(as_text, np.array), each(as_text, objects)]
    for quantity in quantities():
        changes += [each(quantity, list), each(quantity, objects)]
        changes.append(lambda x, unit, quantity=quantity: x if unit == "1/s" else quantity(x * scaled, unit))
    for change in changes:
        arguments = given(name, call, change)
        assert arguments is not None
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # pint warns where numpy strips a unit
            found = call.function(**{key: value for key, value in arguments.items() if value is not None})
        np.testing.assert_array_equal(np.asarray(found), expected)


def objects(values: list[Any]) -> Any:
    array = np.empty(len(values), dtype=object)
    array[:] = values
    return array


def wrong(name: str, argument: str) -> list[Any]:
    """Return quantities of a wrong kind for an argument: of light, and of force or mass."""
    other = "kg" if kind_of(name, argument) == "force" or argument in OF_NAMES else "N"
    return [*(lambda x, q=q, unit=unit: q(x, unit) for q in quantities() for unit in ("candela", other))]


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_a_quantity_of_a_wrong_dimension_is_refused_by_every_argument(part: int) -> None:
    """Of every public callable, and every argument with a number in it, physical or not."""
    numeric = [
        (name, argument)
        for name, call in table().items()
        for argument, value in call.arguments.items()
        if name not in COLUMNS
        and changed(value, lambda x: None) is not value
        and repr(changed(value, lambda x: None)) != repr(value)
    ]
    for name, argument in numeric[part::10]:
        call = table()[name]
        value = call.arguments[argument]
        names = [argument, *(value if isinstance(value, Mapping) else ())]
        for change in wrong(name, argument):
            given = {**call.arguments, argument: changed(value, change)}
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                with pytest.raises((ValueError, TypeError), match="|".join(map(re.escape, map(str, names)))):
                    call.function(**given)
