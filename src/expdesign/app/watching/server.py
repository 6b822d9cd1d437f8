"""The page of a watched run, served on this machine only (127.0.0.1) while the run lasts.

No other machine can reach it. Another page that is open in the same browser can neither read it (no answer allows it
to) nor end the run: that needs a key which only the page itself has, in a header that browsers do not let other pages
send unasked. A request is answered only where it names this machine as its host, so that a foreign name which resolves
to it (DNS rebinding) gets nothing.

What is known of the run is shared by the search, which writes it, and the page, which reads it, in different threads.
The search only ever adds what it reports anyway, so that a run that is watched gives the same results as one that is
not, unless somebody ends it.
"""

import hmac
import json
import secrets
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from plotly.offline import get_plotlyjs

from expdesign.arrays import FloatArray
from expdesign.errors import ArgumentError, ExpdesignError
from expdesign.planning.problem import DesignProblem
from expdesign.planning.search import Progress
from expdesign.report.design_figures import criterion_title

End = Literal["finished", "ended", "failed"]
"""A run finished by itself, was ended by hand, or has no result."""
_MOST_POINTS = 2000
"""Of the course of the hypervolume; of more, every second one is dropped."""


class Watched:
    """The state of one run.

    Args:
        problem: what is searched.
        folder: where the results will be, for the page to say.
    """

    def __init__(self, problem: DesignProblem, folder: str) -> None:
        self._lock = threading.Lock()
        self._started = time.monotonic()
        self._sign = np.array([-1.0 if one.maximise else 1.0 for one in problem.objectives])
        self._course: list[list[float]] = []
        self._wanted = False
        self._state: dict[str, Any] = {
            "title": problem.loaded.robot.name,
            "configuration": problem.source,
            "folder": folder,
            "objectives": [criterion_title(criterion.name) for criterion in problem.objectives],
            "stage": "starting",
            "done": 0,
            "total": 0,
            "note": "",
            "front": [],
            "hypervolume": None,
            "end": None,
            "message": "",
        }

    def follow(self, state: Progress) -> bool:
        """Take the state of the search; True where somebody wants it to end (for `search`)."""
        front: FloatArray = state.front[np.lexsort(state.front.T[::-1])] * self._sign
        with self._lock:
            self._state |= {"front": front.tolist(), "hypervolume": state.hypervolume}
            self._course.append([round(self._elapsed, 3), state.hypervolume])
            if len(self._course) > _MOST_POINTS:
                del self._course[1:-1:2]
            return self._wanted

    def stage(self, title: str, done: int, total: int, note: str) -> None:
        """Take the stage of the run (for `run`)."""
        with self._lock:
            self._state |= {"stage": title, "done": done, "total": total, "note": note}

    @property
    def wanted(self) -> bool:
        """Whether somebody wants it to end."""
        with self._lock:
            return self._wanted

    def end_it(self) -> None:
        """Somebody wants the search to end with what is there."""
        with self._lock:
            self._wanted = True

    def ended(self, how: End, message: str = "") -> None:
        """The run is over; `message` says why there is no result."""
        with self._lock:
            self._state |= {"end": how, "message": message, "elapsed_s": self._elapsed}

    def state(self) -> dict[str, Any]:
        """What the page shows."""
        with self._lock:
            known = {"elapsed_s": self._elapsed} | self._state
            return known | {"course": list(self._course), "ending": self._wanted}

    @property
    def _elapsed(self) -> float:
        return time.monotonic() - self._started


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
_HTML, _SCRIPT = "text/html; charset=utf-8", "text/javascript; charset=utf-8"


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
        if path == "/":
            environment = Environment(loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined)
            page = environment.get_template("page.html").render(state=self.watched.state(), key=self._key)
            return _HTML, page.encode()
        if path == "/state":
            state = self.watched.state() | {"report": self.report is not None}
            return "application/json", json.dumps(state, allow_nan=False).encode()
        if path == "/plotly.js":
            return _SCRIPT, get_plotlyjs().encode()
        if path == "/report":
            return None if self.report is None else (_HTML, self.report.read_bytes())
        files = {"/page.css": ("text/css; charset=utf-8", _STYLE), "/page.js": (_SCRIPT, _HERE / "page.js")}
        kind, file = files.get(path, ("", None))
        return None if file is None else (kind, file.read_bytes())

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
