"""Which variant of the material point method: what a user may choose in every scene."""

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pydantic import Field, model_validator

from taichi_silo.mpm.filters import FILTERS
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.solver import STRESS_UPDATES
from taichi_silo.mpm.velocity_transfer import TRANSFERS, Blend
from taichi_silo.utils.schema import Options

if TYPE_CHECKING:  # for a type checker names, which the method's own lists hold, are text
    Shape: TypeAlias = str
    Transfer: TypeAlias = str
    StressUpdate: TypeAlias = str
    StressFilter: TypeAlias = str
else:
    Shape, Transfer = (Literal[tuple(names)] for names in (SHAPES, TRANSFERS))
    StressFilter = Literal[("auto", *FILTERS)]
    StressUpdate = Literal[STRESS_UPDATES]


class MethodOptions(Options):
    """Transfer, order of the step, filter and time step; the defaults are what the stability map recommends."""

    transfer: Transfer = Field("flip", description="how velocities go from grid to points")
    pic_share: float = Field(0.05, ge=0, le=1, description="share of PIC in each step, with transfer blend")
    stress_update: StressUpdate = Field(
        "last", description="when stresses are updated; modified: last, from velocities sent to the nodes once more"
    )
    stress_filter: StressFilter = Field(
        "auto",
        description="filter of the stresses; patch: takes out, by strain, what no node feels; auto: patch, but none "
        "with one point a cell beside walls that cut cells; smoothing: the paper's",
    )
    time_step_s: float | None = Field(None, ge=1e-9, le=1, description="time step; from the sand's stiffness if absent")
    cfl: float | None = Field(
        None, ge=1e-4, le=2, description="time step over h / (c + |v|); the shape's own limit if absent"
    )
    mass_scaling: float = Field(
        1.0, ge=1, le=1e6, description="factor of inertia, not of weight: fewer steps, a faster flow"
    )

    @model_validator(mode="after")
    def _goes_together(self):
        if TRANSFERS[self.transfer].SECOND_TRANSFER and self.stress_update != "last":
            raise ValueError(
                f"stress update is {self.stress_update}; with the transfer {self.transfer} it must be last"
            )
        if self.time_step_s is not None and self.cfl is not None:
            raise ValueError(f"cfl is {self.cfl}; it cannot be given together with a time step ({self.time_step_s} s)")
        return self

    def transfer_of_points(self) -> Any:
        """The transfer that is meant, an object of `taichi_silo.mpm.velocity_transfer`."""
        return Blend(self.pic_share) if self.transfer == "blend" else TRANSFERS[self.transfer]()

    def solver_options(self) -> dict[str, Any]:
        """Keywords for `taichi_silo.mpm.solver.Solver`."""
        return {
            "transfer": self.transfer_of_points(),
            "stress_update": self.stress_update,
            "filtering": FILTERS["patch" if self.stress_filter == "auto" else self.stress_filter],
        }

    def time_step(self, found: Any, safety: float) -> float:
        """Time step [s]: as given, or what the points' stiffness and speed allow, times `safety` if no cfl is given."""
        if self.time_step_s is not None:
            return self.time_step_s
        return safety * found.stable_step if self.cfl is None else self.cfl * found.transit
