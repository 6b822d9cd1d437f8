"""Runs that take a second, and questions to the page of one."""

import http.client
import json
from pathlib import Path
from typing import Any

import yaml
from tests.sweeps.small import CONFIGS

SHORT = {"population": 16, "generations": 6, "seed": 1, "polish": True}


def config_file(folder: Path, **changes: object) -> Path:
    """The bipod with three measurements, so that there is a front."""
    content = yaml.safe_load((CONFIGS / "bipod.yaml").read_text(encoding="utf-8"))
    content |= {"robot": str(CONFIGS / "robots/bipod.yaml"), "optimiser": SHORT}
    content["experiment"] = content["experiment"] | {"measurements": 3}
    path = folder / "config.yaml"
    path.write_text(yaml.safe_dump(content | changes), encoding="utf-8")
    return path


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
