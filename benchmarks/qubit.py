"""Quasienergies of driven atoms of two and eight levels: time and error, beside QuTiP's Floquet basis and DOP853.

QuTiP is left out where it is not installed: `pip install qutip`.  Errors are differences from a Fourier series in time
whose infinite matrix is cut where its levels no longer change.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import floquetrod as fr
from benchmarks.measure import Row, best_of

_HARMONICS = 60  # of the series in time, either way


class Atom(NamedTuple):
    """A Hamiltonian H0 + H1 sin(omega t), in units with hbar = 1."""

    mean: Any  # (n, n)
    driven: Any  # (n, n)
    omega: float


def atoms() -> list[Atom]:
    """Return QuTiP's driven qubit and a ladder of eight levels with a drive between neighbours."""
    sx, sz = np.array([[0.0, 1.0], [1.0, 0.0]]), np.diag([1.0, -1.0])
    qubit = Atom(-math.pi * (0.2 * sx + sz), 2.5 * math.pi * sz, 2.0 * math.pi)
    level = np.arange(8.0)
    step = np.diag(np.sqrt(level[1:]), 1)
    return [qubit, Atom(np.diag(level - 0.05 * level**2), 0.3 * (step + step.T), 1.1)]


def run() -> list[Row]:
    """Return times and errors of the quasienergies, ours and the peers'."""
    return [row for atom in atoms() for row in rows_of(atom)]


def rows_of(atom: Atom) -> list[Row]:
    """Return the rows of one atom."""
    exact, many = series_in_time(atom), np.ones((400, 1, 1))
    # Kernels are compiled for many systems.
    fr.systems.multipliers(ours(atom._replace(mean=many * atom.mean, driven=many * atom.driven)))
    codes: dict[str, Callable[[], Any]] = {
        "ours": lambda: fr.stability(ours(atom)).quasienergies,
        "DOP853, rtol 1e-12": lambda: by_dop853(atom),
    }
    if importlib.util.find_spec("qutip"):
        codes["QuTiP, as it comes"] = lambda: by_qutip(atom, {})
        codes["QuTiP, rtol 1e-12"] = lambda: by_qutip(
            atom, {"atol": 1e-14, "rtol": 1e-12, "nsteps": 100_000, "method": "vern9"}
        )
    seconds = {name: best_of(code, repeats=5) for name, code in codes.items()}
    off = {name: max(1e-17, distance(code(), exact, atom.omega)) for name, code in codes.items()}
    what, own = f"{len(atom.mean)} levels", codes.keys() - {"ours"}
    return [
        row
        for name in sorted(own)
        for row in (
            Row(f"{what}: quasienergies", 1e3 * seconds["ours"], "ms", name, 1e3 * seconds[name]),
            Row(f"{what}: largest error", off["ours"], "", name, off[name]),
        )
    ]


def ours(atom: Atom) -> Any:
    """Return the atom as a system x' = -i H x."""
    period = 2.0 * math.pi / atom.omega
    return fr.PeriodicSystem(-1j * atom.mean, sines=[-1j * atom.driven], period=period)


def by_qutip(atom: Atom, options: dict[str, Any]) -> Any:
    """Return QuTiP's quasienergies."""
    qutip = importlib.import_module("qutip")
    hamiltonian = [qutip.Qobj(atom.mean), [qutip.Qobj(atom.driven), lambda t: math.sin(atom.omega * t)]]
    return qutip.FloquetBasis(hamiltonian, 2.0 * math.pi / atom.omega, options=options or None).e_quasi


def by_dop853(atom: Atom) -> Any:
    """Return quasienergies of the monodromy matrix by SciPy's DOP853."""
    n, period = len(atom.mean), 2.0 * math.pi / atom.omega

    def rates(t: float, x: Any) -> Any:
        return (-1j * (atom.mean + math.sin(atom.omega * t) * atom.driven) @ x.reshape(n, n)).ravel()

    run = solve_ivp(rates, (0.0, period), np.eye(n, dtype=complex).ravel(), "DOP853", rtol=1e-12, atol=1e-14)
    return -np.angle(np.linalg.eigvals(run.y[:, -1].reshape(n, n))) / period


def series_in_time(atom: Atom) -> Any:
    """Return quasienergies by the Hermitian matrix of all harmonics (Shirley 1965, doi:10.1103/PhysRev.138.B979)."""
    n, size = len(atom.mean), 2 * _HARMONICS + 1
    up = np.diag(np.ones(size - 1), -1)  # exp(i omega t) times a harmonic is the next
    sine = (up - up.T) / 2j
    levels = np.arange(-_HARMONICS, _HARMONICS + 1) * atom.omega
    matrix = np.kron(np.eye(size), atom.mean) + np.kron(np.diag(levels), np.eye(n)) + np.kron(sine, atom.driven)
    values, vectors = np.linalg.eigh(matrix)
    weights = (np.abs(vectors.reshape(size, n, -1)) ** 2).sum(axis=1)
    at = (np.arange(size)[:, None] * weights).sum(axis=0)  # mean harmonic: those in the middle feel no cut
    middle = np.argsort(np.abs(at - _HARMONICS))[: 2 * n]
    return values[middle]


def distance(values: Any, exact: Any, omega: float) -> float:
    """Return the largest distance of quasienergies from the nearest exact one, multiples of omega apart or not."""
    off = np.abs((np.asarray(values)[:, None] - exact + 0.5 * omega) % omega - 0.5 * omega)
    return float(off.min(axis=1).max())
