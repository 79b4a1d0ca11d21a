"""Walls of the paper's model silo: the friction angles that were measured between its smooth walls and the sand."""

from taichi_silo.scene.scene import Walls

SMOOTH_ANGLE_DEG = {"dense": 19.0, "loose": 12.3}
LOOSE_FROM = 0.75  # void ratio, between the paper's dense (0.60) and loose (0.90) sand


def smooth_angle_deg(void_ratio: float) -> float:
    """Friction angle between smooth walls and sand of an initial void ratio [deg]."""
    return SMOOTH_ANGLE_DEG["loose" if void_ratio >= LOOSE_FROM else "dense"]


def walls(kind: str, void_ratio: float) -> Walls:
    """Walls of a kind; smooth ones have the angle measured for sand of that void ratio."""
    return Walls(kind=kind, friction_angle_deg=smooth_angle_deg(void_ratio) if kind == "smooth" else None)
