"""The side walls that a user gives."""

from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from taichi_silo.mpm import own_parts
from taichi_silo.mpm.walls import Coulomb, NoSlip
from taichi_silo.scene.bands import MOST_BANDS, Band, words
from taichi_silo.scene.own_part import need_name
from taichi_silo.utils.schema import Options


class Walls(Options):
    """Side walls; the bottom plate is smooth unless told otherwise."""

    KINDS: ClassVar = ("smooth", "very-rough")

    kind: Literal["smooth", "very-rough"] | str = Field(
        "very-rough",
        description="walls with Coulomb friction, or so rough that sand does not slip on them; or a contact that a "
        "plugin registers",
    )
    friction_angle_deg: float | None = Field(
        None, ge=0, lt=90, description="between sand and smooth walls, which need it"
    )
    bottom_friction_angle_deg: float = Field(0.0, ge=0, lt=90, description="of the bottom plate or floor, against sand")
    bands: tuple[Band, ...] = Field((), max_length=MOST_BANDS)
    constants: dict[str, float] | None = Field(None, description="of a contact that a plugin registers, by their names")

    @field_validator("kind", mode="before")
    @classmethod
    def _known(cls, given):
        return need_name("walls", given, cls.KINDS, own_parts.CONTACTS, "a contact")

    @model_validator(mode="after")
    def _friction(self):
        if self.kind == "very-rough" and self.friction_angle_deg is not None:
            raise ValueError(
                f"wall friction angle is {self.friction_angle_deg}; very rough walls have none (no slip there), "
                "only smooth walls take one"
            )
        if self.kind == "smooth" and self.friction_angle_deg is None:
            raise ValueError(
                "walls.friction_angle_deg is not given; smooth walls need the friction angle between sand and wall "
                "[deg]; the paper's model silo has 19 for dense and 12.3 for loose sand"
            )
        if not self.own and self.constants:
            raise ValueError(f"walls.constants are those of a registered contact; walls are {self.kind}")
        if self.own:
            self.contact()
        return self

    @property
    def own(self) -> bool:
        """Whether their contact is registered by a plugin."""
        return self.kind not in self.KINDS

    @property
    def words(self) -> str:
        """What they are, in words."""
        found = f"walls {self.kind}" if self.own else "very rough walls"
        if self.kind == "smooth":
            found = f"smooth walls ({self.friction_angle_deg:g}°)"
        return ", ".join(filter(None, (found, words(self))))

    def contact(self, friction_angle_deg: float | None = None) -> Any:
        """How they act on the sand, or another wall with a friction angle of its own [deg]."""
        if friction_angle_deg is None and self.own:
            return own_parts.made(own_parts.CONTACTS[self.kind], self.constants or {}, "walls.constants")
        angle = self.friction_angle_deg if friction_angle_deg is None else friction_angle_deg
        return NoSlip() if angle is None else Coulomb(angle)  # very rough walls have no angle
