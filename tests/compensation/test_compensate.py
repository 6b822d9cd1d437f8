"""Commands that reach their targets: the theory's numbers, the model itself, limits, and the virtual laboratory."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.chain import Chain
from expdesign.errors import ConvergenceError, InfeasibleError, SingularConfigurationError
from expdesign.estimation.compensation.compensate import compensate
from expdesign.estimation.compensation.prediction import moved, predict
from expdesign.estimation.identify import identify
from expdesign.mechanics.robots.bipod import Bipod
from tests.cases import ROBOTS, content_of, robot
from tests.compensation.test_prediction import model_of
from tests.diagnosis.samples import effect
from tests.identification.experiments import experiment

NAMES = sorted(ROBOTS)


def bipod(leg_length: tuple[float, float] | None = None) -> Bipod:
    """The bipod of theory.md 2.1 with its zero pose at the origin of O."""
    return Bipod(
        base_joints=np.array([[-0.5, 0.0], [0.5, 0.0]]),
        home=np.zeros(2),
        stiffness=np.array([1.0e7, 1.3e7]),
        leg_length=leg_length,
    )


def test_the_command_of_the_test_vector() -> None:
    """theory.md 11: X_D = (0.10, 0.60), F = (0, −1000), k = (1.0, 1.3)·1e7 N/m."""
    here = bipod()
    made = experiment("bipod", 1)
    target = replace(made, robot=here, poses=np.array([[0.10, 0.60]]), wrenches=np.array([[0.0, -1000.0]]))
    model = model_of(Chain(here), np.ones(2))
    found = compensate(model, target.recordings(np.zeros((1, 2)) + 1e-6))
    np.testing.assert_allclose(found.commands, [[0.100007997793, 0.600071992929]], atol=1e-12)
    np.testing.assert_allclose(found.lengths, np.linalg.norm(found.commands - here.base_joints, axis=1)[None])


@pytest.mark.parametrize("name", NAMES)
def test_the_predicted_pose_under_load_is_the_target(name: str) -> None:
    made = experiment(name, 6, seed=1)
    values = np.random.default_rng(0).uniform(0.7, 1.3, len(made.compliance))
    model = model_of(Chain(made.robot), values, 1e-4 * np.eye(len(values)))
    targets = made.recordings(made.exact)
    found = compensate(model, targets)
    prediction = predict(model, moved(targets, found.commands, made.robot))
    np.testing.assert_allclose(found.commands + prediction.deflections, made.poses, atol=1e-13)
    np.testing.assert_allclose(found.deviations, predict(model, targets).deviations, rtol=1e-12)


@pytest.mark.parametrize(
    ("physics", "component", "variant"),
    [
        ("leg_backlash", "leg 3", "middle"),
        ("leg_nonlinear_stiffness", "leg 2", "quadratic"),
        ("joint_position_error", "leg 1", "base"),
        ("instrument_scale", "instrument", ""),
        ("base_compliance", "base", "diagonal"),
    ],
)
def test_effects_are_compensated_as_the_platform_moves(physics: str, component: str, variant: str) -> None:
    made = experiment("H1", 6, seed=1)
    chain = Chain(made.robot, (effect("H1", physics, component, variant),))
    values = chain.start() + 0.3 * chain.scales()
    values[:6] = 1.0
    model = model_of(chain, values)
    targets = made.recordings(made.exact)
    found = compensate(model, targets)
    motion = predict(model, moved(targets, found.commands, made.robot), platform=True)
    np.testing.assert_allclose(found.commands + motion.deflections, made.poses, atol=1e-13)


@pytest.mark.parametrize(
    ("leg_length", "poses", "force", "error", "words"),
    [
        ((0.5, 0.84855), [[0.0, 0.5], [0.10, 0.60]], 1e3, InfeasibleError, r"recordings\.csv, row 3: .*leg 1 would be"),
        (None, [[0.1, 0.0]], 1e3, SingularConfigurationError, "singular"),
        (None, [[0.1, 0.6]], 1e7, ConvergenceError, "no command was found"),
    ],
    ids=["beyond the limits", "singular", "gives way altogether"],
)
def test_what_has_no_command_is_refused(
    leg_length: tuple[float, float] | None, poses: list[list[float]], force: float, error: type[Exception], words: str
) -> None:
    here, count = bipod(leg_length), len(poses)
    made = replace(
        experiment("bipod", count),
        robot=here,
        poses=np.array(poses),
        wrenches=np.array([[0.0, -force]] * count),
        series=np.arange(1, count + 1),
    )
    with pytest.raises(error, match=words):
        compensate(model_of(Chain(here), np.ones(2)), made.recordings(np.zeros((count, 2)) + 1e-6))


def test_the_virtual_laboratory_attains_what_was_promised() -> None:
    """Attained errors over their predicted standard deviations have unit variance, axis by axis."""
    laboratory = pytest.importorskip(
        "research.laboratory", reason="the laboratory's engine is an extra", exc_type=ImportError
    )
    here = robot("H1")
    made, target = experiment("H1", 4, seed=22), experiment("H1", 3, seed=23, loads_per_pose=1)
    stiffness = 1.0 / made.compliance
    real = laboratory.Robot.from_mapping(content_of(here))
    columns = ["sequence", "series", *here.coordinates.pose, *here.coordinates.wrench]
    plan = made.frame(made.exact)[columns]
    rows = target.frame(target.exact)[columns]
    scores = []
    for seed in range(60):
        bench = laboratory.Laboratory(real, true_stiffness=stiffness, noise_std=made.deviation, seed=seed)
        measured = bench.measure(plan)[list(here.coordinates.deflection)].to_numpy()
        result = identify(here, made.recordings(measured))
        found = compensate(
            model_of(result.fit.chain, result.fit.values, result.fit.covariance), target.recordings(target.exact)
        )
        commands = rows.copy()
        commands[list(here.coordinates.pose)] = found.commands
        attained = bench.attained(pd.DataFrame(commands)).to_numpy()
        scores.append((attained - target.poses) / found.deviations)
    squares = np.mean(np.square(scores), axis=(0, 1))
    # 60 experiments; the three targets of one experiment are not independent of each other.
    np.testing.assert_allclose(squares, np.ones(6), atol=4.0 * np.sqrt(2.0 / 60))
