"""All loads on the vertical walls of a silo after EN 1991-4:2006, each by depth and angle, and their envelope.

Each symmetrical load stands twice: with the values of table 3.1 for the largest pressure, and with those for the
largest friction; pressure and friction of one case belong together, and carry the weight with the solid below. A patch
is added to the case of largest pressure; it is pressure only, and takes away no more than is there: a solid does not
pull at a wall (as far as could be confirmed the clauses do not say it). The envelope takes the largest of each over all
cases and angles, and places of a patch that may stand anywhere. The angle is 0 in the middle of a patch or of a flow
channel, on the side of the outlet.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taichi_silo.analysis.theory.eurocode.flow_channel import FlowChannel, channels
from taichi_silo.analysis.theory.eurocode.patch_loads import STATES, PatchLoad, patch_loads, uniform_increase
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo

EXTREMES = {"pressure": "wall pressure", "friction": "wall friction"}  # of table 3.1
Field = Callable[[NDArray, float], NDArray]  # of depths [m] and an angle [deg]


@dataclass(frozen=True)
class LoadCase:
    """One load: pressure, outward positive, and friction, downward on the wall positive."""

    name: str  # such as "filling_pressure"
    clause: str
    normal_Pa: Field
    shear_Pa: Field
    angles_deg: tuple[float, ...] = (0.0,)  # at which it takes its extremes; one if it is symmetrical
    cuts_m: tuple[float, ...] = ()  # depths at which it jumps
    turns_deg: tuple[float, ...] = ()  # angles at which it jumps

    @property
    def symmetrical(self) -> bool:
        """Whether it is the same all round."""
        return len(self.angles_deg) == 1


def load_cases(silo: EurocodeSilo, wall_thickness_m: float | None = None) -> list[LoadCase]:
    """All cases of a silo's vertical walls."""
    found = []
    for state in STATES:
        found += [_symmetrical(silo, state, extreme) for extreme in EXTREMES]
        more = uniform_increase(silo, state, wall_thickness_m)
        if more is not None:
            found += [_symmetrical(silo, state, extreme, more) for extreme in EXTREMES]
        found += [_patch(silo, one) for one in patch_loads(silo, wall_thickness_m) if one.state == state]
    for channel in channels(silo):
        found += [_channel(channel, extreme) for extreme in EXTREMES]
    return found


def _symmetrical(silo: EurocodeSilo, state: str, extreme: str, more: tuple[float, float] | None = None) -> LoadCase:
    """A state of the whole girth; with its uniform increase, if given."""
    h, w = silo.discharge_factors if state == "discharge" else (1.0, 1.0)
    h, w = (h, w) if more is None else (h * more[0], w * more[1])
    load, clause = EXTREMES[extreme], clause_of(silo, state) if more is None else "5.2.3"
    return LoadCase(
        f"{state}_{extreme}{'' if more is None else '_increased'}", clause,
        lambda z, _: h * silo.filling_normal_Pa(z, load), lambda z, _: w * silo.filling_shear_Pa(z, load),
    )  # fmt: skip


def clause_of(silo: EurocodeSilo, state: str) -> str:
    """Where the symmetrical load of a state stands."""
    if silo.slenderness == "retaining":
        return "5.4.1" if state == "filling" else "5.4.2"
    part = 1 if state == "filling" else 2
    return f"5.2.{part}.1" if silo.slenderness == "slender" else f"5.3.{part}.1"


def _patch(silo: EurocodeSilo, patch: PatchLoad) -> LoadCase:
    base = _symmetrical(silo, patch.state, "pressure")
    top, foot = patch.depth_m - 0.5 * patch.height_m, patch.depth_m + 0.5 * patch.height_m
    angles = {"thin-walled": (0.0, 180.0), "thick-walled": (0.0, 90.0), "band": (0.0,)}[patch.kind]
    turns = (11.25, 168.75, 191.25, 348.75) if patch.kind == "thick-walled" else ()

    def normal(z: NDArray, angle_deg: float) -> NDArray:
        inside = (np.asarray(z) >= top) & (np.asarray(z) <= foot)
        return np.maximum(base.normal_Pa(z, angle_deg) + np.where(inside, patch.pressure_at_Pa(angle_deg), 0.0), 0.0)

    name = f"{patch.state}_patch_{patch.kind.replace('-', '_')}"
    return LoadCase(name, patch.clause, normal, base.shear_Pa, angles, (top, foot), turns)


def _channel(channel: FlowChannel, extreme: str) -> LoadCase:
    load, theta = EXTREMES[extreme], channel.contact_deg
    share = "" if channel.radius_share is None else f"_{100.0 * channel.radius_share:.0f}"  # per cent of r
    turns = (theta, 2.0 * theta, 360.0 - 2.0 * theta, 360.0 - theta)
    return LoadCase(
        f"channel{share}_{extreme}", channel.clause,
        lambda z, angle: channel.normal_Pa(z, angle, load), lambda z, angle: channel.shear_Pa(z, angle, load),
        (0.0, 1.5 * theta, 180.0), (), turns,
    )  # fmt: skip


def depth_table(
    silo: EurocodeSilo, rows: int = 20, wall_thickness_m: float | None = None
) -> tuple[dict[str, NDArray], list[LoadCase]]:
    """Columns by name with unit, from the surface to the foot of the vertical walls, and the cases of the envelope.

    `depth_m`, `p_hf_Pa`, `p_wf_Pa`, `p_vf_Pa` (largest load on a bottom), `p_he_Pa`, `p_we_Pa`, `n_f_N_per_m`,
    `n_e_N_per_m` (n_zSk after filling and on discharge), `envelope_normal_Pa`, `envelope_least_normal_Pa`,
    `envelope_shear_Pa`.
    """
    cases = load_cases(silo, wall_thickness_m)
    z = np.linspace(0.0, silo.height_m, rows)
    normal, shear = (
        [field(one)(z, angle) for one in cases for angle in one.angles_deg]
        for field in (lambda one: one.normal_Pa, lambda one: one.shear_Pa)
    )
    for one in patch_loads(silo, wall_thickness_m):
        if one.anywhere:
            base = silo.filling_normal_Pa if one.state == "filling" else silo.discharge_normal_Pa
            lowest = base(np.minimum(z + 0.5 * one.height_m, one.depth_m))  # where a patch that covers z is largest
            normal += [np.maximum(base(z) + share * lowest, 0.0) for share in one.shares]
    columns = {
        "depth_m": z,
        "p_hf_Pa": silo.filling_normal_Pa(z), "p_wf_Pa": silo.filling_shear_Pa(z),
        "p_vf_Pa": silo.filling_vertical_Pa(z),
        "p_he_Pa": silo.discharge_normal_Pa(z), "p_we_Pa": silo.discharge_shear_Pa(z),
        "n_f_N_per_m": silo.filling_wall_force_N_per_m(z), "n_e_N_per_m": silo.discharge_wall_force_N_per_m(z),
        "envelope_normal_Pa": np.max(normal, axis=0), "envelope_least_normal_Pa": np.min(normal, axis=0),
        "envelope_shear_Pa": np.max(shear, axis=0),
    }  # fmt: skip
    return columns, cases
