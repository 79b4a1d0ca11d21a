"""The scales of time of a scene: its waves, the slowest swing of its fill, and the noise control that holds it."""

import math

from taichi_silo.mpm.laws.stress_point import wave_speed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.scene import fill_shape
from taichi_silo.scene.scene import Scene

CELLS_PER_STRENGTH = 8.0  # of the height, for each of the usual drags: so the drag of a step stays below 0.1


def wave_speed_of(scene: Scene) -> float:
    """Upper bound of the speed of a plane wave at half the height of the filled silo [m/s]; Taichi has been started."""
    law = scene.law
    e = min([scene.sand.void_ratio, *(layer.void_ratio for layer in scene.sand.layers)])
    gravity = scene.method.gravity_m_per_s2 / scene.method.mass_scaling
    middle = 0.5 * law.grain_density / (1.0 + e) * gravity * scene.silo.height_m
    return wave_speed(law, (-0.5 * middle, -middle, -0.5 * middle, 0.0), e)


def period_of(scene: Scene) -> float:
    """Period 4 H / c of the slowest swing of the fill, a column that stands on its bottom [s]."""
    return 4.0 * scene.silo.height_m / wave_speed_of(scene)


def noise_control(scene: Scene, period: float) -> NoiseControl:
    """What the scene asks for, scaled to the period of its column [s]."""
    if scene.method.noise_control == "none":
        return NoiseControl()
    left, right = fill_shape.sides_m(scene.silo)
    strength = min(1.0 + 3.0 * grip(scene), max(1.0, scene.silo.height_m / scene.grid.cell_size_m / CELLS_PER_STRENGTH))
    return NoiseControl.for_column(period, scene.silo.height_m / (right - left), strength)


def grip(scene: Scene) -> float:
    """How far walls make sand shear in zones of its own as it sinks, instead of slipping along them: 0 to 1.

    Such zones feed the swing, which then packs the sand between them, unless the drag is stronger: dense sand softens
    in them, and loose sand packs most easily. Not up to the sand's critical friction angle (0), wholly from 45 degrees
    on and along very rough walls (1); between them it grows with the coefficient of friction. Where less than half of
    the floor sinks, the rest bears the column, and the usual drag is enough.
    """
    return max(0.0, 2.0 * scene.silo.sinking_share - 1.0) * _roughness(scene)


def _roughness(scene: Scene) -> float:
    """The part of the walls in it."""
    walls = scene.walls
    if walls.kind == "very-rough":
        return 1.0
    steepest = max((walls.friction_angle_deg or 0.0, *(band.friction_angle_deg for band in walls.bands)))
    critical = math.tan(math.radians(scene.sand.critical_friction_angle_deg))
    beyond = math.tan(math.radians(steepest)) - critical
    return min(1.0, max(0.0, beyond / max(1.0 - critical, 0.1)))
