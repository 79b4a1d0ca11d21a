"""Pressures on the bottom of a silo after EN 1991-4:2006, section 6: floors, and hoppers, which are Walker's.

The vertical pressure at the transition is p_vft = C_b p_vf (6.2), with p_vf for the largest load on a bottom. C_b is 1
in action assessment classes 2 and 3 and 1.3 in class 1, where means are used; 1.2 and 1.6 of a solid that tends to
dynamic behaviour (6.1.2). By the inclination of the bottom (6.1.1) it is

    flat:     within 5 degrees of the horizontal
    steep:    tan(beta) < (1 - K) / (2 mu_h) (6.1), beta the half angle of the hopper
    shallow:  every other, with mu_heff = (1 - K) / (2 tan(beta)) (6.26), and on discharge as after filling (6.4.3)

K and mu_h are lower characteristic values in both: they maximise the normal pressure on a hopper, which 6.1.1 and 6.4
are about, and only the same pair in both makes mu_heff go over into mu_h at the limit. The hopper's formulas are those
of `walker`: filling with the lower mu_h, discharge with the lower mu_h and the upper phi_i (table 3.1).

A floor carries p_vft in a slender silo (6.2.1); in a squat or intermediate one (6.2.2), over its middle,

    p_vsq = p_vft + (gamma h_tp - p_vf(h0)) (2 - h_c/d_c) / (2 - h_tp/d_c),   h_tp = d_c tan(phi_r) / 2

where h_tp is the height of the heap on the fill; so it goes over into p_vft at h_c/d_c = 2. Not confirmed against the
print: C_b of dynamic solids, 6.2.2; and that the fill's weight plus the heap's rests on a retaining silo's floor.
"""

import math
from dataclasses import dataclass

import numpy as np

from taichi_silo.analysis.theory.eurocode.vertical_walls import SLENDER, EurocodeSilo
from taichi_silo.analysis.theory.walker import WalkerHopper

FLAT_DEG = 85.0  # half angle from which a hopper is a flat bottom


@dataclass(frozen=True)
class Bottom:
    """Floor, wedge or cone below the vertical walls of a silo."""

    silo: EurocodeSilo
    half_angle_deg: float | None = None  # beta; None: a floor
    outlet_m: float = 0.0  # width or diameter of the hopper's outlet
    wall: str = "D2"  # category of the hopper's wall
    dynamic: bool = False  # the solid tends to dynamic behaviour

    @property
    def kind(self) -> str:
        """By 6.1.1: "flat", "steep" or "shallow"."""
        if self.half_angle_deg is None or self.half_angle_deg >= FLAT_DEG:
            return "flat"
        steep = 2.0 * self._friction * math.tan(math.radians(self.half_angle_deg)) < 1.0 - self._ratio
        return "steep" if steep else "shallow"

    @property
    def _friction(self) -> float:
        """Lower mu_h of the hopper's wall."""
        silo = self.silo
        return silo.solid.characteristic(
            "hopper filling", self.wall, silo.action_class, silo.wall_contact
        ).wall_friction

    @property
    def _ratio(self) -> float:
        """Lower K."""
        return self.silo.values("hopper filling").pressure_ratio

    @property
    def load_factor(self) -> float:
        """C_b [-]."""
        if self.silo.action_class == 1:
            return 1.6 if self.dynamic else 1.3
        return 1.2 if self.dynamic else 1.0

    @property
    def transition_Pa(self) -> float:
        """Vertical pressure p_vft at the foot of the vertical walls [Pa]."""
        return self.load_factor * float(self.silo.filling_vertical_Pa(self.silo.height_m))

    @property
    def heap_m(self) -> float:
        """Height h_tp of the heap [m]."""
        return 0.5 * self.silo.width_m * math.tan(math.radians(self.silo.solid.angle_of_repose_deg))

    @property
    def floor_Pa(self) -> float:
        """Largest vertical pressure on a floor [Pa]."""
        silo, ratio = self.silo, self.silo.height_m / self.silo.width_m
        if ratio >= SLENDER:
            return self.transition_Pa
        weight, top = silo.solid.upper_weight_density_N_per_m3, self.heap_m / silo.width_m
        more = weight * self.heap_m - float(silo.filling_vertical_Pa(min(silo.surface_depth_m, silo.height_m)))
        return self.transition_Pa + max(more, 0.0) * (SLENDER - ratio) / (SLENDER - top)

    def hopper(self, state: str) -> WalkerHopper | None:
        """The hopper after "filling" or on "discharge"; None of a floor.

        Raises ValueError if no passive state belongs to so wide a steep hopper.
        """
        if self.kind == "flat" or self.half_angle_deg is None:
            return None
        silo, angle = self.silo, math.degrees(math.atan(self._friction))
        return WalkerHopper(
            silo.width_m, max(self.outlet_m, 1e-6 * silo.width_m), self.half_angle_deg,
            silo.solid.upper_weight_density_N_per_m3, angle, self.transition_Pa, state=state, section=silo.section,
            internal_friction_angle_deg=silo.values("hopper discharge").internal_friction_angle_deg,
            pressure_ratio=self._ratio,
        )  # fmt: skip

    def hopper_rows(self, rows: int = 10) -> list[dict[str, float]]:
        """Pressures on a hopper's wall from the transition down to the outlet; empty of a floor.

        Keys: `depth_m`, `above_outlet_m`, and of `filling` and `discharge` `_normal_Pa`, `_friction_Pa` and
        `_vertical_Pa`. Of a pyramid nothing: a rectangular silo has the wedge's.
        """
        found: dict[str, np.ndarray] = {}
        for state in ("filling", "discharge"):
            one = self.hopper(state)
            if one is None:
                return []
            x = np.linspace(one.transition_height_m, one.outlet_height_m, rows + 1)
            found["depth_m"] = self.silo.height_m + one.transition_height_m - x
            found["above_outlet_m"] = x - one.outlet_height_m
            found[f"{state}_normal_Pa"] = one.normal_stress_Pa(x)
            found[f"{state}_friction_Pa"] = one.shear_stress_Pa(x)
            found[f"{state}_vertical_Pa"] = one.vertical_stress_Pa(x)
        return [{name: float(values[k]) for name, values in found.items()} for k in range(rows + 1)]
