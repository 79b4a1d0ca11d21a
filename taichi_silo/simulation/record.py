"""What is known of one interval of a run."""

import math
from dataclasses import dataclass, field, fields

import numpy as np


@dataclass(frozen=True)
class Record:
    """One interval: forces are means over it, so no impulse is lost between records; state is at its end.

    Signs: normals positive in compression, shears positive where the wall carries weight; per metre run.
    """

    time_s: float
    stage: str  # "filling" or "flow"
    displacement_m: float
    interval_s: float
    bottom_N_per_m: float
    left_normal_N_per_m: float
    left_shear_N_per_m: float
    right_normal_N_per_m: float
    right_shear_N_per_m: float
    weight_N_per_m: float
    momentum_rate_N_per_m: float  # of the vertical momentum
    control_N_per_m: float  # vertical force of the noise control on the sand
    kinetic_energy_J_per_m: float
    kinetic_gain_J_per_m: float  # in the interval
    work_J_per_m: float  # of weight and moving walls, in the interval
    stored_J_per_m: float  # in the sand's stress, as the present stiffness has it
    time_step_s: float
    stable_step_s: float
    void_ratio_low: float
    void_ratio_high: float
    separated: int  # points that carry no stress
    strays: int
    speed_m_per_s: float
    profile: np.ndarray | None  # (left, right, bottom, bodies; slots; 2): force on the sand at each node [N/m]
    discharged_kg_per_m: float = 0.0  # since the start
    bodies_N_per_m: dict = field(default_factory=dict)  # force (x, y) of hopper walls and inserts on the sand

    @property
    def normal_N_per_m(self) -> float:
        """N: mean of both walls."""
        return 0.5 * (self.left_normal_N_per_m + self.right_normal_N_per_m)

    @property
    def shear_N_per_m(self) -> float:
        """T: mean of both walls."""
        return 0.5 * (self.left_shear_N_per_m + self.right_shear_N_per_m)

    @property
    def wall_friction_angle_deg(self) -> float:
        """Arctan(T / N)."""
        return math.degrees(math.atan2(self.shear_N_per_m, self.normal_N_per_m))

    @property
    def residual_N_per_m(self) -> float:
        """P + 2 T - W - d(upward momentum)/dt + control force: zero but for round-off."""
        carried = self.bottom_N_per_m + self.left_shear_N_per_m + self.right_shear_N_per_m
        carried += sum(force[1] for force in self.bodies_N_per_m.values())
        return carried - self.weight_N_per_m - self.momentum_rate_N_per_m + self.control_N_per_m


NUMBERS = tuple(one.name for one in fields(Record) if one.name not in ("profile", "bodies_N_per_m"))


def packed(records: list[Record]) -> dict:
    """Records as arrays, one a field; profiles are left out where there are none."""
    kept = {name: np.array([getattr(r, name) for r in records]) for name in NUMBERS}
    bodies = records[0].bodies_N_per_m if records else {}
    kept["bodies"] = {name: np.array([r.bodies_N_per_m[name] for r in records]) for name in bodies}
    if records and records[0].profile is not None:
        kept["profile"] = np.stack([r.profile for r in records])
    return kept


def unpacked(kept: dict) -> list[Record]:
    """The records that `packed` took."""
    columns = {name: kept[name].tolist() for name in NUMBERS}
    bodies = {name: forces.tolist() for name, forces in kept["bodies"].items()}
    count = len(columns["time_s"])
    profiles = kept.get("profile", [None] * count)
    return [
        Record(
            **{name: column[k] for name, column in columns.items()},
            profile=profiles[k],
            bodies_N_per_m={name: forces[k] for name, forces in bodies.items()},
        )  # fmt: skip
        for k in range(count)
    ]
