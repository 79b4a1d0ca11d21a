"""What the plane of the grid means, a slice of a long body or the half-section of a round one, and what surrounds it.

The contract, a frozen dataclass:

`HOOP`
    whether points also strain around an axis at x = 0; masses, volumes and forces are then per radian.
`depth(x)`
    size of the body across the plane [m]: 1 (per metre run) or the radius x.
"""

import numpy as np

from taichi_silo.mpm.frozen import frozen


@frozen
class PlaneStrain:
    """A slice of one metre; zz is the direction across it, in which nothing strains."""

    HOOP = False

    def depth(self, x: np.ndarray) -> np.ndarray:
        """1 m."""
        return 0.0 * x + 1.0


@frozen
class Axisymmetric:
    """One radian of a body of revolution: x is the radius, y the axis, zz the hoop direction.

    The hoop strain rate is v_r / r at the point, and the hoop stress acts on the nodes with the same weights, so that
    the power of stress is that of the nodal forces. Source: J. Nairn, J. Guilkey, Int. J. Numer. Meth. Eng. 101
    (2015) 127-147, with weights at the point's radius.
    """

    HOOP = True

    def depth(self, x: np.ndarray) -> np.ndarray:
        """Radius [m]."""
        return x


@frozen
class Surroundings:
    """What surrounds the points.

    Parameters
    ----------
    geometry : of `taichi_silo.geometry`.
    ambient_pressure : of a fluid around the body [Pa]; it acts on every free surface, wherever that moves. Reactions
        of walls are those beyond it. Only the stress in excess of it is put on the nodes: the divergence of a uniform
        pressure is zero, so a free surface needs no search for its normal.

    """

    geometry: PlaneStrain | Axisymmetric = PlaneStrain()
    ambient_pressure: float = 0.0
