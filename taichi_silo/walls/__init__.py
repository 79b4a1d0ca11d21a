"""Walls: `planes` says where a wall is, `coulomb` how it acts."""

from taichi_silo.walls.coulomb import Coulomb, Glide, Grip, NoSlip
from taichi_silo.walls.planes import Pin, PlaneWall

__all__ = ["Coulomb", "Glide", "Grip", "NoSlip", "Pin", "PlaneWall"]
