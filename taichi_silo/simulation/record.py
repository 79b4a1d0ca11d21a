"""What is known of one interval of a run."""

import math
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Record:
    """One interval: forces are means over it, so no impulse is lost between records; state is at its end.

    Names are those of the columns of `forces.csv` and `balance.csv`. Signs: normals positive in compression, shears
    positive where the wall carries weight; per metre run.
    """

    time_s: float
    stage: str  # "filling" or "flow"
    displacement_m: float
    interval_s: float
    bottom_force_N_per_m: float  # P, on floor and gate together
    left_normal_N_per_m: float
    left_shear_N_per_m: float
    right_normal_N_per_m: float
    right_shear_N_per_m: float
    weight_N_per_m: float
    momentum_rate_N_per_m: float  # of the vertical momentum
    noise_control_force_N_per_m: float  # vertical, on the sand
    kinetic_energy_J_per_m: float
    kinetic_gain_J_per_m: float  # in the interval
    work_J_per_m: float  # of weight and moving walls, in the interval
    stored_J_per_m: float  # in the sand's stress, as the present stiffness has it, and in inclined walls
    time_step_s: float
    stable_step_s: float
    void_ratio_low: float
    void_ratio_high: float
    separated: int  # points that carry no stress
    strays: int  # points outside the grid or not finite
    speed_m_per_s: float  # of the fastest point
    profile: np.ndarray | None  # nodal forces of the walls on the sand (walls, slots, 2), see `wall_forces` [N/m]
    discharged_kg_per_m: float = 0.0  # since the start
    bodies_N_per_m: dict = field(default_factory=dict)  # force (x, y) of hopper walls and inserts on the sand
    gates: tuple[float, ...] = ()  # of several outlets: speed of each gate over that of an open one,
    gates_N_per_m: tuple[float, ...] = ()  # force of the sand on each,
    outlets_kg_per_m: tuple[float, ...] = ()  # and what has left by each since the start

    @property
    def bottom_N_per_m(self) -> float:
        """P, by the name that it has in `summary.json`."""
        return self.bottom_force_N_per_m

    @property
    def normal_N_per_m(self) -> float:
        """N: mean of both walls."""
        return 0.5 * (self.left_normal_N_per_m + self.right_normal_N_per_m)

    @property
    def shear_N_per_m(self) -> float:
        """T: mean of both walls."""
        return 0.5 * (self.left_shear_N_per_m + self.right_shear_N_per_m)

    @property
    def forces(self) -> dict[str, float]:
        """P, T, N, and those of hopper walls and inserts by the names of their columns in `forces.csv` [N/m]."""
        bodies = {
            f"{body}_{axis}_N_per_m": part
            for body, force in self.bodies_N_per_m.items()
            for axis, part in zip(("horizontal", "vertical"), force, strict=True)
        }
        return {"P": self.bottom_force_N_per_m, "T": self.shear_N_per_m, "N": self.normal_N_per_m} | bodies

    @property
    def wall_friction_angle_deg(self) -> float:
        """Arctan(T / N)."""
        return math.degrees(math.atan2(self.shear_N_per_m, self.normal_N_per_m))

    @property
    def residual_N_per_m(self) -> float:
        """P + 2 T - W - d(upward momentum)/dt + force of the noise control: zero but for round-off."""
        carried = self.bottom_force_N_per_m + self.left_shear_N_per_m + self.right_shear_N_per_m
        carried += sum(force[1] for force in self.bodies_N_per_m.values())
        return carried - self.weight_N_per_m - self.momentum_rate_N_per_m + self.noise_control_force_N_per_m
