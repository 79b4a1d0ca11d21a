"""Shape functions: products of one-dimensional weights.

The contract of a shape, a frozen dataclass:

`NODES`
    how many nodes a point touches along an axis.
`axis(xi)`
    of a coordinate xi = x / h (grid units, node k at xi = k): the first touched node (a float), the weights and
    their derivatives with respect to xi, as tuples of length NODES. Scalars and lanes alike, no branches.
`stable_fraction`
    largest stable time step over h / c on a regular lattice of points in the plane: 2 / sqrt(sum of the greatest
    sum_k S_k'^2 / S_k over both axes), the Irons-Treharne bound of the lumped mass matrix.

A new shape is one file with these members and one name below.
"""

from taichi_silo.shapes.gimp import UniformGimp
from taichi_silo.shapes.linear import Linear

SHAPES = {"linear": Linear, "ugimp": UniformGimp}

__all__ = ["SHAPES", "Linear", "UniformGimp"]
