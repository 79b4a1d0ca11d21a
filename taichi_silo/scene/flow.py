"""How a user lets the sand out; speed and displacement that are not given follow from the size of the silo."""

import math
from typing import Literal

from pydantic import Field

from taichi_silo.scene import fill_shape
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.schema import Options

MODEL_WIDTH_M = 0.2  # of the paper's model silo, whose speed and displacement are the defaults
MODEL_SPEED_M_PER_S = 0.002
FROUDE = 0.00143  # speed over the root of g b: in a silo b wide it is as quasi-static as in the model silo
OF_WIDTH = 0.1  # displacement over the width, as in the model silo,
OF_FILL = 0.1  # and the greatest share of the sand that it lets out, in a silo that is wider than high
FASTEST_M_PER_S = 1.0
FALLS = 10.0  # times of the fall of a column, root of H / g, after which it surely rests
CHOSEN = ("speed_m_per_s", "displacement_m")  # where they are not given


def slow_speed_m_per_s(width_m: float, gravity_m_per_s2: float) -> float:
    """Speed of the bottom, to two digits, from where on a lower one changes nothing; of the model silo 0.002 m/s."""
    if math.isclose(width_m, MODEL_WIDTH_M, rel_tol=1e-9):
        return MODEL_SPEED_M_PER_S
    return min(float(f"{FROUDE * math.sqrt(gravity_m_per_s2 * width_m):.2g}"), FASTEST_M_PER_S)


class Flow(Options):
    """The bottom, or a gate in the outlet, sinks at a speed; or the sand falls out, or spreads, by its weight."""

    outflow: Literal["controlled", "gravity", "collapse"] = Field(
        "controlled",
        description="the bottom or gate sinks at a given speed, or the sand falls out by its weight, or the walls of a "
        "column are taken away at once and it spreads",
    )
    speed_m_per_s: float = Field(
        MODEL_SPEED_M_PER_S, ge=1e-9, le=FASTEST_M_PER_S,
        description="speed of the bottom or gate, without meaning for gravity and collapse; where a scene lacks it and "
        "the silo is not 0.2 m wide, 0.00143 times the root of gravity and width",
    )  # fmt: skip
    displacement_m: float = Field(
        0.02, ge=1e-9, le=1000,
        description="how far the bottom or gate sinks; for gravity that of a gate which lets out as much; for collapse "
        "how far a front may run, and if absent as far as there is free width; where a scene lacks it and the silo is "
        "not 0.2 m wide, a tenth of the width, or what lets out a tenth of the sand",
    )  # fmt: skip
    longest_s: float = Field(
        10.0, ge=1e-6, le=1e6,
        description="time of free outflow after which a run ends; of a collapse too, if absent 10 times the root of "
        "height over gravity",
    )  # fmt: skip

    @property
    def free(self) -> bool:
        """Whether the sand moves by its weight alone."""
        return self.outflow != "controlled"

    @property
    def turns_back(self) -> bool:
        """Whether sand is strained to and fro, as behind a free outflow, so that its law needs a memory."""
        return self.free

    @property
    def chosen(self) -> tuple[str, ...]:
        """Which of speed and displacement were not given."""
        return tuple(name for name in CHOSEN if name not in self.model_fields_set)

    def fitted(self, silo: Silo, gravity_m_per_s2: float) -> "Flow":
        """The outflow, with speed and displacement that follow from the silo where they are not given."""
        wide = silo.width_m
        if self.outflow == "collapse":
            return self._collapsing(silo, gravity_m_per_s2)
        if not self.chosen or math.isclose(wide, MODEL_WIDTH_M, rel_tol=1e-9):
            return self
        emptied = silo.area_m2 / silo.outlet_share_m
        depth = float(f"{min(OF_WIDTH * wide, OF_FILL * emptied):.6g}")
        values = {"speed_m_per_s": slow_speed_m_per_s(wide, gravity_m_per_s2), "displacement_m": depth}
        chosen = self.chosen
        found = self.model_copy(update={name: values[name] for name in chosen})
        found.__pydantic_fields_set__.difference_update(chosen)
        return found

    def _collapsing(self, silo: Silo, gravity_m_per_s2: float) -> "Flow":
        """The same for a column: as far as there is free width, for some times of its fall."""
        left, right = fill_shape.sides_m(silo)
        fall = math.sqrt(silo.height_m / gravity_m_per_s2)
        values = {"displacement_m": max(left, silo.width_m - right), "longest_s": float(f"{FALLS * fall:.3g}")}
        given = self.model_fields_set
        found = self.model_copy(update={name: one for name, one in values.items() if name not in given})
        found.__pydantic_fields_set__.difference_update(values.keys() - given)
        return found
