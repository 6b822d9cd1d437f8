"""The page of a watched run, served on this machine only (127.0.0.1) while the run lasts.

No other machine can reach it. Another page that is open in the same browser can neither read it (no answer allows it
to) nor end the run: that needs a key which only the page itself has, in a header that browsers do not let other pages
send unasked. A request is answered only where it names this machine as its host, so that a foreign name which resolves
to it (DNS rebinding) gets nothing.
"""

import hmac
import json
import secrets
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from expdesign.app.watching.watched import Watched
from expdesign.errors import ArgumentError, ExpdesignError

HOST = "127.0.0.1"
PATIENCE = 5.0
"""s in which a page that is open may fetch the results when the run is over."""
_ABSENT = 2.0
"""s without a question after which nobody is looking."""
_HERE = Path(__file__).parent
_STYLE = _HERE.parents[1] / "report" / "page.css"
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
_HTML, _SCRIPT, _JSON = "text/html; charset=utf-8", "text/javascript; charset=utf-8", "application/json"


class Watch:
    """The page of one run; `serve` opens it.

    Attributes:
        watched: what is shown.
        address: of the page.
        report: the report of the run, once there is one.
    """

    def __init__(self, watched: Watched, port: int) -> None:
        self.watched = watched
        self._key = secrets.token_urlsafe(24)
        self.report: Path | None = None
        self._asked = -_ABSENT
        self._told, self._fetched = threading.Event(), threading.Event()
        try:
            self._server = ThreadingHTTPServer((HOST, port), _handler(self))
        except (OSError, OverflowError) as error:
            what = f"port {port} cannot be opened on this machine ({error})"
            raise ArgumentError(what, argument="port", remedy="Name another, or leave it out.") from None
        self.hosts = {f"{name}:{self._server.server_port}" for name in (HOST, "localhost")}
        self.address = f"http://{HOST}:{self._server.server_port}/"

    def start(self) -> None:
        """Serve, in threads that end with the program."""
        threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True).start()

    def finish(self) -> None:
        """Wait a moment until a page that is open has the last state and the report, and serve no more."""
        until = time.monotonic() + PATIENCE
        awaited = self._told if self.report is None else self._fetched
        while time.monotonic() < min(until, self._asked + _ABSENT) and not awaited.wait(0.05):
            pass
        self._server.shutdown()
        self._server.server_close()

    def answer(self, path: str) -> tuple[str, bytes] | None:
        """Type and content of what is asked for, or None where there is no such thing."""
        from plotly.offline import get_plotlyjs  # noqa: PLC0415 (slow to import)

        texts: dict[str, tuple[str, Callable[[], str]]] = {
            "/": (_HTML, self._page),
            "/page.css": ("text/css; charset=utf-8", lambda: _STYLE.read_text(encoding="utf-8")),
            "/page.js": (_SCRIPT, lambda: (_HERE / "page.js").read_text(encoding="utf-8")),
            "/plotly.js": (_SCRIPT, get_plotlyjs),
            "/state": (_JSON, self._state),
        }
        if path == "/report" and self.report is not None:
            return _HTML, self.report.read_bytes()
        if path not in texts:
            return None
        kind, text = texts[path]
        return kind, text().encode()

    def sent(self, path: str, content: bytes) -> None:
        """Note that an answer has gone out."""
        self._asked = time.monotonic()
        if path == "/report":
            self._fetched.set()
        if path == "/state" and json.loads(content)["end"] is not None:
            self._told.set()

    def wants_to_end(self, key: str | None) -> bool:
        """Whether a wish to end the run has the page's key; if so, it is taken."""
        if key is None or not hmac.compare_digest(key.encode(), self._key.encode()):
            return False
        self.watched.end_it()
        return True

    def _page(self) -> str:
        environment = Environment(loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined)
        return environment.get_template("page.html").render(state=self.watched.state(), key=self._key)

    def _state(self) -> str:
        return json.dumps(self.watched.state() | {"report": self.report is not None}, allow_nan=False)


@contextmanager
def serve(watched: Watched, port: int = 0) -> Iterator[Watch]:
    """The page of a run while the block lasts; `port` 0 is any that is free.

    Raises:
        InputError: the port cannot be opened.
    """
    watch = Watch(watched, port)
    watch.start()
    try:
        yield watch
    except ExpdesignError as error:
        watched.ended("failed", error.message)
        raise
    finally:
        watch.finish()


def _handler(watch: Watch) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """Answers questions of pages on this machine."""

        protocol_version = "HTTP/1.1"
        timeout = 10

        def do_GET(self) -> None:
            path = self.path.split("?")[0]
            found = watch.answer(path) if self._is_here() else None
            if found is None:
                self._send(HTTPStatus.NOT_FOUND, "text/plain", b"there is nothing here\n")
                return
            self._send(HTTPStatus.OK, *found, policy=path != "/report")  # a report has its own
            watch.sent(path, found[1])

        def do_POST(self) -> None:
            allowed = self.path == "/end" and self._is_here() and watch.wants_to_end(self.headers.get("X-Key"))
            self._send(HTTPStatus.NO_CONTENT if allowed else HTTPStatus.FORBIDDEN, "text/plain", b"")

        def _is_here(self) -> bool:
            return self.headers.get("Host") in watch.hosts

        def _send(self, status: HTTPStatus, kind: str, content: bytes, policy: bool = True) -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.send_header("X-Content-Type-Options", "nosniff")
            self.send_header("Connection", "close")
            if policy:
                self.send_header("Content-Security-Policy", _POLICY)
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *values: Any) -> None:
            """Standard error belongs to the progress of the run."""

    return Handler
