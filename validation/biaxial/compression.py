"""The biaxial test itself: a specimen with a weak element, compressed between smooth plates."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.laws.stress_point import wave_speed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.walls import FixedNode, Frictionless, PlaneWall
from taichi_silo.simulation.specimen import Specimen
from taichi_silo.studies.element_tests import start_strain
from validation.biaxial.scene import BiaxialScene

RAMP_PERIODS = 4  # the plate reaches its speed over so many periods of the specimen
ROWS_PER_PERCENT = 40  # rows of the curve in one per cent of shortening
LONGEST_STEP = 1.5  # over the stable one; beyond, results are wrong before anything explodes
ROOM = 0.5  # free width on either side, over the specimen's width


@dataclass(frozen=True)
class BiaxialRow:
    """One row of the curve."""

    shortening: float  # u / height
    friction_angle_deg: float  # from the plate's force over the specimen's present width
    axial_stress_Pa: float  # compression positive
    void_ratio: float
    kinetic_energy_J: float
    time_step_s: float


class Biaxial:
    """The test of a scene; Taichi has been started. Iterate over `run()`."""

    def __init__(self, scene: BiaxialScene):
        self.scene = scene
        law = scene.sand.constitutive_law(scene.mass_scaling)
        gravity = scene.gravity_m_per_s2 / scene.mass_scaling
        h, p = scene.cell_size_m, scene.pressure_Pa
        per_axis = math.isqrt(scene.points_per_cell)
        place = Specimen.lattice(scene.width_m, scene.height_m, h, per_axis)
        weak = (place[:, 0] < scene.weak_size_m) & (
            np.abs(place[:, 1] - scene.weak_height * scene.height_m) < 0.5 * scene.weak_size_m
        )
        e = np.where(weak, scene.weak_void_ratio, scene.sand.void_ratio)
        density = law.grain_density / (1.0 + scene.sand.void_ratio)
        stress = np.tile([-p, -p, -p, 0.0], (len(place), 1))
        stress[:, 1] -= density * gravity * (scene.height_m - place[:, 1])
        middle = stress[len(stress) // 2]
        speed = wave_speed(law, middle, scene.sand.void_ratio)
        self.period = 4.0 * scene.height_m / speed
        control = NoiseControl.for_specimen(self.period, h / speed) if scene.noise_control == "column" else None
        left = ROOM * scene.width_m - math.fmod(ROOM * scene.width_m, h)

        def walls(grid):
            bottom = grid.node_along(0.0)
            return (
                PlaneWall("bottom", 1, -1, bottom, Frictionless()),
                FixedNode(grid.node_along(left + 0.5 * scene.width_m), bottom),
                PlaneWall("top", 1, 1, grid.top, Frictionless(), motion=(0.0, 1.0)),
            )

        kernel, self.about_averaging = scene.averaging.kernel(scene.averaging.length_m(scene.sand), scene.spacing_m)
        self.specimen = Specimen(
            law, e, width_m=scene.width_m, height_m=scene.height_m, cell_size_m=h, per_axis=per_axis,
            walls=walls, stress=stress,
            ambient_pressure=p, left_m=left, gravity=gravity, kernel=kernel,
            control=control, shape=scene.shape, options=scene, h=start_strain(law),
        )  # fmt: skip
        self.left, self.initial_void_ratio = left, e

    def run(self) -> Iterator[BiaxialRow]:
        """Lower the plate: a smooth start, then constant speed."""
        scene, piece = self.scene, self.specimen
        target = scene.shortening * scene.height_m
        duration = 0.01 * scene.height_m / scene.speed_m_per_s / ROWS_PER_PERCENT
        ramp = RAMP_PERIODS * self.period
        while piece.travel > -target * (1.0 - 1e-9):
            part = min((piece.time + duration) / ramp, 1.0)
            speed = scene.speed_m_per_s * part * part * (3.0 - 2.0 * part)
            mean = 0.5 * (speed - piece.speed)
            reading = piece.drive(min(duration, (target + piece.travel) / mean), -speed)
            if reading.time_step_s > LONGEST_STEP * reading.stable_step_s:
                raise RunFailed(
                    f"at u / h = {-reading.travel_m / scene.height_m:.4f} the time step of "
                    f"{1e6 * reading.time_step_s:.2f} us is above {LONGEST_STEP} times the stable one of "
                    f"{1e6 * reading.stable_step_s:.2f} us; let it be chosen, or give a smaller one"
                )
            yield self._row(reading)

    def _row(self, reading) -> BiaxialRow:
        scene = self.scene
        axial = scene.pressure_Pa + reading.plate_force_N[1] * -1.0 / self.top_width()
        if not axial > 0.0:
            raise RunFailed(
                f"at u / h = {-reading.travel_m / scene.height_m:.4f} the plate pulls the specimen ({axial:.0f} Pa); "
                "oscillations are the likely cause (is there a noise control, is the time step short enough?)"
            )
        low, high = sorted((axial, scene.pressure_Pa))
        return BiaxialRow(
            shortening=-reading.travel_m / scene.height_m,
            friction_angle_deg=math.degrees(math.asin((high - low) / (high + low))),
            axial_stress_Pa=axial,
            void_ratio=reading.void_ratio,
            kinetic_energy_J=reading.kinetic_energy_J,
            time_step_s=reading.time_step_s,
        )

    def top_width(self) -> float:
        """Width of the specimen under the upper plate [m]."""
        place = self.specimen.particles.position.to_numpy()[-self.scene.points_across :]
        return float(np.ptp(place[:, 0])) * self.scene.points_across / (self.scene.points_across - 1)

    def points(self) -> dict[str, np.ndarray]:
        """All fields of the points; `position` is counted from the first left edge, `reference` is the first place."""
        scene = self.scene
        arrays = self.specimen.particles.arrays()
        arrays["position"] = arrays["position"] - np.array([self.left, 0.0])
        arrays["reference"] = Specimen.lattice(scene.width_m, scene.height_m, scene.spacing_m)
        arrays["initial_void_ratio"] = self.initial_void_ratio
        arrays["void_ratio"] = arrays["volume"] * self.specimen.law.grain_density / arrays["mass"] - 1.0
        return arrays
