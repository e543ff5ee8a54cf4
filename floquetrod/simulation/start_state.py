"""The state after a run, from which another run starts: the same rod under other loads."""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod.rod.model.data import RodData
from floquetrod.rod.rod import Rod
from floquetrod.simulation.arithmetic import VERSION
from floquetrod.simulation.start import Perturbation, perturbation_from_dict
from floquetrod.simulation.step_size import TimeSteps

MAY_DIFFER = ("damping_rate", "gravity")
"""Parameters of a rod that another run may change: they act on its motion, and are no part of its state."""

_MESH = ("segments", "poisson_ratio", "indentation", "contact_damping", "natural_curvature")
_SAME_STEP = 1e-12  # by which two steps of one size may differ, relative: they are rounded quotients


@dataclass(frozen=True)
class StartState:
    """The state of a rod after its last step in a run, with what another run needs of that run.

    Attributes
    ----------
    record : bytes
        Record of the rod, with positions half a step ahead of velocities.
    step : float
        Time step of the run in s.
    steps : float
        Time since the rod was first set moving, in these steps.
    angle : float
        Largest angle in rad of any node from rest, over the last quarter of the run.
    buckled : bool
        Whether the rod had buckled.
    perturbation : Perturbation
        What first set the rod moving.
    rod : Rod
    segments : int
    poisson_ratio, indentation, contact_damping : float
    natural_curvature : float or str
    friction : float or tuple
        Those of the run.
    """

    record: bytes
    step: float
    steps: float
    angle: float
    buckled: bool
    perturbation: Perturbation
    rod: Rod
    segments: int
    poisson_ratio: float
    indentation: float
    contact_damping: float
    natural_curvature: float | str
    friction: Any

    @classmethod
    def after(cls, run: Any) -> StartState:
        """Return the state after a `floquetrod.Simulation`; ValueError for a run that has none, or one of old."""
        last, problem, step = run.last_state, run.problem, run.time_steps.size
        if last is None:
            raise validate.wrong_value(
                "start", "has no last state: the run diverged, or an earlier version saved it; simulate it again"
            )
        if last.arithmetic.get("simulator") != str(VERSION):
            raise validate.wrong_value(
                "start",
                f"holds a state of version {last.arithmetic.get('simulator')} of the simulator, must be of version "
                f"{VERSION}; simulate that run again",
            )
        (rod,) = np.frombuffer(last.record.tobytes(), problem.mesh.record_type)
        before = 0.0 if problem.start is None else problem.start.steps_before(step)
        return cls(
            record=last.record.tobytes(),
            step=step,
            steps=before + float(rod["clock"][0]),
            angle=run.outcome.angle,
            buckled=run.buckled,
            **{name: getattr(problem, name) for name in ("perturbation", "rod", "friction", *_MESH)},
        )

    @property
    def time(self) -> float:
        """Time since the rod was first set moving, in s."""
        return self.steps * self.step

    def steps_before(self, step: float) -> float:
        """Return the time of the state in steps of another size in s: a whole number where that is the same."""
        return self.steps if step == self.step else self.steps * self.step / step

    def in_its_step(self, steps: TimeSteps) -> TimeSteps:
        """Return time steps with the size of the state's where they differ by rounding alone."""
        return replace(steps, size=self.step) if math.isclose(steps.size, self.step, rel_tol=_SAME_STEP) else steps

    def require_rod(self, rod: RodData) -> None:
        """Raise ValueError for a rod that is another one."""
        mine, its = rod.as_dict(), self.rod.as_dict()
        other = [name for name in {**its, **mine} if name not in MAY_DIFFER and mine.get(name) != its.get(name)]
        if other:
            self._refuse("of the same rod", other, rod, self.rod)

    def require_mesh(self, problem: Any) -> None:
        """Raise ValueError for a rod that is divided or lies on the wall otherwise."""
        other = [name for name in _MESH if getattr(problem, name) != getattr(self, name)]
        if other:
            self._refuse("with the same options", other, problem, self)
        if len(self.record) != problem.mesh.record_type.itemsize:
            raise ValueError(f"start holds {len(self.record)} bytes, which are no state of {self.segments} segments")

    def _refuse(self, subject: str, names: list[str], mine: Any, its: Any) -> None:
        """Raise ValueError that names what differs."""
        differ = ", ".join(
            f"{name} {validate.short(getattr(its, name))}, not {validate.short(getattr(mine, name))}"
            if name != "path"
            else "another path"
            for name in names
        )
        raise validate.wrong_value(
            "start",
            f"must be a run {subject}, got one with {differ}; load, friction, tool, forces on the ends, "
            f"{' and '.join(MAY_DIFFER)} may differ",
        )

    def __repr__(self) -> str:
        """Return, say, "StartState(after 2 s of motion, 250 segments)"."""
        return f"{type(self).__name__}(after {self.time:.6g} s of motion, {self.segments} segments)"

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, for files, which JSON preserves."""
        values = {part.name: getattr(self, part.name) for part in fields(self)}
        record = base64.b64encode(self.record).decode()
        return values | {"record": record, "rod": self.rod.as_dict(), "perturbation": asdict(self.perturbation)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], friction: Any) -> StartState:
        """Return the state that `as_dict` wrote; ValueError, KeyError or TypeError for anything else.

        ``friction`` is a function that reads a coefficient, or pairs of a depth and a coefficient.
        """
        try:
            record = base64.b64decode(data["record"], validate=True)
        except binascii.Error as error:
            raise ValueError(f"the record of its start is damaged: {error}") from None
        if len(record) % 8 or not np.isfinite(np.frombuffer(record)).all():
            raise ValueError("the record of its start is damaged")
        numbers = {name: validate.nonnegative(name, data[name]) for name in ("steps", "angle")}
        cleaned: dict[str, Any] = numbers | {
            "record": record,
            "step": validate.positive("step", data["step"]),
            "buckled": validate.flag("buckled", data["buckled"]),
            "rod": Rod(**data["rod"]),
            "perturbation": perturbation_from_dict(data["perturbation"]),
            "friction": friction(data["friction"]),
        }
        return cls(**{**data, **cleaned})
