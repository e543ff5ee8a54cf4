"""A figure in the browser of this machine, with its sliders: matplotlib's WebAgg behind an address nobody can guess.

panel 1.9 fails two tests of test_explorer_web.py: its scripts and icon answer foreign hosts
(::test_everybody_else_is_refused), and a message that no page sends ends the page with a traceback
(::test_what_no_page_says_is_passed_over).  The numbers are in benchmarks/README.md.
"""

from __future__ import annotations

import asyncio
import hmac
import html
import importlib.util
import json
import math
import secrets
import socket
from collections.abc import Callable, Mapping
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

_MOST_PAGES = 8  # open at once: each takes a figure of its own (a choice)
_SIDES = 200.0, 4000.0  # least and largest side of a picture in pixels of the page (a choice)
_RATIOS = 0.5, 4.0  # least and largest number of pixels of the screen for one of the page (a choice)
_MOST_PIXELS = 9_000_000  # of a picture, some more than a screen of 3840 x 2160 has (a choice)
_EVENTS = (
    *("ack", "draw", "refresh", "resize", "send_image_mode", "set_device_pixel_ratio", "toolbar_button"),
    *("button_press", "button_release", "dblclick", "motion_notify", "scroll", "key_press", "key_release"),
    *("figure_enter", "figure_leave"),
)
"""What a page may tell its figure."""

_HOST = "127.0.0.1"
_DOWNLOADS = {"png": "image/png", "pdf": "application/pdf", "svg": "image/svg+xml"}

_PAGE = """<!DOCTYPE html>
<html lang="en">
  <head>
    <meta charset="utf-8">
    <meta name="viewport" content="width=device-width, initial-scale=1">
    <title>{title}</title>
    <link rel="icon" href="data:,">
    <link rel="stylesheet" href="_static/css/page.css">
    <link rel="stylesheet" href="_static/css/boilerplate.css">
    <link rel="stylesheet" href="_static/css/fbm.css">
    <link rel="stylesheet" href="_static/css/mpl.css">
    <script src="_static/js/mpl_tornado.js"></script>
    <script src="mpl.js"></script>
    <script src="page.js"></script>
  </head>
  <body>
    <main>
      <h1 style="position: absolute; left: -999em">{title}</h1>
      <div id="mpl-warnings" class="mpl-warnings"></div>
      <div id="figure" role="group" aria-label="picture and sliders" style="margin: 10px"></div>
      <p style="margin: 10px" id="verdict" role="status"></p>
      <p style="margin: 10px; overflow-wrap: anywhere"><code id="command"></code>
      <button id="copy" type="button">copy the command</button></p>
      <p style="margin: 10px" id="ended" role="alert"></p>
    </main>
  </body>
</html>
"""

_SCRIPT = """"use strict";
document.addEventListener("DOMContentLoaded", function () {
  const page = Array.from(crypto.getRandomValues(new Uint32Array(4)), (part) => part.toString(16)).join("");
  const socket = new WebSocket(window.location.href.replace(/^http/, "ws") + "ws?page=" + page);
  const show = function (name, text) { document.getElementById(name).textContent = text; };
  const figure = new mpl.figure(1, socket, function (figure, format) {
    window.open("download." + format + "?page=" + page, "_blank", "noopener");
  }, document.getElementById("figure"));
  const fit = function () {  // the picture follows the size of what it is in
    const place = document.getElementById("figure").getBoundingClientRect();
    const width = Math.min(1100, Math.floor(place.width) - 2);
    const height = width < 800 ? 1014 : Math.max(560, Math.round(width * 7 / 11));  // letters keep their size
    Object.assign(figure.canvas_div.style, {width: width + "px", height: height + "px"});
  };
  const handle_resize = figure.handle_resize;
  figure.handle_resize = function (figure, message) {  // the figure's own size, when the page opens, does not count
    if (message.forward) { fit(); } else { handle_resize(figure, message); }
  };
  figure.canvas_div.style.touchAction = "pan-y";  // a finger moved sideways moves a slider
  const names = {pointerdown: "mousedown", pointermove: "mousemove", pointerup: "mouseup"};
  for (const [touched, name] of Object.entries(names)) {
    figure.canvas_div.addEventListener(touched, function (event) {
      if (event.pointerType === "touch") { figure.canvas_div.dispatchEvent(new MouseEvent(name, event)); }
    });
  }
  let waiting = null;
  window.addEventListener("resize", function () {
    clearTimeout(waiting);
    waiting = setTimeout(fit, 200);
  });
  figure.handle_words = function (figure, message) {
    show("verdict", message.verdict);
    show("command", message.command);
  };
  socket.addEventListener("close", function (event) {
    show("ended", event.reason || "The program has ended; what is shown no longer moves.");
  });
  document.getElementById("copy").addEventListener("click", function () {
    navigator.clipboard.writeText(document.getElementById("command").textContent);
  });
});
"""


def require_tornado() -> None:
    """Raise ValueError where the web server is not installed."""
    if importlib.util.find_spec("tornado") is None:
        raise ValueError("--web needs tornado, which is not installed: pip install floquetrod[web]")


class Shown(NamedTuple):
    """What one page shows: a figure, whose canvas is replaced, and the texts "verdict" and "command" below it."""

    figure: Any
    words: Callable[[], Mapping[str, str]]


def serve(opened: Callable[[], Shown], told: Callable[[str], None], *, title: str, port: int = 0) -> None:
    """Show figures in the browser until Ctrl-C: to whoever knows the address, on this machine only.

    ``opened`` returns the figure of a page that has been opened, which is closed with the page; ``told`` is called with
    the address.  A port of 0 is any free one; ValueError where it is taken, or tornado is missing.
    """
    require_tornado()

    async def until_cancelled() -> None:
        server, address = listen(opened, title=title, port=port)
        try:
            told(address)
            await asyncio.Event().wait()
        finally:
            server.stop()
            await server.close_all_connections()

    try:
        asyncio.run(until_cancelled())
    except KeyboardInterrupt:
        return


def listen(opened: Callable[[], Shown], *, title: str, port: int) -> tuple[Any, str]:
    """Return a server of figures, which answers within the running loop, and its address."""
    from tornado.httpserver import HTTPServer

    try:
        listening = socket.create_server((_HOST, port))
    except (OSError, OverflowError) as error:
        raise ValueError(
            f"--port {port} cannot be listened on: {getattr(error, 'strerror', None) or error}; leave --port out for "
            "any free one"
        ) from None
    listening.setblocking(False)
    number, token = listening.getsockname()[1], secrets.token_urlsafe(24)
    server = HTTPServer(_application(opened, token, f"{_HOST}:{number}", title))
    server.add_socket(listening)
    return server, f"http://{_HOST}:{number}/{token}/"


class Page:
    """A figure in one page of the browser, of bounded size."""

    def __init__(self, shown: Shown, socket: Any, title: str) -> None:
        """Give the figure a canvas that draws to a socket."""
        from matplotlib.backends.backend_webagg_core import FigureCanvasWebAggCore

        self.figure = shown.figure
        manager: Any = FigureCanvasWebAggCore.new_manager(self.figure, 1)
        manager.set_window_title(title)
        self.figure.set_label(title)  # matplotlib 3.9 and older title the page with it
        self._manager = manager
        self._size, self._ratio = (math.inf, math.inf), 1.0
        refresh = manager.refresh_all

        def refresh_with_words() -> None:
            refresh()
            manager.canvas.send_event("words", **shown.words())

        manager.refresh_all = refresh_with_words  # every new picture, of a part or whole, ends with it
        manager.add_web_socket(socket)
        self.socket = socket

    def handle(self, message: str | bytes) -> None:
        """Act on an event of the page; messages of any other kind are passed over."""
        try:
            content = json.loads(message, parse_constant=_refused)
            kind = content.get("type") if isinstance(content, dict) else None
            # 1e999 is JSON, and infinite.
            if kind not in _EVENTS or not all(
                math.isfinite(value) for value in content.values() if isinstance(value, int | float)
            ):
                return
            if kind == "resize":
                self._size = float(content["width"]), float(content["height"])
                self._resize()
            elif kind == "set_device_pixel_ratio":
                low, high = _RATIOS
                self._ratio = min(max(float(content["device_pixel_ratio"]), low), high)
                self._manager.handle_json({"type": kind, "device_pixel_ratio": self._ratio})
                self._resize()
            else:
                self._manager.handle_json(content)
        except (ArithmeticError, AttributeError, KeyError, RecursionError, TypeError, ValueError):
            return

    def _resize(self) -> None:
        """Give the figure the size last asked for, within bounds."""
        if math.isfinite(self._size[0]):
            width, height = bounded(*self._size, self._ratio)
            self._manager.handle_json({"type": "resize", "width": width, "height": height})

    def close(self) -> None:
        """Let go of the figure, its timer and its work."""
        from matplotlib import pyplot
        from matplotlib.backend_bases import CloseEvent

        canvas = self._manager.canvas
        self._manager.remove_web_socket(self.socket)
        canvas.callbacks.process("close_event", CloseEvent("close_event", canvas))
        pyplot.close(self.figure)


def bounded(width: float, height: float, ratio: float) -> tuple[int, int]:
    """Return the size of a picture in pixels of a page, as asked for where that is no larger than a large screen.

    >>> bounded(30_000, 30_000, 1.0), bounded(1100, 700, 2.0)
    ((3000, 3000), (1100, 700))
    """
    low, high = _SIDES
    width, height = (min(max(side, low), high) for side in (width, height))
    less = min(1.0, math.sqrt(_MOST_PIXELS / (width * height)) / ratio)
    return int(less * width), int(less * height)


def _refused(constant: str) -> float:
    raise ValueError(constant)  # NaN and Infinity are not JSON


def _application(opened: Callable[[], Shown], token: str, host: str, title: str) -> Any:
    """Return the tornado application; every request without the token, or from a foreign page, is refused with 403."""
    import matplotlib as mpl
    from matplotlib.backends import backend_webagg_core
    from tornado.web import Application, HTTPError, RequestHandler, StaticFileHandler
    from tornado.websocket import WebSocketClosedError, WebSocketHandler

    pages: dict[str, Page] = {}
    files: Any = backend_webagg_core.FigureManagerWebAgg

    policy = f"default-src 'self'; connect-src 'self' ws://{host}; img-src 'self' data: blob:; style-src 'self' "
    policy += "'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"

    class Guarded(RequestHandler):
        def set_default_headers(self) -> None:
            self.set_header("Content-Security-Policy", policy)
            self.set_header("Referrer-Policy", "no-referrer")
            self.set_header("X-Content-Type-Options", "nosniff")
            self.set_header("Cross-Origin-Resource-Policy", "same-origin")

        def prepare(self) -> None:
            given = self.request.path.split("/")[1].encode()
            origin = self.request.headers.get("Origin")
            # A foreign host name that leads here is how a page elsewhere would read this one.
            if (
                not hmac.compare_digest(given, token.encode())
                or self.request.headers.get("Host") != host
                or origin not in (None, f"http://{host}")
            ):
                raise HTTPError(403)

    class Text(Guarded):
        def initialize(self, text: str, kind: str) -> None:
            self.text, self.kind = text, kind

        def get(self) -> None:
            self.set_header("Content-Type", f"{self.kind}; charset=utf-8")
            self.set_header("Cache-Control", "no-store")
            self.finish(self.text)

    class Files(Guarded, StaticFileHandler):
        def validate_absolute_path(self, root: str, absolute_path: str) -> str | None:
            try:
                return super().validate_absolute_path(root, absolute_path)
            except ValueError:  # a NUL in it
                raise HTTPError(404) from None

    class Download(Guarded):
        def get(self, kind: str) -> None:
            page = pages.get(self.get_query_argument("page", ""))
            if kind not in _DOWNLOADS or page is None:
                raise HTTPError(404)
            picture = BytesIO()
            page.figure.savefig(picture, format=kind)
            self.set_header("Content-Type", _DOWNLOADS[kind])
            self.finish(picture.getvalue())

    class Cut(Guarded):
        """The address without the slash at its end, as people copy it at times."""

        def get(self) -> None:
            self.redirect(f"{self.request.path}/")

    class Missing(Guarded):
        def get(self, *_: str) -> None:
            raise HTTPError(404)

    class Socket(Guarded, WebSocketHandler):
        def check_origin(self, origin: str) -> bool:
            return origin == f"http://{host}"

        def open(self, *_: str) -> None:
            self.name = self.get_query_argument("page", "")
            if len(pages) >= _MOST_PAGES:
                self.close(1013, f"{_MOST_PAGES} pages are open; close one and open this one again.")
            elif not self.name or self.name in pages:
                self.close(1008, "this page has no name of its own")
            else:
                self.set_nodelay(True)
                pages[self.name] = Page(opened(), self, title)

        def on_close(self) -> None:
            if (page := pages.get(self.name)) is not None and page.socket is self:
                del pages[self.name]
                page.close()

        def on_message(self, message: str | bytes) -> None:
            if (page := pages.get(self.name)) is not None:
                page.handle(message)

        def send_json(self, content: Mapping[str, Any]) -> None:
            self._send(json.dumps(content))

        def send_binary(self, blob: bytes) -> None:
            self._send(blob, binary=True)

        def _send(self, message: str | bytes, *, binary: bool = False) -> None:
            """Send what a page that is closing no longer wants."""
            with suppress(WebSocketClosedError):
                self.write_message(message, binary=binary).add_done_callback(asyncio.Future.exception)

    page = _PAGE.format(title=html.escape(title))
    script = "application/javascript"
    images = str(Path(mpl.get_data_path()) / "images")
    return Application(
        [
            (r"/[^/]+", Cut),
            (r"/[^/]+/", Text, {"text": page, "kind": "text/html"}),
            (r"/[^/]+/page\.js", Text, {"text": _SCRIPT, "kind": script}),
            (r"/[^/]+/mpl\.js", Text, {"text": files.get_javascript(), "kind": script}),
            (r"/[^/]+/_static/(.*)", Files, {"path": files.get_static_file_path()}),
            (r"/[^/]+/_images/(.*)", Files, {"path": images}),
            (r"/[^/]+/download\.([a-z]+)", Download),
            (r"/[^/]+/ws", Socket),
        ],
        default_handler_class=Missing,
        websocket_max_message_size=1 << 20,
        log_function=lambda handler: None,
    )
