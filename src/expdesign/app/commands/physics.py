"""`expdesign physics`: what a robot can have beside its base model."""

from itertools import groupby
from typing import Any

import expdesign as xd
from expdesign.app.commands.writing import Json, RobotPath
from expdesign.io.output import json_text

GROUP = ("data", 6)
"""Where it stands in the list of commands."""
MOST = 3
"""Names of parameters of one size that are all listed."""


def command(
    robot: RobotPath,
    json: Json = False,
) -> None:
    """List the physics that a robot can have: identifiers, places, forms, parameters with units and usual sizes.

    Example: expdesign physics configs/robots/hexapod-h1.yaml
    """
    found = xd.physics(robot)
    if json:
        print(json_text(found.record), end="")
        return
    last = ""
    for entry in found.record["physics"]:
        if entry["physics"] != last:
            print(f"{entry['physics']}\n  {entry['sentence']}")
            if entry["usually"]:
                print(f"  usually: {entry['usually']}")
            if entry["depends_on"]:
                depends = f"  depends on {', '.join(entry['depends_on'])}"
                print(f"{depends}; beyond what was recorded it {entry['beyond_recorded']}")
        last = entry["physics"]
        print(f"  at {_listed(entry['components'])}")
        if entry["variants"] != [""]:
            print(f"    forms: {', '.join(form or '(none named)' for form in entry['variants'])}")
        for size, alike in groupby(entry["parameters"], _size):
            print(f"    {_names([one['parameter'] for one in alike])}: usually {size}")
        if entry["example"]:
            print(f'    --conceal "{entry["example"]}"')
        if len(entry["shown_in"]) < MOST:
            print(f"    shows in {' and '.join(entry['shown_in'])} only")


def _listed(names: list[str]) -> str:
    """`leg 1 to leg 6, all legs`."""
    numbered = [name for name in names if name[-1].isdigit()]
    others = [name for name in names if name not in numbered]
    return ", ".join(([f"{numbered[0]} to {numbered[-1]}"] if len(numbered) > 2 else numbered) + others)


def _names(names: list[str]) -> str:
    """A few names, or the first and the last."""
    return ", ".join(names) if len(names) <= MOST else f"{names[0]} to {names[-1]} ({len(names)} parameters)"


def _size(one: dict[str, Any]) -> str:
    size = f"{one['usual']:g} × {one['multiple_of']}" if one["multiple_of"] else f"{one['usual']:g} {one['unit']}"
    return size.strip() + (f" ({one['source']})" if one["source"] else "")
