"""Walls: `planes` says where a wall is, `coulomb` how it acts."""

from taichi_silo.walls.coulomb import Coulomb, NoSlip
from taichi_silo.walls.planes import PlaneWall

__all__ = ["Coulomb", "NoSlip", "PlaneWall"]
