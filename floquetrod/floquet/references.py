"""Publications to cite for a result, floquetrod first; `floquetrod.floquet.registry` has the sources of each method."""

from __future__ import annotations

from collections.abc import Iterable

from floquetrod._util.version import __version__

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

THEORY = "V. A. Yakubovich and V. M. Starzhinskii, Linear Differential Equations with Periodic Coefficients, Wiley 1975"
DLMF = "NIST Digital Library of Mathematical Functions, chapter 28, https://dlmf.nist.gov/28"
BOTT = "R. Bott, Comm. Pure Appl. Math. 9 (1956) 171, doi:10.1002/cpa.3160090204"
MEHRMANN = "V. Mehrmann and D. Watkins, SIAM J. Sci. Comput. 22 (2001) 1905, doi:10.1137/S1064827500366434"
ASCHER = (
    "U. M. Ascher, R. M. M. Mattheij and R. D. Russell, Numerical Solution of Boundary Value Problems for Ordinary "
    "Differential Equations, SIAM 1995, doi:10.1137/1.9781611971231"
)
JORBA = "A. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99, doi:10.1080/10586458.2005.10128904"
RUMP = "S. M. Rump, Verification methods, Acta Numerica 19 (2010)"
ARNOLD = "L. Arnold, Stochastic Differential Equations: Theory and Applications, Wiley 1974"

INSPERGER = (
    "T. Insperger and G. Stepan, Semi-Discretization for Time-Delay Systems, Springer 2011, "
    "doi:10.1007/978-1-4614-0335-7"
)
GU = (
    "K. Gu, V. L. Kharitonov and J. Chen, Stability of Time-Delay Systems, Birkhaeuser 2003, "
    "doi:10.1007/978-1-4612-0039-0"
)
SIEBER = "J. Sieber and R. Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011) 129, doi:10.1137/100796455"
BREDA = "D. Breda, S. Maset and R. Vermiglio, SIAM J. Numer. Anal. 50 (2012) 1456, doi:10.1137/100815505"
KUCHLER = "U. Kuechler and B. Mensch, Stochastics and Stochastic Reports 40 (1992) 23"

NOISE = (ARNOLD,)
"""Sources of the second moments of a system under noise."""

SOLUTIONS, DELAYED_SOLUTIONS = (JORBA,), (BREDA,)
"""Sources of `floquetrod.solve`, without delays and with them."""

ORBITS = (ASCHER, THEORY)
"""Sources of periodic orbits: collocation, and multipliers from maps over its mesh."""

ROD = (STUDY,)
"""Sources of the model of a rod."""


def references(*sources: Iterable[str]) -> tuple[str, ...]:
    """Return the publications to cite for a result: floquetrod first, then the sources of what was used, each once.

    >>> references(ROD, NOISE, ROD)[1:] == (STUDY, ARNOLD)
    True
    """
    return united((FLOQUETROD,), *sources)


def united(*references: Iterable[str]) -> tuple[str, ...]:
    """Return the references of several results, each once."""
    return tuple(dict.fromkeys(reference for result in references for reference in result))
