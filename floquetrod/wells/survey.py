"""Checks of a survey: faults, by which it is no path of a well, and probable mistakes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention, Message
from floquetrod._util.arrays import Floats
from floquetrod.wells.minimum_curvature import doglegs
from floquetrod.wells.survey_headings import KINDS

LENGTHS = 1e-6, 1e6
"""Least and largest length of a path in m: the least adds to a depth, the largest shows a wrong unit (a choice)."""

DEEPEST = LENGTHS[1]  # m: seventy times the longest well, so that a depth in mm is seen (a choice)
_TURNS = 4.0 * math.pi  # of an azimuth in rad: two turns, beyond which it is in degrees (a choice)
_SHARPEST = math.radians(175.0)  # beyond it the plane of an arc is not known (a choice)
_SEVERE = math.radians(30.0) / 30.0  # rad/m: twice the curvature of drilling with short radius (a choice)
_NOT_SHORT = 5.0  # m: shorter intervals between stations occur in models in a laboratory (a choice)
_KINK = math.radians(5.0)  # of both intervals at a station that alone is off the path (a choice)
_STRAIGHTER = 0.25  # the bend that is left without that station (a choice)

_WELL = 30.0  # m: shorter paths are models in a laboratory, which may go up (a choice)
_UPWARDS = math.radians(100.0)  # of the first station: beyond it a well would go up from the surface (a choice)
_SURFACE = 0.01  # of the last depth, within which the first station is at the surface (a choice)
_BUILDS = math.radians(20.0)  # least inclination that a well builds to (a choice)
_NEARLY_VERTICAL = math.radians(1.0)  # of a first station of a usual well (a choice)
_LEAST_BUILT, _RIGHT = 0.2, 1.6  # of the largest inclination as it stands in a file, which may be in radians (choices)
_NEARLY_RIGHT = 1.4  # of these, beyond which a largest one of whole quarters may be in radians (a choice)
_ONE_WAY = 1.5  # of the range of inclinations: their changes one after the other, of a well that is built (a choice)


class Fault(NamedTuple):
    """A fault of a survey: the argument, the number of the station from 1, and the rest of a sentence."""

    argument: str
    station: int
    problem: str


class SurveyUnits(NamedTuple):
    """The units in which messages about a survey are, and whether it was read from a file."""

    length: units.Unit = units.unit("m", "", "length")
    angle: units.Unit = units.unit("rad", "", "angle")
    of_file: bool = False

    @property
    def remedy(self) -> str:
        """What to do about an angle that is probably in another unit."""
        if self.of_file:
            return Message("give ", Mention("angle_unit", "angle_unit", "rad"), " where angles are not in deg")
        return "strings such as '30deg' have a unit, and numpy.radians turns degrees into rad"

    def dogleg(self, curvature: float) -> str:
        """Return a curvature in 1/m beside these lengths, to three digits."""
        if self.length.name in ("ft", "ftUS", "in"):
            return f"{math.degrees(30.48 * curvature):.3g} deg/100 ft"
        return f"{math.degrees(30.0 * curvature):.3g} deg/30 m"


IN_SI = SurveyUnits()
"""Lengths in m and angles in rad, of numbers that were given in Python."""


def column(name: str, values: Any, many: int | None = None) -> Floats:
    """Return depths in m or angles in rad, numbers or strings with units; one value stands for ``many``.

    Raises TypeError or ValueError, naming argument and index, for anything but a list of numbers.
    """
    raw = validate.untyped(name, units.si(values, name, KINDS[name]))
    if raw.ndim > 1 or (raw.ndim == 0 and many is None):
        raise validate.wrong_value(
            name, f"must be a list with a number for every station, got {validate.short(values)}"
        )
    if raw.size > validate.MOST_NUMBERS:
        raise validate.wrong_value(name, f"must hold at most {validate.MOST_NUMBERS} stations, got {raw.size}")
    if raw.dtype.kind in "iuf":
        with np.errstate(over="ignore"):  # of longer floats; infinity is refused with its station
            numbers = raw.astype(np.float64)
    elif raw.dtype.kind in "UO" or not raw.size:
        given = raw.ravel().tolist()
        places = [name if raw.ndim == 0 else f"{name}[{i}]" for i in range(len(given))]
        numbers = np.array(
            [units.number(place, value, KINDS[name]) for place, value in zip(places, given, strict=True)]
        )
        numbers = numbers.reshape(raw.shape)
    else:
        raise validate.wrong_type(name, f"must hold real numbers, got {validate.short(values)}")
    if many is not None and numbers.ndim and numbers.size != many:
        raise validate.wrong_value(name, f"must have as many numbers as depth has, {many}, got {numbers.size}")
    return numbers if many is None else np.broadcast_to(numbers, many).copy()


def within(inclination: Floats, azimuth: Floats) -> tuple[Floats, Floats]:
    """Return the same directions with inclinations from 0 to pi and azimuths within two turns."""
    with np.errstate(invalid="ignore"):  # infinite values are refused with their station
        around = np.remainder(inclination, 2.0 * math.pi)
        beyond = around > math.pi
        turned = np.remainder(azimuth + math.pi * beyond, 2.0 * math.pi)
    is_kept = (inclination >= 0.0) & (inclination <= math.pi)
    return (
        np.where(is_kept, inclination, np.where(beyond, 2.0 * math.pi - around, around)),
        np.where(~beyond & (np.abs(azimuth) <= _TURNS), azimuth, turned),
    )


def fault(depth: Floats, inclination: Floats, azimuth: Floats, shown: SurveyUnits = IN_SI) -> Fault | None:
    """Return the first fault by which a survey is no path, None where it is one; in words in the units ``shown``."""
    if depth.size < 2:
        return Fault("depth", depth.size, f"must have two stations or more, got {depth.size}; a path lies between them")
    return next(_faults({"depth": depth, "inclination": inclination, "azimuth": azimuth}, shown), None)


def _faults(columns: dict[str, Floats], shown: SurveyUnits) -> Iterator[Fault]:
    # Columns (stations,): depth in m, inclination and azimuth in rad.  Every rule yields a fault for each station that
    # breaks it, stations counted from 1 and values in the units ``shown``; of a step between two stations the second
    # one is named.
    length, angle = shown.length, shown.angle
    for name, values in columns.items():
        for i in np.flatnonzero(~np.isfinite(values)):
            yield Fault(name, int(i) + 1, f"must be finite, got {values[i]:g}; leave a station without it out")
    depth, inclination, azimuth = columns.values()
    for i in np.flatnonzero((depth < 0.0) | (depth > DEEPEST)):
        remedy = "check its unit"
        if depth[i] < 0.0 and shown.of_file:
            remedy = "it lies above the datum: leave the station out, or add as much to all depths"
        yield Fault(
            "depth",
            int(i) + 1,
            f"must lie between 0 and {length.of(DEEPEST):.3g} {length.name}, got {length.show(depth[i])}; {remedy}",
        )
    for i in np.flatnonzero(np.diff(depth) <= 0.0):
        yield Fault(
            "depth",
            int(i) + 2,
            f"must increase from station to station, got {length.show(depth[i + 1])} after "
            f"{length.show(depth[i])}; sort the stations, and leave out what is measured twice",
        )
    for i in np.flatnonzero((inclination < 0.0) | (inclination > math.pi)):
        up = "pi" if angle.size == 1.0 else "180 deg"
        yield Fault(
            "inclination",
            int(i) + 1,
            Message(
                f"must lie between 0, straight down, and {up}, straight up, got {angle.show(inclination[i])}; ",
                shown.remedy,
            ),
        )
    for i in np.flatnonzero(np.abs(azimuth) > _TURNS):
        yield Fault(
            "azimuth",
            int(i) + 1,
            Message(f"must lie within two turns, got {angle.show(azimuth[i])}; ", shown.remedy),
        )
    angles = doglegs(inclination, azimuth)
    for i in np.flatnonzero(angles > _SHARPEST):
        yield Fault(
            "inclination",
            int(i) + 2,
            f"must not reverse the direction, got {math.degrees(angles[i]):.4g} deg "
            f"from that at {length.show(depth[i])}; give stations between, which determine the side",
        )


def suspicions(
    depth: Floats,
    inclination: Floats,
    azimuth: Floats,
    *,
    shown: SurveyUnits = IN_SI,
    has_headings: bool = True,
    in_degrees: bool = False,
) -> Iterator[Fault]:
    """Yield probable mistakes in a possible survey, one station for each kind of mistake, in the units ``shown``.

    The columns of a file may be exchanged, have no headings, and hold angles taken ``in_degrees`` without a unit.
    Arrays are often sections of a well.
    """
    # Three kinds: angles that make sense in radians only; the first that holds of a well that goes up from its first
    # station, inclination and azimuth exchanged, and columns of another order; a bend that no well has (`_bend`).
    # Depths in m, angles in rad, (stations,) each.
    at = shown.length.show(depth[0])
    if in_degrees and _in_radians(depth, np.degrees(inclination), np.degrees(azimuth)):
        i = int(np.argmax(inclination))
        yield Fault(
            "inclination",
            i + 1,
            Message(
                f"has the largest inclination, {math.degrees(inclination[i]):.4g} deg: these are probably in radians; "
                "give ",
                Mention("angle_unit", 'angle_unit="rad"', "rad"),
                ", or ",
                Mention("angle_unit", 'angle_unit="deg"', "deg"),
                " where they are in degrees",
            ),
        )
    if depth[-1] - depth[0] >= _WELL and inclination[0] > _UPWARDS:
        yield Fault(
            "inclination",
            1,
            f"has {math.degrees(inclination[0]):.4g} deg of inclination, so that the well goes up from there: 0 is "
            "straight down here; where 180 deg is, give 180 deg minus these",
        )
    elif shown.of_file and _exchanged(depth, inclination, azimuth):
        yield Fault(
            "inclination",
            1,
            f"has {math.degrees(inclination[0]):.4g} deg of inclination at a depth of {at}, and the azimuths "
            "look like inclinations: both columns are probably exchanged; inclination comes before azimuth, unless "
            "headings say otherwise",
        )
    elif not has_headings and _begins_inclined(depth, inclination):
        yield Fault(
            "inclination",
            1,
            f"has {math.degrees(inclination[0]):.4g} deg of inclination at a depth of {at}: without headings "
            "columns are taken as depth, inclination and azimuth; if they are in another order, write headings such as "
            "MD (m), Azi (deg), Inc (deg) above them",
        )
    bend = _bend(depth, inclination, azimuth, shown)
    if bend is not None:
        yield bend


def _exchanged(depth: Floats, inclination: Floats, azimuth: Floats) -> bool:
    """Return whether a survey begins inclined at the surface, and would begin vertical if its angles were exchanged.

    The column of azimuths builds as inclinations do, and by more than the column of inclinations changes: a section of
    a well that begins inclined may turn from an azimuth of 0, too.
    """
    builds = azimuth.min() >= 0.0 and _BUILDS < azimuth.max() <= _UPWARDS and azimuth[0] < _NEARLY_VERTICAL
    builds &= np.ptp(azimuth) > np.ptp(inclination)
    return bool(_begins_inclined(depth, inclination) and builds and azimuth[0] == azimuth.min())


def _begins_inclined(depth: Floats, inclination: Floats) -> bool:
    """Return whether a well is inclined at the surface, as few are."""
    is_well, at_surface = depth[-1] - depth[0] >= _WELL, depth[0] <= _SURFACE * depth[-1]
    return bool(is_well and at_surface and inclination[0] > _KINK)


def _in_radians(depth: Floats, inclination: Floats, azimuth: Floats) -> bool:
    """Return whether angles taken in degrees are probably in radians; columns are as they stand in the file.

    No inclination exceeds a right angle in radians.  In degrees inclinations of a vertical well are as small, but they
    go up and down beside azimuths of any size, while they go up in a well that builds; and few in radians are quarters.
    """
    most = float(np.abs(inclination).max())
    if not _LEAST_BUILT < most <= _RIGHT or depth[-1] - depth[0] < _WELL:
        return False
    is_precise = most > _NEARLY_RIGHT or bool((np.abs(4.0 * inclination - np.round(4.0 * inclination)) > 1e-6).any())
    is_built = float(np.abs(np.diff(inclination)).sum()) <= _ONE_WAY * (inclination.max() - inclination.min())
    has_turns = float(np.abs(azimuth).max()) <= 2.0 * math.pi
    return bool(is_precise and (has_turns or (is_built and inclination[-1] > 0.5 * most)))


def _bend(depth: Floats, inclination: Floats, azimuth: Floats, shown: SurveyUnits) -> Fault | None:
    """Return one station off the path through its neighbours, or a bend of no well."""
    angles = doglegs(inclination, azimuth)
    kink = _kinked(angles, inclination, azimuth)
    if kink is not None:
        size = math.degrees(max(angles[kink - 1], angles[kink]))
        return Fault(
            "inclination",
            kink + 1,
            f"turns the well by {size:.3g} deg and back at {shown.length.show(depth[kink])}: "
            "inclination or azimuth is probably mistyped there",
        )
    severity = np.where(np.diff(depth) >= _NOT_SHORT, angles / np.diff(depth), 0.0)
    i = int(np.argmax(severity))
    if severity[i] <= _SEVERE:
        return None
    return Fault(
        "inclination",
        i + 2,
        Message(
            f"gives a dogleg of {shown.dogleg(severity[i])} between {shown.length.of(depth[i]):.6g} and "
            f"{shown.length.show(depth[i + 1])}, sharper than wells are: a depth or an angle is probably mistyped, or "
            "in another unit; ",
            shown.remedy,
        ),
    )


def _kinked(angles: Floats, inclination: Floats, azimuth: Floats) -> int | None:
    """Return the index of the station without which the path would be straightest, None where none is off it."""
    if inclination.size < 3:
        return None
    around, without = angles[:-1] + angles[1:], doglegs(inclination, azimuth, 2)
    is_off = (np.minimum(angles[:-1], angles[1:]) > _KINK) & (without < _STRAIGHTER * around)
    return int(np.argmax(np.where(is_off, around, 0.0))) + 1 if is_off.any() else None
