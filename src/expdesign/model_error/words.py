"""What left-out physics is called in sentences: "a soft platform", "play in leg 3"."""

from expdesign.model_error.hidden_physics import HiddenPhysics

_PHRASES = {
    "payload_com_offset": "a centre of mass that is not where it was assumed",
    "payload_mass_error": "masses that are not what was assumed",
    "load_direction_tilt": "a load that is not along its assumed direction",
    "platform_compliance": "a soft platform",
    "base_compliance": "a soft base",
    "passive_joint_compliance": "soft passive joints of {component}",
    "passive_joint_stiffness": "stiff passive joints of {component}",
    "leg_coupling": "a force in another leg that moves {component}",
    "link_compliance": "a soft {component}",
    "joint_compliance": "a soft bearing of {component}",
    "geometric_stiffness": "the change of geometry under load",
    "leg_nonlinear_stiffness": "a spring that is not linear in {component}",
    "leg_backlash": "play in {component}",
    "joint_backlash": "play in {component}",
    "friction_hysteresis": "friction in {component}",
    "creep": "creep of {component}",
    "encoder_periodic_error": "a periodic error of the encoder of {component}",
    "joint_position_error": "wrong geometry at {component}",
    "instrument_misalignment": "an instrument that is turned",
    "instrument_scale": "a wrong scale of the instrument",
    "thermal_drift": "thermal drift of {component}",
}


def phrase(each: HiddenPhysics) -> str:
    """The effect and its component in words."""
    known = _PHRASES.get(each.physics)
    if known is None:
        return f"{each.physics.replace('_', ' ')} ({each.component})"
    return known.format(component=each.component)


def sentence(worst: HiddenPhysics, freedom: int, readings: str) -> str:
    """What a plan or recordings hide, for people.

    Args:
        worst: of all effects.
        freedom: degrees of freedom of the residuals.
        readings: what would have to show it: `this plan`, `these recordings`.
    """
    if freedom == 0:
        return (
            f"With as many readings as unknowns nothing that the model leaves out could be noticed by {readings}: "
            f"{phrase(worst)} of the size that is assumed would cost {worst.error:.3g} tolerances at the targets."
        )
    text = f"{phrase(worst)[0].upper()}{phrase(worst)[1:]} could cost {worst.error:.3g} tolerances at the targets"
    if worst.limited_by == "detection":
        return f"{text} before {readings} would show it."
    if worst.noticed == float("inf"):
        return f"{text} at the size that is assumed, and {readings} would not show it at all."
    return f"{text} at the size that is assumed; {readings} would show it from {worst.noticed:.3g} times that size on."


def unsized_sentence(physics: tuple[str, ...]) -> str:
    """That physics is left out because nothing says how large it may be."""
    names = ", ".join(f"`{name}`" for name in physics)
    return f"Not considered: {names}, of which no prior size is known; state one under `model_error.sizes`."
