"""Allowed numbers that look like a mistake: another unit, a diameter for a radius, Hz for rad/s.

Every limit here is a heuristic choice.  It leaves room for real rods, from glass fibres of 0.1 mm to strings of 10 km:
a warning that is often wrong would be silenced once and for all.  For the same reason a number is suspected only where
it has few digits, as typed, and where a mistake would explain it: in the other unit it is plausible.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from floquetrod._util.arguments import Mention, Message
from floquetrod._util.calling import level_of_caller
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning, is_typed
from floquetrod.rod.loads.load import Load, LoadSource
from floquetrod.rod.model.catalogue import pipes
from floquetrod.units import unit_of, units_of

_MAKERS = (
    "rod.model.data",
    "rod.model.rod_file",
    "rod.model.catalogue",
    "rod.reading",
    "ensembles.study",
    "_util.calling",
)
"""Modules through which a user's call makes a rod; other code of the package makes its rods from the user's."""

_SLENDEREST = 1e6  # length over diameter: 6 km of capillary string of 1/4 inch, the slenderest string run, has 9e5
_STUBBIEST = 3.0  # length over diameter: no rod, and no theory of one
_THICKEST = 0.75  # radius in m: pipelines reach 0.71 m
_WIDEST = 500.0  # channel over rod: a glass fibre of 0.125 mm in a pipe of 50 mm has 400
_SOFTEST, _STIFFEST = 1e8, 2e12  # Pa: what numbers in GPa are of; diamond has 1.2e12
_USUAL = 1e11  # Pa: that of usual metals, magnesium to steel, within a factor of 2.5
_READINGS = {"MPa": 1e6, "psi": units_of("pressure")["psi"], "GPa": 1e3}  # times Pa; the last of what is in MPa
_METAL = 2500.0, 1e9  # kg/m^3 and Pa: nothing as heavy as aluminium is softer
_LIGHTEST, _HEAVIEST = 25.0, 1e5  # kg/m^3: stiff foam; four times osmium, for fluids counted in
_SOLID = 1e8  # Pa: nothing as stiff as this is lighter than stiff foam
_GRAVITIES = {980.665: "cm/s^2", 9806.65: "mm/s^2", 32.174: "ft/s^2", 386.09: "in/s^2"}
_STRONG, _WEAK = 100.0, 1e-3  # critical forces; ten times a usual mean, in a unit a thousand times too large or small
_THICK_STRING = 1e3  # N: critical force from which kN are usual
_SHARP = 0.01  # curvature times clearance from which growth errs by a percent (docs/theory/bends.md); wells have 1e-3
_QUICKEST = 1e3  # Hz: no machine that shakes a rod is faster; an ultrasonic horn, which has 20 kHz, buckles none
_ORDER = 3.0  # tongues of a higher order are narrow


class HertzWarning(PlausibilityWarning):
    """A frequency that is probably in Hz; the terminal, which knows what was typed, says so itself."""


def warn_of_rod(rod: Any) -> None:
    """Warn of a rod's suspicious parameters, when a user's call has made it."""
    for suspicion in suspicions_of_rod(rod):
        level = _level_of_user()
        if level is None:
            return
        warnings.warn(Message(suspicion, SILENCE), PlausibilityWarning, stacklevel=level)


def _level_of_user() -> int | None:
    """Return the stack level of the user for the caller of this function, None where the package made the rod."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None:
        level, frame = level + 1, frame.f_back
        package, _, module = frame.f_globals.get("__name__", "").partition(".")
        if package != "floquetrod" or module.startswith("cli"):
            return level
        if module not in _MAKERS:
            return None
    return level


def suspicions_of_rod(rod: Any) -> Iterator[str]:
    """Yield the suspicions about a rod, or about each section of one, each with its numbers and a remedy."""
    for number, section in enumerate(rod.sections, start=1):
        every = (_thickness(section), _slenderness(section), _doubled(section, "name={!r}"), _material(section))
        yield from (f"section {number}: {suspicion}" for suspicions in every for suspicion in suspicions)
    if not rod.sections:
        sizes = (_thickness, _slenderness, _stubbiness)
        yield from next(filter(None, ([*suspicions(rod)] for suspicions in sizes)), [])
        yield from _doubled(rod, "Rod.catalogue({!r}, ...)")
        yield from _material(rod)
    yield from _width(rod)
    yield from _fluids(rod)
    widest = max(part.rod.radial_clearance for part in rod.uniform_parts)
    if not rod.course.is_straight and (sharp := rod.course.sharpest * widest) > _SHARP:
        yield (
            f"curvature times clearance is {sharp:.2g}, above {_SHARP:g}: verdicts are those of gentle bends, and err "
            "by a percent or more; check the units of path or curvature and of the channel, or simulate"
        )
    for value, unit in _GRAVITIES.items():
        if abs(rod.gravity / value - 1.0) < 5e-3:
            yield f"gravity = {rod.gravity:g} m/s^2 looks like {unit}; a number is taken in m/s^2: gravity=9.81"


def _thickness(rod: Any) -> Iterator[str]:
    """Yield the suspicion that a radius was given in millimetres."""
    if is_typed(rod.radius) and _THICKEST < rod.radius <= 1e3 * _THICKEST:
        yield (
            f"radius = {rod.radius:g} m makes a rod {2.0 * rod.radius:g} m thick; were these millimetres? A number is "
            f'taken in m: radius="{rod.radius:g}mm"'
        )


def _slenderness(rod: Any) -> Iterator[str]:
    """Yield the suspicion that a length was given in millimetres."""
    slenderness = 0.5 * rod.length / rod.radius
    if is_typed(rod.length) and _SLENDEREST < slenderness <= 1e3 * _SLENDEREST:
        is_judged = getattr(rod, "force_unit", None) is not None
        buckled = f", and the rod would buckle into mode {rod.critical_mode:.0f}" if is_judged else ""
        yield (
            f"length = {rod.length:g} m is {slenderness:.3g} times the diameter of {2.0 * rod.radius:g} m{buckled}; "
            f'were these millimetres? A number is taken in m: length="{rod.length:g}mm"'
        )


def _stubbiness(rod: Any) -> Iterator[str]:
    """Yield the suspicion that a radius is in another unit than the length."""
    slenderness = 0.5 * rod.length / rod.radius
    if is_typed(rod.radius) and 1e-3 * _STUBBIEST <= slenderness < _STUBBIEST:
        yield (
            f"length = {rod.length:g} m is {slenderness:.3g} times the diameter of {2.0 * rod.radius:g} m, which is no "
            f'slender rod; is the radius of {rod.radius:g} m in another unit? Give it as "{rod.radius:g}mm", say'
        )


def _width(rod: Any) -> Iterator[str]:
    """Yield the suspicion that the size of the channel was given in millimetres, once for several bores."""
    radius = min(part.rod.radius for part in rod.uniform_parts)
    name, size, of_rod, as_given = "channel_radius", rod.channel_radius, f"radius of the rod, {radius:g} m", "{}"
    if rod.bores:
        name, size, of_rod = "bores", rod.bores[0].diameter, f"diameter of the rod, {2.0 * radius:g} m"
        radius, as_given = 2.0 * radius, '[("0m", {}), ...]'
    if is_typed(size) and _WIDEST < size / radius <= 1e3 * _WIDEST:
        typed = f'"{size:g}mm"'
        yield (
            f"{name} = {size:g} m is {size / radius:.3g} times the {of_rod}; were these millimetres? A number is taken "
            f"in m: {name}={as_given.format(typed)}"
        )


def _doubled(rod: Any, named: str) -> Iterator[str]:
    """Yield the suspicion that diameters were given as radii, where a pipe of the catalogue, ``named``, shows it."""
    wall = rod.radius - rod.inner_radius
    tubes = [pipe for pipe in pipes() if pipe.wall_thickness] if rod.inner_radius > 0.0 else []
    if any(_alike(2.0 * rod.radius, pipe.diameter) and _alike(wall, pipe.wall_thickness) for pipe in tubes):
        return  # a pipe as it stands in the catalogue
    for pipe in tubes:
        walls = (pipe.wall_thickness, 2.0 * pipe.wall_thickness)  # the second where both diameters are taken for radii
        if _alike(rod.radius, pipe.diameter) and any(_alike(wall, each) for each in walls):
            yield (
                f"radius = {rod.radius:g} m is the diameter of the catalogue's {pipe.name} {pipe.product}, whose wall "
                f"this rod has too; give diameter={rod.radius:g}, or {named.format(pipe.name)}"
            )


def _alike(one: float, other: float) -> bool:
    return abs(one / other - 1.0) < 2e-3


def _material(rod: Any) -> Iterator[str]:
    """Yield the suspicions about Young's modulus, the density and the yield strength."""
    modulus, density = rod.youngs_modulus, rod.density
    if is_typed(modulus) or modulus > _STIFFEST:
        yield from _modulus(modulus, density)
    if is_typed(density) and 1e-3 * _LIGHTEST < density < _LIGHTEST and modulus > _SOLID:
        yield (
            f"density = {density:g} kg/m^3 is too light for what has youngs_modulus = {modulus:g} Pa; was it in "
            f'g/cm^3? A number is taken in kg/m^3: density="{density:g}g/cm3"'
        )
    strength = rod.yield_strength
    if strength is not None and is_typed(strength) and strength < 1e-6 * modulus:
        yield (
            f"yield_strength = {strength:g} Pa is that of no solid; was it in MPa? A number is taken in Pa: "
            f'yield_strength="{strength:g}MPa"'
        )
    yield from _heavy("density", density)


def _fluids(rod: Any) -> Iterator[str]:
    """Yield the suspicions about the fluids."""
    for name in ("fluid_inside", "fluid_outside"):
        yield from _heavy(name, getattr(rod, name))


def _heavy(name: str, value: float) -> Iterator[str]:
    """Yield the suspicion about a density."""
    if is_typed(value) and _HEAVIEST < value <= 1e3 * _HEAVIEST:
        yield f"{name} = {value:g} kg/m^3 is heavier than any metal; a number is taken in kg/m^3"


def _modulus(modulus: float, density: float) -> Iterator[str]:
    """Yield the suspicion about Young's modulus, if any."""
    heavy, stiff = _METAL
    if 1e-9 * _SOFTEST <= modulus <= 1e-9 * _STIFFEST:
        yield (
            f"youngs_modulus = {modulus:g} Pa is softer than any rod; was it in GPa? A number is taken in Pa: "
            f'youngs_modulus="{modulus:g}GPa"'
        )
    elif 1e-6 * stiff < modulus < stiff and density > heavy:
        unit = min(_READINGS, key=lambda name: abs(math.log(modulus * _READINGS[name] / _USUAL)))
        typed = 1e-6 * modulus if unit == "GPa" else modulus
        yield (
            f"youngs_modulus = {modulus:g} Pa is that of rubber, and density = {density:g} kg/m^3 that of a metal; was "
            f'it in {unit}? Give youngs_modulus="{typed:g}{unit}"'
        )
    elif _STIFFEST < modulus <= 1e3 * _STIFFEST:
        yield (
            f"youngs_modulus = {modulus:g} Pa is stiffer than diamond; a number is taken in Pa: "
            f'youngs_modulus="200GPa", say'
        )


def suspicions_of_load(rod: Any, load: Any) -> Iterator[str]:
    """Yield the suspicions about a load on a rod, each with its numbers and a remedy."""
    mean, amplitude, critical = load.mean, load.amplitude, rod.critical_force
    measured = load.waveform != "sine"  # in a file, whose heading may say kN
    if (measured or is_typed(mean)) and _STRONG * critical < mean <= 30.0 * _STRONG * critical:
        yield (
            f"mean = {mean:g} N is {mean / critical:.3g} times the critical force of {critical:.3g} N; was it in mN? A "
            f'number is taken in N: mean="{mean:g}mN", or a part of rod.critical_force'
        )
    elif (
        critical > _THICK_STRING
        and all(0.01 * _WEAK < force / critical < _WEAK for force in (mean, amplitude))
        and is_typed(mean)
    ):
        yield (
            f"mean = {mean:g} N and amplitude = {amplitude:g} N are less than a thousandth of the critical force of "
            f'{critical:.3g} N; were they in kN? A number is taken in N: mean="{mean:g}kN", amplitude="{amplitude:g}kN"'
        )


def suspicions_of_record(rod: Any, record: Any) -> Iterator[str]:
    """Yield the suspicion that a record without a unit of force is not in N: in another unit it would matter.

    In kN or mN it would be about the critical force, and in N it is far from it.  Pounds are so near to newtons that
    both may be plausible; they are as usual for strings as newtons, so that the file has to say which.
    """
    share = (abs(record.mean) + record.amplitude) / rod.critical_force
    is_string, is_far = rod.critical_force > _THICK_STRING, not _matters(share)
    usual = {"kN": is_string and is_far, "mN": rod.critical_force < 1e-2 * _THICK_STRING and is_far, "lbf": is_string}
    others = {unit: share * units_of("force")[unit] for unit, is_usual in usual.items() if is_usual}
    others = {unit: other for unit, other in others.items() if _matters(other)}
    if others:
        yield Message(
            f"the record names no unit of force: taken in N, its {record.mean:.4g} +- {record.amplitude:.4g} N are "
            f"{share:.2g} of the critical force, in ",
            ", in ".join(f"{unit} {other:.2g}" for unit, other in others.items()),
            "; give ",
            Mention("force_unit"),
            f", {', '.join(['N', *others][:-1])} or {list(others)[-1]}",
        )


def suspicions_of_times(record: Any) -> Iterator[str]:
    """Yield the suspicion that the times of a record are in a larger unit than was taken: its force is too quick."""
    times = getattr(record, "time", None)  # a changed record has none of its own
    if times is not None and (hertz := record.frequency / (2.0 * math.pi)) > _QUICKEST:
        sampled = (times.size - 1) / (times[-1] - times[0])
        yield Message(
            f"the record has {sampled:,.0f} samples a second and its force {hertz:,.0f} Hz, more than any machine that "
            "shakes rods: are its times in another unit? Give ",
            Mention("time_unit"),
            ", such as s or ms",
        )


def _matters(share: float) -> bool:
    """Return whether a force of so many critical forces is plausible (the limits are choices)."""
    return 0.02 < share < 20.0


def may_be_hertz(rod: Any, load: Any) -> bool:
    """Return whether a frequency in rad/s may have been meant in Hz: short, too low for all but narrow tongues.

    All modes are faster than sqrt(1 - (mean / F_cr)^2) times the pendulum frequency, and a tongue of order k lies about
    2 / k times a mode's frequency.  The number lies below all tongues up to order 3, and as one of Hz above the first
    of order 1.
    """
    if (critical := rod.force_unit) is None:
        return False
    share = max(0.0, load.mean) / critical
    if share >= 1.0 or load.amplitude == 0.0 or load.waveform != "sine" or not is_typed(load.frequency):
        return False
    first = 2.0 * rod.pendulum_frequency * math.sqrt(1.0 - share * share)
    return bool(_ORDER * load.frequency < first <= 2.0 * math.pi * load.frequency)


def warn_of_load(rod: Any, load: Load, source: LoadSource | None = None) -> None:
    """Warn of a load that is suspicious on this rod, by its critical force, or of the record that is its ``source``."""
    if rod.force_unit is None:
        return
    is_unnamed = source is not None and not source.force_unit_named
    suspicions = [*(suspicions_of_record(rod, source) if is_unnamed else suspicions_of_load(rod, load))]
    for suspicion in [*suspicions_of_times(source), *suspicions]:
        warnings.warn(Message(suspicion, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())


def warn_of_record(rod: Any, record: Any, load: Any, frequencies: Sequence[float] = ()) -> None:
    """Warn of a record with suspicious times, a pull on average, a force without a unit or lines not in the load.

    And where the load's frequency, or the ``frequencies`` at the ends of a range, move its strongest harmonic.
    """
    said = (*record._pull_in_words("the record"), *record._lines_in_words("the record", load))
    suspicions = [*suspicions_of_times(record), *said, *record._moved_in_words(frequencies or (load.frequency,))]
    if not record.force_unit_named:  # taken in N, whatever it is
        forces = [] if rod.force_unit is None else list(suspicions_of_record(rod, record))
        general = "the record names no unit of force: taken in N; give "
        suspicions += forces or [Message(general, Mention("force_unit"), ", such as N or lbf")]
    for suspicion in suspicions:
        warnings.warn(Message(suspicion, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())


def _verdict(rod: Any, load: Any, frequency: float, growth_tolerance: float) -> int:
    """Return the verdict on a load of independent modes at another frequency."""
    found = rod.verdicts(load, frequency=frequency, growth_tolerance=growth_tolerance)
    return int(found)


def warn_of_hertz(rod: Any, load: Any, growth_tolerance: float) -> None:
    """Warn where a load of independent modes that is stable may have been meant in Hz, and in Hz is unstable."""
    if may_be_hertz(rod, load) and _verdict(rod, load, 2.0 * math.pi * load.frequency, growth_tolerance) == 0:
        warnings.warn(
            Message(
                f"frequency = {load.frequency:g} rad/s is below all but the narrowest tongues of this rod, and with it "
                f"nothing grows; with {load.frequency:g} Hz something would. Was it in Hz? AxialLoad.hertz takes Hz, "
                f'and so does frequency="{load.frequency:g}Hz"',
                SILENCE,
            ),
            HertzWarning,
            stacklevel=level_of_caller(),
        )


def suspicion_of_hertz(
    name: str, text: str, rod: Any, loads: Iterable[Any], tolerance: float = 0.0, known: int | None = None
) -> str:
    """Return the suspicion that a frequency written without a unit was meant in Hz, "" without one.

    ``name`` is what gave ``text``, a frequency or a range.  Suspected is what would, in Hz, change the verdict without
    friction on one of the loads.  Where modes are coupled, and a verdict takes its time, a single load is suspected as
    in `may_be_hertz`.  ``known`` is the verdict on a single load where it has been found: 1, 0 or -1.
    """
    if unit_of(text.rpartition(":")[2]) != "":
        return ""
    loads = list(loads)
    for load in loads:
        reading = ""
        if rod._modes_under(load).prompt:
            reading = _in_hertz(rod, load, tolerance, known)
        elif len(loads) == 1 and may_be_hertz(rod, load):
            reading = "below all but the narrowest resonances of this rod, which as many Hz are not"
        if reading:
            at = "" if len(loads) == 1 else f", under mean {load.mean:.4g} N and amplitude {load.amplitude:.4g} N"
            typed = text.strip()
            return f"{name} {text} is taken in rad/s: {reading}{at}; write {typed}rad/s or {typed}Hz"
    return ""


def _in_hertz(rod: Any, load: Any, tolerance: float, known: int | None) -> str:
    """Return how the verdict differs where a frequency is read in Hz, "" where it does not or is not known."""
    if load.amplitude == 0.0 or known == -1:  # the frequency of nothing, or nothing to differ from
        return ""
    try:
        in_hertz = _verdict(rod, load, 2.0 * math.pi * load.frequency, tolerance)
        verdicts = _verdict(rod, load, load.frequency, tolerance) if known is None else known, in_hertz
    except ValueError:  # as many Hz are far beyond this rod
        return ""
    words = {(1, 0): ("no mode grows", "one does"), (0, 1): ("a mode grows", "none does")}.get(verdicts)
    return f"at {load.frequency:.4g} rad/s {words[0]}, at {load.frequency:.4g} Hz {words[1]}" if words else ""
