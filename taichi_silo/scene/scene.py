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
from taichi_silo.mpm.laws import GudehusBauer, Intergranular
from taichi_silo.mpm.neighbour_rows import MOST_PAIRS, most_pairs
from taichi_silo.mpm.nonlocal_average import INACTIVE_FROM, WEIGHTS, Weight, self_weight, summed_by
from taichi_silo.scene.eurocode import Eurocode
from taichi_silo.scene.method_options import MethodOptions, Shape
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.silo import Silo
from taichi_silo.scene.symmetry import half_model
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import Options

MOST_POINTS = 20_000_000
MOST_PER_CELL = 10_000
MOST_CELLS = 20_000  # across or along a silo
SNAPSHOTS, FEWEST_SNAPSHOTS = 100, 10  # over the flow, of small and of large scenes
MOST_STATES = 10_000_000  # points times snapshots, where their number is not given: about 0.8 GB
POINTS_OF_A_THREAD, MOST_THREADS = 1000, 16  # fewer points wait longer for each other than they gain


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Walls(Options):
    """Side walls; the bottom plate is smooth unless told otherwise."""

    kind: Literal["smooth", "very-rough"] = Field(
        "very-rough", description="walls with Coulomb friction, or so rough that sand does not slip on them"
    )
    friction_angle_deg: float | None = Field(
        None, ge=0, lt=90, description="between sand and smooth walls, which need it"
    )
    bottom_friction_angle_deg: float = Field(0.0, ge=0, lt=90, description="of the bottom plate or floor, against sand")

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
        return self


class Mesh(Options):
    """Background grid and points."""

    cell_size_m: float = Field(
        0.005, ge=1e-5, le=100, description="size of a cell of the grid; it divides width and height"
    )
    points_per_cell: int = Field(1, description="points in a cell at the start, a square number: 1, 4, 9, ...")
    shape: Shape = Field("ugimp", description="shape functions")

    @field_validator("points_per_cell")
    @classmethod
    def _square(cls, value: int) -> int:
        if not 1 <= value <= MOST_PER_CELL or math.isqrt(value) ** 2 != value:
            raise ValueError(
                f"points per cell is {shown(value)}; it must be a square number: 1, 4, 9, 16, ... up to {MOST_PER_CELL}"
            )
        return value


class Flow(Options):
    """Outflow: the bottom, or a gate in the outlet, sinks at a speed, or the sand falls out by its weight."""

    outflow: Literal["controlled", "gravity"] = Field(
        "controlled", description="the bottom or gate sinks at a given speed, or the sand falls out by its weight"
    )
    speed_m_per_s: float = Field(
        0.002, ge=1e-9, le=1, description="speed of the bottom or gate, without meaning for gravity"
    )
    displacement_m: float = Field(
        0.02, ge=1e-9, le=1000,
        description="how far the bottom or gate sinks; for gravity that of a gate which lets out as much",
    )  # fmt: skip
    longest_s: float = Field(10.0, ge=1e-6, le=1e6, description="time of free outflow after which a run ends")

    @property
    def turns_back(self) -> bool:
        """Whether sand is strained to and fro, as behind a free outflow, so that its law needs a memory."""
        return self.outflow == "gravity"


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


class Averaging(Options):
    """Non-local mean of the norm of the strain rate in the law's non-linear part."""

    characteristic_length_m: float | None = Field(
        None,
        ge=0,
        le=1000,
        description="characteristic length of the non-local law; 3 d50 if absent, 0 for a local law",
    )
    weight: Literal["gaussian", "exponential"] = Field(
        "gaussian", description="weight of neighbours; the paper prints exponential"
    )
    wall: Literal["ignored", "rigid"] | None = Field(
        None,
        description="very rough straight walls in the mean: left out, or counted as grains that do not strain; rigid "
        "if absent, ignored with another weight than gaussian",
    )

    def length_m(self, sand: Sand) -> float:
        """Characteristic length l_c [m]: as given, or three mean grain diameters."""
        return 3.0 * sand.d50_m if self.characteristic_length_m is None else self.characteristic_length_m

    means: Literal["grid", "rows"] | None = Field(
        None,
        description="how the mean is summed: over rows of neighbours, or, a Gaussian, by way of a grid; the faster one "
        "if absent",
    )

    def summed_by(self, kernel: Weight, spacing_m: float) -> str:
        """How the mean is summed: "grid" or "rows"."""
        return self.means or summed_by(kernel, spacing_m)

    @property
    def walls_count(self) -> bool:
        """Whether walls that sand sticks to count in the mean."""
        return self.weight == "gaussian" if self.wall is None else self.wall == "rigid"

    def check(self, sand: Sand, spacing_m: float, points: int, width_m: float) -> None:
        """Refuse a characteristic length beyond the body, or with more neighbours than memory holds."""
        length = self.length_m(sand)
        if self.wall == "rigid" and self.weight != "gaussian":
            raise ValueError(f"weight is {self.weight}; with walls that count as rigid it must be gaussian")
        if length > width_m:
            raise ValueError(
                f"characteristic length is {length:g} m; it must be between 0 and the width of {width_m:g} m"
            )
        if self.means == "grid" and self.weight != "gaussian":
            raise ValueError(f"weight is {self.weight}; summed by a grid it must be gaussian")
        kernel = WEIGHTS[self.weight](length)
        by_rows = length > 0.0 and self.summed_by(kernel, spacing_m) == "rows"
        if by_rows and most_pairs(kernel.radius, spacing_m, points) > MOST_PAIRS:
            raise ValueError(
                f"characteristic length is {length:g} m; with {points} points {1e3 * spacing_m:g} mm apart that makes "
                f"more than {MOST_PAIRS} pairs of neighbours, give a smaller one, larger cells, or the means by a grid"
            )

    def kernel(self, sand: Sand, spacing_m: float) -> tuple[Weight | None, str]:
        """Weight function of the non-local average, None where it would change nothing, and why in a sentence."""
        length = self.length_m(sand)
        if length == 0.0:
            return None, "The law is local: the characteristic length is 0."
        kernel = WEIGHTS[self.weight](length)
        own = self_weight(kernel, spacing_m)
        apart = (
            f"with points {1e3 * spacing_m:g} mm apart and a characteristic length of {1e3 * length:g} mm a point's "
            "own weight is"
        )
        if own > INACTIVE_FROM:
            return None, (
                f"Non-locality is inactive: {apart} {own:.4f}; points closer than {1e3 * length:g} mm would make it "
                "work."
            )
        return kernel, f"Non-locality is active: {apart} {own:.3f}."


class Method(MethodOptions):
    """Method of computation, and how the fill comes to rest."""

    noise_control: Literal["column", "none"] = Field(
        "column", description="drag against swings of the column, without force in steady flow; none: the paper's"
    )
    gravity_m_per_s2: float = Field(9.81, ge=0.01, le=1e4, description="acceleration of gravity")
    filling_time_s: float = Field(
        0.5, ge=1e-6, le=1e5, description="time in which the weight grows; at least 12 periods of the column"
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
            raise BadInput(str(error)) from error


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
    def _divides(self):
        h = self.grid.cell_size_m
        for name, length in (("width", self.silo.width_m), ("height", self.silo.height_m)):
            cells = length / h
            if cells > MOST_CELLS * (1.0 + 1e-6):
                raise ValueError(
                    f"cell size is {h} m; it makes {cells:.4g} cells along the {name} of {length} m, at most "
                    f"{MOST_CELLS} are allowed (lengths are in metres)"
                )
            if abs(cells - round(cells)) > 1e-6 or round(cells) < 2:
                raise ValueError(
                    f"cell size is {h} m; it must divide the {name} of {length} m into at least 2 whole cells"
                )
        if self.points > MOST_POINTS:
            raise ValueError(
                f"cell size is {h} m; it makes {self.points} points, at most {MOST_POINTS} are allowed (lengths are in "
                "metres)"
            )
        self.averaging.check(self.sand, self.spacing_m, self.points, self.silo.width_m)
        if self.averaging.wall == "rigid" and self.walls.kind != "very-rough":
            raise ValueError(f"walls are {self.walls.kind}; in an average with rigid walls they must be very rough")
        half_model(self)
        self._check_outflow()
        self.eurocode.check(self.silo)
        return self

    @model_validator(mode="after")
    def _share(self):
        if "threads" not in self.machine.model_fields_set:
            threads = max(1, min(MOST_THREADS, cores(), self.points // POINTS_OF_A_THREAD))
            object.__setattr__(self, "machine", self.machine.model_copy(update={"threads": threads}))
        return self

    def _check_outflow(self) -> None:
        silo, flow, h = self.silo, self.flow, self.grid.cell_size_m
        left, right = silo.outlet_m
        if right - left < 2.0 * h * (1.0 - 1e-9):
            raise ValueError(f"outlet width is {right - left:g} m; on cells of {h} m it must be at least {2 * h:g} m")
        for edge in (left, right):
            if silo.outlet is not None and abs(edge / h - round(edge / h)) > 1e-6:
                raise ValueError(
                    f"outlet width is {silo.outlet.width_m} m; its edge at x = {edge:g} m must lie on the grid, whose "
                    f"lines are {h} m apart"
                )
        if silo.section == "round" and round(silo.width_m / h) % 2:
            raise ValueError(f"cell size is {h} m; it must divide the radius of {0.5 * silo.width_m} m of a round silo")
        if flow.outflow == "gravity" and silo.floor_is_outlet:
            raise ValueError("outflow is gravity; the silo needs an outlet or a hopper that sand can fall out of")
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
    def law(self) -> GudehusBauer | Intergranular:
        """The constitutive law of the sand in this scene."""
        return self.sand.constitutive_law(self.method.mass_scaling, self.flow.turns_back)

    @property
    def spacing_m(self) -> float:
        """Distance between neighbouring points at the start [m]."""
        return self.grid.cell_size_m / math.isqrt(self.grid.points_per_cell)

    @property
    def points(self) -> int:
        """Number of material points; of a round silo those of its section from wall to wall."""
        d, silo = self.spacing_m, self.silo
        columns, rows = round(silo.width_m / d), round(silo.height_m / d)
        if silo.floor_is_outlet or columns * rows > MOST_POINTS:
            return columns * rows
        return silo.points(d)

    @property
    def snapshots(self) -> int:
        """Number of snapshots over the flow: as given, or as many as the number of points leaves room for."""
        if self.output.snapshots is not None:
            return self.output.snapshots
        return max(FEWEST_SNAPSHOTS, min(SNAPSHOTS, MOST_STATES // self.points))

    @property
    def density_kg_per_m3(self) -> float:
        """Bulk density of the fill: grain density / (1 + void ratio) [kg/m3]."""
        return self.sand.grain_density_kg_per_m3 / (1.0 + self.sand.void_ratio)

    @property
    def weight_N_per_m(self) -> float:
        """Weight of the fill per metre run, or per metre of a round silo's wall [N/m]."""
        return self.density_kg_per_m3 * self.method.gravity_m_per_s2 * self.silo.area_m2
