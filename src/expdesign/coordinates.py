"""Names, units and order of the coordinates in which poses, loads and deflections are written down.

A column name carries its unit, and the same names serve configurations, plans and recordings
(the project's glossary lists them all).
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Coordinates:
    """The coordinates of one kind of workspace.

    The first `translations` entries of pose, deflection and wrench are lengths (m) and forces (N), the rest
    are angles (rad) and moments (N·m).
    """

    pose: tuple[str, ...]
    wrench: tuple[str, ...]
    deflection: tuple[str, ...]
    deviation: tuple[str, ...]
    gravity: tuple[str, ...]
    centre_of_mass: tuple[str, ...]
    tilt: tuple[str, ...]
    translations: int

    @property
    def n(self) -> int:
        """Number of coordinates of a pose."""
        return len(self.pose)

    @property
    def rotations(self) -> int:
        """How many of them are angles: 3 in space, 1 in the plane, 0 where a point moves without turning."""
        return self.n - self.translations

    @property
    def axes(self) -> str:
        """Names of the axes along which it moves, `xy` or `xyz`."""
        return "xyz"[: self.translations]

    @property
    def rotation_axes(self) -> str:
        """Names of the axes about which it turns: `xyz`, `z` or none."""
        return "xyz"[3 - self.rotations :]


SPATIAL = Coordinates(
    pose=("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"),
    wrench=("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"),
    deflection=("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"),
    deviation=("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad"),
    gravity=("gx_m_s2", "gy_m_s2", "gz_m_s2"),
    centre_of_mass=("com_x_m", "com_y_m", "com_z_m"),
    tilt=("tilt_x_rad", "tilt_y_rad"),
    translations=3,
)

PLANE = Coordinates(
    pose=("x_m", "y_m", "rz_rad"),
    wrench=("fx_N", "fy_N", "mz_Nm"),
    deflection=("dx_m", "dy_m", "drz_rad"),
    deviation=("sx_m", "sy_m", "srz_rad"),
    gravity=("gx_m_s2", "gy_m_s2"),
    centre_of_mass=("com_x_m", "com_y_m"),
    tilt=("tilt_rad",),
    translations=2,
)
"""A platform that moves in the x-y plane and turns about its normal."""

PLANAR = Coordinates(
    pose=("x_m", "y_m"),
    wrench=("fx_N", "fy_N"),
    deflection=("dx_m", "dy_m"),
    deviation=("sx_m", "sy_m"),
    gravity=("gx_m_s2", "gy_m_s2"),
    centre_of_mass=(),
    tilt=("tilt_rad",),
    translations=2,
)
"""A point in the x-y plane, without orientation."""
