"""Predictions are A·c with the standard deviation that the covariance propagates."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model
from expdesign.errors import InputError
from expdesign.estimation.compensation.prediction import predict, require_history
from expdesign.estimation.identify import identify
from tests.cases import ROBOTS, robot
from tests.diagnosis.samples import effect
from tests.identification.experiments import experiment, table_of


def model_of(chain: Chain, values: np.ndarray, covariance: np.ndarray | None = None) -> Model:
    count = len(values)
    nothing = np.zeros((count, count)) if covariance is None else covariance
    return Model(chain, values, nothing, {}, Path(), "model.yaml")


@pytest.mark.parametrize("name", sorted(ROBOTS))
def test_the_base_model_predicts_a_times_c(name: str) -> None:
    made = experiment(name, 7, seed=2)
    recordings = made.recordings(made.noisy(np.random.default_rng(1)))
    result = identify(made.robot, recordings)
    model = model_of(result.fit.chain, result.fit.values, result.fit.covariance)
    points = experiment(name, 5, seed=3)
    found = predict(model, points.recordings(points.exact))
    expected = points.observation @ result.compliance.estimate
    np.testing.assert_allclose(found.deflections, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    variance = np.einsum("nip,pq,niq->ni", points.observation, result.covariance, points.observation)
    np.testing.assert_allclose(found.deviations, np.sqrt(variance), rtol=1e-9)


def test_predictions_scatter_as_they_say_over_repeated_experiments() -> None:
    made, point = experiment("H1", 5, seed=4), experiment("H1", 1, seed=5)
    generator, truth = np.random.default_rng(6), point.observation[0] @ made.compliance
    scores = []
    for _ in range(300):
        result = identify(made.robot, made.recordings(made.noisy(generator)))
        found = predict(
            model_of(result.fit.chain, result.fit.values, result.fit.covariance), point.recordings(point.exact)
        )
        scores.append((found.deflections[0] - truth) / found.deviations[0])
    np.testing.assert_allclose(np.mean(np.square(scores), axis=0), np.ones(6), atol=4.0 * np.sqrt(2.0 / 300))


def test_the_platform_moves_without_the_errors_of_the_instrument() -> None:
    scale = effect("H1", "instrument_scale", "instrument")
    chain = Chain(robot("H1"), (scale,))
    values = chain.start()
    values[6:] = 0.01
    made = experiment("H1", 4)
    points = made.recordings(made.exact)
    platform = predict(model_of(chain, values), points, platform=True).deflections
    read = predict(model_of(chain, values), points).deflections
    base = predict(model_of(Chain(robot("H1")), np.ones(6)), points).deflections
    np.testing.assert_allclose(platform, base, rtol=1e-12)
    assert not np.allclose(read, base, rtol=1e-3)


@pytest.mark.parametrize(
    ("physics", "component", "variant", "missing"),
    [
        ("creep", "leg 1", "", "sequence"),
        ("friction_hysteresis", "leg 2", "rigid", "sequence"),
        ("thermal_drift", "all legs", "", None),
        ("leg_backlash", "leg 3", "middle", None),
    ],
)
def test_history_is_asked_for_where_the_model_depends_on_it(
    physics: str, component: str, variant: str, missing: str | None
) -> None:
    made = experiment("H1", 3)
    frame = made.frame(made.exact)
    chain = Chain(made.robot, (effect("H1", physics, component, variant),))
    model = model_of(chain, chain.start())
    bare = table_of(frame.drop(columns=["sequence", "series"]))
    if physics == "leg_backlash":
        require_history(model, bare)
        return
    with pytest.raises(InputError, match="depend on history") as caught:
        require_history(model, bare)
    if missing:
        assert missing in caught.value.where
    full = frame.assign(time_s=[0.0, 1.0, 2.0], temperature_degC=[20.0, 21.0, 22.0])
    require_history(model, table_of(full))
