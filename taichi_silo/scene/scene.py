"""What a user gives: typed, checked, with units, and every default visible.

A scene is written into `run.toml` and read from it again. Unknown names and impossible values are refused before any
work, in a sentence that names the value and its valid range.
"""

import math
import os
from typing import Literal

from pydantic import Field, field_validator, model_validator

from taichi_silo.errors import BadInput
from taichi_silo.mpm import runtime
from taichi_silo.mpm.contracts import Law
from taichi_silo.scene import bands, cell_sizes, fill_shape
from taichi_silo.scene.averaging import Averaging
from taichi_silo.scene.eurocode import Eurocode
from taichi_silo.scene.flow import Flow
from taichi_silo.scene.mesh import Mesh
from taichi_silo.scene.method_options import MethodOptions
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.silo import Silo
from taichi_silo.scene.symmetry import half_model
from taichi_silo.scene.walls import Walls
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import Options

MOST_POINTS = 20_000_000
SNAPSHOTS, FEWEST_SNAPSHOTS = 100, 10  # over the flow, of small and of large scenes
MOST_STATES = 10_000_000  # points times snapshots, where their number is not given: about 0.8 GB
POINTS_OF_A_THREAD, MOST_THREADS = 1000, 16  # fewer points wait longer for each other than they gain


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Filling(Options):
    """How the sand gets into the silo.

    gravity-ramp: all of it is in place, and its weight grows (the paper's). layers: one after the other, each with its
    weight. rain: row after row falls from a height.
    """

    kind: Literal["gravity-ramp", "layers", "rain"] = Field(
        "gravity-ramp",
        description="all sand in place while its weight grows, one layer after the other, or falling rows",
    )
    layers: int = Field(20, ge=1, le=1000, description="number of layers, where sand is filled in by them")
    drop_m: float = Field(0.02, ge=0, le=1000, description="height of fall, where sand is filled in by rain")


class Method(MethodOptions):
    """Method of computation, and how the fill comes to rest."""

    noise_control: Literal["column", "none"] = Field(
        "column", description="drag against swings of the column, without force in steady flow; none: the paper's"
    )
    gravity_m_per_s2: float = Field(9.81, ge=0.01, le=1e4, description="acceleration of gravity")
    filling_time_s: float = Field(
        0.5, ge=1e-6, le=1e5, description="time in which the weight grows; at least 28 periods of the column"
    )
    longest_settling_s: float = Field(
        1.0, ge=0, le=1e5, description="longest wait for rest after filling; or 20 periods of the column, if longer"
    )


class Output(Options):
    """What is written, and how often."""

    records_per_period: int = Field(10, ge=4, le=100, description="rows of forces.csv in one period of the column")
    snapshots: int | None = Field(
        None,
        ge=0,
        le=10_000,
        description="states of all points over the flow; 100 if absent, or fewer of more than 100,000 points",
    )
    checkpoint_s: float = Field(
        120.0, ge=0.01, le=86_400, description="time by the clock between two checkpoints: what a crash may cost"
    )


class Machine(Options):
    """Processor, threads and precision that a run uses."""

    arch: Literal["cpu", "cuda", "vulkan"] = Field(
        "cpu", description="processor, graphics card of Nvidia, or any card that computes in f64 through Vulkan"
    )
    threads: int = Field(
        default_factory=lambda: min(MOST_THREADS, cores()),
        ge=1,
        description="threads of the processor; if absent, one for each 1000 points, at most 16, if it has so many",
    )
    lanes: bool = Field(True, description="eight points at once on the CPU's vector unit, where that can be trusted")

    @field_validator("threads")
    @classmethod
    def _available(cls, value: int) -> int:
        if value > cores():
            raise ValueError(f"threads is {shown(value)}; this machine has 1 to {cores()}")
        return value

    def start(self) -> None:
        """Start Taichi on it.

        Raises BadInput if it cannot be used.
        """
        if runtime.PRECISION != "f64":
            raise BadInput(
                f"TAICHI_SILO_PRECISION is {runtime.PRECISION}; runs need f64: in f32 sand that sinks at 0.1 mm/s "
                "stands still, and void ratios drift"
            )
        try:
            runtime.init(self.arch, self.threads)
        except runtime.ArchitectureError as error:
            raise BadInput(str(error), runtime.ON_CPU) from error


class Scene(Options):
    """A silo, filled with sand that then flows out."""

    silo: Silo = Silo()
    sand: Sand = Sand()
    walls: Walls = Walls()
    grid: Mesh = Mesh()
    averaging: Averaging = Averaging()
    filling: Filling = Filling()
    flow: Flow = Flow()
    method: Method = Method()
    eurocode: Eurocode = Eurocode()
    output: Output = Output()
    machine: Machine = Machine()

    @model_validator(mode="after")
    def _meshed(self):
        fitted = {
            "grid": self.grid.fitted(self.silo, self.flow.outflow == "gravity"),
            "flow": self.flow.fitted(self.silo, self.method.gravity_m_per_s2),
        }
        for name, part in fitted.items():
            if part is not getattr(self, name):
                object.__setattr__(self, name, part)
        return self

    @model_validator(mode="after")
    def _divides(self):
        self.grid.check(self.silo)
        h = self.grid.cell_size_m
        if self.points > MOST_POINTS:
            raise ValueError(
                f"cell size is {h} m; it makes {self.points} points, at most {MOST_POINTS} are allowed (lengths are in "
                "metres)"
            )
        self.averaging.check(self.characteristic_length_m, self.spacing_m, self.points, self.silo.width_m)
        if self.averaging.wall == "rigid" and self.walls.kind != "very-rough":
            raise ValueError(f"walls are {self.walls.kind}; in an average with rigid walls they must be very rough")
        bands.check(self.walls, self.silo)
        if self.sand.layers and self.sand.layers[-1].from_m >= self.silo.height_m:
            raise ValueError(
                f"the highest layer of sand begins at {self.sand.layers[-1].from_m} m; it must be below the height of "
                f"{self.silo.height_m} m"
            )
        half_model(self)
        self._check_contact()
        self._check_outflow()
        self.eurocode.check(self.silo)
        return self

    @model_validator(mode="after")
    def _share(self):
        if "threads" not in self.machine.model_fields_set:
            threads = max(1, min(MOST_THREADS, cores(), self.points // POINTS_OF_A_THREAD))
            object.__setattr__(self, "machine", self.machine.model_copy(update={"threads": threads}))
        return self

    def _check_contact(self) -> None:
        silo = self.silo
        inclined = [name for name, there in (("a hopper", silo.hopper), ("inserts", silo.inserts)) if there]
        inclined += ["inclined walls"] if any(silo.feet_m) and not silo.hopper else []
        if self.walls.own and inclined:
            raise ValueError(
                f"walls are {self.walls.kind}; a registered contact acts on vertical walls only, and this silo has "
                f"{inclined[0]}"
            )

    def _check_outflow(self) -> None:
        silo, flow = self.silo, self.flow
        if flow.outflow == "gravity" and silo.floor_is_outlet:
            raise ValueError("outflow is gravity; the silo needs an outlet or a hopper that sand can fall out of")
        if flow.outflow == "collapse" and silo.column_m is None:
            raise ValueError("outflow is collapse; the silo needs a column (silo.column_m) whose walls are taken away")
        if flow.outflow != "collapse" and silo.column_m is not None:
            raise ValueError(f"outflow is {flow.outflow}; a column can only collapse (flow.outflow = collapse)")
        over = flow.longest_s if flow.free else flow.displacement_m / flow.speed_m_per_s
        for number, outlet in enumerate(silo.outlets):
            if outlet.opens_at_s >= over:
                raise ValueError(
                    f"outlet {number + 1} opens at {outlet.opens_at_s:g} s; it must open before the outflow ends, "
                    f"after {over:.4g} s"
                )
        most = silo.area_m2 / silo.outlet_share_m
        if silo.floor_is_outlet and flow.displacement_m > silo.height_m:
            raise ValueError(
                f"displacement is {flow.displacement_m} m; it must be at most the height of {silo.height_m} m"
            )
        if flow.outflow == "controlled" and flow.displacement_m > most * (1.0 + 1e-9):
            raise ValueError(
                f"displacement is {flow.displacement_m} m; it must be at most {most:.4g} m, when the silo is empty"
            )
        if self.filling.kind == "rain" and self.filling.drop_m > silo.height_m:
            raise ValueError(
                f"drop is {self.filling.drop_m} m; it must be between 0 and the silo's height of {silo.height_m} m"
            )

    @property
    def law(self) -> Law:
        """The constitutive law of the sand in this scene."""
        return self.sand.constitutive_law(self.method.mass_scaling, self.flow.turns_back)

    @property
    def sticks(self) -> bool:
        """Whether the whole bottom sinks between very rough walls, and the sand dilates as it shears along them."""
        return self.walls.kind == "very-rough" and self.silo.floor_is_outlet and not self.sand.loose

    @property
    def characteristic_length_m(self) -> float:
        """Length of the non-local law [m]: as given, or three mean grain diameters, which coarse cells do not resolve.

        Where sand `sticks` it would be too strong in the zones along the walls: half a cell is the least there.
        """
        return self.averaging.length_m(self.sand, self.grid.cell_size_m if self.sticks else 0.0)

    @property
    def spacing_m(self) -> float:
        """Distance between neighbouring points at the start [m]."""
        return self.grid.cell_size_m / math.isqrt(self.grid.points_per_cell)

    @property
    def cell_height_m(self) -> float:
        """Height of a cell [m]: nearly its width, so that whole rows make the height of the silo."""
        return cell_sizes.height_m(self.silo, self.grid.cell_size_m)

    @property
    def rise_m(self) -> float:
        """Distance between rows of points at the start [m]."""
        return self.cell_height_m / math.isqrt(self.grid.points_per_cell)

    @property
    def points(self) -> int:
        """Number of material points; of a round silo those of its section from wall to wall."""
        d, rise, silo = self.spacing_m, self.rise_m, self.silo
        columns, rows = round(silo.width_m / d), round(silo.height_m / rise)
        box = silo.floor_is_outlet and silo.surface_m is None
        if box or columns * rows > MOST_POINTS:
            return columns * rows
        return silo.points(d, rise)

    @property
    def snapshots(self) -> int:
        """Number of snapshots over the flow: as given, or as many as the number of points leaves room for."""
        if self.output.snapshots is not None:
            return self.output.snapshots
        return max(FEWEST_SNAPSHOTS, min(SNAPSHOTS, MOST_STATES // self.points))

    @property
    def mean_void_ratio(self) -> float:
        """Void ratio of the whole fill: that of its sand, or voids over solids of all layers."""
        sand, silo = self.sand, self.silo
        if not sand.layers:
            return sand.void_ratio
        levels = [0.0, *(layer.from_m for layer in sand.layers), silo.height_m]
        areas = [fill_shape.area_between_m2(silo, low, high) for low, high in zip(levels[:-1], levels[1:], strict=True)]
        ratios = [sand.void_ratio, *(layer.void_ratio for layer in sand.layers)]
        return sum(areas) / sum(area / (1.0 + ratio) for area, ratio in zip(areas, ratios, strict=True)) - 1.0

    @property
    def density_kg_per_m3(self) -> float:
        """Bulk density of the fill: grain density / (1 + void ratio) [kg/m3]."""
        return self.sand.grain_density_kg_per_m3 / (1.0 + self.mean_void_ratio)

    @property
    def weight_N_per_m(self) -> float:
        """Weight of the fill per metre run, or per metre of a round silo's wall [N/m]."""
        return self.density_kg_per_m3 * self.method.gravity_m_per_s2 * self.silo.area_m2
