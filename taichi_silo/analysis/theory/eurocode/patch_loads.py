"""Loads for lack of symmetry after EN 1991-4:2006: patch loads, or the uniform increase that may stand for them.

With E = 2 e / d_c, e = e_f after filling and the larger of e_f and e_o on discharge, p_p = C_p p_h on a height
s = pi d_c / 16 (5.2.1.2, 5.2.2.2):

    filling:                      C_pf = 0.21 C_op (1 + 2 E^2) (1 - exp(-1.5 (h_c/d_c - 1)))       (5.9)
    discharge, h_c/d_c > 1.2:     C_pe = 0.42 C_op (1 + 2 E^2) (1 - exp(-1.5 (h_c/d_c - 1)))       (5.28)
               h_c/d_c <= 1.2:    C_pe = 0.272 C_op (h_c/d_c - 1 + E)                              (5.29)

never below 0; none in class 1 and in retaining silos. C_pe jumps by a factor of two at h_c/d_c = 1.2 with E = 0: 0.272
continues 0.21, not 0.42; so the two sources of these numbers have it. What the patch is:

    thin-walled round (d_c/t > 200; 5.2.1.4, 5.2.2.4):  p_p cos(theta) round the girth, in all F = (pi/2) s d_c p_p
    thick-walled round (5.2.1.3, 5.2.2.3):              p_p outward on two opposite squares s by s, s^2 p_p each, and
                                                        p_p / 7 inward on the rest of the girth: in all 0
    rectangular (5.2.1.5, 5.2.2.5):                     0.36 p_p on all sides, a band

Place: in class 2 a thin-walled silo's at z_p = min(z0, h_c/2), the others' at half the height; in class 3 anywhere, the
largest at the foot. Instead, class 2 may use (5.2.3), for both filling and discharge,

    round:        p_h (1 + zeta C_p),   p_w (1 + C_p),   zeta = 0.5 + 0.01 d_c/t, at least 1
    rectangular:  p_h (1 + 0.36 C_p),   p_w (1 + 0.36 C_p)

Not confirmed against the print: places, 5.2.1.3, zeta.
"""

from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo

THIN = 200.0  # d_c / t above which a round silo is thin-walled
BAND = 0.36  # of p_p, in rectangular silos
OUTWARD = 7.0  # over the inward pressure of a thick-walled silo
LOW = 1.2  # h_c/d_c up to which (5.29) holds
SQUARE_DEG = 22.5  # that s = pi d_c / 16 takes of the girth
STATES = ("filling", "discharge")


@dataclass(frozen=True)
class PatchLoad:
    """A patch load at one depth."""

    state: str  # "filling" or "discharge"
    kind: str  # "thin-walled", "thick-walled" or "band"
    clause: str
    factor: float  # C_p [-]
    depth_m: float  # of its middle
    height_m: float  # s
    pressure_Pa: float  # p_p; of a band 0.36 p_p; outward
    inward_Pa: float  # on the rest of the girth
    force_N: float  # F of a thin-walled silo, of one square of a thick-walled one; of a band per metre of girth
    anywhere: bool  # whether it may stand at any depth; this one is where it is largest

    @property
    def shares(self) -> tuple[float, float]:
        """Largest and least pressure over p_h."""
        if self.kind == "band":
            return BAND * self.factor, 0.0
        return self.factor, -self.factor / (1.0 if self.kind == "thin-walled" else OUTWARD)

    def pressure_at_Pa(self, angle_deg: float) -> float:
        """Pressure at an angle from its middle [Pa], outward positive."""
        if self.kind == "band":
            return self.pressure_Pa
        if self.kind == "thin-walled":
            return float(self.pressure_Pa * np.cos(np.radians(angle_deg)))
        off = abs((angle_deg + 90.0) % 180.0 - 90.0)
        return self.pressure_Pa if off <= 0.5 * SQUARE_DEG else -self.inward_Pa


def filling_factor(silo: EurocodeSilo) -> float:
    """C_pf [-]."""
    return max(0.0, 0.21 * _growth(silo, silo.filling_eccentricity_m)) if _counts(silo) else 0.0


def discharge_factor(silo: EurocodeSilo) -> float:
    """C_pe [-]."""
    off = max(silo.filling_eccentricity_m, silo.outlet_eccentricity_m)
    ratio = silo.height_m / silo.width_m
    if not _counts(silo):
        return 0.0
    if ratio > LOW:
        return max(0.0, 0.42 * _growth(silo, off))
    return max(0.0, 0.272 * silo.solid.patch_factor * (ratio - 1.0 + 2.0 * off / silo.width_m))


def _counts(silo: EurocodeSilo) -> bool:
    return silo.action_class > 1 and silo.slenderness != "retaining"


def _growth(silo: EurocodeSilo, off_m: float) -> float:
    """C_op (1 + 2 E^2) (1 - exp(-1.5 (h_c/d_c - 1)))."""
    e = 2.0 * off_m / silo.width_m
    return silo.solid.patch_factor * (1.0 + 2.0 * e**2) * -float(np.expm1(-1.5 * (silo.height_m / silo.width_m - 1.0)))


def kinds(silo: EurocodeSilo, wall_thickness_m: float | None) -> tuple[str, ...]:
    """Kinds of patch of a silo; both of a round one whose walls have no known thickness."""
    if silo.section == "plane":
        return ("band",)
    if wall_thickness_m is None:
        return "thin-walled", "thick-walled"
    return ("thin-walled",) if silo.width_m / wall_thickness_m > THIN else ("thick-walled",)


CLAUSES = {"thin-walled": 4, "thick-walled": 3, "band": 5}  # of 5.2.1 and 5.2.2


def patch_load(silo: EurocodeSilo, state: str, kind: str) -> PatchLoad | None:
    """The patch load of a kind after filling or on discharge; None if there is none."""
    factor = filling_factor(silo) if state == "filling" else discharge_factor(silo)
    if not factor > 0.0:
        return None
    s = np.pi * silo.width_m / 16.0
    anywhere = silo.action_class == 3
    depth = 0.5 * silo.height_m
    if anywhere:
        depth = silo.height_m - 0.5 * s
    elif kind == "thin-walled":
        depth = min(silo.depth_scale_m(), depth)
    normal = silo.filling_normal_Pa if state == "filling" else silo.discharge_normal_Pa
    pressure = float(factor * normal(depth)) * (BAND if kind == "band" else 1.0)
    force = {"thin-walled": 0.5 * np.pi * s * silo.width_m, "thick-walled": s**2, "band": s}[kind] * pressure
    inward = pressure / OUTWARD if kind == "thick-walled" else 0.0
    clause = f"5.2.{1 if state == 'filling' else 2}.{CLAUSES[kind]}"
    return PatchLoad(state, kind, clause, factor, depth, float(s), pressure, inward, float(force), anywhere)


def patch_loads(silo: EurocodeSilo, wall_thickness_m: float | None) -> list[PatchLoad]:
    """All patch loads of a silo, after filling and on discharge."""
    found = [patch_load(silo, state, kind) for state in STATES for kind in kinds(silo, wall_thickness_m)]
    return [one for one in found if one is not None]


def uniform_increase(silo: EurocodeSilo, state: str, wall_thickness_m: float | None) -> tuple[float, float] | None:
    """Factors of p_h and p_w that may stand for the patch load in class 2.

    None in other classes, without a patch load, and of a round silo whose walls have no known thickness.
    """
    factor = filling_factor(silo) if state == "filling" else discharge_factor(silo)
    if silo.action_class != 2 or not factor > 0.0:
        return None
    if silo.section == "plane":
        return 1.0 + BAND * factor, 1.0 + BAND * factor
    if wall_thickness_m is None:
        return None
    zeta = max(1.0, 0.5 + 0.01 * silo.width_m / wall_thickness_m)
    return 1.0 + zeta * factor, 1.0 + factor
