"""A figure in the browser of this machine, with its sliders: matplotlib's WebAgg behind an address nobody can guess."""

from __future__ import annotations

import asyncio
import hmac
import html
import importlib.util
import json
import secrets
import socket
from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

_HOST = "127.0.0.1"
_DOWNLOADS = {"png": "image/png", "pdf": "application/pdf", "svg": "image/svg+xml"}

_PAGE = """<!DOCTYPE html>
<html lang="en">
  <head>
    <meta charset="utf-8">
    <title>{title}</title>
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
      <p style="margin: 10px"><code id="command"></code> <button id="copy" type="button">copy the command</button></p>
      <p style="margin: 10px" id="ended" role="alert"></p>
    </main>
  </body>
</html>
"""

_SCRIPT = """"use strict";
document.addEventListener("DOMContentLoaded", function () {
  const socket = new WebSocket(window.location.href.replace(/^http/, "ws") + "ws");
  const show = function (name, text) { document.getElementById(name).textContent = text; };
  const figure = new mpl.figure(1, socket, function (figure, format) {
    window.open("download." + format, "_blank", "noopener");
  }, document.getElementById("figure"));
  figure.handle_words = function (figure, message) {
    show("verdict", message.verdict);
    show("command", message.command);
  };
  socket.addEventListener("close", function () {
    show("ended", "The program has ended; what is shown no longer moves.");
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


def serve(
    figure: Any,
    words: Callable[[], Mapping[str, str]],
    told: Callable[[str], None],
    *,
    title: str,
    port: int = 0,
) -> None:
    """Show a figure in the browser until Ctrl-C: to whoever knows its address, on this machine only.

    Parameters
    ----------
    figure : matplotlib figure
        Its canvas is replaced.
    words : callable
        Returns the texts "verdict" and "command" below the picture.
    told : callable
        Called with the address when it can be opened.
    title : str
        Of the page.
    port : int
        0 takes any free one.

    Raises
    ------
    ValueError
        Where tornado is missing, or the port is taken.
    """
    require_tornado()

    async def until_cancelled() -> None:
        server, address = listen(figure, words, title=title, port=port)
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


def listen(figure: Any, words: Callable[[], Mapping[str, str]], *, title: str, port: int) -> tuple[Any, str]:
    """Return a server of a figure, which answers within the running loop, and its address."""
    from matplotlib.backends.backend_webagg_core import FigureCanvasWebAggCore
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
    figure.set_label(title)
    manager: Any = FigureCanvasWebAggCore.new_manager(figure, 1)

    def tell(_: Any) -> None:
        manager.canvas.send_event("words", **words())

    figure.canvas.mpl_connect("draw_event", tell)
    server = HTTPServer(_application(manager, token, f"{_HOST}:{number}", title))
    server.add_socket(listening)
    return server, f"http://{_HOST}:{number}/{token}/"


def _application(manager: Any, token: str, host: str, title: str) -> Any:
    """Return the tornado application; every request without the token, or from a foreign page, is refused with 403."""
    import matplotlib as mpl
    from tornado.web import Application, HTTPError, RequestHandler, StaticFileHandler
    from tornado.websocket import WebSocketHandler

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
        pass

    class Download(Guarded):
        def get(self, kind: str) -> None:
            if kind not in _DOWNLOADS:
                raise HTTPError(404)
            picture = BytesIO()
            manager.canvas.figure.savefig(picture, format=kind)
            self.set_header("Content-Type", _DOWNLOADS[kind])
            self.finish(picture.getvalue())

    class Cut(Guarded):
        """The address as it is copied at times, without the slash at its end."""

        def get(self) -> None:
            self.redirect(f"{self.request.path}/")

    class Missing(Guarded):
        def get(self, *_: str) -> None:
            raise HTTPError(404)

    class Socket(Guarded, WebSocketHandler):
        def check_origin(self, origin: str) -> bool:
            return origin == f"http://{host}"

        def open(self, *_: str) -> None:
            self.set_nodelay(True)
            manager.add_web_socket(self)

        def on_close(self) -> None:
            manager.remove_web_socket(self)

        def on_message(self, message: str | bytes) -> None:
            content = json.loads(message)
            if content["type"] != "supports_binary":  # all browsers of these years do
                manager.handle_json(content)

        def send_json(self, content: Mapping[str, Any]) -> None:
            self.write_message(json.dumps(content))

        def send_binary(self, blob: bytes) -> None:
            self.write_message(blob, binary=True)

    page = _PAGE.format(title=html.escape(title))
    script = "application/javascript"
    images = str(Path(mpl.get_data_path()) / "images")
    return Application(
        [
            (r"/[^/]+", Cut),
            (r"/[^/]+/", Text, {"text": page, "kind": "text/html"}),
            (r"/[^/]+/page\.js", Text, {"text": _SCRIPT, "kind": script}),
            (r"/[^/]+/mpl\.js", Text, {"text": type(manager).get_javascript(), "kind": script}),
            (r"/[^/]+/_static/(.*)", Files, {"path": type(manager).get_static_file_path()}),
            (r"/[^/]+/_images/(.*)", Files, {"path": images}),
            (r"/[^/]+/download\.([a-z]+)", Download),
            (r"/[^/]+/ws", Socket),
        ],
        default_handler_class=Missing,
        websocket_max_message_size=1 << 20,
        log_function=lambda handler: None,
    )
