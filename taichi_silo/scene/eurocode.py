"""What EN 1991-4 needs to know of a silo beside its shape: the stored solid, the wall, the class."""

import math
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from taichi_silo.scene.published_solids import NOTES, key_of, published
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options

Category = Literal["D1", "D2", "D3", "D4"]


class Eurocode(Options):
    """EN 1991-4, computed beside a run: the stored solid of its table E.1, which need not be the simulated sand."""

    WITH_TABLE: ClassVar[bool] = True  # `wall` and `solid` alone could be anything

    solid: str = Field("sand", max_length=100, description="a solid of table E.1, `taichi-silo eurocode --solids`")
    wall: Category | None = Field(
        None, description="category of the vertical walls: polished, smooth, rough, corrugated; if absent D3 where "
        "walls are very rough, else D2",
    )  # fmt: skip
    hopper_wall: Category | None = Field(None, description="of the hopper's walls; that of the vertical ones if absent")
    wall_contact_factor: float = Field(
        0.2, ge=0, le=1, description="a_w of a wall D4: the share on which the solid slides on the sheet (annex D.2)"
    )
    action_class: int = Field(2, ge=1, le=3, description="action assessment class (2.5)")
    length_m: float | None = Field(
        None, ge=0.001, le=1000, description="longer side of a rectangular silo; two parallel walls if absent"
    )
    wall_thickness_m: float | None = Field(
        None, ge=1e-5, le=10, description="of a round silo: tells thin from thick walls, and is needed by 5.2.3"
    )
    filling_eccentricity_m: float = Field(0.0, ge=0, le=1000, description="e_f, of the top of the heap from the axis")
    outlet_eccentricity_m: float | None = Field(
        None, ge=0, le=1000, description="e_o, of the outlet's middle from the axis; as in the silo if absent"
    )
    dynamic: bool = Field(False, description="the solid tends to dynamic behaviour, which raises the load on a bottom")
    from_top: bool = Field(False, description="the silo is unloaded from the top, without flow inside")
    lower_weight_density_N_per_m3: float | None = Field(
        None, ge=100, le=2e5, description="own gamma_l; this and what follows is the solid's if absent"
    )
    upper_weight_density_N_per_m3: float | None = Field(None, ge=100, le=2e5, description="own gamma_u")
    angle_of_repose_deg: float | None = Field(None, ge=1, le=70, description="own phi_r")
    internal_friction_angle_deg: float | None = Field(None, ge=5, le=60, description="own mean phi_i")
    internal_friction_factor: float | None = Field(None, ge=1, le=1.4, description="own a_phi")
    pressure_ratio: float | None = Field(None, ge=0.05, le=0.9, description="own mean K")
    pressure_ratio_factor: float | None = Field(None, ge=1, le=2, description="own a_K")
    wall_friction_D1: float | None = Field(None, ge=0.01, le=1.5, description="own mean mu of a polished wall")
    wall_friction_D2: float | None = Field(None, ge=0.01, le=1.5, description="own mean mu of a smooth wall")
    wall_friction_D3: float | None = Field(None, ge=0.01, le=1.5, description="own mean mu of a rough wall")
    wall_friction_factor: float | None = Field(None, ge=1, le=2, description="own a_mu")
    patch_factor: float | None = Field(None, ge=0, le=2, description="own C_op, of patch loads")

    @field_validator("solid")
    @classmethod
    def _known(cls, name: str) -> str:
        key = key_of(name)
        if key not in published():
            meant = near(key, published())
            hint = (
                f"; did you mean {meant}? All: taichi-silo eurocode --solids"
                if meant
                else f"; it must be one of {', '.join(published())}"
            )
            raise ValueError(f"eurocode.solid is {shown(name)}{hint}")
        return key

    @model_validator(mode="after")
    def _possible(self):
        solid = self.stored
        lower, upper = (solid[f"{end}_weight_density_N_per_m3"] for end in ("lower", "upper"))
        if not lower <= upper:
            raise ValueError(
                f"eurocode.lower_weight_density_N_per_m3 is {lower:g}; it must be at most the upper one, {upper:g}"
            )
        inside = math.tan(math.radians(solid["internal_friction_angle_deg"] / solid["internal_friction_factor"]))
        ratio = solid["pressure_ratio"] * solid["pressure_ratio_factor"]
        if (
            not ratio * inside * math.tan(math.radians(solid["angle_of_repose_deg"])) < 1.0
        ):  # else h0 may reach z0 (5.3)
            raise ValueError(
                f"eurocode.pressure_ratio is {solid['pressure_ratio']:g}; with its factor, internal friction and "
                f"angle of repose K tan(phi_i) tan(phi_r) must be below 1, and is {ratio * inside:.3g} times tan(phi_r)"
            )
        return self

    @property
    def stored(self) -> dict[str, Any]:
        """Title and values of the stored solid: those of table E.1, and those that are given instead."""
        known = {name: value for name, value in published()[self.solid].items() if name != "read_in"}
        own = {name: getattr(self, name) for name in known if name not in NOTES and getattr(self, name) is not None}
        return known | own | ({"title": f"{known['title']}, own values"} if own else {})

    def check(self, silo: Silo) -> None:
        """Refuse a length or a place that the silo cannot have."""
        wide = silo.width_m
        if self.length_m is not None and (silo.section == "round" or self.length_m < wide):
            rule = "a round silo has none" if silo.section == "round" else f"it must be at least the width of {wide} m"
            raise ValueError(f"eurocode.length_m is {self.length_m}; {rule}")
        if self.wall_thickness_m is not None and self.wall_thickness_m >= 0.5 * wide:
            raise ValueError(f"eurocode.wall_thickness_m is {self.wall_thickness_m}; it must be below {0.5 * wide:g}")
        for name in ("filling_eccentricity_m", "outlet_eccentricity_m"):
            value = getattr(self, name)
            if value is not None and value > 0.5 * wide:
                raise ValueError(f"eurocode.{name} is {value}; it must be at most half the width, {0.5 * wide:g} m")
