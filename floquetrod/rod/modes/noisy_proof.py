"""`Rod.certify` under noise: every load of a box of forces, mode by mode, from the second moments of each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import EPS
from floquetrod._util.progress import Progress
from floquetrod.equations import SecondMoments
from floquetrod.floquet.proof import certify
from floquetrod.floquet.proof.region import RegionProof, RegionStatus, Shares, Side, side_ends
from floquetrod.floquet.proof.region_equation import note_on
from floquetrod.floquet.proof.result import Proof
from floquetrod.rod.loads.load import LIMITS, QUANTITIES, Loads, Quantity, load_number
from floquetrod.rod.mode_equations.noisy_modes import NoisyModes
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.modes.mode_model import ModeModel
from floquetrod.rod.modes.noisy_verdict import ASSUMED

_SECONDS = 30.0  # to spend on one mode at most (a choice)
_ROUNDING = 64.0 * EPS  # relative, of the coefficients of modes

_PROOF_ASSUMED = (
    "coefficients of the modes are computed to within 64 units of rounding, and are affine in the forces",
    "the bound on higher modes is computed in doubles",
)


def certify_noisy(
    model: ModeModel,
    sides: tuple[Any, Any, Any],
    growth_tolerance: float,
    rod: Mapping[str, Any] | None,
    max_boxes: int,
    progress: Progress | None,
) -> RegionProof:
    """Return what is proved in mean square of every load of a box of mean forces and amplitudes at one frequency."""
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    max_boxes = validate.integer("max_boxes", max_boxes, 1)
    validate.progress(progress)
    box = _box(model, sides, rod)
    (low, high), (least, most), (frequency, _) = box
    strongest = model.like.with_numbers(high, most, frequency)
    constants = mode_constants(model.rod)
    last, left_out = model.modes_needed(strongest, tolerance)
    middle = model.like.with_numbers(0.5 * (low + high), 0.5 * (least + most), frequency)
    growth = np.array(model.growth_of_modes(middle, range(1, last + 1)))
    found: list[RegionProof | Proof] = []
    for mode in (np.argsort(-growth, kind="stable") + 1).tolist():  # what is unstable first
        moments = _Moments(NoisyModes(constants, model.like), mode, frequency, tolerance)
        if low == high and least == most:
            found.append(certify(moments(low, least)))
        else:
            sides_of = {"mean": (low, high), "amplitude": (least, most)}
            given: dict[str, Any] = {name: ends if ends[0] < ends[1] else ends[0] for name, ends in sides_of.items()}
            found.append(certify(moments, max_boxes=max_boxes, seconds=_SECONDS, **given))
        if progress is not None:
            progress(len(found), last)
        if found[-1].status != "stable":
            break
    return _together(model, box, found, tolerance, (last, left_out))


def _box(model: ModeModel, sides: tuple[Any, Any, Any], rod: Mapping[str, Any] | None) -> list[tuple[float, float]]:
    """Return the ends of all sides, checked."""
    if rod:
        raise wrong_value("rod", "must be left out under noise: a proof is of one rod, got " + ", ".join(rod))
    ends = [_ends(name, side) for name, side in zip(QUANTITIES, sides, strict=True)]
    if ends[2][0] != ends[2][1]:
        raise wrong_value("frequency", "must be one number under noise: the moments are not affine in it, got a range")
    if isinstance(model.like.noise, tuple) and ends[0][0] != ends[0][1]:
        raise wrong_value("mean", "must be one number where the noise depends on the frequency of modes, got a range")
    if not model.rod.course.is_straight:
        raise wrong_value("rod", "must lie in a straight channel for a proof under noise, got one that bends")
    Loads.of(*(np.array(side) for side in ends))
    return ends


def _ends(name: Quantity, side: Any) -> tuple[float, float]:
    """Return both ends of a side, checked."""
    low, high = side_ends(name, side, lambda at, value: load_number(name, value, at))
    return float(low), float(high)


class _Moments:
    """The second moments of one mode, as a family of mean forces and amplitudes."""

    def __init__(self, modes: NoisyModes, mode: int, frequency: float, tolerance: float) -> None:
        """Take what does not vary; the unit of time is that of the mode under no force."""
        self.modes, self.mode, self.frequency, self.tolerance = modes, mode, frequency, tolerance
        self.unit = 2.0 ** round(math.log2(float(self._parts(0.0, 0.0).rate[0, 0])))

    def _parts(self, mean: float, amplitude: float) -> Any:
        loads = Loads((1,), np.array([mean]), np.array([amplitude]), np.array([self.frequency]))
        return self.modes.parts(loads, [self.mode])

    def __call__(self, mean: float, amplitude: float) -> SecondMoments:
        """Return the moments under one load, less the tolerated growth; what is rounded is in their error."""
        parts = self._parts(mean, amplitude)._replace(unit=self.unit)
        found = parts.moments(np.ones((1, 1), dtype=np.bool_))
        matrices = [m[0] for m in found.every_matrix]
        mean_matrix = matrices[0] - self.tolerance / self.unit * np.eye(3)
        size = max(float(np.abs(m).max()) for m in (*matrices, mean_matrix))
        count = len(found.cosines)
        return SecondMoments(
            mean_matrix,
            matrices[1 : 1 + count],
            matrices[1 + count :],
            period=float(found.period[0]),
            coefficient_error=found.coefficient_error + _ROUNDING * size,
        )


def _together(
    model: ModeModel,
    box: list[tuple[float, float]],
    found: list[RegionProof | Proof],
    tolerance: float,
    modes: tuple[int, float],
) -> RegionProof:
    """Return what follows from the proofs of modes."""
    last, left_out = modes
    ends = (high for _, high in box)
    status: RegionStatus = "undecided"
    if any(proof.status == "unstable" for proof in found):
        status = "unstable"
    elif all(proof.status == "stable" for proof in found) and left_out <= tolerance:
        status = "stable"
    sides = tuple(Side(name, low, high, LIMITS[name].unit) for name, (low, high) in zip(QUANTITIES, box, strict=True))
    shares = Shares(float(status == "stable"), float(status == "unstable"))
    boxes = sum(getattr(proof, "boxes", 1) for proof in found)
    note = note_on(status, shares, boxes)
    if status == "undecided" and left_out > tolerance:
        note = f"higher modes may grow at up to {left_out:.2g} 1/s in mean square"
    return RegionProof(
        subject=model.rod,
        status=status,
        box=sides,
        examples=(),
        growth_tolerance=tolerance,
        growth_unit="1/s",
        modes=last,
        left_out_bound=left_out,
        boxes=boxes,
        shares=shares,
        statement=_stated(status, sides, tolerance),
        note=note,
        assumptions=(*assumptions(model.rod, model.like.with_numbers(*ends)), *ASSUMED, *_PROOF_ASSUMED),
    )


def _stated(status: RegionStatus, sides: tuple[Side, ...], tolerance: float) -> str:
    """Return what was proved, in a sentence."""
    where = ", ".join(map(str, sides))
    grows = f"grows faster than {tolerance:g} 1/s in mean square" if tolerance else "grows in mean square"
    return {
        "stable": f"under every {where} no mode {grows}",
        "unstable": f"under every {where} a mode {grows}",
    }.get(status, f"within {where} nothing is proved of all")
