"""The page of a run is for this machine alone, shows the front, and passes on the wish to end it."""

import json
import re
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from tests.commands.calls import call, refusal
from tests.watching.runs import asked, config_file, state_of

import expdesign as xd
from expdesign.app.watching.server import HOST, Watch, Watched, serve
from expdesign.errors import InfeasibleError
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import Progress


@pytest.fixture
def watch(tmp_path: Path) -> Iterator[Watch]:
    problem = read_problem(config_file(tmp_path, objectives=["duir", "o1"]))
    with serve(Watched(problem, "results/mine")) as found:
        yield found


def key_of(address: str) -> dict[str, str]:
    found = re.search(rb'data-key="([^"]+)"', asked(address, "/")[1])
    return {"X-Key": found[1].decode()}


def test_the_page_shows_criteria_as_they_are(watch: Watch) -> None:
    """Maximised ones are negated in the search."""
    watch.watched.stage("searching", 3, 6, "a note")
    front = np.array([[2.0, -5.0], [1.0, -4.0]])
    assert watch.watched.follow(Progress(3, 6, front, 0.5)) is False
    state = state_of(watch.address)
    assert state["front"] == [[1.0, 4.0], [2.0, 5.0]]
    assert (state["stage"], state["done"], state["total"], state["note"]) == ("searching", 3, 6, "a note")
    assert state["course"][0][1] == state["hypervolume"] == 0.5
    assert "larger is better" in state["objectives"][1]


def test_everything_that_the_page_needs_is_there(watch: Watch) -> None:
    status, page = asked(watch.address, "/")
    assert status == 200
    needed = re.findall(r'(?:src|href)="([^"]+)"', page.decode())
    assert {"page.css", "page.js", "plotly.js"} <= set(needed)
    for name in needed:
        assert name.startswith("data:") or asked(watch.address, f"/{name}")[0] == 200
    assert not re.search(rb"https?://", page)
    for name in ("/report", "/../pyproject.toml", "/page.html", "/etc/passwd"):
        assert asked(watch.address, name)[0] == 404


def test_the_wish_to_end_needs_the_page_s_key(watch: Watch) -> None:
    own = key_of(watch.address)
    state = Progress(1, 6, np.array([[1.0, -1.0]]), 0.1)
    for headers in ({}, {"X-Key": "another"}, {**own, "Host": "example.org"}):
        assert asked(watch.address, "/end", method="POST", headers=headers)[0] == 403
        assert watch.watched.follow(state) is False
    assert asked(watch.address, "/other", method="POST", headers=own)[0] == 403
    assert asked(watch.address, "/end", method="POST", headers=own)[0] == 204
    assert watch.watched.follow(state) is True
    assert state_of(watch.address)["ending"] is True


def test_only_this_machine_is_answered(watch: Watch) -> None:
    """Not under a foreign name that resolves to it, and on no other of its addresses."""
    for host in ("example.org", f"example.org:{watch.address.split(':')[-1].rstrip('/')}", ""):
        assert asked(watch.address, "/", headers={"Host": host})[0] == 404
    assert watch.address.startswith(f"http://{HOST}:")
    port = int(watch.address.rstrip("/").split(":")[-1])
    addresses = {str(found[4][0]) for found in socket.getaddrinfo(socket.gethostname(), port, socket.AF_INET)}
    for address in addresses - {HOST}:
        with socket.socket() as other:
            other.settimeout(2.0)
            if not address.startswith("127."):
                assert other.connect_ex((address, port)) != 0


def test_a_long_course_is_thinned(watch: Watch) -> None:
    for number in range(5001):
        watch.watched.follow(Progress(number, 5000, np.array([[1.0, -1.0]]), float(number)))
    course = state_of(watch.address)["course"]
    assert len(course) <= 2000
    assert (course[0][1], course[-1][1]) == (0.0, 5000.0)


def test_nobody_is_waited_for_who_does_not_look(tmp_path: Path) -> None:
    problem = read_problem(config_file(tmp_path))
    started = time.monotonic()
    with serve(Watched(problem, "out")) as watch:
        address = watch.address
    assert time.monotonic() - started < 1.5
    with pytest.raises(ConnectionError):
        asked(address, "/state")


def test_who_looks_is_told_why_there_is_no_result(tmp_path: Path) -> None:
    problem = read_problem(config_file(tmp_path))
    seen: list[dict[str, object]] = []

    def look(address: str) -> None:
        while not seen or seen[-1]["end"] is None:
            seen.append(state_of(address))
            time.sleep(0.02)

    viewers: list[threading.Thread] = []

    def attempt() -> None:
        with serve(Watched(problem, "out")) as watch:
            viewers.append(threading.Thread(target=look, args=(watch.address,)))
            viewers[0].start()
            while not seen:
                time.sleep(0.01)
            raise InfeasibleError("no pose can be reached")

    with pytest.raises(InfeasibleError):
        attempt()
    # The last answer has been sent by now, but perhaps not yet been noted by who asked.
    viewers[0].join()
    assert seen[-1]["end"] == "failed"
    assert "no pose can be reached" in str(seen[-1]["message"])


def _watching(monkeypatch: pytest.MonkeyPatch, end: bool) -> Callable[[], list[dict[str, object]]]:
    """A person who looks from the moment that the command says where, ends the run if `end`, and takes the report.

    What is called tells what was seen, when the person has looked at the last answer.
    """
    seen: list[dict[str, object]] = []
    viewers: list[threading.Thread] = []

    def look(address: str) -> None:
        headers = key_of(address)
        if end:
            assert asked(address, "/end", method="POST", headers=headers)[0] == 204
        while not seen or not seen[-1]["report"]:
            seen.append(state_of(address))
            time.sleep(0.02)
        status, page = asked(address, "/report")
        seen.append({"status": status, "page": page})

    def open_page(address: str) -> None:
        viewers.append(threading.Thread(target=look, args=(address,)))
        viewers[0].start()

    def seen_at_last() -> list[dict[str, object]]:
        for viewer in viewers:
            viewer.join()
        return seen

    monkeypatch.setattr("expdesign.app.commands.run._open", open_page)
    return seen_at_last


@pytest.mark.parametrize("end", [False, True])
def test_the_command_with_somebody_who_looks(
    end: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    config = config_file(tmp_path)
    looked = _watching(monkeypatch, end)
    assert call("run", config, "--out", tmp_path / "out", "--watch") == 0
    said = capsys.readouterr()
    assert re.search(r"watch it at http://127\.0\.0\.1:\d+/", said.err)
    assert said.out.splitlines()[-1] == str(tmp_path / "out" / "report.html")
    seen = looked()
    assert seen[-1] == {"status": 200, "page": (tmp_path / "out" / "report.html").read_bytes()}
    record = json.loads((tmp_path / "out" / "run.json").read_text(encoding="utf-8"))
    assert seen[-2]["end"] == ("ended" if end else "finished")
    assert ("ended_by_hand" in record) is end
    if end:
        assert record["ended_by_hand"].startswith("generation ")
    else:
        plain = xd.run(config, timed=False).files()
        for name in ("pareto.csv", "plans.csv", "plan.csv"):
            assert (tmp_path / "out" / name).read_text(encoding="utf-8") == plain[name]


def test_a_port_that_is_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind((HOST, 0))
        taken.listen()
        port = taken.getsockname()[1]
        said = refusal(capsys, "run", config_file(tmp_path), "--out", tmp_path / "out", "--watch", "--port", port)
    assert f"port {port} cannot be opened" in said
    assert "--port" in said
    assert call("run", config_file(tmp_path), "--out", tmp_path / "out", "--watch", "--port", 99999) == 2
    assert not (tmp_path / "out").exists()
