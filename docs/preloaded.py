"""What the process that kernels are forked from does first: it imports, and calls once, what most pages use.

A page is spared two seconds of importing, and one in which numba, matplotlib and sympy prepare their first use.
"""

from __future__ import annotations

import gc
import importlib
import io
import pkgutil

import numpy as np
import sympy
from matplotlib.figure import Figure

import floquetrod as fr

OTHERS = (
    "ipykernel.debugger",
    "ipykernel.ipkernel",
    "ipykernel.kernelapp",
    "matplotlib.pyplot",
    "numba",
    "psutil",
    "scipy.optimize",
)


def import_all() -> None:
    """Import all of the package, and what else most pages and every kernel import."""
    own = (module.name for module in pkgutil.walk_packages(fr.__path__, "floquetrod."))
    for name in (*OTHERS, *(name for name in own if not name.endswith("__main__"))):
        importlib.import_module(name)


def call() -> None:
    """Ask for verdicts, of an equation for so many that they are compiled, simulate, draw and simplify."""
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(mean=0.2 * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
    fr.mathieu.growth_rate(np.linspace(0.0, 1.0, 100_000), 0.3)
    rod.stability(load)
    rod.replace(inclination="45deg").stability(load)
    fr.simulate(rod, load, duration=1e-3)

    figure = Figure()  # not of pyplot, which would choose how figures are shown before there is a kernel to show them
    axes = figure.subplots()
    axes.plot([0.0, 1.0], label=r"$\alpha$")
    axes.legend()
    figure.savefig(io.BytesIO(), format="png")

    x = sympy.Symbol("x")
    sympy.simplify(sympy.integrate(sympy.sin(x) ** 2, (x, 0, sympy.pi)))
    sympy.lambdify(x, sympy.sin(x))


import_all()
call()
gc.collect()
gc.freeze()  # so that no kernel goes through what is there already to find garbage
