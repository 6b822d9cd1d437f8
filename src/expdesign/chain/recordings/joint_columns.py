"""Columns of joints: by number in the chain (`q3_rad`) or by the URDF's name (`elbow_rad`), commanded or measured.

Of a robot with several tips the column `tip` names the one that a row is of. A column that looks like a joint's and is
none of the robot's is an error: what it says would be lost, and with it the weight that the joint moves.
"""

import difflib
import re
from dataclasses import replace

import numpy as np

from expdesign.chain.recordings.columns import require_mass
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.kinematic_tree import PAYLOAD_COLUMNS, TIP_COLUMN
from expdesign.mechanics.robots.robot import Robot

_NUMBERED = re.compile(r"q\d+_(rad|m)")
_UNIT = re.compile(r"(.+)_(rad|m)")
_LIKE = 0.85
"""Similarity (0 to 1) above which a name is a slip of the pen for a joint's."""


def with_joints(table: Table, robot: Robot) -> Table:
    """`with_joint_columns` of rows that have to be commanded as the robot is.

    Raises:
        InputError: as there, or rows are commanded by joints and the robot is by poses, or the reverse.
    """
    table = with_joint_columns(table, robot)
    _require_its_own(table, robot)
    return table


def with_joint_columns(table: Table, robot: Robot) -> Table:
    """The table with the joints of the chain under their numbered names.

    Raises:
        InputError: a joint has two columns, or a column is of a joint that the robot does not have.
    """
    if not robot.jointed:
        return table
    tree = robot.links.tree
    numbered = {
        f"{coordinate.joint}_{coordinate.unit}": name
        for coordinate, name in zip(tree.coordinates, robot.configuration, strict=False)
    }
    twice = next((own for own, name in numbered.items() if own != name and table.has(own, name)), None)
    if twice is not None:
        what = f"the joint has the column {numbered[twice]} as well"
        raise table.fault(what, column=twice, remedy="Leave one of them out.")
    for column in table.columns:
        if column not in numbered and column not in robot.configuration:
            _require_no_joint(column, table, robot)
    table = _with_tips(table, tree.tips)
    for carrier in tree.carriers:
        require_mass(table, f"{carrier}_{PAYLOAD_COLUMNS[0]}")
    renamed = {own: name for own, name in numbered.items() if own != name and table.has(own)}
    written = table.written | {name: table.written.get(own, own) for own, name in renamed.items()}
    return replace(table, frame=table.frame.rename(columns=renamed), written=written) if renamed else table


def _require_its_own(table: Table, robot: Robot) -> None:
    """Raise an `InputError` where rows are commanded by joints and the robot is by poses, or the reverse."""
    first = robot.configuration[0]
    if table.has(first):
        return
    if not robot.jointed:
        given, others = "joints", [name for name in table.columns if _NUMBERED.fullmatch(name)]
    else:
        given, others = "poses", [name for name in robot.coordinates.pose if table.has(name)]
    if not others or any(table.has(name) for name in robot.configuration):
        return
    known = ", ".join(robot.configuration[:3])
    what = f"the rows have {given} ({', '.join(others[:3])} ...), and `{robot.name}` is commanded by {known} ..."
    raise InputError(what, where=table.source, remedy="Is this the wrong robot file?")


def _with_tips(table: Table, tips: tuple[str, ...]) -> Table:
    """The table with the tips of its rows by number, from 1, of a robot that has several."""
    if len(tips) == 1:
        return table
    known = f"The robot's tips are {', '.join(f'`{tip}`' for tip in tips)}."
    if not table.has(TIP_COLUMN):
        raise table.fault("the column is missing, which says of which tip a row is", column=TIP_COLUMN, remedy=known)
    names = table.frame[TIP_COLUMN].astype(str).str.strip()
    numbers = {name: str(number) for number, tip in enumerate(tips, start=1) for name in (tip, str(number))}
    found = names.str.removesuffix(".0").map(numbers)
    table.refuse(
        found.isna().to_numpy(), (TIP_COLUMN,), "`{}` is no tip of the robot", known, names.to_numpy(dtype=str)
    )
    if table.has("marker"):
        sits = found.groupby(table.frame["marker"].astype(str).str.strip()).transform("first")
        if (sits != found).any():
            row = int(np.argmax(sits != found))
            marker, first = table.frame["marker"].iloc[row], tips[int(sits.iloc[row]) - 1]
            what = f"marker `{marker}` sits on `{first}` in a row before"
            raise table.fault(what, row, TIP_COLUMN, remedy="Name markers of two tips differently.")
    return replace(table, frame=table.frame.assign(**{TIP_COLUMN: found}))


def _require_no_joint(column: str, table: Table, robot: Robot) -> None:
    tree = robot.links.tree
    coordinates = (*tree.coordinates, *tree.branch_coordinates)
    known = f"The robot's columns are {', '.join(robot.configuration)}."
    if _NUMBERED.fullmatch(column):
        what = f"the robot has no such joint between `{tree.base}` and `{'`, `'.join(tree.tips)}`"
        raise table.fault(what, column=column, remedy=known)
    match = _UNIT.fullmatch(column)
    if match is None:
        return
    name = match.group(1)
    moving = [joint.name for joint in tree.urdf.joints.values() if joint.moves]
    if name in (coordinate.joint for coordinate in coordinates):
        remedy = "Angles are columns `NAME_rad`, travels `NAME_m`."
        raise table.fault(f"joint `{name}` has the other unit", column=column, remedy=remedy)
    if name in moving:
        joint = tree.urdf.joints[name]
        led = " and ".join(f"`{mimic.joint}`" for mimic in joint.mimics)
        what = f"joint `{name}` is no column of this robot" + (f": it follows {led}" if led else "")
        remedy = f"Leave the column out; {known}" if led else f"Add `branch_joints: [{name}]` to the robot file."
        raise table.fault(what, column=column, remedy=remedy)
    near = difflib.get_close_matches(name, moving, n=1, cutoff=_LIKE)
    if near:
        raise table.fault(f"the URDF has no joint `{name}`", column=column, remedy=f"Is `{near[0]}` meant?")
