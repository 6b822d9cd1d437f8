"""What the third source conceals, as data: words, literature, machine, right places, sizes and ranges.

Written before the program was asked about any of them. In places `{n}` is the number of the leg or joint that is
drawn, `{next}` the one after it, `{before}` the body before the joint, `{which}` the leg or the base, as drawn.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ..campaigns import Wishes

HEXAPOD, ARM = "hexapod", "arm"
Range = tuple[float, float]


@dataclass(frozen=True)
class Kind:
    """One kind of physics.

    `words`: what it is, `reference`: where its curve or equation is from, `places`: every right answer, `names`:
    identifiers of known physics that are no wrong ones, `size`: what grows (what it is, least, most), `ranges`: what
    else is drawn, uniformly.
    """

    machine: str
    words: str
    reference: str
    places: tuple[str, ...]
    names: tuple[str, ...]
    size: tuple[str, float, float]
    ranges: dict[str, Range] = field(default_factory=dict)
    wishes: Wishes = field(default_factory=Wishes)


_LEG, _JOINT, _BASE = ("leg {n}",), ("joint {n}",), ("base",)
_FOOT = ("base", "leg {n}", "leg {next}")
_SPRING, _SLIP = "leg_nonlinear_stiffness", "friction_hysteresis"

KINDS: dict[str, Kind] = {
    "bearing_pair": Kind(
        HEXAPOD,
        "a pair of preloaded angular contact bearings in a leg, one of which is unloaded beyond 2.83 times the preload",
        "Palmgren 1959; Harris, Kotzalas: Advanced Concepts of Bearing Technology, 2006: F ∝ (a+x)^1.5 − (a−x)^1.5",
        _LEG,
        (_SPRING,),
        ("deflection at the largest force over the leg's stretch", 0.02, 3.0),
        {"unloads_at": (0.15, 0.7)},
        Wishes("wrench", reversing=True, precise=True),
    ),
    "worn_screw": Kind(
        HEXAPOD,
        "a ball screw that has lost its preload: play, then balls in Hertzian contact",
        "Altintas et al.: Machine tool feed drives, CIRP Annals 60, 2011; Hertz 1881: x ∝ F^(2/3)",
        _LEG,
        ("leg_backlash", "joint_backlash", _SPRING),
        ("play over the largest stretch", 0.01, 3.0),
        {"contact": (0.3, 1.0), "rests_at": (0.0, 1.0)},
        Wishes("wrench", reversing=True),
    ),
    "oil_film": Kind(
        HEXAPOD,
        "a hydrostatic pad pair with capillaries in a leg: linear at first, softer near the end of its gap",
        "Rowe: Hydrostatic, Aerostatic and Hybrid Bearing Design, 2012: W = 1/(1+λ(1−ε)³) − 1/(1+λ(1+ε)³)",
        _LEG,
        (_SPRING,),
        ("gap over the leg's stretch", 0.02, 20.0),
        {"pressure_ratio": (0.35, 0.6), "used": (0.6, 0.92)},
        Wishes(precise=True),
    ),
    "presliding": Kind(
        HEXAPOD,
        "guides of a leg that slide before they slip: loops from the first newton on",
        "Dahl 1968; Canudas de Wit et al.: A new model for control of systems with friction, IEEE TAC 40, 1995",
        _LEG,
        (_SLIP,),
        ("friction over the largest force", 0.003, 0.5),
        {"presliding": (0.05, 0.3)},
        Wishes("wrench", "stairs", precise=True),
    ),
    "findley_creep": Kind(
        HEXAPOD,
        "a polymer shim under a leg, or a polymer grout under all, that creeps by a power of time",
        "Findley, Lai, Onaran: Creep and Relaxation of Nonlinear Viscoelastic Materials, 1976: e = m·tⁿ, superposed",
        ("{which}",),
        ("creep", "base_compliance"),
        ("creep after a minute over the leg's stretch", 3e-3, 3.0),
        {"exponent": (0.12, 0.35), "of_all": (0.0, 1.0)},
        Wishes("wrench", "hold", precise=True),
    ),
    "rubber_mounts": Kind(
        HEXAPOD,
        "three rubber mounts under the base that soften with amplitude (Payne) and after their largest load (Mullins)",
        "Kraus 1984 as in Ulmer, Rubber Chem. Technol. 69, 1996; Ogden, Roxburgh, Proc. R. Soc. A 455, 1999",
        _BASE,
        ("base_compliance",),
        ("compliance over that of the legs", 3e-3, 5.0),
        {"softens": (0.3, 0.7), "damage": (0.15, 0.5), "lateral": (0.3, 0.6)},
        Wishes("wrench", "stairs", reversing=True),
    ),
    "opening_foot": Kind(
        HEXAPOD,
        "a flanged foot of two legs with preloaded bolts that opens on one side under tilting and pull",
        "VDI 2230-1, 2015, section 5.3: eccentrically loaded joints that open; contact only pushes",
        _FOOT,
        ("base_compliance", _SPRING, "leg_backlash", "leg_coupling", "joint_backlash"),
        ("compliance of the closed joint over that of a leg", 5e-3, 3.0),
        {"preload": (0.15, 0.6), "radius": (0.12, 0.3), "height": (0.15, 0.4)},
        Wishes("wrench", reversing=True, series=16),
    ),
    "plate_platform": Kind(
        HEXAPOD,
        "a platform that is a thin plate, held by its hub, bent by the legs",
        "Kirchhoff's plate by finite elements (Argyris)",
        ("platform",),
        ("platform_compliance",),
        ("w of a leg's joint under its force over the leg's stretch", 3e-3, 10.0),
        {"hub": (0.15, 0.3), "overhang": (1.05, 1.25)},
        Wishes(precise=True),
    ),
    "plate_base": Kind(
        HEXAPOD,
        "a machine on a thin bed plate that is bolted down at three points between the feet",
        "Kirchhoff's plate by finite elements (Argyris)",
        _BASE,
        ("base_compliance", "leg_coupling"),
        ("w of a foot under its force over the leg's stretch", 3e-3, 10.0),
        {"overhang": (1.1, 1.4), "turned": (0.35, 0.65), "height": (0.05, 0.2)},
    ),
    "warm_wall": Kind(
        HEXAPOD,
        "a wall that carries the base and bends as the room's warmth enters one of its faces",
        "Boley, Weiner: Theory of Thermal Stresses, 1960, ch. 9: κ = 12/h³ ∫ αT y dy; conduction by finite elements",
        ("base", "environment"),
        ("thermal_drift",),
        ("strain per kelvin at the warm face", 1e-8, 3e-4),
        {"diffusion_s": (600.0, 4000.0), "direction": (0.0, 6.283)},
        Wishes(path="hold", temperature=True),
    ),
    "bellows": Kind(
        HEXAPOD,
        "a vacuum bellows between base and platform, a spring in all six directions",
        "EJMA Standards, 10th ed.: axial, angular (K·D²/8) and lateral (3K·D²/2L²) stiffness",
        ("environment", "platform", "payload"),
        ("passive_joint_stiffness",),
        ("axial stiffness over that of the legs together", 3e-3, 0.6),
        {"diameter": (0.5, 0.9), "aside": (0.0, 0.3)},
        Wishes("wrench", precise=True),
    ),
    "crossed_gauge": Kind(
        HEXAPOD,
        "a gauge that reads a share of the motion across it",
        "makers' sheets of inductive gauges: cross-sensitivity",
        ("instrument",),
        (),
        ("share", 0.003, 0.4),
        {"from": (0.0, 1.0), "to": (0.0, 1.0)},
        Wishes(precise=True),
    ),
    "lagging_gauge": Kind(
        HEXAPOD,
        "a gauge whose zero follows its own temperature, which lags behind the room by a first order",
        "makers' sheets of inductive gauges: zero shift with temperature; Newton's law of cooling",
        ("instrument", "environment"),
        ("thermal_drift",),
        ("standard deviations per kelvin", 0.05, 120.0),
        {"lag_s": (200.0, 1500.0), "axis": (0.0, 1.0)},
        Wishes(path="hold", temperature=True),
    ),
    "crossed_cell": Kind(
        HEXAPOD,
        "a six-axis load cell in which a force shows as another force or as a moment",
        "VDI/VDE 2638; Bicchi, A criterion for optimal design of multi-axis force sensors, Rob. Auton. Syst. 10, 1992",
        ("payload", "environment"),
        ("payload_com_offset",),
        ("share of the largest", 0.003, 0.4),
        {"from": (0.0, 1.0), "to": (0.0, 1.0)},
        Wishes("wrench", precise=True),
    ),
    "strain_wave": Kind(
        ARM,
        "a strain-wave gear: three stiffnesses, and a loop of friction",
        "Harmonic Drive CSG catalogue: K1, K2, K3 at T1, T2; Taghirad, Bélanger, ASME J. Dyn. Syst. 120, 1998",
        _JOINT,
        (_SPRING, _SLIP, "joint_backlash"),
        ("windup over that of the joint's drawn stiffness", 0.02, 3.0),
        {"knee": (0.15, 0.35), "second": (1.3, 1.7), "friction": (0.02, 0.08)},
        Wishes("wrench", "stairs", reversing=True, series=16, precise=True),
    ),
    "gear_mesh": Kind(
        ARM,
        "a gear whose mesh changes between one and two pairs of teeth as its joint turns",
        "ISO 6336-1; Cai, Hayashi, ASME J. Mech. Des. 116, 1994: stiffness over a tooth period",
        _JOINT,
        ("joint_compliance",),
        ("compliance of the mesh over the joint's", 0.02, 3.0),
        {"teeth": (9.0, 20.0), "ratio": (1.3, 1.7), "phase": (0.0, 1.0)},
        Wishes(series=30, precise=True),
    ),
    "turning_bearing": Kind(
        ARM,
        "a crossed-roller ring whose tilting compliance turns with its joint: its seat is oval",
        "THK and INA catalogues of crossed-roller rings: moment rigidity; two waves per turn of an oval seat",
        ("joint {n}", "link {n}", "{before}"),
        ("joint_compliance", "link_compliance", "base_compliance"),
        ("tilting compliance over the joint's", 0.01, 6.0),
        {"share": (0.5, 0.9), "phase": (0.0, 3.1416)},
        Wishes(series=18),
    ),
    "solid_link": Kind(
        ARM,
        "a tapering link that bends, shears and twists",
        "linear elasticity by finite elements (quadratic hexahedra), ends rigid",
        ("link {n}",),
        ("link_compliance", "joint_compliance"),
        ("bending compliance over the joint's", 0.01, 3.0),
        {"width": (0.15, 0.3), "depth": (0.15, 0.3), "taper": (0.5, 0.9)},
        Wishes(series=16, precise=True),
    ),
    "pedestal": Kind(
        ARM,
        "a squat pedestal under the arm, held at its foot",
        "linear elasticity by finite elements (quadratic hexahedra), top rigid",
        _BASE,
        ("base_compliance",),
        ("tilting compliance over the first joint's", 0.01, 6.0),
        {"height": (0.4, 0.9), "width": (0.2, 0.4), "depth": (0.2, 0.4), "taper": (0.6, 1.0)},
        Wishes(series=16),
    ),
    "eccentric_encoder": Kind(
        ARM,
        "an encoder's disc that sits off the axis of its joint",
        "Heidenhain, Encoders for Servo Drives: error e/r·sin(q + φ) once per turn",
        _JOINT,
        ("encoder_periodic_error",),  # the program's word for it, learned from its first answers
        ("amplitude in rad", 1e-6, 5e-3),
        {"phase": (0.0, 6.283)},
        Wishes("payload", series=20),
    ),
    "approach_band": Kind(
        ARM,
        "a joint that stops short: where it comes to rest depends on the direction from which it came",
        "ISO 230-2, 2014: reversal value B; half of it to either side",
        _JOINT,
        ("joint_backlash", _SLIP),
        ("reversal value in rad", 1e-6, 1e-2),
        {},
        Wishes("payload", series=24),
    ),
    "umbilical": Kind(
        ARM,
        "a cable that hangs between a stand beside the arm and its flange",
        "Irvine: Cable Structures, 1981: the catenary",
        ("environment", "payload", "platform"),
        ("payload_mass_error",),
        ("weight in N per m", 0.05, 60.0),
        {"slack": (1.1, 1.5), "direction": (-1.2, 1.2), "height": (0.6, 1.4)},
        Wishes("payload", series=20),
    ),
    "counterbalance": Kind(
        ARM,
        "a gas spring that carries a part of the upper arm's weight and is in no drawing",
        "makers' sheets of gas springs: progression F = F₀/(1 − s/s₀)",
        ("joint 2", "link 2", "environment"),
        ("passive_joint_stiffness",),
        ("force in N", 1.0, 2e4),
        {"arm": (0.12, 0.25), "lean": (-0.6, 0.6), "gas": (1.5, 3.0)},
        Wishes("payload", series=20),
    ),
    "warm_link": Kind(
        ARM,
        "a link that grows and bows as the room's warmth enters one of its sides",
        "Boley, Weiner: Theory of Thermal Stresses, 1960, ch. 9; conduction by finite elements",
        ("link {n}", "joint {n}", "environment"),
        ("thermal_drift",),
        ("strain per kelvin at the warm side", 1e-8, 1e-3),
        {"diffusion_s": (600.0, 4000.0), "side": (0.0, 6.283), "slenderness": (4.0, 9.0)},
        Wishes("payload", temperature=True, series=20),
    ),
}
