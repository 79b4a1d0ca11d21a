"""Walls: `planes` and `outlets` hold nodes, `surfaces` press on the sand from anywhere; `contact` says how.

The contract of a wall that holds nodes, a frozen dataclass with `name`, `contact` (see contact.py) and `motion` (its
velocity as a multiple, along x and y, of the plate velocity of the step):

`holds(i, j)`   whether it holds node (i, j)
`normal(i, j)`  unit normal (x, y) out of the sand there
`slot(i, j)`    where along the wall the reaction of the node is booked
"""

from taichi_silo.mpm.walls.bands import Bands
from taichi_silo.mpm.walls.contact import Coulomb, Frictionless, NoSlip, RoughFree
from taichi_silo.mpm.walls.outlets import Edges, Gate, Gates, OpenFloor
from taichi_silo.mpm.walls.planes import FixedNode, PlaneWall
from taichi_silo.mpm.walls.side_outlets import SideEdges, SideGate
from taichi_silo.mpm.walls.surfaces import Surface

__all__ = [
    "Bands", "Coulomb", "Edges", "Gate", "Gates", "Frictionless", "RoughFree", "NoSlip", "OpenFloor", "FixedNode",
    "PlaneWall", "SideEdges", "SideGate", "Surface",
]  # fmt: skip
