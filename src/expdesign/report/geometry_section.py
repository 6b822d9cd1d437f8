"""The identified geometry on the page of `expdesign identify`."""

import numpy as np
import pandas as pd

from expdesign.estimation.identify import Identification
from expdesign.report import words
from expdesign.report.blocks import Section, Sentences, table_of


def geometry_section(result: Identification) -> Section:
    """Errors of joints and lengths with their intervals; needs an identification that has them."""
    interval = result.geometry
    assert interval is not None
    columns = {"estimate": interval.estimate, "low": interval.low, "high": interval.high}
    frame = pd.DataFrame({"parameter": result.geometry_names, **columns})
    rows = [
        [str(row[0]).replace("_", " "), *(words.number(1e3 * float(value), 4) for value in row[1:])]
        for row in frame.to_numpy()
    ]
    size = float(np.sqrt((interval.estimate**2).mean()))
    text = (
        f"Joints and lengths of the legs differ from the robot file by {words.number(1e3 * size)} mm (RMS of "
        f"{len(rows)} parameters). The model file carries them with their covariance: predictions and commands of "
        "`expdesign compensate` allow for them."
    )
    caption = "True minus nominal, in mm or mrad, with 95 % intervals. The CSV is in SI units."
    table = table_of("geometry-table", caption, ["Parameter", "Error", "Low", "High"], rows, frame)
    return Section("geometry", "Geometry", [Sentences([text]), table])
