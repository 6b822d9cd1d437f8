"""A shared unloaded reading is said once, by the recordings or the configuration, and holds wherever they go."""

import copy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.io.yaml_reader import read_yaml
from tests.design.problems import searched

ROOT = Path(__file__).parents[2]
SERIES, LOADS = 5, 4


def configuration(*, shared: bool) -> dict[str, Any]:
    """The example hexapod with or without shared references, without load errors."""
    content: dict[str, Any] = copy.deepcopy(read_yaml(ROOT / "configs" / "hexapod-h1.yaml").content)
    content["robot"] = read_yaml(ROOT / "configs" / "robots" / "hexapod-h1.yaml").content
    content["experiment"].pop("load_error", None)
    content["experiment"]["deflection_noise"]["shared_reference"] = shared
    content["model_error"] = {"physics": ["instrument_scale"]}  # of which nothing more is asked here
    return content


def plan() -> pd.DataFrame:
    """Several loads at each of several poses."""
    generator = np.random.default_rng(3)
    poses = np.repeat(generator.uniform(-1.0, 1.0, (SERIES, 6)) * [0.02, 0.02, 0.01, 0.1, 0.1, 0.1], LOADS, axis=0)
    names = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
    frame = pd.DataFrame({"series": np.repeat(np.arange(SERIES) + 1, LOADS)} | dict(zip(names, poses.T, strict=True)))
    frame.insert(0, "sequence", np.arange(1, len(frame) + 1))
    frame["mass_kg"] = np.tile([10.0, 26.5, 26.5, 26.5], SERIES)
    frame["com_x_m"] = np.tile([0.1, -0.1, 0.1, 0.0], SERIES)
    frame["com_y_m"] = generator.uniform(-0.1, 0.1, len(frame))
    frame["com_z_m"] = 0.12
    return frame


@cache
def _recorded() -> pd.DataFrame:
    return xd.simulate(configuration(shared=True), plan(), seed=3).frame


def recorded() -> pd.DataFrame:
    return _recorded().copy()


@cache
def chi2_of(*, said: bool, shared: bool | None = None, targets: bool = False) -> float | None:
    """χ² of the recordings, which say it themselves or not, with the argument, and with the configuration."""
    config = configuration(shared=True)
    frame = recorded() if said else recorded().drop(columns="reference")
    return chi2(xd.identify(config["robot"], frame, shared_reference=shared, targets=config if targets else None))


def chi2(identified: xd.IdentificationResult) -> float | None:
    return identified.result.goodness.chi2


def test_simulated_recordings_say_it_and_need_no_option() -> None:
    recordings, config = recorded(), configuration(shared=True)
    assert recordings["reference"].tolist() == [f"unloaded-{n}" for n in recordings["series"]]
    independent = xd.simulate(configuration(shared=False), plan().assign(reference="a"), seed=3).frame
    assert "reference" not in independent
    right = chi2_of(said=False, shared=True)
    assert chi2_of(said=True) == right
    assert chi2_of(said=False, targets=True) == right
    assert chi2_of(said=False) != right
    identified = xd.identify(config["robot"], recordings, shared_reference=False)
    assert chi2(identified) == chi2_of(said=False)
    assert not identified.record["shared_reference"]


def test_diagnosis_takes_it_from_the_configuration() -> None:
    recordings, config = recorded(), configuration(shared=True)
    found = xd.diagnose(config["robot"], recordings.drop(columns="reference"), targets=config)
    assert found.verdict == "consistent"
    assert found.record["tests"]["chi2"] == pytest.approx(chi2_of(said=True), rel=1e-6)


def test_the_next_measurements_and_a_verification_take_it_as_well() -> None:
    recordings, config = recorded(), configuration(shared=True)
    plain = recordings.drop(columns="reference")
    with_column, without = (xd.plan_next(config, frame) for frame in (recordings, plain))
    assert without.before == pytest.approx(with_column.before, rel=1e-9)
    assert without.frame["reference"].tolist() == [f"unloaded-{SERIES + 1}"]
    other = xd.plan_next(configuration(shared=False), plain)
    assert other.before != pytest.approx(with_column.before, rel=1e-3)

    model = xd.identify(config["robot"], recordings).model
    # Every command is read twice: two readings of one series at one command have one reference.
    targets = plan().iloc[1::LOADS]
    check = pd.concat(2 * [xd.compensate(model, targets).frame]).assign(sequence=range(1, 2 * SERIES + 1))
    check[["dx_m", "dz_m"]] = 1e-6
    check[["sx_m", "sz_m"]] = 5e-7
    size = 2 * len(check)
    assert np.count_nonzero(xd.verify(model, check, config=config).result.comparison.noise) == 2 * size
    assert np.count_nonzero(xd.verify(model, check).result.comparison.noise) == size


def test_a_plan_of_shared_references_names_them(tmp_path: Path) -> None:
    content = copy.deepcopy(configuration(shared=True))
    content["optimiser"] = {"population": 8, "generations": 1, "seed": 1, "polish": False}
    frame = searched(content).plan
    assert frame["reference"].tolist() == [f"unloaded-{number}" for number in frame["series"]]
