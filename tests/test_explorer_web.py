"""The explorer in a browser and in a notebook."""

from __future__ import annotations

import asyncio
import contextlib
import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from floquetrod.plotting import web

ROOT = Path(__file__).parents[1]
CHROMIUM = shutil.which("chromium")


def fetched(requests: list[tuple[str, dict[str, str]]]) -> list[tuple[int, bytes]]:
    """Return status and body of requests to a served figure; "TOKEN" in a path stands for the real one."""
    pytest.importorskip("tornado")
    from tornado.httpclient import AsyncHTTPClient

    async def ask() -> list[tuple[int, bytes]]:
        server, address = web.listen(Figure(), lambda: {"verdict": "stable", "command": "x"}, title="a & b", port=0)
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
        [*((path, {}) for path in PATHS), ("/TOKEN/download.png", {}), ("/TOKEN", {}), ("/TOKEN/nothing", {})]
    )
    assert [status for status, _ in answers] == [200] * 7 + [404]
    assert b"<title>a &amp; b</title>" in answers[0][1]
    assert answers[5][1].startswith(b"\x89PNG")
    assert answers[6] == answers[0]  # without the slash at its end


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
            web.serve(Figure(), dict, print, title="", port=number)


def test_without_tornado(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tornado", None)
    with pytest.raises(ValueError, match=r"--web needs tornado, which is not installed: pip install floquetrod\[web\]"):
        web.serve(Figure(), dict, print, title="")


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
            until = time.monotonic() + 120.0
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
        out, _ = process.communicate(timeout=60)
        assert process.returncode == 0
        assert out.splitlines()[-1].startswith(f"floquetrod check --rod nitinol --mean {mean[1]}Fcr ")


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
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(ROOT)}}).execute()
    assert notebook.cells[-1].outputs[0].text.startswith("floquetrod check --rod nitinol --mean 0.5N ")
