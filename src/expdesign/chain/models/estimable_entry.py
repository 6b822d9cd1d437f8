"""What a model file says of combinations of parameters, where not every parameter is determined by itself."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import Estimable
from expdesign.errors import InputError
from expdesign.io.schema import Section
from expdesign.io.yaml_reader import YamlDocument


class EstimableSection(Section):
    """Covariance of the estimable combinations (p×p), kernel (d×p) and conditional standard deviations (p)."""

    covariance: list[list[float]]
    undetermined: list[list[float]]
    resolution: list[float]


def estimable_entry(estimable: Estimable) -> dict[str, object]:
    """The key `estimable` of a model file; nothing where every parameter is determined."""
    if estimable.directions.shape[1] == 0:
        return {}
    section = {
        "covariance": estimable.generalised.tolist(),
        "undetermined": estimable.directions.T.tolist(),
        "resolution": estimable.resolution.tolist(),
    }
    return {"estimable": section}


def subspace_of(
    section: EstimableSection | None, count: int, document: YamlDocument, units: FloatArray
) -> Estimable | None:
    """What the section says, its `count` parameters multiplied by `units` (p,); None where the file says nothing.

    Raises:
        InputError: the section does not fit the parameters.
    """
    if section is None:
        return None
    sizes = [len(row) for row in (*section.covariance, *section.undetermined, section.resolution)]
    values = np.array([x for row in (*section.covariance, *section.undetermined, section.resolution) for x in row])
    if set(sizes) != {count} or len(section.covariance) != count or not np.isfinite(values).all():
        what = f"rows of {count} finite numbers are needed here, and {count} rows of `covariance`"
        raise InputError(what, where=document.where(("estimable",)), remedy="Identify the recordings again.")
    directions = np.array(section.undetermined).reshape(-1, count).T
    found = Estimable(np.array(section.covariance), directions, np.array(section.resolution))
    return found.in_units(units)
