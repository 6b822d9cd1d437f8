"""The page of the study."""

from __future__ import annotations

from typing import Any


def page(found: dict[str, Any]) -> str:
    """README.md of what `repeated` and `compensated` found."""
    coverage, after = found["coverage"], found["compensated"]
    lines = [
        "# Geometry of a hexapod, identified",
        "",
        f"    python -m benchmarks.geometry --experiments {found['experiments']} --seed {found['seed']}",
        "",
        "The hexapod of `configs/robots/hexapod-h1.yaml` with every joint coordinate off by 0.2 mm, every length by "
        "0.1 mm and every stiffness by 20 % (standard deviations), solved by forward kinematics of the study's own "
        f"(`benchmarks/geometry/machine.py`). {found['rows']} measured poses, {found['rows'] // 2} commands each "
        "without and with a load, noise 5 µm and 20 µrad, 48 parameters. Machine and noise are drawn anew in each of "
        f"{found['experiments']} experiments; {found['held_out']} other loaded poses are held out.",
        "",
        "| | µm (RMS per axis) | µrad |",
        "|---|---|---|",
        _row("geometry and stiffness from the same rows (`--calibration both`)", found["error"]),
        _row("best possible unbiased estimator (Cramér-Rao bound)", found["bound"]),
        _row("geometry from unloaded rows, then stiffness from deflections", found["one_after_the_other"]),
        "",
        f"In units of the noise the error is {found['ratio_to_bound']:.4f} ± {found['ratio_standard_error']:.4f} times "
        "the bound (one standard error). Identified one after the other from the same rows, the error is "
        f"{found['gain']:.3f} times as large: the loaded rows tell of the geometry as well.",
        "",
        f"Coverage of 95 % intervals: {100 * coverage['geometry']:.2f} % of 42 geometric parameters, "
        f"{100 * coverage['compliance']:.2f} % of 6 compliances (single parameters between "
        f"{100 * coverage['least']:.1f} and {100 * coverage['most']:.1f} %), "
        f"{100 * coverage['held_out_poses']:.2f} % of the coordinates of held-out poses. The χ² test rejects the true "
        f"model at the level of 5 % in {100 * found['chi2_below_5_percent']:.1f} % of the experiments.",
        "",
        f"Compensation, {after['machines']} machines with joints off by {after['joints_mm']:g} mm, pose under load "
        "against its target:",
        "",
        "| | µm (RMS per axis) | µrad |",
        "|---|---|---|",
        _row("command = target", after["before"]),
        _row("compensated", after["after"]),
        _row("stated standard deviation", after["stated"]),
        "",
        f"Processor time of all this: {found['processor_s']:.0f} s on one core.",
        "",
    ]
    return "\n".join(lines)


def _row(name: str, values: dict[str, float]) -> str:
    return f"| {name} | {values['um']:.2f} | {values['urad']:.2f} |"
