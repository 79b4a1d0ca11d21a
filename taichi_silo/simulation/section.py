"""Which part of a silo is computed, and how the whole follows from it.

Of a plane silo everything is computed, or its left half; of a round one the section from its axis (x = 0 of the grid)
to its wall.
"""

from dataclasses import dataclass

import numpy as np

from taichi_silo.mpm.geometry import Axisymmetric, PlaneStrain
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.symmetry import half_model, whole_points


@dataclass(frozen=True)
class Section:
    """The computed part of a silo, [0, width] of the grid.

    Attributes
    ----------
    width : [m].
    shift : x in the laboratory less x in the grid [m].
    half : whether it is the left half of a plane silo.
    round : whether it is that of a round silo, from the axis to the wall.
    columns : nodes across the whole silo, margins included.

    """

    width: float
    shift: float
    half: bool
    round: bool
    columns: int

    @classmethod
    def of(cls, scene: Scene) -> "Section":
        """The part of a scene's silo that is computed."""
        silo, round_ = scene.silo, scene.silo.section == "round"
        half = half_model(scene)[0]
        width = 0.5 * silo.width_m if half or round_ else silo.width_m
        columns = round(silo.width_m / scene.grid.cell_size_m) + 1 + 2 * MARGIN
        return cls(width, width if round_ else 0.0, half, round_, columns)

    @property
    def geometry(self) -> Axisymmetric | PlaneStrain:
        """What the plane of the grid means."""
        return Axisymmetric() if self.round else PlaneStrain()

    @property
    def factor(self) -> float:
        """Factor from computed to reported sums over the sand: 2 for a half, 2 / R for a round silo, else 1.

        A round silo is reported per metre of the wall's girth, twice: so left and right wall, a metre of girth each,
        and the bottom carry the weight of the sand, as in a plane silo.
        """
        if self.round:
            return 2.0 / self.width
        return 2.0 if self.half else 1.0

    @property
    def points_per_computed(self) -> int:
        """How many points of the whole silo a computed one stands for."""
        return 2 if self.half or self.round else 1

    def whole(self, computed: dict[str, np.ndarray], silo_width_m: float) -> dict[str, np.ndarray]:
        """Fields of the points of the whole silo, in the laboratory, from those of the computed part.

        Masses and volumes become those per metre run; in a round silo, of which positions must be among the fields, per
        metre of the point's own girth.
        """
        if self.round:
            radius = computed["position"][:, 0]
            per_metre = {name: computed[name] / radius for name in ("mass", "volume") if name in computed}
            right = computed | per_metre | {"position": computed["position"] + (self.shift, 0.0)}
            return whole_points(right, silo_width_m)
        return whole_points(computed, silo_width_m) if self.half else computed
