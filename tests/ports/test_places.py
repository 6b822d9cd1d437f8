"""Families of laws at single ports: physics of several axes at once is one entry."""

import numpy as np
import pytest
from tests.cases import ROBOTS, robot
from tests.ports.machines import recordings_of

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.readings.deflection import DEFLECTION
from expdesign.chain.row import row_data
from expdesign.ports.dictionary import Dictionary, port_map
from expdesign.ports.evidence import Present
from expdesign.ports.law import ports_of
from expdesign.ports.measured import Measured
from expdesign.ports.port import Entry
from expdesign.ports.quantities import Quantity

NAME = "irregular"


def _bench(port: str) -> tuple[Dictionary, Measured, FloatArray]:
    here, recordings = robot(NAME), recordings_of(None, NAME)
    deviation = np.array(ROBOTS[NAME].deviation)

    def whiten(values: FloatArray) -> FloatArray:
        return np.asarray(values / deviation.reshape(-1, *[1] * (values.ndim - 2)))

    rows = row_data(recordings, here)
    everything = np.ones(len(rows), dtype=bool)
    axes = tuple(range(here.coordinates.n))
    measured = Measured(rows, axes, everything, whiten, rows.series, False, DEFLECTION, True)
    values = np.ones(Chain(here).compliances)
    return Dictionary(here, measured, values, only=(port,)), measured, values


def _best(dictionary: Dictionary, measured: Measured, values: FloatArray, shown: FloatArray) -> Entry:
    """The entry that explains a motion of the reading (N, n), ten standard deviations large, best."""
    here = robot(NAME)
    base = measured.whiten(Chain(here).predict_with_sensitivities(measured.rows, values)[1])
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
    dictionary, measured, values = _bench(port)
    here = robot(NAME)
    n, first = here.coordinates.n, len(here.stiffness) + (0 if port == "platform" else here.coordinates.n)
    limits = [0.3 * dictionary.sight.largest(Quantity("effort", first + a)) for a in range(n)]
    slipped = [dictionary.sight.values(Quantity("stop", first + a, (limits[a],))) for a in range(n)]
    (place,) = (p for p in ports_of(here) if p.name == port)
    maps = port_map(place, here, measured, values, ())
    sizes = np.sqrt((maps**2).mean(axis=(0, 1)))
    twist = np.column_stack([s / limit / size for s, limit, size in zip(slipped, limits, sizes, strict=True)])
    entry = _best(dictionary, measured, values, np.einsum("nkw,nw->nk", maps, twist))
    assert (entry.form, entry.blocks) == ("friction", n)


def test_a_reading_whose_scale_changes_with_the_place_is_one_law_of_all_axes() -> None:
    dictionary, measured, values = _bench("instrument")
    here = robot(NAME)
    own = measured.whiten(Chain(here).predict(measured.rows, values)[:, :, None])[:, :, 0]
    place = dictionary.sight.values(Quantity("position", 0))
    way = (place - place.mean()) / place.std()
    entry = _best(dictionary, measured, values, own * (way + 0.5 * way**2)[:, None])
    assert (entry.form, entry.blocks) == ("scale", 1)
