"""The path of a well as a value."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Message, error_in
from floquetrod._util.arrays import Floats, shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import TellsAttributes, constructor_hints, level_of_caller
from floquetrod._util.content import ByContent
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod.tables.arguments import column_argument, delimiter_argument
from floquetrod.wells import survey
from floquetrod.wells.minimum_curvature import Points, WellArcs

if TYPE_CHECKING:
    from floquetrod.wells.survey_file import SurveyFile

_ROUNDING = 1e-9  # of a depth, by which it may miss the ends of the path
_PROJECTED = 0.1  # of the length of a survey, beyond which a straight piece is doubted (a choice)
_SHOWN = 40  # stations of a report


@constructor_hints(
    measured_depth="the measured depth is depth",
    md="the measured depth is depth",
    inc="the inclination is inclination",
    azi="the azimuth is azimuth",
)
@dataclass(frozen=True, eq=False, init=False, repr=False)
class WellPath(units.InUnits, Reported, ByContent, TellsAttributes):
    """Path of a well through the stations of a survey, joined by circular arcs: minimum curvature.

    Parameters
    ----------
    depth : array_like (n,)
        Measured depths of the stations, along the well, in m; at least two, increasing.  Elements may be strings with a
        unit, such as "300ft", here and below.
    inclination : array_like (n,) or float
        Inclination from the vertical in rad, 0 straight down, pi/2 horizontal; one number stands for all stations.
    azimuth : array_like (n,) or float
        Direction seen from above in rad, clockwise from north.

    Attributes
    ----------
    depth : ndarray (n,)
        As given, in m; it cannot be written to.
    inclination : ndarray (n,)
        As given, in rad, likewise.
    azimuth : ndarray (n,)
        As given, in rad, likewise.
    note : str
        What was left out of a file, and how it was read.

    Raises
    ------
    TypeError, ValueError
        For stations that make no path; the message names the station, counted from 1.

    Warns
    -----
    PlausibilityWarning
        Of a station that is off the path through its neighbours, doglegs of more than 30 deg/30 m, a well that goes up
        from its first station, and an inclination at the surface beside azimuths that look like inclinations.

    Notes
    -----
    Between stations the path is the arc of a circle that has the directions measured at both ends (Taylor & Mason 1972;
    Zaremba 1973, doi:10.2118/3664-PA).  On a station curvatures are of the interval below it.  A vertical station has
    no azimuth: the given one is not used.

    Examples
    --------
    >>> well = WellPath(["0m", "1000m", "1450m", "3000m"], ["0deg", "0deg", "90deg", "90deg"])
    >>> well
    <well path of 4 stations, 0 to 3000 m, inclination 0 to 90 deg, doglegs up to 6 deg/30 m between 1000 and 1450 m>
    >>> north, east, down = well.position(3000.0)
    >>> round(float(north), 1), round(float(down), 1)
    (1836.5, 1286.5)
    >>> round(well.curvature(1200.0)[0] * 450.0, 6)
    1.570796
    """

    depth: Floats
    inclination: Floats
    azimuth: Floats
    note: ClassVar[str] = ""

    def __init__(self, depth: Any, inclination: Any, azimuth: Any = 0.0) -> None:
        """Check and clean the stations."""
        depths = survey.column("depth", depth)
        angles = survey.column("inclination", inclination, depths.size)
        turns = survey.column("azimuth", azimuth, depths.size)
        self._keep(depths, angles, turns)
        self.given_in(units.GivenUnits.of(length=depth))
        self._check()

    def _keep(self, depth: Floats, inclination: Floats, azimuth: Floats) -> Self:
        """Set the stations."""
        for name, values in (("depth", depth), ("inclination", inclination), ("azimuth", azimuth)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        return self

    def _check(self, read: SurveyFile | None = None, file: str = "") -> None:
        """Raise ValueError for stations that make no path, and warn of probable mistakes.

        Messages about stations that were ``read`` from a file have its lines and units.
        """
        columns = self.depth, self.inclination, self.azimuth
        shown, has_headings, in_degrees = survey.SurveyUnits(self._length), True, False
        if read is not None:
            length, angle = units.unit(read.depth_unit, "", "length"), units.unit(read.angle_unit, "", "angle")
            shown = survey.SurveyUnits(length, angle, of_file=True)
            has_headings, in_degrees = read.has_headings, read.in_degrees
        fault = survey.fault(*columns, shown)
        if fault is not None:
            index = fault.station - 1
            station = fault.station if read is None or not read.stations else read.stations[index]
            error = validate.wrong_value(fault.argument, Message(f"at station {station} ", fault.problem))
            raise error if read is None else error_in(f"{file}line {read.lines[index]}", error)
        doubts = [Message(doubt, SILENCE) for doubt in (() if read is None else read.doubts)]
        for suspicion in survey.suspicions(*columns, shown=shown, has_headings=has_headings, in_degrees=in_degrees):
            index = suspicion.station - 1
            where = f"station {suspicion.station} "
            if read is not None:
                where = f"line {read.lines[index]}: station {read.stations[index]} "
            doubts.append(Message(where, suspicion.problem, SILENCE))
        for doubt in doubts:
            warnings.warn(Message(file, doubt), PlausibilityWarning, stacklevel=level_of_caller())

    @classmethod
    def straight(cls, *, length: Any, inclination: Any, azimuth: Any = 0.0, depth: Any = 0.0) -> Self:
        """Return a straight path, ``depth`` at its upper end.

        Returns
        -------
        WellPath
            Of two stations.

        Raises
        ------
        TypeError, ValueError
            As `arc`.

        Examples
        --------
        >>> WellPath.straight(length=300.0, inclination="60deg").position(300.0).round(6).tolist()
        [259.807621, 0.0, 150.0]
        """
        return cls.arc(length=length, inclination=(inclination, inclination), azimuth=azimuth, depth=depth)

    @classmethod
    def arc(cls, *, length: Any, inclination: Any, azimuth: Any = 0.0, depth: Any = 0.0) -> Self:
        """Return one arc of a circle.

        Parameters
        ----------
        length : float or str
            Along the well, in m.
        inclination : two floats or str
            At the upper and at the lower end, in rad.
        azimuth : float, str or two of them
            In rad; one for a plane path, or two, at both ends.
        depth : float or str
            Measured depth of the upper end in m.

        Returns
        -------
        WellPath
            Of two stations.

        Raises
        ------
        TypeError, ValueError
            For other units, a length that is not positive, and unless there are two inclinations.

        Examples
        --------
        >>> build = WellPath.arc(length=450.0, inclination=("0deg", "90deg"), depth=1000.0)
        >>> round(build.curvature(1100.0)[0], 9)
        0.003490659
        """
        start = units.number("depth", depth, "length")
        extent = validate.within("length", units.number("length", length, "length"), *survey.LENGTHS, "give it in m")
        angles = survey.column("inclination", inclination)
        if angles.size != 2:
            raise validate.wrong_value("inclination", f"must be two, at both ends, got {validate.short(inclination)}")
        arc = cls([start, start + extent], angles, azimuth)
        return arc.given_in(units.GivenUnits.of(length=(length, depth)))

    @classmethod
    def from_csv(
        cls,
        path: str | Path,
        depth: str | int | None = None,
        inclination: str | int | None = None,
        azimuth: str | int | None = None,
        *,
        depth_unit: str | None = None,
        angle_unit: str | None = None,
        delimiter: str | None = None,
        sheet: str | int | None = None,
        to: Any = None,
    ) -> Self:
        """Read a survey from a text file of columns, a log in LAS 2.0 or a workbook; lines with # are comments.

        The text is in UTF-8, in UTF-16 with its mark or, where it cannot be, in Windows-1252.  Lines before the
        headings, which may be in several rows, are passed over; units may stand in the headings or in a line below.
        The table ends at the first line that is no station.  Lost values are empty, ``---``, N/A, -999.25 or the like.
        Instead of inclinations there may be positions: x, y, z or north, east, TVD beside measured depths.

        Parameters
        ----------
        path : path
        depth : str or int, optional
            Heading of its column, or its number from 0.  By default one that surveys usually have, such as MD or
            Measured Depth, in any case; without headings the first column.
        inclination : str or int, optional
            Likewise, such as Inc or INC (deg); without headings the second column.
        azimuth : str or int, optional
            Likewise, such as Azi or AZIMUTH; without headings the third column.  A file of two columns is of a well in
            one plane.
        depth_unit : str, optional
            Unit of the depths, by default that in the heading, as in "MD (ft)"; there is no other default.
        angle_unit : str, optional
            Unit of the angles, by default that in their headings, else deg.
        delimiter : str, optional
            Separator of columns, by default the first of semicolon, tab, comma, bar and space that separates the
            columns of a survey.
        sheet : str or int, optional
            Of a workbook (.xlsx, which needs ``pip install floquetrod[xlsx]``), its name or its number from 0; by
            default the only one that is filled.
        to : float or str, optional
            Measured depth of TD in m, to which the well goes on straight from the last station; see `projected`.

        Returns
        -------
        WellPath
            As `WellPath` of the stations.

        Raises
        ------
        TypeError, ValueError
            For a file that cannot be read, and for stations that make no path; the message names line and station, in
            the units of the file.

        Warns
        -----
        PlausibilityWarning
            As `WellPath`, with the line; of stations left out because a value is missing; of angles taken in degrees
            but probably in radians, unless ``angle_unit`` is given; and of an inclination at the surface below no
            headings, where columns may be in another order.
        """
        from floquetrod.wells.survey_file import read_survey_file

        file = validate.path("path", path)
        wanted = {"depth": depth, "inclination": inclination, "azimuth": azimuth}
        chosen = {name: column_argument(name, choice) for name, choice in wanted.items()}
        given = {"depth": depth_unit, "inclination": angle_unit, "azimuth": angle_unit}
        for unit, argument, kind in ((depth_unit, "depth_unit", "length"), (angle_unit, "angle_unit", "angle")):
            if unit is not None:
                units.unit(unit, argument, kind)
        mark, page = delimiter_argument(delimiter), column_argument("sheet", sheet)
        try:
            stations = read_survey_file(file, chosen, given, mark, page)
        except (OSError, ValueError) as error:
            raise error_in(f"survey {file}", error) from None
        if not stations.lines:
            raise ValueError(f"survey {file}: it holds no stations below its headings")
        well = cls.__new__(cls)._keep(*stations[:3]).given_in(units.GivenUnits(length=stations.depth_unit))
        well._check(stations, f"survey {file}: ")
        object.__setattr__(well, "note", "; ".join(stations.notes))
        return well if to is None else well.projected(to)

    # --- where it lies ---

    @property
    def start(self) -> float:
        """Measured depth of the first station in m."""
        return float(self.depth[0])

    @property
    def end(self) -> float:
        """Measured depth of the last station in m."""
        return float(self.depth[-1])

    @property
    def length(self) -> float:
        """Length between the first and the last station in m."""
        return self.end - self.start

    @property
    def stations(self) -> Floats:
        """Measured depths in m at which curvature may jump; integrate from one to the next."""
        return self.depth

    def position(self, depth: Any) -> Floats:
        """Return north, east and true vertical depth in m from the first station, (..., 3), at measured depths.

        Returns
        -------
        ndarray
            (..., 3), in m.

        Raises
        ------
        TypeError, ValueError
            For depths beyond the ends of the path, and for other units.
        """
        shape, points = self._points(depth)
        return np.asarray((self._corners[points.arc] + points.moved).reshape(*shape, 3))

    def inclination_at(self, depth: Any) -> Any:
        """Return the inclination from the vertical in rad at measured depths in m.

        Returns
        -------
        float or ndarray
            In rad, in the shape of ``depth``.

        Raises
        ------
        TypeError, ValueError
            For depths beyond the ends of the path, and for other units.
        """
        shape, points = self._points(depth)
        return shaped(points.inclination, shape)

    def azimuth_at(self, depth: Any) -> Any:
        """Return the azimuth in rad at measured depths in m.

        Returns
        -------
        float or ndarray
            In rad, in the shape of ``depth``.

        Raises
        ------
        TypeError, ValueError
            For depths beyond the ends of the path, and for other units.
        """
        shape, points = self._points(depth)
        return shaped(points.azimuth, shape)

    def curvature(self, depth: Any) -> tuple[Any, Any]:
        """Return the curvatures kappa_n and kappa_b in 1/m at measured depths in m.

        With inclination phi and azimuth psi, kappa_n = d phi / ds in the vertical plane, positive where the well
        builds, and kappa_b = sin(phi) d psi / ds sideways; on a station of the interval below it.

        Returns
        -------
        tuple of two floats or ndarrays
            kappa_n and kappa_b in 1/m, in the shape of ``depth``.

        Raises
        ------
        TypeError, ValueError
            For depths beyond the ends of the path, and for other units.
        """
        shape, points = self._points(depth)
        build, side = points.curvature
        return shaped(build, shape), shaped(side, shape)

    @property
    def dogleg_severity(self) -> Floats:
        """Curvature of each interval in deg/30 m, (n - 1,)."""
        return np.degrees(30.0 * self.arcs.curvature)

    def part(self, start: Any, end: Any) -> Self:
        """Return the part of the path between two measured depths in m; depths stay the same.

        Returns
        -------
        WellPath
            With a station at both ends.

        Raises
        ------
        TypeError, ValueError
            For depths beyond the ends of the path, and unless the end lies below the start.
        """
        ends = np.array(
            [
                self._inside(np.array([units.number(name, value, "length")]), name)[0]
                for name, value in (("start", start), ("end", end))
            ]
        )
        if not ends[0] < ends[1]:
            raise validate.wrong_value("end", f"must lie below start = {ends[0]:g} m, got {ends[1]:g} m")
        points = self.arcs.at(ends)
        between = (self.depth > ends[0]) & (self.depth < ends[1])
        kept = (
            np.concatenate([cut[:1], whole[between], cut[1:]])
            for cut, whole in (
                (ends, self.depth),
                (points.inclination, self.inclination),
                (points.azimuth, self.azimuth),
            )
        )
        return type(self).__new__(type(self))._keep(*kept).given_in(self.given_units)

    def projected(self, to: Any) -> Self:
        """Return the path with a straight piece from its last station to a measured depth, such as TD.

        Parameters
        ----------
        to : float or str
            In m, below the last station.

        Returns
        -------
        WellPath
            With one more station; its ``note`` says so.

        Raises
        ------
        TypeError, ValueError
            For a depth that does not lie below the last station, and for other units.

        Warns
        -----
        PlausibilityWarning
            Of a straight piece longer than a tenth of the survey.

        Examples
        --------
        >>> well = WellPath([0.0, 1000.0, 1450.0], ["0deg", "0deg", "90deg"])
        >>> well.projected("1500m").report().lines[-1]
        ('note', 'projected straight from 1450 to 1500 m')
        """
        depth = units.number("to", to, "length")
        length = self._length
        if not self.end < depth <= survey.DEEPEST:
            raise validate.wrong_value(
                "to", f"must lie below the last station at {length.show(self.end)}, got {length.show(depth)}"
            )
        columns = (
            np.append(values, last)
            for values, last in zip(
                (self.depth, self.inclination, self.azimuth),
                (depth, self.inclination[-1], self.azimuth[-1]),
                strict=True,
            )
        )
        path = type(self).__new__(type(self))._keep(*columns).given_in(self.given_units)
        note = f"projected straight from {length.of(self.end):.6g} to {length.show(depth)}"
        share = (depth - self.end) / (self.end - self.start)
        if share > _PROJECTED:
            text = f"to = {length.show(depth)} is {length.show(depth - self.end, 4)} straight on below the last station"
            more = f"{100.0 * share:.0f} % of the survey's length: is that its unit?"
            warnings.warn(Message(f"{text}, {more}", SILENCE), PlausibilityWarning, stacklevel=level_of_caller())
        object.__setattr__(path, "note", "; ".join(filter(None, [self.note, note])))
        return path

    def with_errors(self, inclination: Any = 0.0, azimuth: Any = 0.0) -> Self:
        """Return the path with errors added to the angles measured at its stations.

        Parameters
        ----------
        inclination : float, str or array_like (n,)
            In rad, or strings with a unit such as "0.2deg": one for all stations, or of each station its own.  An
            inclination beyond the vertical continues on its other side, with the azimuth reversed.
        azimuth : float, str or array_like (n,)
            Likewise; of any size, as directions repeat after a turn.

        Returns
        -------
        WellPath
            Of the same depths.

        Raises
        ------
        TypeError, ValueError
            For values other than angles, and where the path then reverses its direction between two stations.

        Examples
        --------
        >>> build = WellPath([1000.0, 1450.0], ["0deg", "90deg"])
        >>> build.with_errors("-0.5deg").position(1450.0).round(1).tolist()
        [284.0, 0.0, 289.0]
        """
        errors = [
            survey.column(name, given, self.depth.size)
            for name, given in (("inclination", inclination), ("azimuth", azimuth))
        ]
        columns = survey.within(self.inclination + errors[0], self.azimuth + errors[1])
        fault = survey.fault(self.depth, *columns)
        if fault is not None:
            raise validate.wrong_value(fault.argument, f"at station {fault.station} {fault.problem}")
        return type(self).__new__(type(self))._keep(self.depth.copy(), *columns).given_in(self.given_units)

    # --- in words and numbers ---

    def __repr__(self) -> str:
        """Return stations, depths, inclinations and doglegs as a sentence, in the unit of depth they were given in."""
        return f"<{self.in_words(self._length)}>"

    @property
    def _length(self) -> units.Unit:
        """The unit of lengths in which the path is shown."""
        return units.AnswerUnits.named(given=self.given_units).length

    def in_words(self, length: units.Unit) -> str:
        """Return stations, depths, inclinations and doglegs in words, lengths in a unit.

        Returns
        -------
        str
            On one line.
        """
        lowest, highest = np.degrees([self.inclination.min(), self.inclination.max()])
        angles = f"{lowest:.4g}" if lowest == highest else f"{lowest:.4g} to {highest:.4g}"
        doglegs, per = self._doglegs(length)
        i = int(np.argmax(doglegs))
        ends = f"{length.of(self.depth[i]):.6g} and {length.show(self.depth[i + 1])}"
        where = f" between {ends}" if doglegs.size > 1 and doglegs[i] > 0.0 else ""
        return (
            f"well path of {self.depth.size} stations, {length.of(self.start):.6g} to {length.show(self.end)}, "
            f"inclination {angles} deg, doglegs up to {doglegs.max():.3g} {per}{where}"
        )

    def _doglegs(self, length: units.Unit) -> tuple[Floats, str]:
        """Return the curvature of each interval beside lengths in a unit, and its own unit."""
        if length.name in ("ft", "ftUS", "in"):
            return 1.016 * self.dogleg_severity, "deg/100 ft"
        return self.dogleg_severity, "deg/30 m"

    def report(self) -> Report:
        """Return the path in words and its stations as a table.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        length = self._length
        bends, per = self._doglegs(length)
        severity = ["", *(f"{row:.2f}" for row in bends)]
        columns = [(f"{name} {length.name}", ">9") for name in ("depth", "TVD", "north", "east")]
        columns[1:1] = [("inc deg", ">8"), ("azi deg", ">8")]
        numbers = zip(
            length.of(self.depth),
            np.degrees(self.inclination),
            np.degrees(self.azimuth),
            *length.of(self._corners[:, [2, 0, 1]]).T,
            strict=True,
        )
        rows = [[*(f"{x:.2f}" for x in row), bend] for row, bend in zip(numbers, severity, strict=True)]
        rest = f"and {len(rows) - _SHOWN} more stations" if len(rows) > _SHOWN else ""
        table = Table((*columns, (per, f">{len(per)}")), rows[:_SHOWN], rest)
        start = f"the string begins at {length.show(self.start)}, the first station"
        lines = [("start", start)] if self.start > 0.0 else []
        return Report(self.in_words(length), [*lines, *([("note", self.note)] if self.note else [])], table)

    def as_dict(self) -> dict[str, list[float]]:
        """Return the stations in m and rad, the arguments of an equal path.

        Returns
        -------
        dict of str to list of float
            ``depth`` in m, ``inclination`` and ``azimuth`` in rad.
        """
        return {name: getattr(self, name).tolist() for name in ("depth", "inclination", "azimuth")}

    # --- arcs ---

    @cached_property
    def arcs(self) -> WellArcs:
        """The arcs between stations."""
        return WellArcs.between(self.depth, self.inclination, self.azimuth)

    @cached_property
    def _corners(self) -> Floats:
        """Positions of the stations, (n, 3)."""
        arcs = self.arcs
        chords = Points(arcs, np.arange(arcs.length.size), arcs.length).moved
        return np.concatenate([np.zeros((1, 3)), np.cumsum(chords, axis=0)])

    def _points(self, depth: Any) -> tuple[tuple[int, ...], Points]:
        """Return the shape of measured depths and the points there, flat."""
        depths = units.array("depth", depth, "length", -validate.LARGEST, validate.LARGEST)
        return depths.shape, self.arcs.at(self._inside(depths.ravel()))

    def _inside(self, depths: Floats, name: str = "depth") -> Floats:
        """Return depths, checked to lie on the path, to rounding; ValueError names the first outside."""
        room = _ROUNDING * max(self.end, self.length)
        outside = (depths < self.start - room) | (depths > self.end + room)
        if outside.any():
            raise validate.wrong_value(
                name, f"must lie between {self.start:g} and {self.end:g} m, got {depths[outside][0]:g} m"
            )
        return np.clip(depths, self.start, self.end)
