"""The explorer: how often a second it follows a slider, and what memory moves and pages in a browser add."""

from __future__ import annotations

import asyncio
import importlib.util
import itertools
import json
import resource

import matplotlib as mpl

import floquetrod as fr
from benchmarks.measure import Row, best_of
from floquetrod.plotting import web

MOVES, PAGES = 500, 40


def run() -> list[Row]:
    """Return what a move of each slider costs, picture included, and the memory that moves and pages add."""
    backend = mpl.get_backend()
    mpl.use("Agg")
    from matplotlib import pyplot

    try:
        rows = [
            Row(f"a move of the {name}", seconds(name), "s", at_most=0.1) for name in ("mean", "amplitude", "frequency")
        ]
        rows += [Row(f"memory added by {MOVES:,} moves, after the first tenth", added_by_moves(), "MB", at_most=20.0)]
        if importlib.util.find_spec("tornado") is not None:
            added = asyncio.run(added_by_pages())
            rows += [Row(f"memory added by {PAGES} pages, after the first half", added, "MB", at_most=20.0)]
        return rows
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


def added_by_moves() -> float:
    """Return the megabytes that moves of a slider add after the first tenth of them."""
    explorer = fr.Explorer(fr.Rod.nitinol())
    explorer.window.figure.canvas.draw()
    slider = explorer.window.sliders["mean"]
    for k in range(MOVES):
        slider.set_val(slider.valmin + (slider.valmax - slider.valmin) * (k % 100) / 100.0)
        if k == MOVES // 10:
            began = most_memory()
    return most_memory() - began


async def added_by_pages() -> float:
    """Return the megabytes that pages add, opened, drawn and closed one after another, after the first half."""
    from tornado.websocket import websocket_connect

    def opened() -> web.Shown:
        explorer = fr.Explorer(fr.Rod.nitinol())
        return web.Shown(explorer.window.figure, lambda: explorer.window.words)

    server, address = web.listen(opened, title="explorer", port=0)
    for k in range(PAGES):
        socket = await websocket_connect(f"{address.replace('http', 'ws', 1)}ws?page={k}")
        for message in ({"type": "resize", "width": 1100, "height": 700}, {"type": "refresh"}, {"type": "draw"}):
            await socket.write_message(json.dumps(message))
        while not isinstance(await socket.read_message(), bytes):
            pass
        socket.close()
        while await socket.read_message() is not None:
            pass
        if k == PAGES // 2:  # figures that hold each other are collected now and then
            began = most_memory()
    server.stop()
    await server.close_all_connections()
    return most_memory() - began


def most_memory() -> float:
    """Return the most memory that this process has had, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
