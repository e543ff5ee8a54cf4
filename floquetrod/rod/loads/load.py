"""Loads along the axis of a rod: the same all along it, or waves from its end; one or arrays of them."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, ClassVar, Literal, NamedTuple, Self, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention
from floquetrod._util.arrays import broadcast
from floquetrod._util.calling import TellsAttributes, constructor_hints
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, ShownInNotebook
from floquetrod.parameter import EVERYWHERE, NAMES, Option, Parameter, Subsystem, by_name

Quantity: TypeAlias = Literal["mean", "amplitude", "frequency"]
"""A quantity of `AxialLoad`."""

_STRONGEST = 1e12  # N
_LOUDEST = 1e24  # N^2/Hz
_SLOWEST, _FASTEST = 1e-9, 1e12  # rad/s: beyond any rod, and within what doubles can follow

QUANTITIES: tuple[Quantity, ...] = ("mean", "amplitude", "frequency")

FAR_ENDS = ("held", "free", "driven")
"""What the lower end may be under an axial wave."""

_POSITION = "a fraction of the length: 0 is the upper end, 1 the lower, None neglects the weight along the rod"

LOAD = by_name(
    Parameter(
        name="mean",
        symbol="F_ave",
        kind="force",
        least=-_STRONGEST,
        largest=_STRONGEST,
        called="mean force",
        known_to=EVERYWHERE,
        option=Option("mean force such as 0.2Fcr, 20%%, 12N or 3lbf{range}; negative pulls", "FORCE", "0:1.2Fcr"),
    ),
    Parameter(
        name="amplitude",
        symbol="dF",
        kind="force",
        least=0.0,
        largest=_STRONGEST,
        hint="a negative amplitude only shifts time: give its size",
        known_to=EVERYWHERE,
        option=Option(
            "amplitude of the force such as 0.2Fcr, 20%%, 3N or 1lbf{range}; 0 is the static limit",
            "FORCE",
            "0:0.5Fcr",
        ),
    ),
    Parameter(
        name="frequency",
        symbol="omega",
        kind="frequency",
        least=_SLOWEST,
        largest=_FASTEST,
        hint="for a constant force set amplitude=0 and any frequency",
        known_to=EVERYWHERE,
        option=Option("frequency such as 24Hz, 1440rpm or 150 (rad/s){range}", "FREQUENCY", "10Hz:60Hz"),
    ),
    Parameter(
        name="mean_at",
        symbol="s / L",
        kind="ratio",
        least=0.0,
        largest=1.0,
        default=0.5,
        hint=_POSITION,
        known_to=EVERYWHERE,
        option=Option(
            "position along an inclined rod where the mean force is given, from 0, the upper end, to 1 (default 0.5); "
            "none neglects the weight along the rod",
            "FRACTION",
        ),
    ),
    Parameter(name="waveform", symbol="h_1, h_2, ...", kind="", default="sine", known_to=EVERYWHERE),
    Parameter(
        name="noise",
        symbol="S",
        kind="force density",
        least=0.0,
        largest=_LOUDEST,
        default=0.0,
        hint="a density in N^2/Hz, zero or more",
        known_to=EVERYWHERE - {"simulation"},
        option=Option(
            "one-sided spectral density of the random part of the force, such as 0.02N^2/Hz, or spectrum, that of the "
            "residual of --force; verdicts are then in mean square",
            "DENSITY",
        ),
    ),
    Parameter(
        name="second",
        symbol="dF_2, omega_2",
        kind="",
        default=None,
        hint="give (amplitude, frequency), or with a phase (amplitude, frequency, phase)",
        known_to=frozenset({"modes", "stress"}),
        option=Option(
            "a second sine of another frequency, that of a second tool, such as 0.1N@37Hz, or 0.1N@37Hz@90deg with a "
            "phase; beside --force its frequency alone, such as 37Hz, takes the rest from the record; a sine that was "
            "measured is fitted together with the record, and an amplitude typed replaces the measured one; verdicts "
            "then need a growth tolerance or damping",
            "FORCE@FREQUENCY",
        ),
    ),
    Parameter(
        name="far_end",
        symbol="",
        kind="",
        default="held",
        known_to=EVERYWHERE,
        option=Option(
            "the upper end sends axial waves; the lower end is held, free, or driven like the upper one",
            name="wave",
            choices=FAR_ENDS,
        ),
    ),
    Parameter(
        name="axial_damping",
        symbol="c_a",
        kind="rate",
        least=0.0,
        largest=_FASTEST,
        default=0.0,
        hint="give the decay rate in 1/s",
        known_to=EVERYWHERE,
        option=Option("decay rate of axial waves in 1/s (needs --wave; default 0)", "RATE"),
    ),
)
"""Parameters of a load by their names; far end and axial damping are those of an `AxialWave`."""


def load_number(quantity: Quantity, value: Any, name: str | None = None) -> float:
    """Return a quantity of a load as a float within its limits; ``name`` is the argument's, where it is another."""
    return LOAD[quantity].number(value, name)


def load_bounds(quantity: Quantity, bounds: Any) -> tuple[float, float]:
    """Return the argument ``bounds``, (low, high) of a quantity of a load, low below high."""
    return validate.interval("bounds", bounds, lambda name, value: load_number(quantity, value, name))


_REPORTS = 50  # of progress over an array of loads: one every two percent
_LEAST_REPORTED = 1024  # loads between two of them, some milliseconds of work


class Loads(NamedTuple):
    """Loads in flat arrays of one length: mean force (N), amplitude (N), frequency (rad/s); ``shape`` is theirs."""

    shape: tuple[int, ...]
    mean: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    frequency: NDArray[np.float64]

    @classmethod
    def of(cls, mean: Any, amplitude: Any, frequency: Any) -> Loads:
        """Return arrays that broadcast as loads; ValueError and TypeError name the quantity that cannot be."""
        given: dict[Quantity, Any] = {"mean": mean, "amplitude": amplitude, "frequency": frequency}
        arrays: dict[str, NDArray[np.float64]] = {
            name: units.array(name, values, LOAD[name].kind, LOAD[name].least, LOAD[name].largest)
            for name, values in given.items()
        }
        shape, flat = broadcast(**arrays)
        return cls(shape, *flat)

    @classmethod
    def single(cls, load: Load) -> Loads:
        """Return one load as arrays of one element."""
        return cls((), *(np.array([value]) for value in (load.mean, load.amplitude, load.frequency)))

    def as_single(self, template: Load) -> Load:
        """Return the one load of the shape (), with everything but its three quantities from a template."""
        return template.with_numbers(*(float(values[0]) for values in self.flat))

    @classmethod
    def along(cls, load: Load, quantity: Quantity, values: NDArray[np.float64]) -> Loads:
        """Return loads equal to ``load`` except for one quantity, which takes the ``values`` (n,)."""
        numbers = {name: np.full(values.shape, getattr(load, name)) for name in QUANTITIES}
        return cls(values.shape, **(numbers | {quantity: values}))

    @property
    def size(self) -> int:
        """Number of loads."""
        return self.frequency.size

    @property
    def flat(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The three arrays."""
        return self.mean, self.amplitude, self.frequency

    def in_parts(self, progress: Progress | None) -> Iterator[Loads]:
        """Yield the loads in parts, calling ``progress`` after each part; without ``progress``, all at once."""
        if progress is None:
            yield self
            return
        step = max(_LEAST_REPORTED, -(-self.size // _REPORTS))
        for start in range(0, max(self.size, 1), step):
            yield self.some(slice(start, start + step))
            progress(min(self.size, start + step), self.size)

    def some(self, chosen: slice | NDArray[np.intp]) -> Loads:
        """Return some of the loads."""
        return Loads((len(self.frequency[chosen]),), *(values[chosen] for values in self.flat))

    def lines(self, least: int) -> Iterator[tuple[Quantity, NDArray[np.intp]]]:
        """Yield the indices of ``least`` loads or more that differ in the mean force alone, or in the amplitude alone.

        Each set comes after the name of the quantity that varies; loads without vibration are in no set.
        """
        left = np.flatnonzero(self.amplitude > 0.0)
        pairs: list[tuple[Quantity, NDArray[np.float64]]] = [("mean", self.amplitude), ("amplitude", self.mean)]
        for varied, other in pairs:
            fixed = np.stack([self.frequency[left], other[left]])
            _, which, counts = np.unique(fixed, axis=1, return_inverse=True, return_counts=True)
            order = np.argsort(which.ravel(), kind="stable")
            for line in np.split(left[order], np.cumsum(counts)[:-1]):
                if line.size >= least:
                    yield varied, line
            left = left[counts[which.ravel()] < least]


Waveform: TypeAlias = str | tuple[complex, ...]
""""sine", or complex amplitudes h_1, h_2, ... of the harmonics."""

Noise: TypeAlias = float | str | tuple[tuple[float, float], ...]
"""A density in N^2/Hz, with a unit before it is checked, or pairs of a frequency in Hz and the density there."""

Second: TypeAlias = tuple[Any, ...]
"""Amplitude in N, frequency in rad/s, and a phase in rad where it is not 0, of a second sine; with units before."""

_MOST_HARMONICS = 1000  # of a waveform (a choice)
RESONANT = 1e-6  # denominator of an axial wave below which rounding leaves it too few digits (a choice)


@dataclass(frozen=True, repr=False)
class Load(units.InUnits, ShownInNotebook, TellsAttributes, ABC):
    """What every load has: F(s, t) = mean + w_e cos(inclination) (s - mean_at L) + the vibration, compression positive.

    Parameters
    ----------
    mean : float
        F_ave in N; negative pulls.
    amplitude : float
        dF in N, zero or more; zero is the static limit.
    frequency : float
        omega in rad/s, greater than zero.
    mean_at : float or None
        Where along an inclined rod the mean force holds, as a fraction of its length from the upper end; from there it
        grows downwards by the weight along the rod.  None neglects that weight.
    waveform : "sine" or sequence of complex
        sin(omega t), or h_1, h_2, ...: the amplitude times Re(h_1 e^(i omega t) + h_2 e^(2 i omega t) + ...).
    noise : float, str or sequence of (float, float)
        One-sided spectral density of the random part of the force, see `AxialLoad`; waves have none.
    second : tuple of float or str
        A second sine, see `AxialLoad`; waves have none.
    """

    mean: float
    amplitude: float
    frequency: float
    mean_at: float | None = field(default=0.5, kw_only=True)
    waveform: Waveform = field(default="sine", kw_only=True)
    noise: Noise = field(default=0.0, kw_only=True)
    second: Second | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        second = self.second if isinstance(self.second, list | tuple) and len(self.second) > 1 else (None, None)
        forces, frequencies = (self.mean, self.amplitude, second[0]), (self.frequency, second[1])
        self.given_in(units.GivenUnits.of(force=forces, frequency=frequencies))
        for name in QUANTITIES:
            object.__setattr__(self, name, load_number(name, getattr(self, name)))
        if self.mean_at is not None:
            object.__setattr__(self, "mean_at", validate.within("mean_at", self.mean_at, 0.0, 1.0, _POSITION))
        object.__setattr__(self, "waveform", _waveform(self.waveform))
        object.__setattr__(self, "noise", noise_density("noise", self.noise))
        object.__setattr__(self, "second", second_sine(self.second))
        if self.second is not None and self.noise:
            raise validate.wrong_value(
                "second",
                f"goes without noise, got {second_in_words(self)} and {noise_in_words(self.noise)}; leave one "
                "of them out",
            )

    @property
    def harmonics(self) -> NDArray[np.complex128]:
        """Complex amplitudes h_1, h_2, ... of the waveform, without unit."""
        return np.array([-1j] if self.waveform == "sine" else self.waveform)

    @abstractmethod
    def profile(self, wave_speed: float, length: float, s: NDArray[np.float64], frequency: float) -> NDArray[Any]:
        """Return the vibration of unit amplitude along the rod at a frequency, real or complex (len(s),)."""

    @property
    @abstractmethod
    def is_uniform(self) -> bool:
        """Whether the vibration is the same all along the rod."""

    def varied(self, quantity: Quantity, value: float) -> Self:
        """Return the same load with one quantity changed."""
        numbers: dict[str, Any] = {quantity: value}
        return replace(self, **numbers).given_in(self.given_units)

    def with_numbers(self, mean: float, amplitude: float, frequency: float) -> Self:
        """Return the same kind of load with other numbers."""
        return replace(self, mean=mean, amplitude=amplitude, frequency=frequency).given_in(self.given_units)

    def as_dict(self) -> dict[str, Any]:
        """Return the arguments of an equal load, without those at their defaults."""
        every = ((f, getattr(self, f.name)) for f in fields(self))
        return {f.name: value for f, value in every if f.default is MISSING or value != f.default}

    @property
    def features(self) -> str:
        """In words, how this load differs from a sine, uniform except for the weight along the rod; "" if not."""
        features = []
        if self.waveform != "sine":
            features.append(f"waveform of {len(self.harmonics)} harmonic{'s' * (len(self.harmonics) > 1)}")
        if self.mean_at is None:
            features.append("weight along the rod neglected")
        elif self.mean_at != 0.5:
            features.append(f"mean force at {self.mean_at:g} of the length")
        if self.noise:
            given = units.AnswerUnits.named(given=self.given_units).force
            features.append(noise_in_words(self.noise, given.name))
        if self.second is not None:
            features.append(second_in_words(self))
        return ", ".join(features)

    def _at_hand(self) -> Report:
        """Return the load in the units in which it was given, for a notebook."""
        force = units.AnswerUnits.named(given=self.given_units).force
        frequency = units.unit(self.given_units.frequency, "frequency", "frequency")
        shown = {"mean": force, "amplitude": force, "frequency": frequency}
        lines = [(LOAD[name].words, unit.show(getattr(self, name))) for name, unit in shown.items()]
        return Report(type(self).__name__, [*lines, *([("", self.features)] if self.features else [])])

    def kind_as_dict(self) -> dict[str, Any]:
        """Return everything but mean, amplitude and frequency, as words and numbers for a file."""
        values = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in QUANTITIES}
        if not self.noise:
            del values["noise"]
        if self.second is None:
            del values["second"]
        if self.waveform != "sine":
            values["waveform"] = [[h.real, h.imag] for h in self.harmonics.tolist()]
        return {"type": type(self).__name__, **values}

    def __repr__(self) -> str:
        """Return the constructor's call, without arguments at their defaults."""
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.as_dict().items())})"

    @classmethod
    def hertz(cls, mean: float, amplitude: float, frequency: float, **others: Any) -> Self:
        """Return a load whose frequency, where it has no unit with it, is given in Hz.

        Returns
        -------
        AxialLoad or AxialWave
            Of the class on which it is called; its ``frequency`` is in rad/s.

        Raises
        ------
        TypeError, ValueError
            As the class.
        """
        in_hertz = validate.positive("frequency", _hertz("frequency", frequency), "give it in Hz")
        load = cls(mean, amplitude, 2.0 * math.pi * in_hertz, **others)
        return load.given_in(load.given_units._replace(frequency="Hz"))


@constructor_hints()
@dataclass(frozen=True, repr=False)
class AxialLoad(Load):
    """Force F(t) = mean + amplitude sin(frequency t) that pushes both ends of the rod inwards, uniform along the rod.

    Parameters
    ----------
    mean : float or str
        F_ave in N, or a string with a unit such as "0.2kN"; negative pulls.
    amplitude : float or str
        dF in N or with a unit, zero or more; zero is the static limit.
    frequency : float or str
        omega in rad/s, greater than zero, or with a unit: "24Hz"; `AxialLoad.hertz` takes Hz.
    mean_at : float or None
        Where along an inclined rod the mean force holds, as a fraction of its length from the upper end, 0 to 1, by
        default 0.5; from there it grows downwards by the weight along the rod.  None neglects that weight.
    waveform : "sine" or sequence of complex
        sin(omega t), the default, or h_1, h_2, ...: the amplitude times Re(h_1 e^(i omega t) + h_2 e^(2 i omega t) +
        ...).
    noise : float, str or sequence of (float, float)
        One-sided spectral density S of the random part of the force, in N^2/Hz or with a unit, "0.02 N^2/Hz": the mean
        square of the force in a band is S times its width in Hz.  Or pairs of a frequency in Hz and the density there,
        linear in between, the first one below the first frequency, and none above the last.  0, none, by default.
        Verdicts are then those in mean square, see `floquetrod.Rod.stability`.
    second : tuple of float or str, optional
        Amplitude in N and frequency in rad/s, or each with a unit, ``("0.1N", "37Hz")``, of a second sine, as of a
        second tool; with a phase in rad as a third number it is amplitude sin(frequency t + phase).  The phase matters
        only where the ratio of both frequencies is a fraction of small numbers.  None by default.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, and for other units.

    Examples
    --------
    >>> round(AxialLoad.hertz(0.3, 0.3, 24.0).frequency, 3)
    150.796
    >>> AxialLoad("300mN", "300mN", "24Hz") == AxialLoad.hertz(0.3, 0.3, 24.0)
    True
    """

    def profile(self, wave_speed: float, length: float, s: NDArray[np.float64], frequency: float) -> NDArray[Any]:
        """Return ones: the vibration is the same all along the rod."""
        return np.ones_like(s)

    @property
    def is_uniform(self) -> bool:
        """True."""
        return True


class LoadSource(ABC):
    """A measured force, or one that differs from it in some numbers: as an argument it stands for its load."""

    force_unit_named: ClassVar[bool] = True

    @property
    @abstractmethod
    def load(self) -> Load:
        """The load."""

    @property
    @abstractmethod
    def lines(self) -> tuple[Second, ...]:
        """Sines that were measured and that the load does not hold, as ``second`` of a load takes them."""

    @abstractmethod
    def _line_in_words(self, line: Second) -> str:
        """Return one of them as ``--second`` takes it."""

    @abstractmethod
    def _left_out_in_words(self, load: Load) -> str:
        """Return those that a load does not hold in words, "" without any."""

    @property
    @abstractmethod
    def _means(self) -> tuple[float, ...]:
        """Mean forces in N at the ends of what was measured, where they drift and the load has the mean of them."""

    @property
    @abstractmethod
    def _mean_error(self) -> float:
        """Standard error in N of the mean force of the load, 0 where it was not measured."""

    @property
    @abstractmethod
    def _is_uneven(self) -> bool:
        """Whether what the load leaves of the force is too uneven for the noise of a sensor."""

    @abstractmethod
    def _with_residual(self) -> LoadSource:
        """Return the force with what its load leaves of it as the noise of its load."""

    @abstractmethod
    def _with_fine_noise(self) -> Load | None:
        """Return the load with densities of its measured noise over few frequencies, plus errors, None without any."""

    @abstractmethod
    def _within_errors(self, count: int) -> Iterator[Load]:
        """Yield loads drawn within the errors of the load, the same ones in every call."""


AnyLoad: TypeAlias = Load | LoadSource
"""An argument that is a load or stands for one."""


def load_from_dict(data: Mapping[str, Any]) -> Load:
    """Return the load that `Load.kind_as_dict`, with its three numbers, describes; KeyError or a ValueError else."""
    kinds = {kind.__name__: kind for kind in (AxialLoad, AxialWave)}
    values = dict(data)
    load = kinds[values.pop("type")]
    if values.get("waveform", "sine") != "sine":
        values["waveform"] = tuple(complex(*pair) for pair in values["waveform"])
    if values.get("second") is not None:
        values["second"] = tuple(values["second"])
    if isinstance(values.get("noise"), list):
        values["noise"] = tuple(tuple(pair) for pair in values["noise"])
    return load(**values)


def require_load(name: str, value: Any) -> Load:
    """Return an argument that is a load, or what it stands for; TypeError for anything else."""
    if isinstance(value, LoadSource):
        return value.load
    if isinstance(value, Load):
        return value
    raise validate.wrong_type(
        name,
        f"must be an AxialLoad, AxialWave or ForceRecord, got {validate.short(value)}; give fr.AxialLoad(mean, "
        "amplitude, frequency), say",
    )


def require_noise(name: str, load: Any) -> Load:
    """Return a load, which has noise; ValueError where it has none, and as `require_load`."""
    noisy = require_load(name, load)
    if not noisy.noise:
        raise validate.wrong_value(name, "must have noise, such as noise=1.0, to find its critical multiple")
    return noisy


def kind(load: AnyLoad | None) -> Load:
    """Return the argument ``load``, by default a sine."""
    return AxialLoad(0.0, 0.0, 1.0) if load is None else require_load("load", load)


@constructor_hints()
@dataclass(frozen=True, repr=False)
class AxialWave(Load):
    """Force that a vibration at the upper end, s = 0, sends along the rod as axial waves of its speed c_0.

    Parameters
    ----------
    mean : float or str
        F_ave in N, or a string with a unit such as "0.2kN"; negative pulls.
    amplitude : float or str
        dF at the driven end in N or with a unit, zero or more.
    frequency : float or str
        omega in rad/s, greater than zero, or with a unit: "16Hz".
    mean_at : float or None
        As in `AxialLoad`, by default 0.5.
    waveform : "sine" or sequence of complex
        As in `AxialLoad`, by default "sine".
    noise : float
        None but 0: random waves are not computed.
    second : None
        Waves of two frequencies are not computed.
    far_end : {"held", "free", "driven"}
        The lower end, s = L: held against axial motion, the default; free of axial vibration; driven by the same force,
        as both ends are in the paper.
    axial_damping : float
        Decay rate c_a of free axial waves in 1/s, zero or more, by default 0: u_tt + 2 c_a u_t = c_0^2 u_ss.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, for other units, and for noise.

    Notes
    -----
    With kappa = sqrt(omega^2 - 2 i c_a omega) / c_0 the vibration is the amplitude times cos kappa(L - s) / cos kappa L
    (held), sin kappa(L - s) / sin kappa L (free), cos kappa(s - L/2) / cos(kappa L/2) (driven).  Where sections of the
    impedances Z = A sqrt(E rho) meet, force and velocity are continuous, and the share (Z_2 - Z_1) / (Z_2 + Z_1) of the
    force of a wave is reflected; ``rod.axial_line.profile(load, s, frequency)`` is the vibration along any rod.

    Examples
    --------
    >>> AxialWave(6e3, 3.6e3, 25.0, far_end="free")
    AxialWave(mean=6000.0, amplitude=3600.0, frequency=25.0, far_end='free')
    """

    far_end: str = "held"
    axial_damping: float = 0.0

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        super().__post_init__()
        if self.noise:
            raise validate.wrong_value(
                "noise",
                f"is taken to be the same all along the rod, got {noise_in_words(self.noise)} with waves; give an ",
                Mention("wave", "AxialLoad", "no --wave"),
            )
        if self.second is not None:
            raise validate.wrong_value(
                "second",
                f"is taken to be the same all along the rod, got {second_in_words(self)} with waves; leave ",
                Mention("second"),
                " out, or give a load without waves",
            )
        validate.choice("far_end", self.far_end, FAR_ENDS)
        object.__setattr__(self, "axial_damping", LOAD["axial_damping"].number(self.axial_damping))

    def profile(self, wave_speed: float, length: float, s: NDArray[np.float64], frequency: float) -> NDArray[Any]:
        """Return the vibration of unit amplitude along a rod of one section; real without axial damping.

        Returns
        -------
        ndarray
            In the shape of ``s``.
        """
        kappa = np.sqrt(complex(frequency * frequency, -2.0 * self.axial_damping * frequency)) / wave_speed

        def decayed(distance: Any) -> Any:
            """Return the complex factor exp(-i kappa x), decay and phase of a wave after a distance x."""
            return np.exp(-1j * kappa * distance)

        # The cosines and sines of the Notes, in exponentials that do not overflow.
        if self.far_end == "driven":
            top, below = decayed(s) + decayed(length - s), 1.0 + decayed(length)
        elif self.far_end == "held":
            top, below = decayed(s) * (1.0 + decayed(2.0 * (length - s))), 1.0 + decayed(2.0 * length)
        else:  # keeps its digits where the rod is short against the wave
            top, below = (f * np.expm1(-2j * kappa * x) for f, x in ((decayed(s), length - s), (1.0, length)))
        if abs(below) < RESONANT and abs(kappa) * length > 1.0:
            raise resonates(self, frequency, length)
        profile = top / below
        return np.asarray(profile.real if self.axial_damping == 0.0 else profile)

    @property
    def resonant_phases(self) -> tuple[float, float]:
        """Phases omega L / c_0 of the first axial resonance without damping, and from each to the next, in rad."""
        # cos kappa L = 0, sin kappa L = 0, cos(kappa L / 2) = 0
        return {
            "held": (0.5 * math.pi, math.pi),
            "free": (math.pi, math.pi),
            "driven": (math.pi, 2.0 * math.pi),
        }[self.far_end]

    @property
    def is_uniform(self) -> bool:
        """False."""
        return False

    @property
    def features(self) -> str:
        """In words, how this load differs from a sine, uniform except for the weight along the rod."""
        ends = "both ends driven" if self.far_end == "driven" else f"lower end {self.far_end}"
        rate = f", axial damping {self.axial_damping:g} 1/s" if self.axial_damping else ""
        return ", ".join(filter(None, [f"axial waves, {ends}{rate}", super().features]))


def resonates(load: AxialWave, frequency: float, length: float) -> ValueError:
    """Return the error for a frequency in rad/s at which axial waves of a rod resonate without damping."""
    damping = Mention("axial_damping")
    return validate.wrong_value(
        "frequency",
        f"{frequency:g} rad/s is a resonance of axial waves in a rod of {length:g} m, far end {load.far_end}: without ",
        damping,
        " the force is infinite; give ",
        damping,
        ", or another frequency",
    )


def with_waves(load: Load, axial_damping: float = 0.0, name: str = "axial_damping") -> AxialWave:
    """Return an `AxialLoad` with the waves it sends from both ends, damped at a rate in 1/s that errors give a name."""
    rate = LOAD["axial_damping"].number(axial_damping, name)
    return AxialWave(**load.as_dict(), far_end="driven", axial_damping=rate)


def noise_density(name: str, value: Any) -> float | tuple[tuple[float, float], ...]:
    """Return a spectral density of noise, checked: a number in N^2/Hz, or pairs of a frequency in Hz and a density."""
    if units.is_written(value):
        return units.quantity(value, name, "force density", least=0.0, largest=_LOUDEST)
    if not validate.iterable(value) or (isinstance(value, np.ndarray) and value.ndim == 0):
        return validate.within(name, value, 0.0, _LOUDEST, "a density in N^2/Hz, zero or more")
    densities = []
    for i, pair in enumerate(validate.listed(name, value, validate.MOST_NUMBERS, "pairs")):
        if isinstance(pair, str) or not validate.iterable(pair) or len(tuple(pair)) != 2:
            example = "a density in N^2/Hz or pairs of a frequency in Hz and a density"
            raise validate.wrong_type(name, f"must be {example}, got {validate.short(pair)} among the pairs")
        hertz, density = pair
        at = validate.within(f"{name}[{i}][0]", _hertz(f"{name}[{i}][0]", hertz), 0.0, _FASTEST, "give it in Hz")
        size = units.number(f"{name}[{i}][1]", density, "force density", 0.0, _LOUDEST, "give it in N^2/Hz")
        densities.append((at, size))
    if not densities or any(one >= other for (one, _), (other, _) in pairwise(densities)):
        raise validate.wrong_value(
            name, f"must have frequencies that increase, one at least, got {validate.short(value)}"
        )
    return tuple(densities) if any(density for _, density in densities) else 0.0


def _hertz(name: str, value: Any) -> Any:
    """Return a frequency in Hz that is given as a number in Hz or with its unit."""
    return units.quantity(value, name, "frequency") / (2.0 * math.pi) if units.is_written(value) else value


def density_at(noise: Noise, hertz: Any) -> NDArray[np.float64]:
    """Return the one-sided spectral density of noise in N^2/Hz at frequencies in Hz."""
    if isinstance(noise, tuple):
        at, density = np.array(noise).T
        return np.asarray(np.interp(hertz, at, density, right=0.0))
    return np.full(np.shape(hertz), float(noise))


def largest_density(noise: Noise, hertz: Any) -> NDArray[np.float64]:
    """Return the largest density in N^2/Hz at any frequency from so many Hz on."""
    if not isinstance(noise, tuple):
        return np.full(np.shape(hertz), float(noise))
    at, density = np.array(noise).T
    beyond = np.append(np.maximum.accumulate(density[::-1])[::-1], 0.0)
    return np.asarray(np.maximum(density_at(noise, hertz), beyond[np.searchsorted(at, hertz)]))


def scaled_noise(noise: Noise, factor: float) -> Noise:
    """Return noise whose density is a factor as large."""
    if isinstance(noise, tuple):
        return tuple((at, factor * density) for at, density in noise)
    return factor * float(noise)


def noise_in_words(noise: Noise, force: str = "N") -> str:
    """Return the largest density of noise in words, by a unit of force."""
    densities = units.units_of("force density")
    unit = f"{force}^2/Hz" if f"{force}^2/Hz" in densities else "N^2/Hz"
    size = densities[unit]
    if not isinstance(noise, tuple):
        return f"noise of {float(noise) / size:.4g} {unit}"
    return f"noise of up to {max(density for _, density in noise) / size:.4g} {unit} below {noise[-1][0]:.4g} Hz"


def second_sine(value: Any) -> Second | None:
    """Return a second sine, checked, without a phase of zero."""
    if value is None:
        return None
    if (
        isinstance(value, str)
        or not validate.iterable(value)
        or len(parts := tuple(itertools.islice(value, 4))) not in (2, 3)
    ):
        raise validate.wrong_type(
            "second", f"must be (amplitude, frequency), or these and a phase, got {validate.short(value)}"
        )
    amplitude = load_number("amplitude", parts[0], "second[0]")
    frequency = load_number("frequency", parts[1], "second[1]")
    phase = units.number("second[2]", parts[2], "angle", hint="give it in rad") if len(parts) == 3 else 0.0
    return (amplitude, frequency, phase) if phase else (amplitude, frequency)


def second_in_words(load: Load) -> str:
    """Return the second sine of a load, which has one, in words and in the units in which the load was given."""
    amplitude, frequency, *phase = cast(Second, load.second)
    given = units.AnswerUnits.named(given=load.given_units)
    force, cycles = given.force, units.unit(load.given_units.frequency, "frequency", "frequency")
    ahead = f" of phase {phase[0]:.4g} rad" if phase else ""
    return f"a second sine of {force.show(amplitude, 4)} at {cycles.show(frequency)}{ahead}"


def require_one_sine(load: Load, subsystem: Subsystem) -> None:
    """Raise ValueError for a second sine where a subsystem would ignore it."""
    if load.second is not None and subsystem not in LOAD["second"].known_to:
        raise validate.wrong_value(
            "second",
            f"is not part of {NAMES[subsystem]}, which would ignore it: got {second_in_words(load)}; leave ",
            Mention("second"),
            " out",
        )


def _waveform(value: Any) -> Waveform:
    """Return a waveform, checked: "sine", or finite complex numbers, the last not zero."""
    if isinstance(value, str) and value == "sine":
        return value
    try:
        numbers = validate.untyped("waveform", value)
        known = numbers.ndim == 1 and numbers.size > 0 and numbers.dtype.kind in "iufc"
    except ValueError:
        known = False
    if not known:
        raise validate.wrong_value(
            "waveform",
            f"must be 'sine' or a sequence of complex numbers h_1, h_2, ..., got {validate.short(value)}; a "
            "square wave has -4i/pi, 0, -4i/(3 pi), 0, ..., of which give as many as matter",
        )
    if numbers.size > _MOST_HARMONICS:
        raise validate.wrong_value("waveform", f"must hold at most {_MOST_HARMONICS} harmonics, got {numbers.size}")
    if not np.isfinite(numbers).all() or np.abs(numbers).max() > 1e6:
        raise validate.wrong_value("waveform", f"must hold finite numbers up to 1e6, got {validate.short(value)}")
    last = np.flatnonzero(numbers)
    if not last.size:
        raise validate.wrong_value(
            "waveform", "must hold a harmonic other than zero; for a constant force set amplitude=0"
        )
    return tuple(complex(z) for z in numbers[: last[-1] + 1])
