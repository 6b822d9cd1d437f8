"""Laws in the report of a diagnosis: their curves, and where they may be."""

import numpy as np
import pandas as pd

from expdesign.chain.ports.words import quantity_name, unit_of
from expdesign.diagnosis.law_findings import LawFinding, curve_file, curves
from expdesign.diagnosis.result import Diagnosis
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Figure, table_of
from expdesign.report.figures import band, chart, curve

_LISTED = 0.01
_MOST_LINES = 6


def law_blocks(result: Diagnosis) -> list[Block]:
    """Table of places and curves; empty where no law was found."""
    if result.laws is None:
        return []
    return [_places_table(result), *(law_figure(result, finding) for finding in curves(result.findings))]


def law_figure(result: Diagnosis, finding: LawFinding) -> Figure:
    """The curve of a law with its 95 % band, one line per output, over the input that tells most."""
    found = finding.curve
    assert found is not None
    varied, outputs = np.array(found.varied), np.array(found.output)
    ranges = {i: float(np.ptp(found.mean[varied == i])) for i in np.unique(varied)}
    telling = max(ranges, key=lambda i: ranges[i])
    names = [quantity_name(q, result.robot) for q in found.quantities]
    unit = unit_of(found.quantities[telling], result.robot)
    chosen = {name: (outputs == name) & (varied == telling) for name in dict.fromkeys(found.output)}
    largest = sorted(chosen, key=lambda name: -float(np.ptp(found.mean[chosen[name]])))
    traces = []
    for name in largest[:_MOST_LINES]:
        rows = chosen[name]
        x = found.inputs[rows, telling]
        traces += [band(x, found.low[rows], found.high[rows]), curve(name, x, found.mean[rows])]
    file = curve_file(result.findings, finding) or "law.csv"
    others = "" if len(names) == 1 else " Its other inputs are held at their medians."
    return chart(
        file.removesuffix(".csv"),
        f"{finding.component.capitalize()}: {finding.variant}",
        traces,
        f"What was found, with its 95 % band, over the range that the recordings cover.{others}",
        f"Curve of a law at {finding.component} over {names[telling]} with its 95 % band.",
        x=f"{names[telling]}{', ' + unit if unit else ''}",
        y={"compliance": "compliance, m/N", "elongation": "elongation, m"}.get(found.meaning, "law, SI units"),
        frame=found.frame(list(finding.columns)),
        height=340,
        showlegend=len(chosen) > 1,
    )


def _places_table(result: Diagnosis) -> DataTable:
    assert result.laws is not None
    listed = [
        (number, place)
        for number, part in enumerate(result.laws.parts, start=1)
        for place in part.places
        if place.probability >= _LISTED
    ]
    rows = [
        [str(number), str(place.component), words.number(place.log_evidence, 4), probability_text(place.probability, 2)]
        for number, place in listed
    ]
    caption = (
        "Where each law may be. The evidence is that of all laws that the place could hold, beside the other laws; "
        "places whose probabilities are close cannot be told apart by these recordings."
    )
    frame = pd.DataFrame([{"law": number, **vars(place)} for number, place in listed])
    heads = ["Law", "Where", "Log evidence", "Probability"]
    return table_of("places", caption, heads, rows, frame if listed else None)
