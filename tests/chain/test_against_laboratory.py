"""Effects against an independent multibody engine: what it measures without noise, the chain explains and names."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

from expdesign.chain.effect import Effect
from tests.chain.hidden import CASES, Case
from tests.chain.laboratory import STIFFNESS, fitted, machine, recorded


def reported(effect: Effect, values: Any) -> dict[str, float]:
    theta = ca.SX.sym("theta", len(effect.parameters))
    expressions = effect.reported(theta)
    numbers = np.array(ca.Function("f", [theta], [ca.vertcat(*expressions.values())])(values)).ravel()
    return dict(zip(expressions, numbers.tolist(), strict=True))


@pytest.mark.parametrize("case", CASES, ids=str)
def test_what_it_hides(case: Case) -> None:
    """What remains is below 3 % of the base model's residuals, and parameters are right to 3 %."""
    recordings = recorded(case.robot, case.element)
    base, best, values = fitted(case.robot, recordings, case.element["physics"], case.component, case.variant)
    assert np.sqrt(best.chi2 / base.chi2) < 0.03
    found = reported(best.chain.effects[0], values)
    for name, expected in case.expected.items():
        assert found[name] == pytest.approx(expected, rel=0.03), name
    if case.element["physics"] not in ("platform_compliance", "base_compliance", "passive_joint_compliance",
                                       "leg_coupling", "leg_nonlinear_stiffness", "instrument_scale"):  # fmt: skip
        # What is not in series with the legs leaves their stiffness as it is.
        stiffness = machine(case.robot).stiffness / best.values[: best.chain.compliances]
        np.testing.assert_allclose(stiffness, STIFFNESS[case.robot], rtol=0.01)


def test_without_hidden_physics_the_base_model_is_exact_but_for_the_geometry_under_load() -> None:
    recordings = recorded("hexapod-h1")
    base, best, values = fitted("hexapod-h1", recordings, "geometric_stiffness", "geometry", "")
    np.testing.assert_allclose(machine("hexapod-h1").stiffness / base.values, STIFFNESS["hexapod-h1"], rtol=1e-3)
    assert values[0] == pytest.approx(1.0, rel=0.03)
    assert np.sqrt(best.chi2 / base.chi2) < 0.03


def test_a_share_that_all_loads_lack_is_one_of_all_compliances() -> None:
    """5 % more mass than assumed: the base model explains it, with legs that seem 5 % softer (theory.md 5.2)."""
    plain = recorded("hexapod-h1")
    heavier = recorded("hexapod-h1", {"physics": "payload_mass_error", "relative_mass_error": 0.05})
    bases = [fitted("hexapod-h1", r, "geometric_stiffness", "geometry", "")[0] for r in (plain, heavier)]
    np.testing.assert_allclose(bases[1].values, 1.05 * bases[0].values, rtol=1e-4)
    # What remains is the change of geometry under load, quadratic in the load.
    assert bases[1].chi2 == pytest.approx(1.05**4 * bases[0].chi2, rel=0.01)
