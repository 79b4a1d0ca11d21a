"""The slowest oscillation of the fill: what filling, noise control and records are timed by."""

from taichi_silo.mpm.laws.stress_point import wave_speed


def wave_speed_of(scene) -> float:
    """Upper bound of the speed of a plane wave at half the height of the filled silo [m/s]; Taichi has been started."""
    law, e = scene.law, scene.sand.void_ratio
    gravity = scene.method.gravity_m_per_s2 / scene.method.mass_scaling
    middle = 0.5 * law.grain_density / (1.0 + e) * gravity * scene.silo.height_m
    return wave_speed(law, (-0.5 * middle, -middle, -0.5 * middle, 0.0), e)


def period_of(scene) -> float:
    """Period 4 H / c of the column that stands on its bottom [s]."""
    return 4.0 * scene.silo.height_m / wave_speed_of(scene)
