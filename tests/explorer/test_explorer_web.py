"""The explorer in a browser and in a notebook."""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from floquetrod.plotting import web

ROOT = Path(__file__).parents[2]
CHROMIUM = shutil.which("chromium")


def opened() -> web.Shown:
    """Return what a new page shows."""
    return web.Shown(Figure(), lambda: {"verdict": "stable", "command": "x"})


def fetched(requests: list[tuple[str, dict[str, str]]]) -> list[tuple[int, bytes]]:
    """Return status and body of requests to a served figure; "TOKEN" in a path stands for the real one."""
    pytest.importorskip("tornado")
    from tornado.httpclient import AsyncHTTPClient

    async def ask() -> list[tuple[int, bytes]]:
        server, address = web.listen(opened, title="a & b", port=0)
        base, token = address.rstrip("/").rsplit("/", 1)
        answers = []
        try:
            for path, headers in requests:
                url = base + path.replace("TOKEN", token)
                got = await AsyncHTTPClient().fetch(url, headers=headers, raise_error=False)
                answers.append((got.code, got.body))
        finally:
            server.stop()
            await server.close_all_connections()
        return answers

    return asyncio.run(ask())


PATHS = ("/TOKEN/", "/TOKEN/mpl.js", "/TOKEN/page.js", "/TOKEN/_static/js/mpl_tornado.js", "/TOKEN/_images/home.png")


def test_the_page_answers_who_knows_its_address() -> None:
    answers = fetched(
        [*((path, {}) for path in PATHS), ("/TOKEN", {}), ("/TOKEN/nothing", {}), ("/TOKEN/download.png", {})]
    )
    assert [status for status, _ in answers] == [200] * 6 + [404] * 2
    assert b"<title>a &amp; b</title>" in answers[0][1]
    assert b'<meta name="viewport" content="width=device-width' in answers[0][1]
    assert answers[5] == answers[0]  # without the slash at its end


def test_a_name_with_a_nul_is_not_found() -> None:
    paths = ("/TOKEN/_static/%00", "/TOKEN/_images/a%00.png", "/TOKEN/%00")
    assert {status for status, _ in fetched([(path, {}) for path in paths])} == {404}


class Pages:
    """Pages of one server, each with a figure of its own, as a browser opens them."""

    def __init__(self) -> None:
        self.figures: list[Figure] = []
        self.closed: list[Figure] = []
        self.words = {"verdict": "stable", "command": "x"}

    def opened(self) -> web.Shown:
        """Open another figure."""
        figure = Figure()
        figure.canvas.mpl_connect("close_event", lambda _: self.closed.append(figure))
        self.figures.append(figure)
        return web.Shown(figure, lambda: self.words)


def talked(talk: Callable[[Pages, Callable[[str], Awaitable[Any]], str], Awaitable[None]]) -> Pages:
    """Let a coroutine open sockets by the names of their pages, at an address."""
    pytest.importorskip("tornado")
    from tornado.websocket import websocket_connect

    pages = Pages()

    async def run() -> None:
        server, address = web.listen(pages.opened, title="pages", port=0)
        sockets = []

        async def connect(name: str) -> Any:
            sockets.append(await websocket_connect(f"{address.replace('http', 'ws', 1)}ws?page={name}"))
            return sockets[-1]

        try:
            await talk(pages, connect, address)
        finally:
            for socket in sockets:
                socket.close()
                while socket.close_code is None and await socket.read_message() is not None:
                    pass
            server.stop()
            await server.close_all_connections()

    asyncio.run(run())
    return pages


async def answered(socket: Any) -> None:
    """Wait until everything said to a page has been done: it then tells its image mode."""
    await socket.write_message(json.dumps({"type": "send_image_mode"}))
    while True:
        message = await socket.read_message()
        assert message is not None, "the socket has been closed"
        if isinstance(message, str) and json.loads(message)["type"] == "image_mode":
            return


SIZES = [
    ("30000", "30000", "1"),
    ("1e9", "5", "1"),
    ("1100", "700", "1000"),
    ("1100", "700", "0"),
    ("1100", "700", "-3"),
    ("1100", "700", "NaN"),
    ("1100", "700", "1e999"),
    ("NaN", "700", "2"),
    ('"wide"', "700", "2"),
    ("0", "0", "0.01"),
    ("-5", "1e308", "4"),
]


def test_no_page_makes_a_picture_larger_than_a_screen() -> None:
    async def talk(pages: Pages, connect: Callable[[str], Awaitable[Any]], address: str) -> None:
        socket = await connect("one")
        for width, height, ratio in SIZES:
            await socket.write_message(f'{{"type": "set_device_pixel_ratio", "device_pixel_ratio": {ratio}}}')
            await socket.write_message(f'{{"type": "resize", "width": {width}, "height": {height}}}')
            await answered(socket)
            across, up = pages.figures[0].canvas.get_width_height(physical=True)
            assert min(across, up) >= 50
            assert across * up <= 9_000_000
            assert 0.5 <= pages.figures[0].canvas.device_pixel_ratio <= 4.0

    talked(talk)


def test_a_page_has_a_title_and_is_told_which_sizes_it_did_not_ask_for() -> None:
    """The script of the page fits the picture to the screen where a size is the figure's own, "forward"."""
    told: list[dict[str, Any]] = []

    async def talk(pages: Pages, connect: Callable[[str], Awaitable[Any]], address: str) -> None:
        socket = await connect("one")
        await socket.write_message('{"type": "resize", "width": 370, "height": 960}')
        await socket.write_message('{"type": "refresh"}')
        await socket.write_message('{"type": "send_image_mode"}')
        while not told or told[-1]["type"] != "image_mode":
            message = await socket.read_message()
            told.extend([json.loads(message)] if isinstance(message, str) else [])

    talked(talk)
    assert "pages" in [each["label"] for each in told if each["type"] == "figure_label"]
    sizes = [(each["size"][0], each["forward"]) for each in told if each["type"] == "resize"]
    assert [forward for _, forward in sizes] == [True, False]
    assert sizes[1][0] == 370


def test_verdict_and_command_come_with_every_picture() -> None:
    """A slider that moves redraws parts only, and the command that is copied then is that of the picture."""

    async def talk(pages: Pages, connect: Callable[[str], Awaitable[Any]], address: str) -> None:
        socket = await connect("one")
        await answered(socket)
        canvas = pages.figures[0].canvas
        canvas.draw()
        for verdict, show in (("unstable", canvas.blit), ("undecided", canvas.draw)):
            pages.words = {"verdict": verdict, "command": "y"}
            show()
            heard: dict[str, str] = {}
            while heard.get("verdict") != verdict:
                message = await asyncio.wait_for(socket.read_message(), 60.0)
                if isinstance(message, str) and json.loads(message)["type"] == "words":
                    heard = json.loads(message)
            assert heard["command"] == "y"

    talked(talk)


@given(st.floats(1.0, 1e300) | st.sampled_from([0.0, -1.0]), st.floats(1.0, 1e300), st.floats(*web._RATIOS))
def test_bounded_sizes(width: float, height: float, ratio: float) -> None:
    across, up = web.bounded(width, height, ratio)
    assert across * up * ratio**2 <= 9_000_000
    if min(width, height) >= 200 and width * height * ratio**2 <= 8_000_000 and max(width, height) <= 4000:
        assert (across, up) == (int(width), int(height))


JUNK = [
    "",
    "[]",
    "null",
    "7",
    "{",
    "{}",
    '{"type": []}',
    '{"type": "resize"}',
    '{"type": "button_press", "x": "left"}',
    '{"type": "motion_notify", "x": 1e999, "y": 0}',
    '{"type": "toolbar_button", "name": "print_figure"}',
    '{"type": "toolbar_button", "name": "__init__"}',
    '{"type": "set_device_pixel_ratio", "device_pixel_ratio": {}}',
    '{"type": "savefig", "path": "x"}',
    "[" * 5000,
]


def test_what_no_page_says_is_passed_over(caplog: pytest.LogCaptureFixture) -> None:
    async def talk(pages: Pages, connect: Callable[[str], Awaitable[Any]], address: str) -> None:
        socket = await connect("one")
        for message in JUNK:
            await socket.write_message(message)
        await answered(socket)

    talked(talk)
    assert not caplog.records


def test_two_pages_share_nothing_and_one_that_closes_says_nothing(caplog: pytest.LogCaptureFixture) -> None:
    pytest.importorskip("tornado")
    from tornado.httpclient import AsyncHTTPClient

    async def status(address: str) -> int:
        return int((await AsyncHTTPClient().fetch(address, raise_error=False)).code)

    async def talk(pages: Pages, connect: Callable[[str], Awaitable[Any]], address: str) -> None:
        one, other = await connect("one"), await connect("other")
        await one.write_message(json.dumps({"type": "set_device_pixel_ratio", "device_pixel_ratio": 2}))
        await one.write_message(json.dumps({"type": "resize", "width": 300, "height": 400}))
        await answered(one)
        await answered(other)
        assert [figure.canvas.device_pixel_ratio for figure in pages.figures] == [2, 1]
        assert pages.figures[0].canvas.get_width_height(physical=True) == (600, 800)
        assert pages.figures[1].canvas.get_width_height(physical=True) == (640, 480)
        assert await status(f"{address}download.png?page=one") == 200
        assert await status(f"{address}download.png?page=none") == 404
        one.close()
        pages.figures[0].canvas.draw_idle()
        while pages.figures[0] not in pages.closed:
            await asyncio.sleep(0.01)
        pages.figures[0].canvas.manager.refresh_all()  # as a timer that still runs
        assert await status(f"{address}download.png?page=one") == 404
        await answered(other)

    pages = talked(talk)
    assert len(pages.figures) == 2
    assert not caplog.records


def test_pages_are_so_many_and_no_more() -> None:
    async def talk(pages: Pages, connect: Callable[[str], Awaitable[Any]], address: str) -> None:
        sockets = [await connect(f"page{k}") for k in range(web._MOST_PAGES)]
        for name, code, reason in (("more", 1013, "8 pages are open"), ("", 1013, "8 pages")):
            refused = await connect(name)
            assert await refused.read_message() is None
            assert refused.close_code == code
            assert refused.close_reason.startswith(reason)
        sockets[0].close()
        while not pages.closed:
            await asyncio.sleep(0.01)
        again = await connect("more")
        await answered(again)
        twice = await connect("more")
        assert await twice.read_message() is None

    talked(talk)


def test_everybody_else_is_refused() -> None:
    wrong = [path.replace("TOKEN", token) for path in PATHS for token in ("x", "", "TOKENx", "TOKE")]
    upgrade = {
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
    }
    requests = [
        *((path, {}) for path in (*wrong, "/", "/favicon.ico", "/x/ws", "/x/download.png", "/nothing")),
        *((path, {"Host": "evil.example"}) for path in PATHS),
        *((path, {"Origin": "http://evil.example"}) for path in PATHS),
        ("/x/ws", upgrade),
        ("/TOKEN/ws", {**upgrade, "Origin": "http://evil.example"}),
        ("/TOKEN/ws", {**upgrade, "Host": "evil.example"}),
    ]
    assert {status for status, _ in fetched(requests)} == {403}


def test_a_port_that_is_taken() -> None:
    pytest.importorskip("tornado")
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        number = taken.getsockname()[1]
        with pytest.raises(ValueError, match=f"--port {number} cannot be listened on"):
            web.serve(opened, print, title="", port=number)


def test_without_tornado(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tornado", None)
    with pytest.raises(ValueError, match=r"--web needs tornado, which is not installed: pip install floquetrod\[web\]"):
        web.serve(opened, print, title="")


@contextlib.contextmanager
def explorer(*options: str) -> Iterator[tuple[Any, str]]:
    """Run the explorer for the browser; yield its process and its address."""
    command = [sys.executable, "-m", "floquetrod", "explore", *options, "--web"]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, cwd=ROOT, env=environment, **pipes) as process:
        try:
            found = None
            while found is None:
                line = process.stderr.readline()  # type: ignore[union-attr]
                assert line, "the explorer has ended"
                found = re.search(r"http://\S+/", line)
            yield process, found[0]
        finally:
            process.kill()


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_slider_moved_in_a_browser() -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    load = ("--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150")
    with explorer("--rod", "nitinol", *load) as (process, address), playwright.sync_playwright() as driver:
        arguments = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=arguments)
        page = browser.new_page(viewport={"width": 1200, "height": 1000})
        errors: list[str] = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)

        def waited(words: str) -> None:
            until = time.monotonic() + 600.0
            while not page.inner_text("#verdict").startswith(words) and time.monotonic() < until:
                time.sleep(0.2)
            assert page.inner_text("#verdict").startswith(words)

        waited("unstable: mode 7 grows")
        canvas = page.locator("canvas").first
        before, box = canvas.screenshot(), canvas.bounding_box()
        across, height = box["x"] + 0.26 * box["width"], box["y"] + 0.75 * box["height"]
        page.mouse.move(across + 0.18 * 0.58 * box["width"], height)
        page.mouse.down()
        page.mouse.move(across + 0.34 / 1.1 * 0.58 * box["width"], height, steps=3)
        page.mouse.up()
        waited("stable")
        mean = re.search(r"--mean (\S+)Fcr", page.inner_text("#command"))
        assert mean is not None
        assert 0.33 < float(mean[1]) < 0.35
        assert canvas.screenshot() != before
        refused = browser.new_page()
        assert refused.goto(address.rsplit("/", 2)[0] + "/wrong/").status == 403
        browser.close()
        assert not errors
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=600)
        assert process.returncode == 0
        assert out.splitlines()[-1].startswith(f"floquetrod check --rod nitinol --mean {mean[1]}Fcr ")


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_on_a_phone_the_picture_fits_and_a_finger_moves_a_slider() -> None:
    playwright = pytest.importorskip("playwright.sync_api")
    load = ("--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150rad/s")
    with explorer("--rod", "nitinol", *load) as (_, address), playwright.sync_playwright() as driver:
        arguments = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=arguments)
        page = browser.new_page(viewport={"width": 390, "height": 844}, has_touch=True)
        errors: list[str] = []
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.goto(address)

        def waited(holds: Callable[[], bool]) -> None:
            until = time.monotonic() + 60.0
            while not holds() and time.monotonic() < until:
                time.sleep(0.2)
            assert holds()

        waited(lambda: "--mean 0.2Fcr" in page.inner_text("#command"))
        waited(lambda: page.locator("canvas").first.bounding_box()["width"] < 390)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        box = page.locator("canvas").first.bounding_box()
        slider = page.evaluate("window.scrollY") + box["y"] + 0.819 * box["height"]
        page.evaluate(f"window.scrollTo(0, {slider - 400})")
        up, finger = page.evaluate("window.scrollY"), page.context.new_cdp_session(page)
        for kind, across in (("touchStart", 0.2), ("touchMove", 0.25), ("touchMove", 0.3), ("touchEnd", None)):
            points = [] if across is None else [{"x": box["x"] + across * box["width"], "y": slider - up}]
            finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
            page.wait_for_timeout(100)  # movements that follow each other at once count as one
        waited(lambda: "--mean 0.2Fcr" not in page.inner_text("#command"))
        browser.close()
        assert not errors


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ipympl") is None, reason="needs ipympl")
def test_in_a_notebook() -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    cells = [
        "%matplotlib widget\nimport floquetrod as fr\nexplorer = fr.Explorer(fr.Rod.nitinol())",
        "assert explorer.window.is_live\nexplorer.window.figure.canvas",
        "explorer.window.figure.canvas.draw()\nexplorer.window.sliders['mean'].set_val(0.5)",
        "import asyncio\n"
        "for _ in range(600):\n"
        "    await asyncio.sleep(0.1)\n"
        "    if 'amplitude' in explorer.window.words['details']: break\n"
        "assert 'same verdict for' in explorer.window.words['details']\n"
        "print(explorer.command)",
    ]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(ROOT)}}).execute()
    assert notebook.cells[-1].outputs[0].text.startswith("floquetrod check --rod nitinol --mean 0.5N ")
