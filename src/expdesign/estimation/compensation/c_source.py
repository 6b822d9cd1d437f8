"""A correction table as one file of C99 that needs nothing else: no allocation, no library, one function."""

import textwrap
from collections.abc import Sequence

from expdesign.estimation.compensation.correction_table import MARGIN, SAFETY, CorrectionTable

_HEADER = """\
/* Corrections of commands: command = target + correction.
 *
{about}
 *
 * in[{inputs}], in this order, with the range of the table:
{ranges}
{held} * out[{outputs}], the corrections, and by how much interpolation may be wrong:
{errors}
 * How that was found: the larger one of the bound sum(h^2/8 max|f''|) over the axes, f'' sampled and taken {safety:g}
 * times as large, and of {margin:g} times the largest error against the exact correction at {checks} centres of
 * cells and random points. It is the error of interpolation alone: how well the robot was identified is not in it.
 *
 * Returns 0, or 1 where an input is outside its range (or not a number); the correction is then that at the edge.
 * Multilinear interpolation between {nodes} nodes. C99; no allocation, no state: safe in interrupts and threads.
 */

int expdesign_correction(const double in[{inputs}], double out[{outputs}]);
"""

_BODY = """
int expdesign_correction(const double in[{inputs}], double out[{outputs}])
{{
    unsigned long cell[{inputs}];
    double part[{inputs}];
    int outside = 0;
    for (int k = 0; k < {inputs}; ++k) {{
        double place = (in[k] - low[k]) * per_step[k];
        const double last = (double)(count[k] - 1ul);
        if (!(place >= 0.0)) {{ /* also where it is not a number */
            outside |= !(place >= -1e-9);
            place = 0.0;
        }} else if (place > last) {{
            outside |= place > last + 1e-9;
            place = last;
        }}
        cell[k] = (unsigned long)place;
        if (cell[k] > count[k] - 2ul) {{
            cell[k] = count[k] - 2ul;
        }}
        part[k] = place - (double)cell[k];
    }}
    for (int i = 0; i < {outputs}; ++i) {{
        out[i] = 0.0;
    }}
    for (unsigned long corner = 0ul; corner < {corners}ul; ++corner) {{
        double weight = 1.0;
        unsigned long node = 0ul;
        for (int k = 0; k < {inputs}; ++k) {{
            const unsigned long upper = (corner >> k) & 1ul;
            weight *= upper ? part[k] : 1.0 - part[k];
            node = node * count[k] + cell[k] + upper;
        }}
        for (int i = 0; i < {outputs}; ++i) {{
            out[i] += weight * value[node][i];
        }}
    }}
    return outside;
}}
"""


def c_source(
    table: CorrectionTable,
    inputs: Sequence[str],
    outputs: Sequence[str],
    held: Sequence[tuple[str, float]],
    about: str,
) -> str:
    """The text of the file.

    Args:
        table: what is interpolated.
        inputs: names of the axes with their units.
        outputs: names of the corrected coordinates with their units.
        held: coordinates that have one value in the whole table.
        about: where the table is from, in words.
    """
    grid = table.grid
    sizes = {"inputs": len(inputs), "outputs": len(outputs)}
    rows = zip(inputs, grid.low, grid.high, grid.counts, strict=True)
    ranges = [f" *   {name:12} {low:.9g} to {high:.9g}, {count} nodes" for name, low, high, count in rows]
    errors = [f" *   {name:12} {error:.3g}" for name, error in zip(outputs, table.stated, strict=True)]
    values = "; ".join(f"{name} = {value:.9g}" for name, value in held)
    lines = textwrap.wrap(f"Held: {values}.", 110) if held else []
    text = _HEADER.format(
        **sizes,
        about="\n".join(f" * {line}" for line in textwrap.wrap(_plain(about), 110)),
        ranges="\n".join(ranges),
        held="".join(f" * {line}\n" for line in lines),
        errors="\n".join(errors),
        safety=SAFETY,
        margin=MARGIN,
        checks=table.checks,
        nodes=len(table.values),
    )
    per_step = (grid.counts - 1) / (grid.high - grid.low)
    text += "\n" + _array("double", "low", [repr(float(x)) for x in grid.low])
    text += _array("double", "per_step", [repr(float(x)) for x in per_step])
    text += _array("unsigned long", "count", [f"{x}ul" for x in grid.counts])
    nodes = ",\n".join("    {" + ", ".join(repr(float(x)) for x in row) + "}" for row in table.values)
    text += f"static const double value[{len(table.values)}][{len(outputs)}] = {{\n{nodes}\n}};\n"
    return text + _BODY.format(**sizes, corners=2 ** len(inputs))


def _array(kind: str, name: str, values: list[str]) -> str:
    return f"static const {kind} {name}[{len(values)}] = {{{', '.join(values)}}};\n"


def _plain(text: str) -> str:
    """Text that cannot end a comment."""
    return text.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/")
