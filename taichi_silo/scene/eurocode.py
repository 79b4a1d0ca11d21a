"""What EN 1991-4 needs to know of a silo beside its shape: the stored solid, the wall, the class."""

from dataclasses import replace
from typing import Literal

from pydantic import Field, field_validator, model_validator

from taichi_silo.analysis.theory.eurocode.bottoms import Bottom
from taichi_silo.analysis.theory.eurocode.solids import Solid, solids
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.messages import near, shown
from taichi_silo.utils.schema import Options

Category = Literal["D1", "D2", "D3", "D4"]
OF_SOLID = tuple(name for name in Solid.__dataclass_fields__ if name != "title")  # that a user may give


class Eurocode(Options):
    """EN 1991-4, computed beside a run: the stored solid of its table E.1, which need not be the simulated sand."""

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
        key = name.strip().lower().replace(" ", "-").replace("_", "-")
        if key not in solids():
            meant = near(key, solids())
            hint = f"; did you mean {meant}?" if meant else f"; it must be one of {', '.join(solids())}"
            raise ValueError(f"eurocode.solid is {shown(name)}{hint}")
        return key

    @model_validator(mode="after")
    def _ordered(self):
        solid = self.stored
        lower, upper = solid.lower_weight_density_N_per_m3, solid.upper_weight_density_N_per_m3
        if not lower <= upper:
            raise ValueError(f"lower_weight_density_N_per_m3 is {lower:g}; it must be at most the upper one, {upper:g}")
        return self

    @property
    def stored(self) -> Solid:
        """The stored solid: that of table E.1 with the values that are given instead."""
        own = {name: value for name in OF_SOLID if (value := getattr(self, name)) is not None}
        known = solids()[self.solid]
        return replace(known, title=f"{known.title}, own values", **own) if own else known

    def check(self, silo: Silo, rough: bool) -> None:
        """Refuse a length, a place or a solid that the silo cannot have."""
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
        self.silo(silo, rough)  # may refuse the solid

    def silo(self, silo: Silo, rough: bool) -> EurocodeSilo | None:
        """The vertical walls of a silo as the code sees them; None if it has none.

        Raises ValueError if the solid is impossible there.
        """
        height = silo.height_m - silo.transition_m
        if not height > 0.0:
            return None
        left, right = silo.outlet_m
        eccentricity = abs(0.5 * (left + right) - 0.5 * silo.width_m)
        return EurocodeSilo(
            silo.width_m, height, wall=self.wall or ("D3" if rough else "D2"), section=silo.section,
            outlet_eccentricity_m=eccentricity if self.outlet_eccentricity_m is None else self.outlet_eccentricity_m,
            solid=self.stored, length_m=self.length_m, filling_eccentricity_m=self.filling_eccentricity_m,
            action_class=self.action_class, wall_contact=self.wall_contact_factor,
            flat_bottom=silo.transition_m == 0.0, from_top=self.from_top,
        )  # fmt: skip

    def bottom(self, silo: Silo, walls: EurocodeSilo) -> Bottom | None:
        """The floor or hopper of a silo below its vertical walls; None below an outline's inclined walls."""
        if silo.hopper is None and silo.transition_m > 0.0:
            return None
        angle = None if silo.hopper is None else silo.hopper.half_angle_deg
        outlet = 0.0 if silo.hopper is None else silo.hopper.outlet_width_m
        return Bottom(walls, angle, outlet, self.hopper_wall or walls.wall, self.dynamic)
