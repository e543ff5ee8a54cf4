"""A rod and a load as people write them in a terminal or in files: words and numbers with units."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from floquetrod import units
from floquetrod._util.arguments import Message, argument_of, error_in
from floquetrod._util.plausibility_warning import PlausibilityWarning
from floquetrod._util.suggest import short
from floquetrod._util.tables import require_file
from floquetrod.bare_numbers import Quantity as Written
from floquetrod.bare_numbers import bare_numbers
from floquetrod.rod.loads.load import LOAD, QUANTITIES, AxialWave, Load, Quantity, kind, noise_density
from floquetrod.rod.loads.tool import VibrationTool
from floquetrod.rod.model.catalogue import is_size
from floquetrod.rod.rod import Rod
from floquetrod.tables.arguments import column_text

if TYPE_CHECKING:
    from floquetrod.rod.loads.record import ForceRecord
    from floquetrod.wells.path import WellPath

_L = TypeVar("_L", bound=Load)

ArgumentName: TypeAlias = Callable[[str], str]
"""How messages call an argument: as in a file, or ``--axial-damping`` in a terminal."""

RECORD_OPTIONS = ("time_column", "force_column", "time_unit", "force_unit", "force_frequency")
"""What says how to read a measured force."""

LOAD_OPTIONS = ("mean_at", "wave", "axial_damping", "noise", "second", "force", *RECORD_OPTIONS)
"""What says of which kind a load is."""

_LARGEST = 1e12  # of an axial damping in 1/s: a typing error lies beyond


def read_record(given: Mapping[str, Any], named: ArgumentName = str) -> ForceRecord | None:
    """Return the measured force in the file ``force``, None without any.

    All but its mean and a trend is random where ``given`` asks for an amplitude of zero and the noise of the record,
    near no frequency; else it is fitted together with the sine near the frequency of ``second``, where it holds one,
    whose amplitude and phase, if given, are for `read_kind`.
    Raises ValueError where it cannot be read, where ``second`` is a frequency alone near which it holds no sine, and
    for what says how to read it without a file.
    """
    if given["force"] is None:
        for name in RECORD_OPTIONS:
            if given[name] is not None:
                force = named("force")
                raise ValueError(
                    f"{named(name)} needs {force}, got {given[name]!r} alone: it says how to read that file"
                )
        return None
    columns = [column_text(given[name]) for name in ("time_column", "force_column")]
    from floquetrod.rod.loads.record import ForceRecord
    from floquetrod.rod.loads.record_period import NoPeriodError

    wanted = "a text file with columns of time and force"
    require_file(named("force"), Path(given["force"]), wanted)
    text = given.get("second")  # which not every subsystem knows
    sine = {} if text is None else _second_sine(text, named, True)

    def read_with(second: float | None, harmonics: int | None) -> ForceRecord:
        return ForceRecord.from_csv(
            given["force"],
            *columns,
            time_unit=given["time_unit"],
            force_unit=given["force_unit"],
            frequency=given["force_frequency"],
            harmonics=harmonics,
            second=second,
        )

    def read(harmonics: int | None = None) -> ForceRecord:
        try:
            return read_with(sine.get("frequency"), harmonics)
        except ValueError as error:
            about = argument_of(error)
            if "amplitude" not in sine or about is None or about.name != "second":
                raise
            return read_with(None, harmonics)  # the sine typed is one that was not measured

    try:
        return read(harmonics=0 if _is_random_alone(given, sine) else None)
    except NoPeriodError:  # whose file was read
        raise
    except (ValueError, OSError) as error:
        about = argument_of(error)
        is_of_options = about is not None and about.name in _OF_COLUMNS
        message = about.named(named(_OF_COLUMNS[about.name])) if about is not None and is_of_options else str(error)
        if is_of_options and about is not None and (not about.where or about.name in ("frequency", "second")):
            raise ValueError(message) from None
        raise ValueError(f"{named('force')} must be {wanted}: {message}") from None


def _is_random_alone(given: Mapping[str, Any], second: Mapping[str, float]) -> bool:
    """Return whether the amplitude is zero and the noise that of a record, without a frequency of a sine measured."""
    amplitude, noise = given.get("amplitude"), given.get("noise")
    is_measured = given["force_frequency"] is not None or ("frequency" in second and "amplitude" not in second)
    if is_measured or noise is None or noise.strip().lower() != "spectrum":
        return False
    try:
        return LOAD["amplitude"].quantity(amplitude, "amplitude", critical_force=1.0) == 0.0
    except (TypeError, ValueError):  # none, a range, or what is refused where it is read
        return False


_OF_COLUMNS = {
    "time": "time_column",
    "force": "force_column",
    "time_unit": "time_unit",
    "force_unit": "force_unit",
    "frequency": "force_frequency",
    "second": "second",
}
"""Names of the arguments of `floquetrod.ForceRecord.from_csv`."""


_OF_WELLS = {
    **dict.fromkeys(("depth", "inclination", "azimuth"), "survey_columns"),
    **{name: name for name in ("depth_unit", "angle_unit", "delimiter", "sheet", "to")},
}
"""Arguments of `floquetrod.WellPath.from_csv`, and the options that set them."""


def read_well(given: Mapping[str, Any], path: Path, named: ArgumentName = str) -> WellPath:
    """Return the well whose survey is in a file, read as the options say."""
    from floquetrod.wells.path import WellPath

    depth, inclination, azimuth = _survey_columns(given["survey_columns"], named("survey_columns"))
    more: dict[str, str | None] = {name: given[name] for name in ("depth_unit", "angle_unit", "delimiter")}
    try:
        return WellPath.from_csv(
            path, depth, inclination, azimuth, **more, sheet=column_text(given["sheet"]), to=given["to"]
        )
    except ValueError as error:
        about = argument_of(error)
        if about is None or about.name not in _OF_WELLS or "line " in about.where:
            raise
        option = named(about.name) if _OF_WELLS[about.name] == about.name else about.name
        where = f"{about.where}: " if about.where else ""
        raise ValueError(Message(f"{where}{option} ", about.problem)) from None


def _survey_columns(text: Any, name: str) -> list[str | int | None]:
    """Return the columns of a survey from a text such as MD,Inc,Azi, or a list of them."""
    if text is None:
        return [None] * 3
    parts = text.split(",") if isinstance(text, str) else [str(each) for each in text]
    if not 2 <= len(parts) <= 3:
        raise ValueError(f"{name} must be three headings or numbers such as MD,Inc,Azi or 1,2,3, got {text!r}")
    return [*(column_text(part) for part in parts), *[None] * (3 - len(parts))]


def read_kind(
    given: Mapping[str, Any], record: ForceRecord | None, named: ArgumentName = str, fit: Load | None = None
) -> Load:
    """Return a load of the kind described by ``given``, with the numbers of ``fit``, by default the record's."""
    damping, wave = given["axial_damping"], given["wave"]
    if damping is not None and wave is None:
        raise ValueError(
            f"{named('axial_damping')} needs {named('wave')}, got {damping!r} alone: without waves the force is the "
            f"same all along the rod; add {named('wave')} held, free or driven"
        )
    at = 0.5 if given["mean_at"] is None else _fraction(given["mean_at"], named("mean_at"))
    template = kind(record if fit is None else fit)
    load = replace(template, mean_at=at)
    noise, second = given.get("noise"), given.get("second")  # which not every subsystem knows
    if noise is not None:
        load = replace(load, noise=_noise(noise, record, named))
    typed = units.GivenUnits()
    if second is not None:
        sine = _second_sine(second, named, record is not None)
        if "amplitude" in sine:  # else the sine is the record's
            load = replace(load, second=tuple(sine.values()))
        texts_of = dict(zip(sine, second.split("@"), strict=True))
        typed = units.GivenUnits.of(force=texts_of.get("amplitude"), frequency=texts_of["frequency"])
    known = template.given_units.or_else(typed)
    if wave is None:
        return load.given_in(known)
    rate = units.quantity(
        "0" if damping is None else damping, named("axial_damping"), "rate", least=0.0, largest=_LARGEST
    )
    return AxialWave(**load.as_dict(), far_end=wave, axial_damping=rate).given_in(known)


def _second_sine(text: str, named: ArgumentName, is_beside_record: bool) -> dict[str, float]:
    """Return amplitude, frequency and perhaps phase of a text such as 0.1N@37Hz or 0.1N@37Hz@90deg.

    Beside a record the frequency may be alone.
    """
    name, parts = named("second"), text.split("@")
    kinds = {"amplitude": "force", "frequency": "frequency", "phase": "angle"}
    if is_beside_record and len(parts) == 1 and units.kind_of(units.unit_of(text.strip()) or "") in (None, "frequency"):
        return {"frequency": units.quantity(text, name, "frequency")}
    if len(parts) not in (2, 3):
        raise ValueError(
            f"{name} must be such as 0.1N@37Hz or, with a phase, 0.1N@37Hz@90deg, or, beside {named('force')}, the "
            f"frequency alone of a sine that was measured, such as 37Hz; got {short(text)}"
        )
    return {each: units.quantity(part, name, kinds[each]) for each, part in zip(kinds, parts, strict=False)}


def _noise(text: str, record: ForceRecord | None, named: ArgumentName) -> Any:
    """Return the density of noise, for the word "spectrum" the density of a record's residual."""
    if text.strip().lower() != "spectrum":
        return noise_density(named("noise"), text)
    if record is None:
        raise ValueError(f"{named('noise')} spectrum needs {named('force')}: it is that of a measured force")
    return record.noise_spectrum


def _fraction(text: str, name: str) -> float | None:
    """Return a fraction of the length, None for the word none."""
    if text.strip().lower() == "none":
        return None
    try:
        return units.quantity(text, name, "ratio", least=0.0, largest=1.0)
    except ValueError:
        raise ValueError(
            f"{name} must be a fraction of the length from 0, the upper end, to 1, the lower, or none, which "
            f"neglects the weight along the rod; got {text!r}"
        ) from None


def read_load(given: Mapping[str, Any], rod: Rod, like: _L, named: ArgumentName = str) -> _L:
    """Return a load of the kind of ``like``, which gives the numbers left out."""
    texts = {name: given[name] for name in QUANTITIES if given[name] is not None}
    numbers: dict[str, Any] = {name: read_quantity(text, name, rod, named) for name, text in texts.items()}
    typed = units.GivenUnits.of(force=(texts.get("mean"), texts.get("amplitude")), frequency=texts.get("frequency"))
    return replace(like, **numbers).given_in(typed.or_else(like.given_units))


def read_quantity(value: Any, name: Quantity, rod: Rod, named: ArgumentName = str, quoted: str | None = None) -> float:
    """Return a quantity of the load in SI units; messages quote ``quoted`` in place of the value."""
    record = LOAD[name]
    return record.quantity(
        value,
        named(name),
        critical_force=rod.force_unit,
        least=record.least,
        largest=record.largest,
        given=quoted,
    )


def is_pipe(text: str) -> bool:
    """Return whether a rod is named as a pipe of the catalogue, and not as a file."""
    return is_size(text) and not text.endswith(".toml") and not Path(text).is_file()


def named_rod(name: str, text: str, folder: Path | None = None) -> Rod:
    """Return nitinol or the rod of a TOML file, which is searched for in ``folder``; messages begin with ``name``."""
    if text.strip().lower() == "nitinol":
        return Rod.nitinol()
    wanted = "nitinol, a steel pipe such as '2.00x0.156 CT90', or a TOML file"
    path = Path(text) if folder is None else folder / text
    require_file(name, path, wanted, ["nitinol"])
    try:
        return Rod.from_toml(path if text else text)
    except (ValueError, OSError) as error:
        raise error_in(name, error) from None


_OF_TOOLS = {"force": "kN", "length": "ft"}
"""Units in which numbers of a tool may be meant where nothing beside them tells."""


def read_tool(text: str, name: str) -> VibrationTool:
    """Return a tool written as amplitude@frequency, or amplitude@frequency@distance from the lower end.

    A second sine follows a plus sign, as amplitude@frequency or amplitude@frequency@phase.
    """
    first, plus, more = text.partition("+")
    parts = first.split("@")
    if len(parts) not in (2, 3):
        raise ValueError(f"{name} must be such as 5kN@18Hz or, 30 m above the end, 5kN@18Hz@30m, got {short(text)}")
    written = [*zip(("amplitude", "frequency", "distance"), parts, ("force", "frequency", "length"), strict=False)]
    second = more.split("@") if plus else []
    if plus and len(second) not in (2, 3):
        raise ValueError(f"{name} must be such as 5kN@18Hz@30m+3kN@29Hz with a second sine, got {short(text)}")
    names = "second amplitude", "second frequency", "phase"
    written += zip(names, second, ("force", "frequency", "angle"), strict=False)
    _require_order(parts, name, text)
    for number in bare_numbers((Written(*each) for each in written), _OF_TOOLS):
        raise ValueError(f"{name} {short(text)}: its {number.quantity.name} {number.problem}")
    bare = parts[1].strip()
    if units.unit_of(bare) == "":
        hertz = units.unit("Hz", name, "frequency").show(units.quantity(bare, name, "frequency"), 3)
        typed = f"{parts[0].strip()}N@{bare}"
        warnings.warn(
            f"{name} {text.strip()} is taken in N and rad/s, that is, at {hertz}; write {typed}rad/s or {typed}Hz",
            PlausibilityWarning,
            stacklevel=2,
        )
    return VibrationTool(*parts, second=tuple(second) if plus else None)  # type: ignore[arg-type]


_PARTS_OF_TOOL = ("force", "frequency", "length")
"""Kinds of the quantities as which a tool is written, in this order."""


def _require_order(parts: Sequence[str], name: str, text: str) -> None:
    """Raise ValueError where the units of a tool's parts are those of parts at other places, and show the order."""
    kinds = [units.kind_of(units.unit_of(part.strip()) or "") for part in parts]
    if all(kind in (None, expected) for kind, expected in zip(kinds, _PARTS_OF_TOOL, strict=False)):
        return
    by_kind = {kind: part.strip() for kind, part in zip(kinds, parts, strict=True) if kind is not None}
    came = ", ".join(f"{part} is a {kind}" for kind, part in by_kind.items())
    order = _PARTS_OF_TOOL[: len(parts)]
    is_whole = set(order) == set(kinds)
    write = f"write {'@'.join(by_kind[kind] for kind in order)}" if is_whole else "write it such as 5kN@18Hz@30m"
    wanted = "force@frequency, or force@frequency@distance above the lower end"
    raise ValueError(f"{name} must be {wanted}, got {short(text)}: {came}; {write}")


def read_friction(text: str, name: str) -> float | list[tuple[float | str, float]]:
    """Return the coefficient of friction, or pairs (depth, coefficient), of a text such as 0.2 or 0.2,0.35@1500m."""
    pairs: list[tuple[float | str, float]] = []
    for part in text.split(","):
        coefficient, at, depth = part.partition("@")
        if bool(at) != bool(pairs):
            wanted = "0.2 or, with another from 1500 m on, 0.2,0.35@1500m"
            raise ValueError(f"{name} must be such as {wanted}, got {short(text)}")
        pairs.append((depth.strip() if at else 0.0, units.quantity(coefficient, name, "ratio")))
    return pairs if pairs[1:] else pairs[0][1]


def read_frictions(text: str, name: str) -> list[float | list[tuple[float | str, float]]]:
    """Return factors of friction written as 0.2,0.3,0.4, each with others by depth as in 0.2,0.35@1500m,0.3.

    A coefficient without a depth begins another factor.
    """
    factors: list[str] = []
    for part in text.split(","):
        if "@" in part and factors:
            factors[-1] += f",{part}"
        else:
            factors.append(part)
    return [read_friction(factor, name) for factor in factors]
