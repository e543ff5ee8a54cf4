"""How a simulated rod is set moving: speeds across the channel, by mode or node by node at random."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod.units import with_unit

LEAST_SEGMENTS = 6  # segments in half a wave, with which its bending stiffness is 5 % low (a choice)
SEGMENTS_TO_SEE = 2  # in half a wave, for a mode to be told from others by its nodes (a choice)
MOST_SEGMENTS = 100_000  # of a rod: 40 MB of state, and steps of which a second of motion takes ever more
_HIGHEST = MOST_SEGMENTS // LEAST_SEGMENTS  # mode that any simulated rod can carry
_FASTEST = 1e5  # m/s: no solid carries sound faster


@dataclass(frozen=True)
class Perturbation:
    """Speeds across the channel at the start of a simulation; perturbations add up with ``+``.

    Attributes
    ----------
    speeds : tuple of (int, float)
        (mode m, speed in m/s): adds speed * sin(m pi s / L).
    noises : tuple of (float, int)
        (speed in m/s, seed): adds to every inner node its own speed, uniform in [-speed, speed].

    Raises
    ------
    TypeError, ValueError
        For modes and seeds that are no whole numbers, and speeds that are not finite.

    Notes
    -----
    The cases A to D of DOI 10.1115/1.4031710 come from `Perturbation.case`.

    Examples
    --------
    >>> kick = Perturbation.modes({8: 0.05}) + Perturbation.random(1e-3, seed=1)
    >>> kick.velocities(250).shape
    (251,)
    """

    speeds: tuple[tuple[int, float], ...] = ()
    noises: tuple[tuple[float, int], ...] = ()

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        speeds = tuple(
            (
                _mode(f"speeds: mode {validate.short(mode)}", mode),
                _speed(f"speeds: speed of mode {validate.short(mode)}", speed),
            )
            for mode, speed in _pairs("speeds", self.speeds, "((8, 0.05),)")
        )
        noises = tuple(
            (
                validate.nonnegative("speed", _speed("noises: speed", speed), "in m/s"),
                validate.integer("noises: seed", seed, 0),
            )
            for speed, seed in _pairs("noises", self.noises, "((0.05, 1),)")
        )
        object.__setattr__(self, "speeds", speeds)
        object.__setattr__(self, "noises", noises)

    @classmethod
    def modes(cls, speeds: Mapping[int, float]) -> Perturbation:
        """Return the sum of modes: {mode: speed in m/s}.

        Returns
        -------
        Perturbation
            The sum.

        Raises
        ------
        TypeError, ValueError
            For anything but a mapping of whole numbers from 1 to speeds.

        Examples
        --------
        >>> Perturbation.modes({8: 0.05}).highest_mode
        8
        """
        if not isinstance(speeds, Mapping):
            raise validate.wrong_type(
                "speeds", f"must map modes to speeds in m/s such as {{8: 0.05}}, got {validate.short(speeds)}"
            )
        return cls(speeds=tuple(speeds.items()))

    @classmethod
    def random(cls, speed: float, seed: int) -> Perturbation:
        """Return a perturbation that gives every inner node its own speed, uniform in [-speed, speed] m/s.

        Returns
        -------
        Perturbation
            The same for the same seed.

        Raises
        ------
        TypeError, ValueError
            For a speed that is not finite, and a seed that is no whole number from 0.
        """
        return cls(noises=((speed, seed),))

    @classmethod
    def case(cls, name: str, speed: float = 0.05, mode: int = 8, seed: int = 1, highest: int = 20) -> Perturbation:
        """Return a perturbation of the paper's friction runs (section 4.3 of DOI 10.1115/1.4031710).

        Parameters
        ----------
        name : {"A", "B", "C", "D"}
            A: one mode.  B: modes 4, 6, 8 and 10 together.  C: one mode, and every other one up to ``highest`` with its
            own speed, uniform in [-speed, speed].  D: every node its own speed, uniform in [-speed, speed].
        speed : float
            v_0 in m/s.
        mode : int
            The mode of A and C.
        seed : int
            Of C and D.
        highest : int
            The last mode of C, which the paper does not state.

        Returns
        -------
        Perturbation
            The case.

        Raises
        ------
        TypeError, ValueError
            For another name, and for numbers as in `modes` and `random`.
        """
        name = validate.choice("name", name, tuple("ABCD"))
        speed, mode, seed = _speed("speed", speed), _mode("mode", mode), validate.integer("seed", seed, 0)
        highest = _mode("highest", highest)
        if name == "A":
            return cls.modes({mode: speed})
        if name == "B":
            return cls.modes(dict.fromkeys((4, 6, 8, 10), speed))
        if name == "D":
            return cls.random(speed, seed)
        highest = validate.integer("highest", highest, mode)
        drawn = np.random.default_rng(seed).uniform(-abs(speed), abs(speed), highest)
        return cls.modes({k: speed if k == mode else float(drawn[k - 1]) for k in range(1, highest + 1)})

    def __str__(self) -> str:
        """Return, say, "8 mm/s in mode 3, random speeds up to 1 mm/s (seed 1)"."""
        modes = [f"{with_unit(1e3 * speed, 'mm/s', 3)} in mode {mode}" for mode, speed in self.speeds]
        if len(modes) > 4:
            strongest = max(self.speeds, key=lambda pair: abs(pair[1]))
            most = with_unit(1e3 * strongest[1], "mm/s", 3)
            modes = [f"{len(modes)} modes kicked, mode {strongest[0]} most, by {most}"]
        noises = [
            f"random speeds up to {with_unit(1e3 * speed, 'mm/s', 3)} (seed {seed})" for speed, seed in self.noises
        ]
        return ", ".join([*modes, *noises]) or "no perturbation"

    def __add__(self, other: Perturbation) -> Perturbation:
        """Return both at once."""
        if not isinstance(other, Perturbation):
            return NotImplemented
        return Perturbation(self.speeds + other.speeds, self.noises + other.noises)

    @property
    def highest_mode(self) -> int:
        """The highest mode it names, 0 for none."""
        return max((mode for mode, _ in self.speeds), default=0)

    def velocities(self, segments: int) -> NDArray[np.float64]:
        """Return the speed across the channel of every node of a rod of so many segments, in m/s; held ends rest.

        Returns
        -------
        ndarray
            (segments + 1,), in m/s.

        Raises
        ------
        TypeError, ValueError
            For fewer segments than 2, and where a mode has fewer than 6 segments in half a wave.
        """
        segments = validate.integer("segments", segments, 2)
        if segments > MOST_SEGMENTS:
            raise validate.wrong_value("segments", f"must be at most {MOST_SEGMENTS:,}, got {segments:,}; take fewer")
        if self.highest_mode * LEAST_SEGMENTS > segments:
            raise validate.wrong_value(
                "perturbation",
                f"names mode {self.highest_mode}, which {segments} segments cannot resolve: it needs at "
                f"least {LEAST_SEGMENTS * self.highest_mode}, {LEAST_SEGMENTS} for every half wave",
            )
        place = np.arange(1, segments) * (math.pi / segments)
        total = np.zeros(segments + 1)
        for mode, speed in self.speeds:
            total[1:-1] += speed * np.sin(mode * place)
        for speed, seed in self.noises:
            total[1:-1] += np.random.default_rng(seed).uniform(-speed, speed, segments - 1)
        return total


def perturbation_from_dict(data: Mapping[str, Any]) -> Perturbation:
    """Return the perturbation that a file holds; ValueError, KeyError or TypeError for anything else."""
    return Perturbation(*(tuple((a, b) for a, b in data[name]) for name in ("speeds", "noises")))


def _pairs(name: str, values: Any, example: str) -> list[tuple[Any, Any]]:
    """Return a sequence of pairs as a list."""
    pairs = []
    for value in validate.sequence(name, values, example):
        try:
            first, second = value
        except Exception:  # no pair, or whatever an object raises when asked for its parts
            raise validate.wrong_type(
                name, f"must be a sequence of pairs such as {example}, got {validate.short(value)} in it"
            ) from None
        pairs.append((first, second))
    return pairs


def _mode(name: str, value: int) -> int:
    """Return the number of a mode that a simulated rod can carry."""
    mode = validate.integer(name, value, 1)
    if mode > _HIGHEST:
        raise validate.wrong_value(name, f"must be at most {_HIGHEST:,}, which takes {MOST_SEGMENTS:,} segments")
    return mode


def _speed(name: str, value: float) -> float:
    """Return a speed of plausible size."""
    speed = units.number(name, value, "speed", hint="in m/s")
    if abs(speed) > _FASTEST:
        raise validate.wrong_value(name, f"must be at most {_FASTEST:g} m/s, got {speed:g}; check the units")
    return speed
