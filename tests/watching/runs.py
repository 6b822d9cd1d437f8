"""Runs that take a second, and questions to the page of one."""

import http.client
import json
from pathlib import Path
from typing import Any

from tests.commands import calls

SHORT = {"population": 16, "generations": 6, "seed": 1, "polish": True}


def config_file(folder: Path, **changes: object) -> Path:
    """The bipod with three measurements, so that there is a front."""
    return calls.config_file(folder, {"optimiser": SHORT, "experiment.measurements": 3} | changes, "bipod")


def asked(address: str, path: str, *, method: str = "GET", headers: dict[str, str] | None = None) -> tuple[int, bytes]:
    """Status and content of an answer."""
    host = address.removeprefix("http://").rstrip("/")
    connection = http.client.HTTPConnection(host, timeout=30)
    try:
        connection.request(method, path, headers=headers or {})
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


def state_of(address: str) -> dict[str, Any]:
    status, content = asked(address, "/state")
    assert status == 200
    found = json.loads(content)
    assert isinstance(found, dict)
    return found
