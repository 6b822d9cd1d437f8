"""What a fit takes, from recordings as tests make them."""

from expdesign.chain.readings.reading import DEFLECTION, Reading
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.fit import Data
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot


def data_of(recordings: Recordings, robot: Robot, reading: Reading = DEFLECTION) -> Data:
    """All rows, weighted by their stated standard deviations, without a shared reference."""
    assert recordings.deviations is not None
    return Data(recordings, row_data(recordings, robot), Whitening(recordings.deviations), reading=reading)
