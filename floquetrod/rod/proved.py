"""A rod with proofs: of boxes of loads and rods, and the largest box about a load that is safe."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from floquetrod.floquet.proof.result import MAX_BOXES
from floquetrod.rod.constants import HAIRLINE_GROWTH
from floquetrod.rod.load import QUANTITIES, AnyLoad, Progress, Quantity
from floquetrod.rod.modal import ModalRod

if TYPE_CHECKING:
    from floquetrod.floquet.proof.region import RegionProof
    from floquetrod.rod.safe_box import SafeBox


@dataclass(frozen=True, init=False, repr=False)
class ProvedRod(ModalRod):
    """A rod with its proofs; `floquetrod.Rod` adds the verdicts."""

    def certify(
        self,
        mean: Any,
        amplitude: Any,
        frequency: Any,
        *,
        growth_tolerance: float = HAIRLINE_GROWTH,
        rod: Mapping[str, Any] | None = None,
        like: AnyLoad | None = None,
        max_boxes: int = MAX_BOXES,
        progress: Progress | None = None,
    ) -> RegionProof:
        """Prove every load of a box stable or unstable, on this rod or on every rod within tolerances.

        Interval arithmetic, rounded outwards, over boxes that are halved until they are decided; all modes, those
        beyond a number by a bound (docs/theory/regions.md).

        Parameters
        ----------
        mean : float or (low, high)
            F_ave in N: a number, or both ends of what it may be.
        amplitude : float or (low, high)
            dF in N, 0 or more: a number, or both ends of what it may be.
        frequency : float or (low, high)
            omega in rad/s, greater than 0: a number, or both ends of what it may be.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.  Without damping no box of positive size can be
            proved stable with 0: thin tongues are everywhere.
        rod : mapping, optional
            Parameters of the rod that vary, by name, each a number or (low, high) in SI units:
            ``{"length": (3.05, 3.15)}``; diameters may be given in place of radii.
        like : AxialLoad, optional
            What everything else of the load is taken from: ``AxialLoad(0, 0, 1, mean_at=None)`` neglects the weight
            along an inclined rod.
        max_boxes : int
            Parts of the box to look at before it is given up.
        progress : callable, optional
            Called with the numbers of parts looked at and of those allowed.

        Returns
        -------
        RegionProof
            "stable": under every load of the box, on every rod, no mode grows faster than the tolerance; "unstable":
            under every one some mode does; "mixed": with a proved example of each; "undecided": with the share of the
            box that was proved.

        Raises
        ------
        ValueError
            For a box whose ends do not increase, that reaches zero frequency, or that holds what is no rod; for modes
            that are coupled; for loads that need more than 20,000 modes.
        TypeError
            For what is no number.

        Examples
        --------
        >>> from floquetrod import Rod
        >>> rod = Rod.nitinol().replace(damping_rate=0.5)
        >>> rod.certify(mean=(0.56, 0.59), amplitude=(0.32, 0.35), frequency=(149.0, 151.0)).status
        'stable'
        """
        from floquetrod.rod.region import certify_rods

        return certify_rods(self, mean, amplitude, frequency, growth_tolerance, rod, like, max_boxes, progress)

    def largest_safe_box(
        self,
        around: AnyLoad,
        *,
        vary: Iterable[Quantity] = QUANTITIES,
        growth_tolerance: float = HAIRLINE_GROWTH,
        rod: Mapping[str, Any] | None = None,
        accuracy: float = 0.01,
        progress: Progress | None = None,
    ) -> SafeBox:
        """Return a box of loads about a working point that is proved safe, and cannot be widened on any one side.

        First the widest window of the same relative width in each quantity; then each side alone is moved outwards,
        in turn, as far as the proof goes.  Forces are searched up to a critical force away, frequencies from half to
        twice.

        Parameters
        ----------
        around : AxialLoad
            The working point.
        vary : iterable of "mean", "amplitude", "frequency"
            Quantities that may vary.
        growth_tolerance : float
            Growth rate in 1/s up to which a mode counts as stable.
        rod : mapping, optional
            Tolerances of the rod, as in `certify`: the box is safe for every rod within them.
        accuracy : float
            How closely sides are found, as a share of the width of the box, 1e-4 to 0.5.
        progress : callable, optional
            Called with the numbers of sides moved and of those to move at most.

        Raises
        ------
        ValueError
            Where the load itself is not proved stable, on every rod within the tolerances; and as `certify` does.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = fr.Rod.nitinol().replace(damping_rate=0.5)
        >>> safe = rod.largest_safe_box(fr.AxialLoad(0.577, 0.339, 150.0), vary=("mean", "frequency"), accuracy=0.1)
        >>> safe.proof.status
        'stable'
        """
        from floquetrod.rod.safe_box import largest_safe_box

        return largest_safe_box(self, around, vary, growth_tolerance, rod, accuracy, progress)
