"""Element tests: one piece of sand that strains alike everywhere, through the law alone or through the whole method."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.laws.stress_point import StressPoint, wave_speed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.walls import Frictionless, NoSlip, PlaneWall, RoughFree
from taichi_silo.scene.method_options import MethodOptions, Shape
from taichi_silo.scene.scene import Sand
from taichi_silo.simulation.specimen import Specimen

COLUMNS = (
    "strain", "sigma_11_Pa", "sigma_22_Pa", "sigma_33_Pa", "sigma_12_Pa", "void_ratio", "friction_angle_deg",
)  # fmt: skip
ROWS = 400
POINT_INCREMENT = 2e-5  # of strain, through the stress point
CELL_M, CELLS, PER_AXIS = 0.005, 1, 2  # of the piece that goes through the method: with more cells it may shear-band
STRAIN_RATE = 0.2  # [1/s] at most: the plate's speed stays below 1e-4 of the wave speed
LARGEST_STRAIN = {"axial": 0.5, "shear": 5.0}


@dataclass(frozen=True)
class ElementTest:
    """What is prescribed; components of stress and strain are (xx, yy, zz, xy)."""

    name: str  # as on the command line
    axial: int  # index of the stress that is called 11; 22 is the other one in the plane
    strain: tuple[float, float, float, float]  # prescribed rate per unit of strain
    spin: float = 0.0  # likewise
    free: int | None = None  # component whose stress stays as it is at the start
    tied: int | None = None  # component that strains like `free`
    pressure_Pa: float = 50e3  # usual one
    final: float = 0.2  # usual strain at the end

    @property
    def sheared(self) -> bool:
        """Whether the strain is gamma."""
        return self.strain[3] != 0.0

    @property
    def extended(self) -> bool:
        """Whether the axial strain is negative."""
        return self.strain[1] > 0.0


TESTS = {
    test.name: test
    for test in (
        ElementTest("oedometer", 1, (0.0, -1.0, 0.0, 0.0), pressure_Pa=1e3, final=0.04),
        ElementTest("triaxial", 1, (0.3, -1.0, 0.3, 0.0), free=0, tied=2),
        ElementTest("triaxial-extension", 1, (-0.3, 1.0, -0.3, 0.0), free=0, tied=2),
        ElementTest("plane-strain", 1, (0.3, -1.0, 0.0, 0.0), free=0),
        ElementTest("simple-shear", 0, (0.0, 0.0, 0.0, 0.5), 0.5, free=1),
        ElementTest("simple-shear-constant-volume", 0, (0.0, 0.0, 0.0, 0.5), 0.5),
    )
}


class ElementScene(MethodOptions):
    """One element test."""

    test: Literal[
        "oedometer", "triaxial", "triaxial-extension", "plane-strain", "simple-shear", "simple-shear-constant-volume"
    ]  # fmt: skip
    sand: Sand = Sand()
    pressure_Pa: float = Field(50e3, ge=100.0, le=5e6, description="isotropic at the start")
    strain: float = Field(0.2, gt=0, description="at the end: axial logarithmic, or shear gamma")
    through: Literal["point", "mpm"] = "point"
    shape: Shape = Field("ugimp", description="of the method, as all that follows")

    @model_validator(mode="before")
    @classmethod
    def _usual(cls, values):
        """Each test has its own usual pressure and strain."""
        test = TESTS.get(values.get("test")) if isinstance(values, dict) else None
        return values if test is None else {"pressure_Pa": test.pressure_Pa, "strain": test.final, **values}

    @model_validator(mode="after")
    def _possible(self):
        self.sand.check_at(self.pressure_Pa)
        most = LARGEST_STRAIN["shear" if TESTS[self.test].sheared else "axial"]
        if self.strain > most:
            raise ValueError(f"strain is {self.strain}; it must be above 0 and at most {most}")
        return self


def curve_of(scene: ElementScene) -> Iterator[tuple]:
    """The rows of curve.csv (see COLUMNS); Taichi has been started.

    Raises RunFailed if the law cannot follow the path.
    """
    try:
        if scene.through == "mpm":
            yield from through_method(scene)
        else:
            law = scene.sand.constitutive_law()
            yield from through_point(TESTS[scene.test], law, scene.sand.void_ratio, scene.pressure_Pa, scene.strain)
    except RunFailed:
        raise
    except RuntimeError as error:
        raise RunFailed(f"in the test {scene.test}: {error}") from error


def friction_angle_deg(stress) -> float:
    """Mobilised friction angle by principal stresses, asin((s1 - s3) / (s1 + s3)), of (xx, yy, zz, xy)."""
    centre, half = 0.5 * (stress[0] + stress[1]), 0.5 * (stress[0] - stress[1])
    radius = math.hypot(half, stress[3])
    principal = (-centre - radius, -centre + radius, -stress[2])
    low, high = min(principal), max(principal)
    return math.degrees(math.asin(min((high - low) / (high + low), 1.0))) if low + high > 0.0 else 0.0


def row(test: ElementTest, strain: float, stress, void_ratio: float) -> tuple[float, ...]:
    """One row of curve.csv: compression positive, and the shear stress positive where it drives the shear."""
    other = 1 - test.axial
    sign = -1.0 if test.extended else 1.0
    return (
        sign * strain, -stress[test.axial], -stress[other], -stress[2], stress[3], void_ratio,
        friction_angle_deg(stress),
    )  # fmt: skip


def start_strain(law):
    """Intergranular strain of sand that has been compressed alike from all sides, h = -R I / sqrt 3."""
    part = -law.radius / math.sqrt(3.0) if law.REMEMBERS else 0.0
    return (part, part, part, 0.0)


def through_point(test: ElementTest, law, void_ratio: float, pressure_Pa: float, final: float) -> Iterator[tuple]:
    """Rows of the curve, from the law alone."""
    point = StressPoint(law, [-pressure_Pa] * 3 + [0.0], void_ratio, start_strain(law))
    yield row(test, 0.0, point.stress, point.void_ratio)
    count = max(1, math.ceil(final / ROWS / POINT_INCREMENT))
    part = final / ROWS / count
    for number in range(1, ROWS + 1):
        increment = np.array(test.strain) * part
        if test.free is None:
            point.step(increment, test.spin * part, count)
        else:
            point.step_mixed(increment, test.spin * part, test.free, -pressure_Pa, test.tied, count)
        yield row(test, final * number / ROWS, point.stress, point.void_ratio)


def specimen(scene: ElementScene) -> Specimen:
    """A piece of one cell and four points between plates, with the boundary conditions of the test."""
    test, law, void_ratio = TESTS[scene.test], scene.sand.constitutive_law(scene.mass_scaling), scene.sand.void_ratio
    pressure_Pa, size = scene.pressure_Pa, CELL_M * CELLS

    def walls(grid):
        bottom, top = grid.node_along(0.0), grid.node_along(size)
        held = NoSlip() if test.free is None else RoughFree()
        base, lid, motion = (
            (NoSlip(), held, (1.0, 0.0)) if test.sheared else (Frictionless(), Frictionless(), (0.0, 1.0))
        )
        plates = (PlaneWall("bottom", 1, -1, bottom, base), PlaneWall("top", 1, 1, top, lid, motion=motion))
        if test.sheared:
            return plates
        side = PlaneWall("axis", 0, -1, grid.node_along(0.0), Frictionless())
        far = (PlaneWall("side", 0, 1, grid.node_along(size), Frictionless()),) if test.free is None else ()
        return (side, *far, *plates)

    kept = test.free is not None
    speed = wave_speed(law, (-pressure_Pa, -pressure_Pa, -pressure_Pa, 0.0), void_ratio)
    return Specimen(
        law, void_ratio, width_m=size, height_m=size, cell_size_m=CELL_M, walls=walls,
        stress=(-pressure_Pa, -pressure_Pa, -pressure_Pa, 0.0), ambient_pressure=pressure_Pa if kept else 0.0,
        right_m=size if kept and not test.sheared else 0.0, axisymmetric=test.tied is not None,
        per_axis=PER_AXIS, follows=("surface" if kept else "nothing") if test.sheared else "top", periodic=test.sheared,
        control=NoiseControl.for_column(4.0 * size / speed), h=start_strain(law), shape=scene.shape, options=scene,
    )  # fmt: skip


def through_method(scene: ElementScene) -> Iterator[tuple]:
    """Rows of the curve, from the material point method; Taichi has been started."""
    test, pressure_Pa, final = TESTS[scene.test], scene.pressure_Pa, scene.strain
    piece = specimen(scene)
    height = piece.solver.grid.height
    yield row(test, 0.0, (-pressure_Pa, -pressure_Pa, -pressure_Pa, 0.0), scene.sand.void_ratio)
    gamma = 0.0
    for number in range(1, ROWS + 1):
        part = final * number / ROWS
        # the rate grows smoothly over the first twentieth of the strain
        rate = STRAIN_RATE * min(1.0, 20.0 * (number - 0.5) / ROWS)
        duration = final / ROWS / rate
        if test.sheared:
            before, gone = piece.solver.grid.present_height, piece.travel
            reading = piece.drive(duration, 2.0 * before * final / ROWS / duration - piece.speed)
            gamma += (piece.travel - gone) / (0.5 * (before + reading.height_m))
            strain = gamma
        else:
            aim = height * math.exp(part if test.extended else -part)
            mean = (aim - reading.height_m if number > 1 else aim - height) / duration
            reading = piece.drive(duration, 2.0 * mean - piece.speed)
            strain = abs(math.log(reading.height_m / height))
        yield row(test, strain, reading.stress_Pa, reading.void_ratio)
