"""The periodic motion of a stable rod that is not straight: how far it moves, where, and its stress."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Printed, Report
from floquetrod.floquet.status import Status
from floquetrod.rod.answers.reports import answer_units, shown_in, subject_lines
from floquetrod.rod.loads.load import Load
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.rod_in_words import section_in_words

_LARGE = math.radians(15.0)  # angle from which finite angles change it by a percent: (0.26 rad)^2 / 6


@dataclass(frozen=True, eq=False, repr=False)
class RodResponse(ByContent, Printed, NoTruthValue):
    """The motion with the period of the load that a natural shape causes, of a rod on its wall; linear in the shape.

    The deflection y is across the channel from its lowest line, in m, the angle y / R about the axis of the channel.
    Of a random shape all sizes are standard deviations.

    Attributes
    ----------
    rod : Rod
    load : AxialLoad or AxialWave
    status : "stable", "unstable" or "undecided"
        Of the rod without its shape: of an unstable one nobody sees this motion.
    largest : float
        Largest deflection in m, at any place and time.
    largest_at : float
        Where, in m from the upper end.
    largest_time : float
        When, in s after the load begins a period.
    error : float
        Estimate of the error of the largest deflection in m: of the harmonics and, where modes are left out, of these.
    angle : float
        Largest angle in rad.
    moment : float
        Largest bending moment in N m.
    stress : float
        Largest stress by bending in Pa, in the outer fibre; the stress of the axial force is not part of it.
    stress_at : float
        Where, in m from the upper end.
    contact : tuple of float or None
        Least and largest contact force in N/m; None of a random shape, and in channels that bend.
    distance : float
        Of 1 from the nearest multiplier of the driven modes: the motion grows without bound as it vanishes.
    positions : ndarray (p,)
        In m from the upper end.
    harmonics : ndarray (patterns, 2 K + 1, p)
        Complex amplitudes in m of exp(i k w t), k from -K to K, of the deflection at the positions; of a random shape
        one pattern for each sine of it, else one.
    modes : int
        Functions in which the motion is written.
    """

    ask = ".largest, in m"

    rod: RodData
    load: Load
    status: Status
    largest: float
    largest_at: float
    largest_time: float
    error: float
    angle: float
    moment: float
    stress: float
    stress_at: float
    contact: tuple[float, float] | None
    distance: float
    positions: Floats
    harmonics: Complexes
    modes: int

    @property
    def is_random(self) -> bool:
        """Whether sizes are standard deviations of a random shape."""
        shape = self.rod.natural_shape
        return shape is not None and shape.is_random

    @property
    def mean(self) -> Floats:
        """Mean deflection in m at the positions; of a random shape its standard deviation."""
        return _together(np.abs(self.harmonics[:, self._middle]) if self.is_random else self.harmonics[:, self._middle])

    @property
    def rms(self) -> Floats:
        """Root mean square of the deflection in m at the positions, over a period."""
        return _together(np.sqrt((np.abs(self.harmonics) ** 2).sum(axis=1)))

    def deflection(self, time: Any) -> Floats:
        """Return the deflection in m at the positions, (..., p); of a random shape its standard deviation.

        Parameters
        ----------
        time : array_like
            In s after the load begins a period.

        Returns
        -------
        ndarray
            (..., p), behind the shape of ``time``, in m.

        Raises
        ------
        TypeError, ValueError
            For times other than finite numbers.
        """
        times = validate.array("time", time)
        turns = np.arange(-self._middle, self._middle + 1) * self.load.frequency
        waves = np.exp(1j * times[..., None] * turns)
        return _together(np.tensordot(waves, self.harmonics, (-1, 1)).real)

    @property
    def _middle(self) -> int:
        return int(self.harmonics.shape[1]) // 2

    def in_words(self, units: Mapping[str, str] | None = None) -> str:
        """Return how far it moves, and where, without a verb.

        Parameters
        ----------
        units : mapping, optional
            Units in which to show lengths: ``{"length": "ft"}``.

        Returns
        -------
        str
            On one line.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        shown = answer_units(shown_in(units, self.rod, self.load))
        size, where = shown.across.show(self.largest, 4), shown.length.show(self.largest_at, 4)
        if self.is_random:
            return f"by a standard deviation of up to {size}, at {where}"
        return f"by up to {size}, {math.degrees(self.angle):.3g} degrees, at {where}"

    def _headline(self, units: Mapping[str, str] | None) -> str:
        unstable = "" if self.status == "stable" else f"; the rod without its shape is {self.status}"
        return f"moves {self.in_words(units)}{unstable}"

    def report(self, units: Mapping[str, str] | None = None) -> Report:
        """Return deflection, bending and contact in lines.

        Parameters
        ----------
        units : mapping, optional
            Units in which to show forces and lengths: ``{"force": "lbf", "length": "ft"}``.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        names = shown_in(units, self.rod, self.load)
        shown = answer_units(names)
        deviation = "standard deviation of " if self.is_random else ""
        bending = shown.pressure
        lines = [
            *subject_lines(self.rod, self.load, names),
            ("error", f"{shown.across.show(self.error, 2)} of the deflection, in {self.modes} modes"),
            (
                "bending",
                f"{deviation}{bending.show(self.stress, 4)} at {shown.length.show(self.stress_at, 4)}"
                + (f", {section_in_words(self.rod, self.stress_at, shown)}" if self.rod.sections else "")
                + f", moment {self.moment:.4g} N m",
            ),
        ]
        if self.contact is not None:
            pressed = shown.per_length
            least, most = (pressed.of(value) for value in self.contact)
            lost = "; lost where it is negative: simulate it" if least < 0.0 else ""
            lines.append(("contact", f"{least:.4g} to {most:.4g} {pressed.name}{lost}"))
        lines.append(("distance", f"{self.distance:.3g} from the nearest multiplier to 1, where motion is infinite"))
        if self.angle > _LARGE:
            lines.append(("note", "small angles are assumed, and this one is large; simulate it"))
        return Report(self._headline(units), lines)

    _keys = (
        "largest_m=largest largest_at_m=largest_at largest_time_s=largest_time error_m=error angle_rad=angle "
        "moment_Nm=moment stress_Pa=stress stress_at_m=stress_at contact_N_per_m=contact distance status modes "
        "is_random"
    )

    def plot(self, ax: Any = None) -> Any:
        """Draw mean and range of the deflection along the rod.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.response_along import draw_rod_response

        return draw_rod_response(self, ax)


def _together(patterns: Any) -> Floats:
    """Return the sum of one pattern, or the root of the sum of squares of several independent ones."""
    patterns = np.asarray(patterns)
    axis = -2
    if patterns.shape[axis] == 1:
        return np.asarray(patterns[..., 0, :].real)
    return np.asarray(np.sqrt((np.abs(patterns) ** 2).sum(axis=axis)))
