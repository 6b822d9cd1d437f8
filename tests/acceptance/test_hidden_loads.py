"""What left-out physics does by way of the load errors that took it up, which are applied at targets as well."""

import numpy as np
import pytest

import expdesign as xd
from expdesign.assurance.acceptance.hidden_risk import joint_model, left_out_by
from expdesign.assurance.model_error.physics import offsets
from expdesign.report.at_targets import AtTargets
from tests.design.problems import HEXAPOD, plan_table, problem

ERRORS = [{"source": "com", "std": [0.02, 0.02, 0.02]}, {"source": "direction", "std": [0.01, 0.01]}]
CASE = {
    "experiment.load_error": ERRORS,
    "experiment.measurements": 8,
    "experiment.load.gravity": ...,
    "targets.0.payload.same_as": "experiment",
    "model_error": {"physics": ["leg_coupling"]},
}
POSES = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


def test_a_bias_by_way_of_load_errors_is_what_commands_then_have() -> None:
    """The change of the commands with a concealed coupling of legs, against the bias that the decision expects."""
    case = problem(HEXAPOD, CASE)
    plan = plan_table(case)
    commands, motions = [], []
    coupling = "leg_coupling at leg 2, force of leg 1, 2e-9"
    for conceal in ((), coupling):
        recorded = xd.simulate(case, plan, conceal=conceal, noise=False, load_errors=False).frame
        identified = xd.identify(HEXAPOD["robot"], recorded, targets=case)
        found = xd.compensate(identified, case).frame
        commands.append(found[POSES].to_numpy(dtype=float))
        there = found.assign(**{name: found[f"target_{name}"] for name in POSES})
        moved = xd.simulate(case, there, conceal=conceal, noise=False, load_errors=False).frame
        motions.append(moved[["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]].to_numpy(dtype=float))
    attained = (commands[1] + motions[1]) - (commands[0] + motions[0])
    model = AtTargets.identified(case, identified.result).model
    shown = left_out_by(case, model)
    assert shown is not None
    places = [(str(entry.effect.component), str(entry.effect.variant)) for entry in shown.meir.physics]
    place = places.index(("leg 2", "force of leg 1"))
    base, start = joint_model(case, model), offsets(shown.meir.physics)
    part = slice(start[place], start[place + 1])
    rows = len(base.readings)
    readings = model.whitening.unshared(shown.directions[:rows, part])
    at = (shown.meir.motions[..., part] * shown.meir.deviations[part]).reshape(-1, part.stop - part.start)
    expected = base.unexplained(readings, at)
    scale = 2e-9 / shown.meir.deviations[part]
    bias = (expected * scale).sum(axis=1).reshape(attained.shape)
    assert bias == pytest.approx(attained, rel=0.15, abs=0.05 * np.abs(attained).max())
