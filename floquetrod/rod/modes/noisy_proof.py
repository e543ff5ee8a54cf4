"""`Rod.certify` under noise: every load of a box of forces, mode by mode, from the second moments of each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import EPS
from floquetrod._util.progress import Progress
from floquetrod.equations import SecondMoments
from floquetrod.floquet.proof import certify
from floquetrod.floquet.proof.proof import Proof
from floquetrod.floquet.proof.region_equation import note_on
from floquetrod.floquet.proof.region_proof import RegionProof, RegionStatus, Shares, Side, side_ends
from floquetrod.floquet.status import STABLE, UNSTABLE
from floquetrod.rod.answers.rod_box import RodExample
from floquetrod.rod.loads.load import LOAD, QUANTITIES, Loads, Quantity, load_number
from floquetrod.rod.mode_equations.noisy_equations import ASSUMED, NoisyModes
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.modes.mode_model import ModeModel

_SECONDS = 30.0  # to spend on one mode at most (a choice)
_PLACES = 9  # along each side of a box at which verdicts tell where to prove examples (a choice)
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
    """Return the proof in mean square for every load of a box of mean forces and amplitudes at one frequency."""
    # The box is (mean, amplitude, frequency), the last a number.  Modes 1 to ``last`` may grow under its strongest
    # load; all others grow by ``left_out`` at most.  First examples: one load stable and one unstable decide "mixed"
    # without a proof.  Then one proof a mode, in the order of growth at the middle of the box, since the first that is
    # not stable ends it.
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    max_boxes = validate.integer("max_boxes", max_boxes, 1)
    validate.progress(progress)
    box = _box(model, sides, rod)
    (low, high), (smallest, largest), (frequency, _) = box
    strongest = model.template.with_numbers(high, largest, frequency)
    constants = mode_constants(model.rod)
    last, left_out = model.modes_needed(strongest, tolerance)
    modes = [_Moments(NoisyModes(constants, model.template), m, frequency, tolerance) for m in range(1, last + 1)]
    is_point = low == high and smallest == largest
    examples = () if is_point else _examples(model, box, modes, (tolerance, left_out))
    proofs: list[RegionProof | Proof] = []
    if len(examples) == 2:
        return _together(model, box, proofs, examples, tolerance, (last, left_out))
    middle = model.template.with_numbers(0.5 * (low + high), 0.5 * (smallest + largest), frequency)
    growth = np.array(model.growth_of_modes(middle, range(1, last + 1)))
    for i in np.argsort(-growth, kind="stable").tolist():  # what is unstable first
        moments = modes[i]
        if is_point:
            proofs.append(certify(moments(low, smallest)))
        else:
            sides_of = {"mean": (low, high), "amplitude": (smallest, largest)}
            given: dict[str, Any] = {name: ends if ends[0] < ends[1] else ends[0] for name, ends in sides_of.items()}
            proofs.append(certify(moments, max_boxes=max_boxes, seconds=_SECONDS, **given))
        if progress is not None:
            progress(len(proofs), last)
        if proofs[-1].status != "stable":
            break
    return _together(model, box, proofs, examples, tolerance, (last, left_out))


def _box(model: ModeModel, sides: tuple[Any, Any, Any], rod: Mapping[str, Any] | None) -> list[tuple[float, float]]:
    """Return the ends of all sides, checked."""
    if rod:
        raise wrong_value("rod", "must be left out under noise: a proof is of one rod, got " + ", ".join(rod))
    ends = [_ends(name, side) for name, side in zip(QUANTITIES, sides, strict=True)]
    if ends[2][0] != ends[2][1]:
        raise wrong_value("frequency", "must be one number under noise: the moments are not affine in it, got a range")
    if isinstance(model.template.noise, tuple) and ends[0][0] != ends[0][1]:
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
        """Take the fixed arguments; the unit of time is the mode's under no force."""
        self.modes, self.mode, self.frequency, self.tolerance = modes, mode, frequency, tolerance
        self.unit = 2.0 ** round(math.log2(float(self._parts(0.0, 0.0).rate[0, 0])))

    def _parts(self, mean: float, amplitude: float) -> Any:
        loads = Loads((1,), np.array([mean]), np.array([amplitude]), np.array([self.frequency]))
        return self.modes.without_drift(loads, [self.mode])

    def __call__(self, mean: float, amplitude: float) -> SecondMoments:
        """Return the moments under one load, less the tolerated growth; their error holds the rounding."""
        parts = self._parts(mean, amplitude)._replace(unit=self.unit)
        moments = parts.moments(np.ones((1, 1), dtype=np.bool_))
        matrices = [m[0] for m in moments.every_matrix]
        mean_matrix = matrices[0] - self.tolerance / self.unit * np.eye(3)
        size = max(float(np.abs(m).max()) for m in (*matrices, mean_matrix))
        count = len(moments.cosines)
        return SecondMoments(
            mean_matrix,
            matrices[1 : 1 + count],
            matrices[1 + count :],
            period=float(moments.period[0]),
            coefficient_error=moments.coefficient_error + _ROUNDING * size,
        )


def _examples(
    model: ModeModel, box: list[tuple[float, float]], modes: Sequence[_Moments], limits: tuple[float, float]
) -> tuple[RodExample, ...]:
    """Return a load of the box that is proved stable and one proved unstable, where samples show both."""
    tolerance, left_out = limits
    sides = (np.linspace(low, high, _PLACES if low < high else 1) for low, high in box[:2])
    mean, amplitude = (grid.ravel() for grid in np.meshgrid(*sides))
    status, growth, fastest = model.answers(Loads.of(mean, amplitude, box[2][0]), tolerance)
    worst = int(np.nan_to_num(growth).argmax())
    quiet = np.flatnonzero(status == STABLE)
    if not quiet.size or status[worst] != UNSTABLE or fastest[worst] < 1:
        return ()
    farthest = int(quiet[np.abs(quiet - worst).argmax()])
    rest = f"every higher mode grows at less than {left_out:.2g} 1/s" if left_out > 0.0 else "no higher mode grows"
    limit, examples = f"{tolerance:g} 1/s in mean square", []
    for i, kind, chosen, statement in (
        (farthest, "stable", modes, f"modes 1 to {len(modes)} grow at no more than {limit}, {rest}"),
        (worst, "unstable", [modes[fastest[worst] - 1]], f"mode {fastest[worst]} grows faster than {limit}"),
    ):
        at = float(mean[i]), float(amplitude[i])
        is_known = kind == "unstable" or left_out <= tolerance
        if is_known and all(certify(moments(*at)).status == kind for moments in chosen):
            examples.append(RodExample(kind, model.template.with_numbers(*at, box[2][0]), model.rod, statement))
    return tuple(examples)


def _together(
    model: ModeModel,
    box: list[tuple[float, float]],
    proofs: list[RegionProof | Proof],
    examples: tuple[RodExample, ...],
    tolerance: float,
    modes: tuple[int, float],
) -> RegionProof:
    """Return the proof for all modes that follows from the proofs of modes."""
    last, left_out = modes
    ends = (high for _, high in box)
    status: RegionStatus = "undecided"
    if len(examples) == 2:
        status = "mixed"
    elif any(proof.status == "unstable" for proof in proofs):
        status = "unstable"
    elif all(proof.status == "stable" for proof in proofs) and left_out <= tolerance:
        status = "stable"
    sides = tuple(Side(name, low, high, LOAD[name].unit) for name, (low, high) in zip(QUANTITIES, box, strict=True))
    growing = max((proof.shares.unstable for proof in proofs if isinstance(proof, RegionProof)), default=0.0)
    shares = Shares(0.0, growing).with_status(status)
    boxes = len(examples) + sum(getattr(proof, "boxes", 1) for proof in proofs)
    note = note_on(status, shares, boxes)
    if status == "undecided" and left_out > tolerance:
        note = f"higher modes may grow at up to {left_out:.2g} 1/s in mean square"
    return RegionProof(
        subject=model.rod,
        status=status,
        box=sides,
        examples=examples if status in ("mixed", "undecided") else (),
        growth_tolerance=tolerance,
        growth_unit="1/s",
        modes=last,
        left_out_bound=left_out,
        boxes=boxes,
        shares=shares,
        statement=_stated(status, sides, tolerance),
        note=note,
        assumptions=(*assumptions(model.rod, model.template.with_numbers(*ends)), *ASSUMED, *_PROOF_ASSUMED),
    )


def _stated(status: RegionStatus, sides: tuple[Side, ...], tolerance: float) -> str:
    """Return the statement that was proved, in a sentence."""
    where = ", ".join(map(str, sides))
    grows = f"grows faster than {tolerance:g} 1/s in mean square" if tolerance else "grows in mean square"
    return {
        "stable": f"under every {where} no mode {grows}",
        "unstable": f"under every {where} a mode {grows}",
        "mixed": f"within {where} under some loads a mode {grows}, under some none",
    }.get(status, f"within {where} nothing is proved of all")
