"""The explorer: how often a second it follows a slider, without a screen."""

from __future__ import annotations

import itertools

import matplotlib as mpl

import floquetrod as fr
from benchmarks.measure import Row, best_of


def run() -> list[Row]:
    """Return what a move of each slider costs, picture included."""
    backend = mpl.get_backend()
    mpl.use("Agg")
    from matplotlib import pyplot

    try:
        return [
            Row(f"a move of the {name}", seconds(name), "s", at_most=0.1) for name in ("mean", "amplitude", "frequency")
        ]
    finally:
        pyplot.close("all")
        mpl.use(backend)


def seconds(name: str) -> float:
    """Return the seconds from a move of one slider to the new picture, over moves across half of its range."""
    explorer = fr.Explorer(fr.Rod.nitinol())
    explorer.window.figure.canvas.draw()
    slider = explorer.window.sliders[name]
    width = slider.valmax - slider.valmin
    places = [slider.valmin + width * (0.25 + 0.5 * step / 20.0) for step in range(21)]
    there_and_back = itertools.cycle([*places, *reversed(places)])

    def moves() -> None:
        for _ in range(20):
            slider.set_val(next(there_and_back))

    return best_of(moves, repeats=3) / 20.0
