"""Numbers that others have published beside ours: the rows of docs/theory/validation.md, which test_published checks.

A row names what was printed, digit by digit, and where.  Printed and computed differ by no more than half a unit of the
last digit printed or by what the row allows; where they differ by more, ``why`` says so and the difference is held:
``here`` is our own answer, checked to half a unit of its last digit.  Sources that were read elsewhere than in print
say where.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from html import escape
from typing import Any

import numpy as np
from scipy.optimize import brentq

import floquetrod as fr
from benchmarks import drag
from floquetrod.rod import EndConditions
from floquetrod.rod.model import beam
from tests.system_cases import blade, coupled


@dataclass(frozen=True)
class Row:
    """One published number and what computes it here."""

    what: str
    printed: str  # as printed, or the value of a printed formula
    source: str
    compute: Callable[[], float]
    here: str = ""  # our own answer, where it has more digits than what was printed or differs
    why: str = ""  # the two differ by more than ``allowed``
    allowed: float | None = None  # half a unit of the last digit printed, unless a formula is known to be rougher
    slow: bool = False

    @functools.cached_property
    def ours(self) -> float:
        """Our number."""
        return float(self.compute())

    @property
    def difference(self) -> float:
        """The published number less ours."""
        return float(self.printed) - self.ours

    @property
    def faults(self) -> list[str]:
        """What is wrong with the row, in words."""
        found = []
        if bool(self.why) == (abs(self.difference) <= self.tolerance):
            found.append(f"{self.what}: {self.ours!r} is{'' if self.why else ' not'} what is printed, {self.printed}")
        if self.here and abs(float(self.here) - self.ours) > half_unit(self.here):
            found.append(f"{self.what}: {self.ours!r} is not {self.here}")
        return found

    @property
    def tolerance(self) -> float:
        """By how much the two may differ if the published one is right."""
        return half_unit(self.printed) if self.allowed is None else self.allowed


def half_unit(digits: str) -> float:
    """Return half a unit of the last digit, and what rounding takes away."""
    exponent = Decimal(digits).as_tuple().exponent
    return 0.5000001 * 10.0 ** int(exponent)


@dataclass(frozen=True)
class Shown:
    """Rows as a page shows them, under their sources."""

    rows: Sequence[Row]

    def __str__(self) -> str:
        """Return the rows as lines, each group under its source."""
        parts = (
            f"{source}\n" + "\n".join("  ".join(map(str, cells)) for cells in group) for source, group in self._groups
        )
        return "\n\n".join(parts)

    def _repr_html_(self) -> str:
        titles = "".join(f'<th style="{_STYLE}">{each}</th>' for each in ("published", "here", "difference"))
        groups = "".join(
            f'<tr><th colspan="5" style="{_SOURCE}">{escape(source)}</th></tr>'
            + "".join(f"<tr>{''.join(map(_cell, cells, _STYLES))}</tr>" for cells in group)
            for source, group in self._groups
        )
        return f"<table><tr><td></td>{titles}<td></td></tr>{groups}</table>"

    @property
    def _groups(self) -> list[tuple[str, list[tuple[str, ...]]]]:
        return [(s, list(map(_cells, rows))) for s, rows in itertools.groupby(self.rows, key=lambda row: row.source)]


_STYLE = "padding-right: 1.2em; white-space: nowrap; text-align: left"
_SOURCE = "text-align: left; padding-top: 0.8em; white-space: normal"
_TEXT = "padding-right: 1.2em; text-align: left; min-width: 7em; white-space: normal"
_STYLES = (_TEXT, _STYLE, _STYLE, _STYLE, _TEXT)


def _cell(text: str, style: str) -> str:
    return f'<td style="{style if text else ""}">{escape(text)}</td>'


def _cells(row: Row) -> tuple[str, ...]:
    digits = max(0, -int(Decimal(row.here or row.printed).as_tuple().exponent)) + (0 if row.here else 1)
    return row.what, row.printed, f"{row.ours:.{digits}f}", f"{row.difference:+.1e}", row.why


# --- Mathieu's equation -----------------------------------------------------------------------------------------------

BURKARDT = "Abramowitz & Stegun, table 20.1, to the digits of Mathematica in J. Burkardt's test_values"
WOLFRAM = "Wolfram Alpha, MathieuCharacteristicA and B, as in SciPy's tests (special/tests/test_basic.py)"
ZHANG = "S. Zhang & J. Jin, Computation of Special Functions, Wiley 1996, "
SERIES = "Abramowitz & Stegun 20.2.25, DLMF 28.6(i)"


def value(kind: str, order: int, q: float) -> Callable[[], float]:
    """Return what computes a characteristic value."""
    return lambda: fr.mathieu.characteristic_values(order, q, kind)


def function(kind: str, order: int, q: float, z: float) -> Callable[[], float]:
    """Return what computes a value of ce or se."""
    return lambda: fr.mathieu.characteristic_function(order, q, kind)(z)


def characteristic() -> Iterator[Row]:
    """Yield the characteristic values that Abramowitz and Stegun, Wolfram, Zhang and Jin print."""
    for kind, order, q, printed in (
        ("a", 5, 5, "25.54997174998161"), ("a", 5, 10, "27.70376873393928"), ("a", 5, 15, "31.95782125217288"),
        ("a", 5, 20, "36.64498973413284"), ("a", 5, 25, "40.05019098580771"), ("a", 0, 5, "-5.800046020851508"),
        ("a", 0, 25, "-40.25677954656679"), ("a", 1, 20, "-14.49130142517482"), ("a", 2, 15, "5.077983197543472"),
        ("a", 10, 10, "100.5067700246813"), ("b", 1, 25, "-40.25677898468416"), ("b", 2, 5, "2.099460445486665"),
        ("b", 2, 10, "-2.382158235956956"), ("b", 2, 15, "-8.099346798895896"), ("b", 2, 20, "-14.49106325598072"),
        ("b", 2, 25, "-21.31486062224985"), ("b", 5, 15, "27.96788059671747"), ("b", 10, 10, "100.5067694628784"),
        ("b", 15, 20, "225.8951534161768"),
    ):  # fmt: skip
        yield Row(f"{kind}_{order}({q})", printed, BURKARDT, value(kind, order, q), allowed=4e-14 * abs(float(printed)))
    for kind, order, q, printed in (
        ("a", 0, 8.0, "-10.6067292355526479852024"), ("a", 3, 1.5, "9.19330104768060974047804"),
        ("a", 5, 0.25, "25.0013021454698022809572"), ("a", 8, -10.0, "64.8008910105046444848962"),
        ("b", 1, 15.0, "-22.5130034974234666335"), ("b", 5, 3.0, "25.1870798027185125480"),
        ("b", 9, 0.25, "81.00039062627570760760"), ("b", 10, -3.0, "100.0454683359769326164"),
    ):  # fmt: skip
        row = f"{kind}_{order}({q:g})"
        yield Row(row, printed, WOLFRAM, value(kind, order, q), allowed=4e-15 * abs(float(printed)))
    for order, a, b in (
        (3, "12.964079444", "-3.520941527"), (4, "27.805240581", "12.986489953"), (6, "48.975786716", "41.801071292"),
        (7, "57.534689001", "55.002957151"), (8, "69.524065166", "69.057988351"), (9, "85.076999882", "85.023356505"),
        (12, "146.207690643", "146.207674647"),
    ):  # fmt: skip
        for kind, printed in (("a", a), ("b", b)):
            yield Row(f"{kind}_{order}(25)", printed, ZHANG + "program MCVA2", value(kind, order, 25.0))


def functions() -> Iterator[Row]:
    """Yield values of ce and se."""
    table_20_1 = "Abramowitz & Stegun, table 20.1, to the digits of GSL's tests (specfunc/test_mathieu.c)"
    for name, order, place, q, printed in (
        ("ce", 0, "0", 5, "0.04480018165188902"), ("ce", 0, "pi/2", 5, "1.334848674698019"),
        ("ce", 0, "0", 10, "0.007626517570935782"), ("ce", 0, "pi/2", 10, "1.468660470712856"),
        ("ce", 0, "0", 25, "0.0002158630184146612"), ("ce", 0, "pi/2", 25, "1.657510298323475"),
        ("ce", 1, "0", 5, "0.2565428793223637"), ("ce", 1, "0", 25, "0.001911051506657645"),
        ("se", 1, "pi/2", 5, "1.337433887022345"), ("se", 1, "pi/2", 25, "1.657510398374516"),
        ("ce", 2, "0", 5, "0.7352943084006845"), ("ce", 2, "pi/2", 5, "-0.7244881519676682"),
        ("ce", 2, "0", 25, "0.0115128663308875"), ("ce", 2, "pi/2", 25, "-1.116278953295253"),
        ("ce", 5, "0", 5, "1.12480725063848"), ("ce", 5, "0", 25, "0.6106943100506986"),
        ("se", 5, "pi/2", 5, "0.9060779302023551"), ("se", 5, "pi/2", 25, "0.8992683245108413"),
        ("ce", 10, "0", 25, "1.156239918632239"), ("ce", 10, "pi/2", 25, "-0.8826919105636903"),
        ("ce", 15, "0", 25, "1.059800441813937"), ("se", 15, "pi/2", 25, "-0.9467086958780897"),
    ):  # fmt: skip
        kind, z = "a" if name == "ce" else "b", 0.0 if place == "0" else math.pi / 2
        row = f"{name}_{order}({place}, {q})"
        yield Row(row, printed, table_20_1, function(kind, order, q, z), allowed=1e-14)
    for kind, order, q, printed in (
        ("a", 0, 5, ".3025683"), ("a", 1, 5, ".7669652"), ("b", 1, 5, ".2988052"), ("a", 5, 5, "-.9810931"),
        ("b", 5, 5, ".1694850"), ("b", 2, 25, ".2074275"), ("b", 5, 25, "1.1881232"),
    ):  # fmt: skip
        name = f"{'ce' if kind == 'a' else 'se'}_{order}(40 deg, {q})"
        yield Row(name, printed, ZHANG + "program MMTU0", function(kind, order, q, math.radians(40.0)))
    yield Row(
        "ce_2(40 deg, 25)", "-.5297051", ZHANG + "program MMTU0", function("a", 2, 25, math.radians(40.0)),
        here="0.5297050", why="the sign: ce_2(0) > 0 for every q (DLMF 28.2(vi))",
    )  # fmt: skip


def power_series() -> Iterator[Row]:
    """Yield characteristic values by the printed series, each as good as the term it leaves out."""
    for kind, order, q, terms in (
        ("a", 0, 0.5, (0.0, -1 / 2, 7 / 128, -29 / 2304, 68687 / 18874368)),
        ("a", 2, 0.5, (4.0, 5 / 12, -763 / 13824, 1002401 / 79626240, -1669068401 / 458647142400)),
        ("b", 2, 0.5, (4.0, -1 / 12, 5 / 13824, -289 / 79626240, 21391 / 458647142400)),
    ):
        found = sum(term * q ** (2 * i) for i, term in enumerate(terms))
        left_out = abs(terms[-1]) * q ** (2 * len(terms)) * abs(terms[-1] / terms[-2])
        yield Row(
            f"{kind}_{order}({q:g}), series to q^8",
            f"{found:.13f}",
            SERIES,
            value(kind, order, q),
            allowed=2.0 * left_out,
        )


def elsewhere_wrong() -> Iterator[Row]:
    """Yield a characteristic value that a widely used library gets wrong."""
    scipy = "scipy.special.mathieu_a of SciPy 1.17.1 (issues 4479 and 14526 of SciPy)"
    yield Row(
        "a_50(2000)", "4078.3949221407206", scipy, value("a", 50, 2000.0), here="3439.80",
        why="the value of another order",
    )  # fmt: skip


def trap() -> Iterator[Row]:
    """Yield the first stability region of an ion trap."""

    def tip() -> float:
        def both(q: float) -> float:
            return float(np.sum([fr.mathieu.characteristic_values(m, q, k) for m, k in ((0, "a"), (1, "b"))]))

        return float(brentq(both, 0.5, 0.9, xtol=1e-14))

    dawson = "P. H. Dawson, Quadrupole Mass Spectrometry and its Applications, Elsevier 1976"
    yield Row("mass filter, q at its tip", "0.706", dawson, tip, here="0.7059961")
    yield Row("mass filter, a at its tip", "0.237", dawson, lambda: -value("a", 0, tip())(), here="0.2369940")
    yield Row(
        "trap without a constant field, largest q", "0.908", "W. Paul, Rev. Mod. Phys. 62 (1990) 531",
        lambda: brentq(lambda q: value("b", 1, q)(), 0.8, 1.0, xtol=1e-14), here="0.9080463",
    )  # fmt: skip


# --- the published study ----------------------------------------------------------------------------------------------

STUDY = "doi:10.1115/1.4031710"


def study() -> Iterator[Row]:
    """Yield what the published study says of its rod."""
    rod = fr.Rod.nitinol()
    unit = rod.critical_force
    blind = math.log(1e6) / (200.0 * math.pi)

    def first_end(frequency: float) -> float:
        found = rod.ranges(
            "mean", amplitude=0.2 * unit, frequency=frequency, bounds=(0.0, unit), growth_tolerance=blind * frequency
        )
        return next(iter(found)).high / unit

    def thinnest() -> float:
        gaps = [*rod.ranges("mean", amplitude=0.2 * unit, frequency=85.0, bounds=(0.0, unit), growth_tolerance=0.0)]
        parts = [(one.high / unit, other.low / unit) for one, other in itertools.pairwise(gaps)]
        return next(low for low, high in parts if high - low > 0.01)

    yield Row("F_cr of the rod, N", "1.70", STUDY, lambda: unit, here="1.6960286")
    yield Row(
        "the same with 9.4 mm as radius of the channel, as the text says", "1.70", STUDY,
        lambda: rod.replace(channel_radius=9.4e-3).critical_force, here="1.1421319",
        why="9.4 mm is the diameter",
    )  # fmt: skip
    yield Row("m_cr of the rod", "6", STUDY, lambda: rod.critical_mode, here="6.1438")
    yield Row(
        "beta = -0.8: stable up to alpha =", "1.5", STUDY + ", Fig. 2",
        lambda: brentq(lambda alpha: value("b", 2, 2.0 * alpha)() - 3.2, 1.0, 2.0, xtol=1e-13),
        here="1.5807427", why="read off a chart; it holds",
    )  # fmt: skip
    yield Row(
        "0.2 F_cr at 85 rad/s: stable below F_ave / F_cr =", "0.45", STUDY + ", Fig. 3",
        lambda: first_end(85.0), here="0.459527", why="read off a chart of its 100-period test",
    )  # fmt: skip
    yield Row(
        "the same without the 100-period test: the first tongue wider than 0.01", "0.45", STUDY + ", Fig. 3",
        thinnest, here="0.2765", why="100 periods show no growth below 0.022 per unit of tau",
    )  # fmt: skip
    yield Row(
        "0.2 F_cr at 20 rad/s: stable up to F_ave / F_cr =", "0.8", STUDY + ", Fig. 3",
        lambda: first_end(20.0), here="0.759196", allowed=0.05,
    )  # fmt: skip


# --- systems ----------------------------------------------------------------------------------------------------------


def between(is_stable: Callable[[float], bool], stable: float, unstable: float, steps: int = 40) -> float:
    """Return where verdicts change, by halving."""
    for _ in range(steps):
        middle = 0.5 * (stable + unstable)
        stable, unstable = (middle, unstable) if is_stable(middle) else (stable, middle)
    return 0.5 * (stable + unstable)


def ziegler(load: float, damping: float = 0.0) -> fr.HillSystem:
    """Return Ziegler's double pendulum, masses 2 m and m, under a constant follower force in k / l."""
    springs = np.array([[2.0, -1.0], [-1.0, 1.0]])
    follower = np.array([[1.0, -1.0], [0.0, 0.0]])
    return fr.HillSystem(springs - load * follower, mass=[[3.0, 1.0], [1.0, 1.0]], damping=damping * springs)


def width_of_the_sum_tongue(strength: float, damping: tuple[float, float]) -> float:
    """Return half the width in frequency of the combination resonance at w_1 + w_2."""

    def is_stable(w: float) -> bool:
        return fr.stability(coupled(w, damping, strength)).status == "stable"

    low, high = between(is_stable, 2.97, 3.0, 30), between(is_stable, 3.03, 3.0, 30)
    return 0.5 * (high - low)


def systems() -> Iterator[Row]:
    """Yield follower forces, combination resonances and a blade in hover."""
    for what, printed, source, damping, here in (
        (
            "flutter of Ziegler's column, P l / k",
            "2.086",
            "H. Ziegler, Ing.-Arch. 20 (1952) 49: 7/2 - sqrt(2)",
            0.0,
            "2.0857864",
        ),
        ("with damping that vanishes, P l / k", "1.464", "H. Ziegler, the same: 41/28", 1e-5, "1.4642857"),
    ):
        yield Row(
            what, printed, source,
            functools.partial(between, lambda p, c=damping: fr.stability(ziegler(p, c)).status == "stable", 1.0, 2.5),
            here=here, slow=damping > 0.0,
        )  # fmt: skip
    hsu = "C. S. Hsu, J. Appl. Mech. 30 (1963) 367, first order"
    strength = 0.02
    g = strength / (4.0 * math.sqrt(2.0))
    for what, c in (("undamped", (0.0, 0.0)), ("damped unequally", (1e-4, 2e-3))):
        spread = (c[0] + c[1]) * math.sqrt(g * g / (c[0] * c[1]) - 1.0) if any(c) else 2.0 * g
        yield Row(
            f"half width of the sum resonance, {what}", f"{spread:.9f}", hsu,
            functools.partial(width_of_the_sum_tongue, strength, c), allowed=strength * spread, slow=True,
        )  # fmt: skip
    yield Row(
        "a blade that flaps in hover, Lock number 12: decay", "-0.75", "W. Johnson, Helicopter Theory, 1980: -gamma/16",
        lambda: max(each.real for each in fr.stability(blade(0.0)).exponents), here="-0.7500000000",
    )  # fmt: skip


def delayed(b: float) -> fr.DelaySystem:
    """Return x' = -b x(t - 1)."""
    return fr.DelaySystem.first_order([[0.0]], delayed=[(1.0, [[-b]])])


def milled(depth: str) -> Callable[[], float]:
    """Return what computes the largest multiplier of the slotting cutter of the literature."""
    mode = fr.ToolMode("922Hz", 0.011, mass="39.93g")
    cutter = fr.Milling(x=[mode], teeth=2, tangential="600MPa", radial="200MPa", immersion=1.0, direction="up")
    return lambda: abs(cutter.stability("5000rpm", depth).multipliers[0])


def delays_and_noise() -> Iterator[Row]:
    """Yield Hayes' equation, a milling cutter and white noise."""
    yield Row(
        "x' = -b x(t - 1): largest b", f"{math.pi / 2:.12f}", "N. D. Hayes, J. London Math. Soc. 25 (1950) 226: pi/2",
        lambda: between(lambda b: fr.stability(delayed(b)).status == "stable", 1.5, 1.6), allowed=1e-11, slow=True,
    )  # fmt: skip
    source = "printed by papers on discretisations as the value to converge to (slotting, 5,000 rpm, 922 Hz)"
    for depth, printed, here in (
        ("0.2mm", "0.8192", "0.819742784"), ("0.5mm", "1.0726", "1.073975587"), ("1mm", "1.4040", "1.406473525"),
    ):  # fmt: skip
        yield Row(
            f"milling, largest multiplier at {depth}", printed, source, milled(depth), here=here,
            why="not converged: the steps were too few", slow=True,
        )  # fmt: skip
    yield Row(
        "y'' + 0.2 y' + 1.3 y = s y xi: s^2 bearable in mean square", "0.52", "L. Arnold, 1974: 4 c w^2",
        lambda: fr.critical_noise(fr.HillSystem([[1.3]], damping=[[0.2]]), [([[1.0]], 1.0)]).factor ** 2,
        here="0.5200000000",
    )  # fmt: skip


# --- orbits -----------------------------------------------------------------------------------------------------------


def van_der_pol(t: Any, x: Any, mu: float) -> Any:
    """Return the derivatives of van der Pol's equation."""
    return x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]


def lorenz(t: Any, x: Any, s: float, r: float, b: float) -> Any:
    """Return the derivatives of Lorenz' equations."""
    return s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2]


@functools.cache
def limit_cycle() -> fr.results.PeriodicOrbit:
    """Return van der Pol's, mu = 1."""
    return fr.periodic_orbit(fr.NonlinearSystem(van_der_pol, parameters={"mu": 1.0}), [2.0, 0.0])


def largest() -> float:
    """Return the amplitude of van der Pol's orbit, where x' = 0."""
    orbit = limit_cycle()
    times = np.linspace(0.0, orbit.period, 2001)
    first = int(np.argmax(orbit(times)[:, 0]))
    turn = brentq(lambda t: orbit(t)[1], times[first] - 0.01, times[first] + 0.01, xtol=1e-14)
    return float(orbit(turn)[0])


def orbits() -> Iterator[Row]:
    """Yield periods of van der Pol's and Lorenz' equations."""
    hairer = "E. Hairer, S. P. Norsett & G. Wanner, Solving Ordinary Differential Equations I, exercise I.16.1"
    yield Row("van der Pol, mu = 1: period", "6.66328685932313", hairer, lambda: limit_cycle().period, allowed=1e-12)
    yield Row("van der Pol, mu = 1: amplitude", "2.00861986087484", hairer, largest, allowed=1e-11)
    viswanath = "D. Viswanath, Nonlinearity 16 (2003) 1035"
    system = fr.NonlinearSystem(lorenz, parameters={"s": 10.0, "r": 28.0, "b": 8.0 / 3.0})
    for name, x, y, period in (
        ("AB", -13.763610682134, -19.578751942452, "1.5586522107162"),
        ("AAB", -12.595115397689, -16.970525307084, "2.3059072639398"),
        ("AAAB", -11.998523280062, -15.684254096883, "3.0235837034339"),
        ("AABB", -12.915137970311, -17.673100172646, "3.0842767758221"),
    ):
        yield Row(
            f"Lorenz (10, 28, 8/3), orbit {name}: period", period, viswanath,
            lambda start=(x, y, 27.0), near=float(period): fr.periodic_orbit(system, start, near).period,
            allowed=1.5e-13,
        )  # fmt: skip


# --- rods and wells ---------------------------------------------------------------------------------------------------


def onset(rod: fr.Rod, unit: float, stable: float, unstable: float, **load: float) -> float:
    """Return the mean force from which on some mode grows, without vibration, in ``unit`` N."""

    def is_stable(force: float) -> bool:
        return rod.stability(fr.AxialLoad(force * unit, 0.0, 100.0, **load)).status == "stable"

    return between(is_stable, stable, unstable, 25)


def hanging(length: float, push: float = 1.0) -> tuple[fr.Rod, fr.AxialLoad]:
    """Return a string that hangs, its length in (E I / w)^(1/3), and a push on its lower end in (E I w^2)^(1/3)."""
    pipe = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, inclination=1e-9)
    rigidity, weight = pipe.flexural_rigidity, pipe.weight_per_length
    force = push * (rigidity * weight**2) ** (1.0 / 3.0)
    rod = pipe.replace(length=length * (rigidity / weight) ** (1.0 / 3.0))
    return rod, fr.AxialLoad(force, 0.0, 100.0, mean_at=1.0)


def buckled(length: float) -> float:
    """Return the push that buckles a string that hangs, hinged at both ends, in (E I w^2)^(1/3)."""

    def is_stable(push: float) -> bool:
        rod, load = hanging(length, push)
        return rod.stability(load).status == "stable"

    return between(is_stable, 1.0, 4.0, 25)


def bent(curvature: float) -> Callable[[], float]:
    """Return what finds the onset in a bend from verdicts on the modes of a long rod."""
    rod = fr.Rod.nitinol().replace(length=31.0, curvature=curvature)
    return lambda: onset(rod, 1.0, 1.0, 5.0)


def kyllingstad(curvature: float) -> float:
    """Return F from F^2 = 4 E I (q + F k), q = w / R, k = curvature / R, of the nitinol rod."""
    rod = fr.Rod.nitinol()
    q, k = rod.weight_per_length / rod.radial_clearance, curvature / rod.radial_clearance
    return float(max(np.roots([1.0, -4.0 * rod.flexural_rigidity * k, -4.0 * rod.flexural_rigidity * q]).real))


def beams() -> Iterator[Row]:
    """Yield first frequencies of beams, in sqrt(E I / m) / L^2."""
    blevins = "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1"
    for ends, printed in (
        ("clamped", "22.3733"), ("clamped-hinged", "15.4182"), ("clamped-free", "3.5160"), ("clamped-guided", "5.5933")
    ):  # fmt: skip

        def frequency(ends: str = ends) -> float:
            waves = beam.wavenumbers(EndConditions.of(ends), 3)
            return float(waves[waves > 0.0][0] ** 2)

        yield Row(f"first frequency of a beam, {ends}", printed, blevins, frequency)


def rods() -> Iterator[Row]:
    """Yield constant forces that buckle a rod, against verdicts on its modes."""
    whole = 3e-4  # modes are whole numbers: the nearest to the critical one asks for a little more
    flat = fr.Rod.nitinol().replace(length=31.0)
    yield Row(
        "first unstable mode of a level rod 31 m long, F / sqrt(E I w / R)", "2",
        "Dawson & Paslay, J. Pet. Tech. 36 (1984) 1734",
        lambda: 2.0 * onset(flat, flat.critical_force, 0.9, 1.1), here="2.0002", allowed=whole,
    )  # fmt: skip
    for curvature, here in ((0.002, "1.718635"), (0.05, "2.347377")):
        yield Row(
            f"the same in a bend of {curvature:g}/m, N", f"{kyllingstad(curvature):.6f}",
            "He & Kyllingstad, SPE Drill. Compl. 10 (1995) 10: F^2 = 4 E I (q + F k)",
            bent(curvature), here=here, allowed=whole,
        )  # fmt: skip
    lubinski = "A. Lubinski, Drill. Prod. Pract. (1950) 178"
    for length, here, why in (
        (8.0, "1.9372", ""),
        (12.0, "1.8217", "1.94 is that of a length of 8"),
        (20.0, "1.7112", "the same"),
    ):
        yield Row(
            f"string that hangs, {length:g} (E I / w)^(1/3) long, pushed, (E I w^2)^(1/3)", "1.94", lubinski,
            functools.partial(buckled, length), here=here, why=why, slow=True,
        )  # fmt: skip


HOOK_LOADS = {
    ("arc", "pushed"): ("0.535", "0.760", "0.4255"), ("arc", "pulled"): ("16.46", "18.43", "16.5162"),
    ("S", "pushed"): ("73.70", "72.03", "74.14"), ("S", "pulled"): ("113.67", "114.85", "114.02"),
    ("turn", "pushed"): ("-4.39", "-4.18", "-4.45"), ("turn", "pulled"): ("25.00", "26.05", "25.08"),
}  # fmt: skip
"""Of torque_drag 0.1.1, of welleng 0.30.0 and here, in kN: wells of benchmarks/drag.py, stations 10 m apart."""


def lock_up() -> Iterator[Row]:
    """Yield the push on a helix that is on its way to locking up."""
    rod = fr.Rod.nitinol()
    unit = rod.critical_force
    level = fr.WellPath.straight(length=10.0, inclination="90deg")
    formula = math.tan(0.2 * rod.weight_per_length * 10.0 / unit + math.atan(3.2))
    yield Row(
        "push on 10 m of a helix in a level hole, 3.2 F_p at its far end, in F_p", f"{formula:.9f}",
        "tan(mu w s / F_p + arctan 3.2), from the contact F^2 R / (4 E I) of Chen, Lin & Cheatham 1990",
        lambda: rod.mean_force(level, 0.2, far_force=3.2 * unit).at_top / unit,
        allowed=1e-8,
    )  # fmt: skip


def hook_loads() -> Iterator[Row]:
    """Yield hook loads in kN as public torque-and-drag codes find them."""
    for (well, motion), (torque_drag, welleng, here) in HOOK_LOADS.items():

        @functools.cache
        def ours(well: str = well, motion: str = motion) -> float:
            found = drag.TUBING.mean_force(drag.path(well, 10.0), drag.FRICTION, motion=motion, depth=[0.0])
            return -1e-3 * found.at_top

        def downwards(well: str = well, motion: str = motion) -> float:
            return 1e-3 * drag.johancsik(drag.path(well, 10.0), motion, upwards=-1.0)

        name = f"{well}, {motion}, kN"
        early = "inclinations of intervals from the stations above"
        yield Row(name, torque_drag, "torque_drag 0.1.1", ours, here=here, why=early, slow=well != "arc")
        why = "tension taken to press where the well builds"
        yield Row(name, welleng, "welleng 0.30.0", ours, here=here, why=why, slow=well != "arc")
        yield Row(name + ", with that sign", welleng, "welleng 0.30.0", downwards)


SUBJECTS: dict[str, Callable[[], Iterator[Row]]] = {
    "characteristic values": characteristic,
    "functions": functions,
    "power series": power_series,
    "elsewhere wrong": elsewhere_wrong,
    "ion traps": trap,
    "the published study": study,
    "systems": systems,
    "delays and noise": delays_and_noise,
    "orbits": orbits,
    "beams": beams,
    "rods": rods,
    "lock-up": lock_up,
    "hook loads": hook_loads,
}
"""Rows by subject, as the page has them."""
