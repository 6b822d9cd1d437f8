"""How much pages show, and from when on."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PageOptions:
    """Limits of pages; what they leave out stands in the files beside them.

    Attributes:
        recorded_rows: rows of recordings beyond which `identification.json` lists only those that are flagged.
        listed_rows: rows of the table of measurements; of more the outliers and the largest leverages.
        downloaded_rows: rows beyond which that table's CSV holds what is shown, so that the page stays small.
        points: points of a figure; of more rows every second, third ... is drawn.
        fast_points: points from which they are drawn by the graphics card.
        levels: decimals of a quantity's range to which its values are the same level.
        models: models in the table of what was considered.
        curve_lines: outputs of a law that its figure shows, the largest.
        listed_place: probability from which a page lists a place of a law.
        recorded_place: the same for `diagnosis.json`.
        names: names that a sentence lists.
        bars_beside: axes of an error budget that are drawn beside the robot; more take the full width.
        growth: part by which the total error may grow where a plan is not met exactly.
        delicate_evaluations: measurements that are evaluated for the sensitivity of all designs (a second or two);
            where these are more, of the recommended one and the knee, of the recommended one, or of none.
        ellipse: probability of the error to lie inside an ellipse.
        bins: of a histogram.
        half_width: predicted standard deviations that a density is drawn to either side.
        panels: figures of densities beside each other.
        hidden_bars: bars of the figure of what could stay hidden.
        cheap: part of the least total error that noticing may cost before it is called dear.
        few_poses: share of reachable poses below which the units of `experiment.poses` are probably wrong.
        arrow: length of the largest force's arrow as a share of the robot's size.
        axis: length of a joint's axis, likewise.
        label: distance of a leg's number from its base joint, likewise.
        unbroken: characters of a cell that stay in one line.
        negligible: part of a column's scale below which a number is shown as 0: rounding, not a finding.
    """

    recorded_rows: int = 2000
    listed_rows: int = 200
    downloaded_rows: int = 10000
    points: int = 3000
    fast_points: int = 500
    levels: int = 6
    models: int = 60
    curve_lines: int = 6
    listed_place: float = 0.01
    recorded_place: float = 0.001
    names: int = 6
    bars_beside: int = 12
    growth: float = 0.01
    delicate_evaluations: int = 60_000
    ellipse: float = 0.95
    bins: int = 60
    half_width: float = 4.0
    panels: int = 3
    hidden_bars: int = 30
    cheap: float = 0.05
    few_poses: float = 0.01
    arrow: float = 0.3
    axis: float = 0.1
    label: float = 0.11
    unbroken: int = 30
    negligible: float = 1e-6


SHOWN = PageOptions()
