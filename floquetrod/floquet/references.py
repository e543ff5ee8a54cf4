"""What to cite for a result: one table of the sources of every method, and floquetrod itself."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from floquetrod._util.version import __version__
from floquetrod.floquet.problems import kind_of

STUDY_TITLE = "The Instability Mechanism of a Confined Rod Under Axial Vibrations, J. Appl. Mech. 83 (2016) 011005"
"""The published study behind the rod."""

STUDY_DOI = "10.1115/1.4031710"
"""Its DOI."""

STUDY = f"{STUDY_TITLE}, doi:{STUDY_DOI}"
"""Both, as they are cited."""

FLOQUETROD = (
    "The floquetrod developers, floquetrod: Floquet and spectral stability of a rod vibrated inside a channel, version "
    f"{__version__}"
)
"""The package itself, as in CITATION.cff."""

_THEORY = (
    "V. A. Yakubovich and V. M. Starzhinskii, Linear Differential Equations with Periodic Coefficients, Wiley 1975"
)
_DLMF = "NIST Digital Library of Mathematical Functions, chapter 28, https://dlmf.nist.gov/28"
_BOTT = "R. Bott, Comm. Pure Appl. Math. 9 (1956) 171, doi:10.1002/cpa.3160090204"
_MEHRMANN = "V. Mehrmann and D. Watkins, SIAM J. Sci. Comput. 22 (2001) 1905, doi:10.1137/S1064827500366434"
_ASCHER = (
    "U. M. Ascher, R. M. M. Mattheij and R. D. Russell, Numerical Solution of Boundary Value Problems for Ordinary "
    "Differential Equations, SIAM 1995, doi:10.1137/1.9781611971231"
)
_JORBA = "A. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99, doi:10.1080/10586458.2005.10128904"
_RUMP = "S. M. Rump, Verification methods, Acta Numerica 19 (2010)"
_ARNOLD = "L. Arnold, Stochastic Differential Equations: Theory and Applications, Wiley 1974"

_INSPERGER = (
    "T. Insperger and G. Stepan, Semi-Discretization for Time-Delay Systems, Springer 2011, "
    "doi:10.1007/978-1-4614-0335-7"
)
_GU = (
    "K. Gu, V. L. Kharitonov and J. Chen, Stability of Time-Delay Systems, Birkhaeuser 2003, "
    "doi:10.1007/978-1-4612-0039-0"
)
_SIEBER = "J. Sieber and R. Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011) 129, doi:10.1137/100796455"
_BREDA = "D. Breda, S. Maset and R. Vermiglio, SIAM J. Numer. Anal. 50 (2012) 1456, doi:10.1137/100815505"

SOURCES: dict[tuple[str, str], tuple[str, ...]] = {
    ("equation", "spectral"): (_DLMF,),
    ("equation", "determinant"): (STUDY, _DLMF),
    ("equation", "monodromy"): (_THEORY,),
    ("equation", "square_wave"): (STUDY,),
    ("equation", "leapfrog"): (STUDY,),
    ("equation", "reference"): (_THEORY,),
    ("system", "half_period"): (_THEORY,),
    ("system", "monodromy"): (_THEORY, _MEHRMANN),
    ("system", "segmented"): (_THEORY,),
    ("system", "spectral"): (_THEORY, _BOTT),
    ("system", "reference"): (_THEORY, _MEHRMANN),
    ("equation", "certify"): (_DLMF, _THEORY),
    ("system", "certify"): (_THEORY, _BOTT, _RUMP),
    ("delays", "collocation"): (_BREDA, _INSPERGER),
    ("delays", "semi_discretisation"): (_INSPERGER,),
    ("delays", "certify"): (_GU, _SIEBER),
    ("delays", "solve"): (_BREDA,),
    ("any", "solve"): (_JORBA,),
    ("any", "noise"): (_ARNOLD,),
    ("orbit", "collocation"): (_ASCHER,),
    ("rod", "model"): (STUDY,),
}
"""Sources of each method, by what it is for and its name."""


def used_on(subject: Any, method: str) -> tuple[tuple[str, str], ...]:
    """Return what was used where a method answered for an equation, a system, or second moments."""
    own = (kind_of(subject).name, method)
    return (own, ("any", "noise")) if getattr(subject, "MEANING", "") else (own,)


def references(*used: tuple[str, str]) -> tuple[str, ...]:
    """Return what to cite for a result: floquetrod first, then the sources of the methods used, each once.

    >>> references(("equation", "square_wave"))[1].rpartition(" ")[2]
    'doi:10.1115/1.4031710'
    """
    return united((FLOQUETROD,), *(SOURCES[method] for method in used))


def united(*several: Iterable[str]) -> tuple[str, ...]:
    """Return the references of several results, each once."""
    return tuple(dict.fromkeys(each for found in several for each in found))
