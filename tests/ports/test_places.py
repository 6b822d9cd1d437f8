"""Families of laws at single ports: physics of several axes at once is one entry."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.component import ALL_LEGS, GEOMETRY, passive_joint_turns
from expdesign.chain.effects.legs.geometry import EQUILIBRIUM, GeometricStiffness
from expdesign.chain.effects.legs.passive_joints import PassiveJoints, PassiveJointStiffness
from expdesign.chain.ports.law import ports_of
from expdesign.chain.ports.port import Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.evidence.dictionary import Dictionary, law_of, port_map
from expdesign.diagnosis.evidence.state import Present
from expdesign.estimation.fit import Data
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction
from tests.cases import robot
from tests.fitting import data_of
from tests.oracle import skew
from tests.ports.machines import recordings_of

NAME = "irregular"


@cache
def _bench(*ports: str, unloaded: bool = False) -> tuple[Dictionary, Data, FloatArray]:
    """Laws of some ports, the rows and the base model; `unloaded`: every series starts with a row without a load."""
    here, recordings = robot(NAME), recordings_of(None, NAME)
    if unloaded:
        first = np.append(True, np.diff(recordings.series) != 0)
        recordings = replace(recordings, wrenches=np.where(first[:, None], 0.0, recordings.wrenches))
    sample = data_of(replace(recordings, time=None), here)
    values = np.ones(Chain(here).compliances)
    return Dictionary(here, sample, values, only=ports), sample, values


def _maps(port: str, sample: Data, values: FloatArray) -> FloatArray:
    """Whitened derivatives of the readings with respect to what a port adds, shape (N, k, width)."""
    here = robot(NAME)
    (place,) = (p for p in ports_of(here) if p.name == port)
    return port_map(place, here, sample, values)


def _wrenches(dictionary: Dictionary) -> FloatArray:
    """Wrenches on the platform of all rows, shape (N, n)."""
    first = len(robot(NAME).stiffness)
    return np.column_stack([dictionary.sight.values(Quantity("effort", first + axis)) for axis in range(6)])


def _best(dictionary: Dictionary, sample: Data, values: FloatArray, shown: FloatArray) -> Entry:
    """The entry that explains a motion of the reading (N, n), ten standard deviations large, best."""
    here = robot(NAME)
    base = sample.whiten(Chain(here).predict_with_sensitivities(sample.rows, values)[1])
    noise = np.random.default_rng(4).standard_normal(shown.size)
    readings = noise + 10.0 * shown.ravel() / shown.std()
    present = Present(base.reshape(shown.size, -1), np.zeros(base.shape[2]), readings)
    gains = [present.gain(atom.directions)[0] for atom in dictionary.atoms]
    entry = dictionary.atoms[int(np.argmax(gains))].entry
    assert entry is not None
    return entry


@pytest.mark.parametrize("port", ["platform", "base"])
def test_a_mount_that_slips_along_every_axis_by_itself_is_one_law(port: str) -> None:
    """Each component of the twist is the clipped component of the wrench since the series' start."""
    dictionary, sample, values = _bench(port, f"{port} opening")
    here = robot(NAME)
    n, first = here.coordinates.n, len(here.stiffness) + (0 if port == "platform" else here.coordinates.n)
    limits = [0.3 * dictionary.sight.largest(Quantity("effort", first + a)) for a in range(n)]
    slipped = [dictionary.sight.values(Quantity("stop", first + a, (limits[a],))) for a in range(n)]
    maps = _maps(port, sample, values)
    sizes = np.sqrt((maps**2).mean(axis=(0, 1)))
    twist = np.column_stack([s / limit / size for s, limit, size in zip(slipped, limits, sizes, strict=True)])
    entry = _best(dictionary, sample, values, np.einsum("nkw,nw->nk", maps, twist))
    assert (entry.form, entry.blocks) == ("friction", n)


def test_a_reading_whose_scale_changes_with_the_place_is_one_law_of_all_axes() -> None:
    dictionary, sample, values = _bench("instrument", "cross talk")
    here = robot(NAME)
    own = sample.whiten(Chain(here).predict(sample.rows, values)[:, :, None])[:, :, 0]
    place = dictionary.sight.values(Quantity("position", 0))
    way = (place - place.mean()) / place.std()
    entry = _best(dictionary, sample, values, own * (way + 0.5 * way**2)[:, None])
    assert (entry.form, entry.blocks) == ("scale", 1)


def test_what_comes_with_the_load_pulls_as_a_force_does_and_not_at_all_without_a_load() -> None:
    assert not _bench("attachments")[0].atoms
    dictionary, sample, values = _bench("attachments", unloaded=True)
    loaded = np.asarray(_wrenches(dictionary).any(axis=1))
    always, attached = _maps("payload", sample, values), _maps("attachments", sample, values)
    assert loaded.any()
    assert not loaded.all()
    assert np.array_equal(attached[loaded], always[loaded])
    assert not attached[~loaded].any()
    assert {atom.entry.form for atom in dictionary.atoms if atom.entry is not None} == {"field"}


def test_a_moved_centre_of_mass_adds_the_moment_of_the_load_about_it() -> None:
    """Δm = (R·u) × F, and the readings change as the base model's do with that moment."""
    dictionary, sample, values = _bench("centre of mass")
    moved = np.array([0.02, -0.01, 0.03])
    columns = [dictionary.sight.values(Quantity("rotation", index)) for index in range(9)]
    rotation = np.stack(columns, axis=1).reshape(-1, 3, 3).transpose(0, 2, 1)
    moments = np.cross(rotation @ moved, _wrenches(dictionary)[:, :3])
    added = np.concatenate([np.zeros_like(moments), moments], axis=1)
    expected = np.einsum("nkw,nw->nk", _maps("payload", sample, values), added)
    found = np.einsum("nkw,w->nk", _maps("centre of mass", sample, values), moved)
    assert np.abs(expected).max() > 1.0
    assert np.allclose(found, expected, atol=1e-9 * np.abs(expected).max())
    assert {str(atom.component) for atom in dictionary.atoms} == {"payload"}


def test_an_axis_that_shows_in_another_one_is_a_single_coefficient() -> None:
    """2 % of the rotation about x show along z, which no rotation of the instrument does."""
    dictionary, sample, values = _bench("instrument", "cross talk")
    own = sample.whiten(Chain(robot(NAME)).predict(sample.rows, values)[:, :, None])[:, :, 0]
    shown = np.zeros_like(own)
    shown[:, 2] = 0.02 * own[:, 3]
    entry = _best(dictionary, sample, values, shown)
    (channel,) = entry.channels
    assert entry.port == "cross talk"
    assert (channel.output, channel.amplitude) == (2, Quantity("deflection", 3))


@pytest.mark.parametrize("port", ["platform", "base"])
def test_a_joint_that_opens_at_a_skew_edge_is_a_law_of_the_moments_in_its_plane(port: str) -> None:
    """It turns about an edge between x and y by what the moment about that exceeds 40 % of its largest, either way."""
    dictionary, sample, values = _bench(port, f"{port} opening")
    effort = "carried" if port == "platform" else "ground"
    edge = np.array([0.8, 0.6])
    moment = np.column_stack([dictionary.sight.values(Quantity(effort, 3 + axis)) for axis in (0, 1)]) @ edge
    beyond = np.sign(moment) * np.maximum(np.abs(moment) - 0.4 * np.abs(moment).max(), 0.0)
    entry = _best(dictionary, sample, values, _maps(port, sample, values)[:, :, 3:5] @ edge * beyond[:, None])
    assert (entry.port, entry.kernel) == (f"{port} opening", "arc_cosine")
    assert {3, 4} <= {channel.output for channel in entry.channels}
    assert entry.inputs == tuple(Quantity(effort, component) for component in (2, 3, 4))


def test_friction_that_is_tight_at_one_end_is_a_law_of_the_history_and_the_length() -> None:
    """A rigid slider whose friction is five times as large at one end of the travel as at the other."""
    dictionary, sample, values = _bench("actuators")
    length = dictionary.sight.values(Quantity("length", 2))
    share = (length - length.min()) / np.ptp(length)
    force, friction = dictionary.sight.values(Quantity("effort", 2)), np.zeros(len(length))
    limit = (0.05 + 0.2 * share) * np.abs(force).max()
    for series in np.unique(sample.rows.series):
        held = before = 0.0
        for row in np.flatnonzero(sample.rows.series == series):
            held = float(np.clip(held + force[row] - before, -limit[row], limit[row]))
            before, friction[row] = force[row], held
    entry = _best(dictionary, sample, values, _maps("actuators", sample, values)[:, :, 2] * friction[:, None])
    assert (str(entry.component), entry.form) == ("leg 3", "friction")
    assert entry.inputs == (Quantity("length", 2),)


def test_two_legs_on_a_bracket_with_play_are_one_law_of_both_forces() -> None:
    """Pulled together, both are longer by the same; pushed, the bracket is where it rests."""
    dictionary, sample, values = _bench("actuators")
    sign = dictionary.sight.values(Quantity("pair_sign", 1, (4.0,)))
    both = sum(dictionary.sight.values(Quantity("effort", leg)) for leg in (1, 4))
    np.testing.assert_array_equal(sign, np.sign(both))
    maps = _maps("actuators", sample, values)
    pulled = (sign > 0.0).astype(float)
    entry = _best(dictionary, sample, values, (maps[:, :, 1] + maps[:, :, 4]) * pulled[:, None])
    assert (entry.form, [channel.output for channel in entry.channels]) == ("bracket", [1, 4])
    assert entry.inputs == (Quantity("pair_sign", 1, (4.0,)),)


def test_a_leg_that_is_softer_when_it_is_warm_follows_the_temperature_from_its_mean() -> None:
    """Not the warming since the series began: and its compliance stays positive, since a constant is the spring's."""
    dictionary, sample, values = _bench("actuators")
    temperature = dictionary.sight.values(Quantity("temperature", 4))
    maps = _maps("actuators", sample, values)[:, :, 4]
    softer = (temperature - temperature.mean()) * dictionary.sight.values(Quantity("effort", 4))
    entry = _best(dictionary, sample, values, maps * softer[:, None])
    (seen,) = entry.inputs
    assert (str(entry.component), entry.form, entry.kernel, seen.kind) == (
        "leg 5",
        "compliance",
        "linear",
        "temperature",
    )
    assert dictionary.sight.values(seen).mean() == pytest.approx(0.0, abs=1e-3)


def test_the_force_in_either_of_two_legs_moves_the_other_one_by_one_law_of_a_leg() -> None:
    dictionary, sample, values = _bench("actuators", "base")
    extra = np.zeros((len(sample.rows), 6))
    extra[:, 1], extra[:, 4] = (dictionary.sight.values(Quantity("effort", leg)) for leg in (4, 1))
    shown = np.einsum("nkw,nw->nk", _maps("actuators", sample, values), extra)
    entry = _best(dictionary, sample, values, shown)
    assert (str(entry.component), entry.form, entry.blocks, entry.rank) == ("leg 2", "bracket", 1, 1)


def test_a_leg_that_rests_at_one_end_of_its_play_is_one_law_of_the_sign_of_its_force() -> None:
    """An unloaded row shows no play: the leg is where it was at rest, whichever way it is pushed later."""
    dictionary, sample, values = _bench("actuators", "environment", "payload", unloaded=True)
    extra = np.zeros((len(sample.rows), 6))
    extra[:, 2] = dictionary.sight.values(Quantity("effort", 2)) > 0.0
    shown = np.einsum("nkw,nw->nk", _maps("actuators", sample, values), extra)
    entry = _best(dictionary, sample, values, shown)
    assert (str(entry.component), entry.form) == ("leg 3", "step at zero")


@pytest.mark.parametrize("end", ["base", "platform"])
def test_an_end_of_a_leg_that_is_elsewhere_is_a_law_of_that_leg(end: str) -> None:
    dictionary, sample, values = _bench("geometry")
    names = robot(NAME).geometry_names  # type: ignore[attr-defined]
    moved = np.array([name.startswith(f"{end} 5 ") for name in names])
    shown = _maps("geometry", sample, values) @ (moved * np.linspace(1.0, 2.0, len(names)))
    entry = _best(dictionary, sample, values, shown)
    assert (str(entry.component), entry.form, len(entry.channels)) == ("leg 5", "geometry", 3)
    assert {names[channel.output].rpartition(" ")[0] for channel in entry.channels} == {f"{end} 5"}


def test_a_load_in_another_direction_is_a_law_of_two_weights() -> None:
    """A base that yields in all directions and a load that is another one everywhere have ten times as many."""
    dictionary, sample, values = _bench("load direction", "payload", "base")
    shown = _maps("load direction", sample, values) @ np.array([1.0, -2.0])
    entry = _best(dictionary, sample, values, shown)
    assert (entry.port, str(entry.component), entry.blocks, entry.rank) == ("load direction", "payload", 2, 1)


def test_one_weight_that_is_wrong_is_a_law_of_the_size_of_the_load() -> None:
    dictionary, sample, values = _bench("payload", "base", "platform")
    size = dictionary.sight.values(Quantity("weight"))
    share = np.exp(-0.5 * ((size - np.median(size)) / (0.1 * size.std())) ** 2)
    extra = share[:, None] * _wrenches(dictionary)
    shown = np.einsum("nkw,nw->nk", _maps("payload", sample, values), extra)
    entry = _best(dictionary, sample, values, shown)
    assert (str(entry.component), entry.form, [q.kind for q in entry.inputs]) == ("payload", "load", ["weight"])


def test_legs_that_grow_with_the_temperature_do_so_in_proportion_to_their_lengths() -> None:
    here, recordings = robot(NAME), recordings_of(None, NAME)
    warm = replace(recordings, temperature=20.0 + np.random.default_rng(2).uniform(0.0, 5.0, len(recordings)))
    sight = _sight(here, warm)
    (port,) = (port for port in ports_of(here) if port.name == "actuators")
    grown = [e for e in port.entries(sight) if any(c.amplitude == Quantity("length", 0) for c in e.channels)]
    (entry,) = grown
    assert str(entry.component) == "all legs"
    assert entry.blocks == 1
    assert [c.amplitude for c in entry.channels] == [Quantity("length", leg) for leg in range(6)]


def _sight(here: Robot, recordings: Recordings) -> Sight:
    rows = row_data(recordings, here)
    axes = list(range(here.coordinates.n))
    return Sight(here, Chain(here).row_symbols(), rows, np.ones(len(rows), dtype=bool), axes, timed=False)


def test_joints_that_resist_being_turned_are_a_law_of_the_legs() -> None:
    """As the named effect has it: what two percent of it do to the readings, all legs alike."""
    dictionary, sample, values = _bench("passive joints", "geometry", "base", "platform")
    here = robot(NAME)
    chain = Chain(here, (PassiveJointStiffness(here, ALL_LEGS, PassiveJoints.CARDAN),))
    small = np.append(values, 1.0)
    shown = chain.predict(sample.rows, small) - chain.predict(sample.rows, np.append(values, 0.0))
    entry = _best(dictionary, sample, values, sample.whiten(shown))
    assert (entry.port, str(entry.component)) == ("passive joints", "all legs")
    ends = _maps("passive joints", sample, values) @ np.r_[np.full(6, 1.0), np.full(6, 1.0)]
    bending = Chain(here, (PassiveJointStiffness(here, ALL_LEGS, PassiveJoints.BENDING),))
    exact = sample.whiten(bending.predict_with_sensitivities(sample.rows, np.append(values, 0.0))[1])[..., -1]
    assert ends == pytest.approx(exact, rel=1e-9, abs=1e-9 * np.abs(exact).max())


def test_flexures_of_both_ends_do_together_what_the_named_effect_does_to_first_order() -> None:
    """And bent ones are told from joints that are relaxed at every pose."""
    dictionary, sample, values = _bench("passive joints", "flexures", "geometry", "base", "platform")
    here = robot(NAME)
    chain = Chain(here, (PassiveJointStiffness(here, ALL_LEGS, PassiveJoints.FLEXURES),))
    exact = sample.whiten(chain.predict_with_sensitivities(sample.rows, np.append(values, 0.0))[1])[..., -1]
    ends = _maps("flexures", sample, values).sum(axis=2)
    assert ends == pytest.approx(exact, rel=1e-9, abs=1e-9 * np.abs(exact).max())
    entry = _best(dictionary, sample, values, exact)
    assert (entry.port, str(entry.component)) == ("flexures", "all legs")


def test_a_change_of_geometry_under_load_is_a_law_of_one_weight_of_the_geometry() -> None:
    dictionary, sample, values = _bench("loaded geometry", "geometry", "base", "platform")
    here = robot(NAME)
    chain = Chain(here, (GeometricStiffness(here, GEOMETRY, EQUILIBRIUM),))
    exact = chain.predict(sample.rows, np.append(values, 1.0)) - chain.predict(sample.rows, np.append(values, 0.0))
    shown = sample.whiten(exact)
    assert _maps("loaded geometry", sample, values)[:, :, 0] == pytest.approx(shown, abs=1e-9 * np.abs(shown).max())
    entry = _best(dictionary, sample, values, shown)
    assert (entry.port, str(entry.component), entry.blocks, entry.rank) == ("loaded geometry", "geometry", 1, 1)


def test_a_loop_that_closes_at_zero_is_a_law_of_the_history_and_the_force() -> None:
    """Friction that grows with the load, as of a flag-shaped loop, is nothing where the force is."""
    dictionary, sample, values = _bench("actuators")
    force = dictionary.sight.values(Quantity("effort", 3))
    stop = dictionary.sight.values(Quantity("stop", 3, (0.2 * np.abs(force).max(),)))
    loop = stop * (force / force.std()) ** 2
    entry = _best(dictionary, sample, values, _maps("actuators", sample, values)[:, :, 3] * loop[:, None])
    assert (str(entry.component), entry.form, entry.inputs) == ("leg 4", "friction", (Quantity("effort", 3),))


def test_a_leg_between_joints_that_stick_bends_as_a_clamped_beam() -> None:
    """While nothing slips: the stiffness of Euler's and Bernoulli's beam element, with 4EI/q = 1 and GJ = 4EI."""
    here, (_, sample, _) = robot(NAME), _bench("sticking joints")
    row, leg = Chain(here).row_symbols(), 2
    turns = ca.vertcat(*passive_joint_turns(here, row, leg))
    share = np.eye(7)
    share[:3, 3:6] = share[3:6, :3] = -0.5 * np.eye(3)
    direction, arm = row.inverse[leg, :3].T, row.rotation @ ca.SX(here.straight_legs.platform_joints[leg])
    expressions = [turns.T @ share @ turns, direction, arm, row.lengths[leg]]
    found = BatchFunction("stiffness", [row.flat()], expressions)(sample.rows.values[:1])
    (stiffness,), u, lever, length = found[0], found[1].ravel(), found[2].ravel(), float(found[3].item())
    across = np.eye(3) - np.outer(u, u)
    # Of the end at the platform: force by displacement 12EI/q³, by rotation 6EI/q², moment by rotation 4EI/q.
    coupling = 1.5 / length * skew(u)
    beam = np.block([[3.0 / length**2 * across, coupling], [coupling.T, across + np.outer(u, u)]])
    moved = np.block([[np.eye(3), -skew(lever)], [np.zeros((3, 3)), np.eye(3)]])
    np.testing.assert_allclose(stiffness, moved.T @ beam @ moved, rtol=1e-9, atol=1e-9)


def test_a_leg_whose_joints_stick_and_slip_is_one_law_of_that_leg_and_the_chain_remembers_as_it_was_found() -> None:
    dictionary, sample, values = _bench("sticking joints", "passive joints", "actuators", "base", "platform")
    here = robot(NAME)
    own = [atom for atom in dictionary.atoms if atom.entry is not None and atom.entry.port == "sticking joints"]
    (fifth,) = (atom for atom in own if str(atom.component) == "leg 5")
    weights = np.random.default_rng(3).standard_normal(fifth.width)
    shown = fifth.directions @ weights
    entry = _best(dictionary, sample, values, shown.reshape(len(sample.rows), -1))
    assert (entry.port, str(entry.component)) == ("sticking joints", "leg 5")
    law, start = law_of(fifth, 1e9, weights, dictionary.sight, here, 1)
    chain = Chain(here, (law,))
    changes = chain.predict(sample.rows, np.append(values, start)) - Chain(here).predict(sample.rows, values)
    np.testing.assert_allclose(sample.whiten(changes).ravel(), shown, atol=1e-8 * np.abs(shown).max())


@pytest.mark.parametrize("name", ["irregular", "bipod", "moving-xyz"])
def test_laws_that_remember_act_where_the_chain_remembers(name: str) -> None:
    """A law at another port would forget every row before, and say so when it is made."""
    here = robot(name)
    sight = _sight(here, recordings_of(None, name))
    for port in ports_of(here):
        remember = [entry for entry in port.entries(sight) if any(q.states for q in entry.quantities)]
        assert hasattr(port, "actuator") or hasattr(port, "structure") or not remember, port.name
