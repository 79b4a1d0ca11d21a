"""The sand that a user gives."""

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, ValidationError, field_validator, model_validator

from taichi_silo.mpm import own_parts
from taichi_silo.mpm.contracts import Law
from taichi_silo.mpm.laws import GudehusBauer, Intergranular
from taichi_silo.mpm.laws.several import Several
from taichi_silo.scene.own_part import need_name
from taichi_silo.scene.published_sands import published
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import Options

MOST_LAYERS = 100


class IntergranularStrain(Options):
    """Constants of Niemunis and Herle (1997); the defaults are theirs for Hochstetten sand."""

    radius: float = Field(1e-4, ge=1e-7, le=0.01, description="R, largest intergranular strain")
    m_R: float = Field(5.0, ge=1, le=100, description="factor of stiffness when the strain turns back")
    m_T: float = Field(2.0, ge=1, le=100, description="the same when it turns by a right angle; at most m_R")
    beta_r: float = Field(0.5, ge=0.01, le=100, description="exponent of how fast the memory follows")
    chi: float = Field(6.0, ge=0.01, le=100, description="exponent of how fast the stiffness falls")

    @model_validator(mode="after")
    def _ordered(self):
        if self.m_T > self.m_R:
            raise ValueError(f"m_T is {self.m_T}; it must be at most m_R = {self.m_R}")
        return self


# constants that sands of one silo may have of their own
OWN = (
    "critical_friction_angle_deg", "granular_hardness_Pa", "n", "alpha", "beta", "e_i0", "e_c0", "e_d0",
)  # fmt: skip


class SandLayer(Options):
    """Another void ratio or another sand, from a height up to that of the next layer or the surface.

    Constants that are not given are those of the sand that is named, or else of the sand below all layers. Grains are
    as dense and as large as those of that.
    """

    from_m: float = Field(ge=0, le=1000, description="height above the floor where it begins")
    void_ratio: float = Field(ge=0.01, le=10, description="its initial void ratio, between e_d0 and e_i0")
    name: str | None = Field(None, description="of a published sand, if it is another one than below")
    critical_friction_angle_deg: float | None = Field(None, ge=5, le=85, description="phi_c")
    granular_hardness_Pa: float | None = Field(None, ge=1e5, le=1e12, description="h_s")
    n: float | None = Field(None, ge=0.01, le=0.99, description="exponent of compression")
    alpha: float | None = Field(None, ge=0.001, le=5, description="exponent of density in the peak of strength")
    beta: float | None = Field(None, ge=0.001, le=20, description="exponent of density in stiffness")
    e_i0: float | None = Field(None, ge=0.01, le=10, description="loosest void ratio without pressure")
    e_c0: float | None = Field(None, ge=0.01, le=10, description="critical void ratio without pressure")
    e_d0: float | None = Field(None, ge=0.01, le=10, description="densest void ratio without pressure")

    @field_validator("name")
    @classmethod
    def _published(cls, value: str | None) -> str | None:
        if value is not None and value not in published():
            raise ValueError(f"name of a layer of sand is {shown(value)}; it must be one of {', '.join(published())}")
        return value

    @property
    def own(self) -> dict[str, float]:
        """The constants of another sand; empty if it is that below."""
        named = published()[self.name] if self.name else {}
        given = {key: getattr(self, key) for key in OWN if getattr(self, key) is not None}
        return {key: named[key] for key in OWN if key in named} | given


class Sand(Options):
    """Gudehus-Bauer constants; the defaults are the paper's Karlsruhe sand."""

    LAWS: ClassVar = ("auto", "gudehus-bauer", "intergranular")

    name: str = Field(
        "karlsruhe",
        max_length=100,
        description="the name of a published sand stands for all constants that are not given",
    )
    void_ratio: float = Field(0.60, description="initial void ratio, between e_d0 and e_i0")
    law: Literal["auto", "gudehus-bauer", "intergranular"] | str = Field(
        "auto",
        description="law; intergranular is the one with memory, which auto takes where strain turns back; or one that "
        "a plugin registers",
    )
    constants: dict[str, float] | None = Field(None, description="of a law that a plugin registers, by their names")
    critical_friction_angle_deg: float = Field(30.0, ge=5, le=85, description="phi_c")
    granular_hardness_Pa: float = Field(190e6, ge=1e5, le=1e12, description="h_s")
    n: float = Field(0.5, ge=0.01, le=0.99, description="exponent of compression")
    alpha: float = Field(0.3, ge=0.001, le=5, description="exponent of density in the peak of strength")
    beta: float = Field(1.0, ge=0.001, le=20, description="exponent of density in stiffness")
    e_i0: float = Field(1.30, ge=0.01, le=10, description="loosest void ratio without pressure")
    e_c0: float = Field(0.82, ge=0.01, le=10, description="critical void ratio without pressure")
    e_d0: float = Field(0.51, ge=0.01, le=10, description="densest void ratio without pressure")
    grain_density_kg_per_m3: float = Field(2650.0, ge=10, le=1e5, description="of the grains themselves")
    d50_m: float = Field(0.5e-3, ge=1e-7, le=1, description="mean grain diameter")
    intergranular: IntergranularStrain = IntergranularStrain()
    layers: tuple[SandLayer, ...] = Field((), max_length=MOST_LAYERS)

    @field_validator("name")
    @classmethod
    def _printable(cls, value: str) -> str:
        if not value.isprintable():
            raise ValueError(f"sand.name is {shown(value)}; it must be letters and signs that can be printed")
        return value

    @field_validator("law", mode="before")
    @classmethod
    def _known(cls, given):
        return need_name("law", given, cls.LAWS, own_parts.LAWS, "a law")

    @model_validator(mode="after")
    def _own(self):
        if self.law in self.LAWS and self.constants:
            raise ValueError(f"sand.constants are those of a registered law; the law is {self.law}")
        if self.law not in self.LAWS:
            self._made(self.grain_density_kg_per_m3)
        return self

    @model_validator(mode="after")
    def _ordered(self):
        if not self.e_d0 < self.e_c0 < self.e_i0:
            raise ValueError(
                f"limits of the void ratio are {self.e_d0}, {self.e_c0}, {self.e_i0}; e_d0 < e_c0 < e_i0 must hold"
            )
        if self.skeleton().h_i <= 0:
            raise ValueError(
                f"alpha is {self.alpha}; with these void ratios it gives h_i <= 0, a smaller one is needed"
            )
        if not self.e_d0 < self.void_ratio < self.e_i0:
            raise ValueError(
                f"void ratio is {self.void_ratio}; it must lie between e_d0 = {self.e_d0} and e_i0 = {self.e_i0}"
            )
        below = 0.0
        for layer in self.layers:
            if not layer.from_m > below:
                raise ValueError(
                    f"from_m of a layer of sand is {layer.from_m}; it must be above {below}, where the one below begins"
                )
            below = layer.from_m
            if layer.own and self.law not in self.LAWS:
                own = f"the layer from {layer.from_m} m has constants of its own"
                raise ValueError(f"{own}; it must have none, as the law is {self.law}")
            self._check(layer)
        return self

    def _check(self, layer: SandLayer) -> None:
        try:
            self.of_layer(layer)
        except ValidationError as error:
            what = str(error.errors()[0]["msg"]).removeprefix("Value error, ")
            raise ValueError(f"in the layer from {layer.from_m} m the {what}") from error

    def of_layer(self, layer: SandLayer) -> "Sand":
        """The sand of a layer."""
        other = {"void_ratio": layer.void_ratio, "layers": ()} | layer.own
        return Sand.model_validate(self.model_dump() | other | ({"name": layer.name} if layer.name else {}))

    @property
    def sands(self) -> tuple["Sand", ...]:
        """Those of the silo from below, each with its void ratio: its own, and those of the layers."""
        return (self, *(self.of_layer(layer) for layer in self.layers))

    @property
    def words(self) -> str:
        """Which sands there are."""
        others = (f"above {layer.from_m:g} m {layer.name or 'another'}" for layer in self.layers if layer.own)
        return ", ".join((self.name, *others))

    def sand_at(self, y: np.ndarray) -> np.ndarray:
        """Numbers of the `sands` at heights y (array) [m]."""
        return np.searchsorted([layer.from_m for layer in self.layers], y, side="right")

    def void_ratio_at(self, y: np.ndarray) -> np.ndarray:
        """Initial void ratio at heights y (array) [m]."""
        return np.array([self.void_ratio, *(layer.void_ratio for layer in self.layers)])[self.sand_at(y)]

    @property
    def loose(self) -> bool:
        """Whether it is looser than its critical void ratio without pressure, so that shear contracts it."""
        return self.void_ratio > self.e_c0

    def law_for(self, turns_back: bool) -> str:
        """Name of the law: as given, or with memory only where strain turns back."""
        if self.law != "auto":
            return self.law
        return "intergranular" if turns_back else "gudehus-bauer"

    def constitutive_law(self, mass_scaling: float = 1.0, turns_back: bool = False) -> Law:
        """The constitutive law with these constants, the grains' density times a factor; of several sands, all."""
        if any(layer.own for layer in self.layers):
            alone = (one.model_copy(update={"layers": ()}) for one in self.sands)
            return Several(tuple(one.constitutive_law(mass_scaling, turns_back) for one in alone))
        if self.law not in self.LAWS:
            return self._made(mass_scaling * self.grain_density_kg_per_m3)
        skeleton = self.skeleton(mass_scaling)
        if self.law_for(turns_back) == "gudehus-bauer":
            return skeleton
        return Intergranular(skeleton=skeleton, **self.intergranular.model_dump())

    def _made(self, grain_density: float) -> Law:
        """The registered law."""
        kind, constants = own_parts.LAWS[self.law], self.constants or {}
        law = own_parts.made(kind, constants, "sand.constants", grain_density=grain_density)
        own_parts.check_constants(kind, (*constants.items(), ("grain_density", grain_density)))
        return law

    def check_at(self, pressure_Pa: float, name: str = "void ratio") -> None:
        """Refuse a void ratio that this sand cannot have at an isotropic pressure."""
        e_d, _, e_i = self.skeleton().void_ratio_limits(pressure_Pa)
        if not e_d < self.void_ratio < e_i:
            raise ValueError(
                f"{name} is {self.void_ratio}; at {pressure_Pa:g} Pa it must lie between "
                f"e_d = {e_d:.4f} and e_i = {e_i:.4f}"
            )

    def skeleton(self, mass_scaling: float = 1.0) -> GudehusBauer:
        """The law without memory."""
        return GudehusBauer(
            critical_friction_angle_deg=self.critical_friction_angle_deg,
            granular_hardness_Pa=self.granular_hardness_Pa,
            n=self.n, alpha=self.alpha, beta=self.beta,
            e_i0=self.e_i0, e_c0=self.e_c0, e_d0=self.e_d0,
            grain_density=mass_scaling * self.grain_density_kg_per_m3,
        )  # fmt: skip
