"""Laws in the report of a diagnosis: their curves, where they may be, and the part of the robot that is concerned."""

import numpy as np
import pandas as pd

from expdesign.diagnosis.diagnose import Diagnosis
from expdesign.diagnosis.law_findings import LawFinding, curve_file, curves
from expdesign.files.csv_writer import csv_text
from expdesign.ports.words import quantity_name, unit_of
from expdesign.report import words
from expdesign.report.blocks import Block, DataTable, Download, Figure, SideBySide
from expdesign.robots.drawing import Drawing

_LISTED = 0.01
_MOST_LINES = 6


def law_blocks(result: Diagnosis) -> list[Block]:
    """Picture, table of places and curves; empty where no law was found."""
    if result.laws is None:
        return []
    picture = robot_figure(result)
    table = _places_table(result)
    blocks: list[Block] = [table] if picture is None else [SideBySide([picture], [table])]
    for finding in curves(result.findings):
        blocks.append(law_figure(result, finding))
    return blocks


def law_figure(result: Diagnosis, finding: LawFinding) -> Figure:
    """The curve of a law with its 95 % band, one line per output, over the input that tells most."""
    curve = finding.curve
    assert curve is not None
    varied = np.array(curve.varied)
    ranges = {i: float(np.ptp(curve.mean[varied == i])) for i in np.unique(varied)}
    telling = max(ranges, key=lambda i: ranges[i])
    names = [quantity_name(q, result.robot) for q in curve.quantities]
    unit = unit_of(curve.quantities[telling], result.robot)
    data = []
    outputs = np.array(curve.output)
    sizes = {
        name: float(np.ptp(curve.mean[(outputs == name) & (varied == telling)])) for name in dict.fromkeys(curve.output)
    }
    for name in sorted(sizes, key=lambda n: -sizes[n])[:_MOST_LINES]:
        chosen = (outputs == name) & (varied == telling)
        x = curve.inputs[chosen, telling]
        band_x, band_y = np.concatenate([x, x[::-1]]), np.concatenate([curve.high[chosen], curve.low[chosen][::-1]])
        data.append(
            {
                "type": "scatter", "mode": "lines", "x": band_x, "y": band_y, "fill": "toself", "hoverinfo": "skip",
                "line": {"width": 0}, "fillcolor": "rgba(120,140,180,0.25)", "showlegend": False,
            }
        )  # fmt: skip
        line = {"type": "scatter", "mode": "lines", "name": name, "x": x, "y": curve.mean[chosen]}
        data.append(line)
    meaning = {"compliance": "compliance, m/N", "elongation": "elongation, m"}.get(curve.meaning, "law, SI units")
    layout = {
        "xaxis": {"title": {"text": f"{names[telling]}{', ' + unit if unit else ''}"}},
        "yaxis": {"title": {"text": meaning}},
        "showlegend": len(sizes) > 1,
    }
    file = curve_file(result.findings, finding) or "law.csv"
    identifier = file.removesuffix(".csv")
    others = "" if len(names) == 1 else " Its other inputs are held at their medians."
    return Figure(
        identifier,
        f"{finding.component.capitalize()}: {finding.variant}",
        {"data": data, "layout": layout},
        f"What was found, with its 95 % band, over the range that the recordings cover.{others}",
        f"Curve of a law at {finding.component} over {names[telling]} with its 95 % band.",
        Download(file, csv_text(curve.frame(list(finding.columns)))),
        height=340,
        filename=identifier,
    )


def _places_table(result: Diagnosis) -> DataTable:
    assert result.laws is not None
    rows, records = [], []
    for number, part in enumerate(result.laws.parts, start=1):
        for place in part.places:
            if place.probability >= _LISTED:
                rows.append(
                    [
                        str(number),
                        str(place.component),
                        words.number(place.log_evidence, 4),
                        words.number(place.probability, 2),
                    ]
                )
                records.append({"law": number, **vars(place)})
    return DataTable(
        "places",
        "Where each law may be. The evidence is that of all laws that the place could hold, beside the other laws; "
        "places whose probabilities are close cannot be told apart by these recordings.",
        ["Law", "Where", "Log evidence", "Probability"],
        rows,
        Download("places.csv", csv_text(pd.DataFrame(records))) if records else None,
    )


def robot_figure(result: Diagnosis) -> Figure | None:
    """The robot at its middle pose with the parts that are concerned in another colour; None where it is not drawn."""
    drawing = result.robot.drawing(np.median(result.recordings.configurations, axis=0))
    if drawing is None:
        return None
    concerned = _concerned(result)
    data = [_trace(drawing, *line, concerned) for line in _lines(result, drawing)]
    space = drawing.points.shape[-1] == 3
    layout = {"scene": {"aspectmode": "data"}} if space else {"yaxis": {"scaleanchor": "x"}}
    listed = ", ".join(sorted(concerned)) or "none"
    return Figure(
        "robot-concerned",
        "The part that is concerned",
        {"data": data, "layout": {**layout, "showlegend": False}},
        f"The robot at the middle of the recorded poses. Highlighted: {listed}.",
        f"Drawing of the robot; highlighted: {listed}.",
        height=380,
        filename="robot-concerned",
    )


def _concerned(result: Diagnosis) -> set[str]:
    """Components of the findings, or the most probable places where nothing is modelled."""
    named = {finding.component for finding in result.findings if isinstance(finding, LawFinding)}
    if named or result.laws is None:
        return named
    return {str(part.places[0].component) for part in result.laws.parts if part.places}


def _lines(result: Diagnosis, drawing: Drawing) -> list[tuple[str, str, tuple[int, ...]]]:
    """Name of the component, role, and points of every line."""
    found: list[tuple[str, str, tuple[int, ...]]] = []
    for part in drawing.parts:
        single = part.role == "actuator" and len(part.paths) == len(result.robot.actuators)
        for index, path in enumerate(part.paths):
            found.append((result.robot.actuators[index] if single else part.role, part.role, path))
    return found


def _trace(drawing: Drawing, name: str, role: str, path: tuple[int, ...], concerned: set[str]) -> dict[str, object]:
    points = drawing.points[list(path)]
    every = role == "actuator" and any(c.startswith("all ") or c.startswith(("joint", "link")) for c in concerned)
    marked = name in concerned or every or (role == "platform" and bool(concerned & {"payload", "tool", "tip"}))
    colour = "var(--accent)" if marked else "var(--muted)"
    axes = dict(zip("xyz", points.T, strict=False))
    kind = "scatter3d" if points.shape[1] == 3 else "scatter"
    line = {"color": colour, "width": 7 if marked else 3}
    return {
        "type": kind,
        "mode": "lines+markers",
        "name": name,
        **axes,
        "line": line,
        "marker": {"size": 3, "color": colour},
    }
