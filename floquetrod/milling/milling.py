"""A milling cutter as people ask about it: verdicts, critical depths and stability lobes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from floquetrod._util import validate
from floquetrod._util.progress import Progress
from floquetrod.milling import stability_lobes
from floquetrod.milling.cutter import Cutter, read_depth, read_speed
from floquetrod.milling.stability_lobes import Lobes
from floquetrod.milling.tool_file import read_tool


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Milling(Cutter):
    """A cutter, fed along x, whose tip vibrates in modes along x and y.

    The chip of a tooth at the angle phi from y has a thickness given by the feed and by the tip's vibration now, q(t),
    and one tooth earlier, q(t - tau); its force is depth times (tangential, radial) times that.  About the periodic
    motion

        M q'' + C q' + K q = -depth H(t) (q(t) - q(t - tau)),   tau = 2 pi / (teeth speed),

    with H of period tau, zero where no tooth is within the immersion.  That is of teeth evenly spaced, straight and of
    one length.  Of others it is depth sum_j H_j(t) (q(t) - q(t - tau_j)), of a term for each time since the surface
    was left that a tooth cuts: the pitch before it, or of a tooth behind one that stood out several; the period is the
    time until teeth repeat.  The edge of a helical tooth lags behind its tip, and H_j is the mean over it.

    Parameters
    ----------
    x : sequence of ToolMode
        Modes along the feed; at least one in all.
    y : sequence of ToolMode
        Modes across it.
    teeth : int
        Number of teeth, 1 to 64.
    tangential : str or float
        Cutting coefficient of the force against the tooth's motion, such as "600N/mm2" or "600MPa"; a number is in Pa.
    radial : str or float
        That of the force away from the chip, likewise.
    immersion : str or float
        Width of cut as a fraction of the cutter's diameter, above 0 and up to 1, a slot.
    direction : {"up", "down"}
        Whether a tooth enters where the chip is thin ("up") or thick; of a slot it does not matter.
    pitch : sequence of str or float
        Angle from each tooth to the one that cuts before it, such as ["70deg", "110deg", "70deg", "110deg"], which add
        up to 360 degrees within 0.001; numbers are in rad.  By default all are equal.
    helix : str or float
        Helix angle, of either hand, such as "30deg", up to 80 degrees; a number is in rad.  0, straight teeth, by
        default.
    diameter : str or float, optional
        Of the cutter, such as "12mm"; a number is in m.  Needed with a helix.
    runout : sequence of str or float
        Radius of each tooth, as measured from any zero, in the order of ``pitch``, such as ["0um", "10um"]; numbers
        are in m.  By default all are equal.
    feed_per_tooth : str or float, optional
        Feed between two teeth on average, such as "0.1mm"; a number is in m.  Needed with runout: where a tooth stands
        back by more than the chip it cuts nothing, and the next one cuts what two pitches left.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges or in other units, without a mode, and where pitches do not add up to a
        turn.

    Examples
    --------
    >>> from floquetrod import ToolMode
    >>> slot = Milling(x=[ToolMode("922Hz", 0.011, "39.93g")], teeth=2, tangential="600MPa", radial="200MPa")
    >>> slot.stability("5000rpm", "0.5mm").status
    'unstable'
    >>> f"{1000.0 * slot.critical_depth('5000rpm'):.5f} mm"
    '0.40863 mm'
    """

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Return the cutter of a TOML file: a table [tool] with the parameters, [[tool.x]] and [[tool.y]] with modes.

        Keys are names of the parameters, of a mode as in `ToolMode`; ``speed`` and ``depth``, ranges for the lobes,
        are for the terminal.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Milling
            The cutter.

        Raises
        ------
        ValueError
            For a file that cannot be read; the message names file and key.
        """
        given = read_tool(path).arguments
        try:
            return cls(**given)
        except TypeError as error:
            raise ValueError(f"tool file {path}: {error}") from None

    def critical_depth(self, speed: Any, most: Any = None) -> float:
        """Return the least depth of cut, in m, at which chatter begins, infinite where none is up to ``most``.

        Depths are tried in steps of about a quarter of the smallest one that chatters at any speed, so that a narrower
        range of chatter may be missed.  The relative error of the depth is below 1e-8: over cutters drawn at random it
        was at most 2e-9.

        Parameters
        ----------
        speed : str or float
            As of `system`; the tool may vibrate up to 120 times between two teeth.
        most : str or float, optional
            Depth up to which is searched; by default fifty times that smallest one, and 500 times at most.

        Returns
        -------
        float
            In m.

        Raises
        ------
        TypeError, ValueError
            For another unit, and for a speed or depth out of range.
        """
        limit = None if most is None else read_depth(most, "most")
        return float(stability_lobes.critical_depths(self, np.array([read_speed(speed)]), limit)[0])

    def lobes(self, speed: Any, depth: Any, *, growth: bool = False, progress: Progress | None = None) -> Lobes:
        """Return the stability lobes: the chart of spindle speed and depth of cut, and the kind of each lobe.

        Parameters
        ----------
        speed : (low, high, number)
            Ends with units as of `critical_depth`: ("5000rpm", "10000rpm", 400).
        depth : (low, high, number)
            Likewise: ("0mm", "4mm", 200).
        growth : bool
            Whether to keep growth rates, in 1/s, too, which takes several times as long.
        progress : callable, optional
            Called with the numbers of hundredths done and of all, 100: of the chart, then of the search for its lobes.
            An exception that it raises ends the work.

        Returns
        -------
        Lobes
            Chart, critical depths and lobes by name.

        Raises
        ------
        TypeError, ValueError
            For ranges that do not increase, and for other units.

        Examples
        --------
        >>> from floquetrod import ToolMode
        >>> slot = Milling(x=[ToolMode("922Hz", 0.011, "39.93g")], teeth=2, tangential="600MPa", radial="200MPa")
        >>> found = slot.lobes(("8000rpm", "10000rpm", 12), ("0mm", "4mm", 10))
        >>> print(found.chart.x.unit, found.chart.y.unit)
        rpm mm
        """
        growth = validate.flag("growth", growth)
        validate.progress(progress)
        return stability_lobes.lobes_of(self, speed, depth, growth=growth, progress=progress)
