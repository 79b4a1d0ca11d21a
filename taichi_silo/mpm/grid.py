"""Every field of the nodes, and where the nodes are."""

from taichi_silo.mpm.field_memory import put, values
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.runtime import real

MARGIN = 2  # nodes beyond the sand on every side: a domain that reaches through a wall still finds its nodes


@ti.data_oriented
class Grid:
    """Cells over a box [0, width] x [0, height], node (i, j) at ((i - MARGIN) h, (j - MARGIN) times their height).

    The grid may be laid anew in each step, so its origin follows the bottom plate of a silo, or its height the top
    plate of a specimen; no field here outlives a step but `memory` and `stretch`.

    ==============  ==========  ========================================================================
    field           shape       meaning
    ==============  ==========  ========================================================================
    mass            copy, node  nodal mass [kg/m], one copy for each thread
    momentum        copy, node  nodal momentum [kg m/s /m]
    force           copy, node  internal force [N/m]
    velocity        node        after the step [m/s]
    change          node        of the velocity in the step [m/s]; see `hold` for these five
    second_velocity node        velocities that went to the nodes once more in the step [m/s]; see `hold_second`
    memory          3, node     exponential means of momentum (2) and mass, for the noise control [kg m/s /m, kg/m]
    stretch         copy        height of the grid over its first height [-], one copy for each thread
    ==============  ==========  ========================================================================

    Parameters
    ----------
    width_m, height_m : size of the box that sand may fill.
    cell_size_m : h, their width.
    copies : number of copies of the three sums.
    follows : "bottom": the grid rides on the plate; "top": its height follows the plate, y = 0 stands still;
        "surface": its height follows the free nodes at y = height; "nothing".
    periodic : whether column `width / h` is column 0 again.
    open_sides : whether sand may leave beside the box, as it may below it.
    cell_height_m : of a cell; that of a square if absent. It should be nearly that.

    """

    FOLLOWS = ("bottom", "top", "surface", "nothing")

    def __init__(
        self, width_m: float, height_m: float, cell_size_m: float, copies: int = 1, follows: str = "bottom",
        periodic: bool = False, open_sides: bool = False, cell_height_m: float | None = None,
    ):  # fmt: skip
        if follows not in self.FOLLOWS:
            raise ValueError(f"follows is {follows!r}; it must be one of {', '.join(self.FOLLOWS)}")
        if follows == "surface" and not periodic:
            raise ValueError("a grid that follows the surface must be periodic: its first column must hold sand")
        self.cell_size, self.height = cell_size_m, height_m
        self.first_cell_height = cell_size_m if cell_height_m is None else cell_height_m
        self.follows, self.periodic, self.open_sides = follows, periodic, open_sides
        self.columns = round(width_m / cell_size_m) + (0 if periodic else 1 + 2 * MARGIN)
        self.top = round(height_m / self.first_cell_height) + MARGIN
        self.rows = self.top + 1 + MARGIN
        self.nodes = self.columns * self.rows
        self.copies = copies
        self.mass = self.momentum = self.force = self.velocity = self.change = self.second_velocity = None
        self.memory = ti.field(real, shape=(3, self.nodes))
        self.stretch = ti.field(real, shape=copies)
        put(self.stretch, 1.0)

    def hold(self) -> None:
        """Have the sums and the velocities, for which the vector unit has arrays of its own."""
        if self.mass is None:
            self.mass = ti.field(real)
            self.momentum, self.force = ti.Vector.field(2, real), ti.Vector.field(2, real)
            ti.root.dense(ti.i, self.copies * self.nodes).place(self.mass, self.momentum, self.force)
            self.velocity, self.change = ti.Vector.field(2, real), ti.Vector.field(2, real)
            ti.root.dense(ti.i, self.nodes).place(self.velocity, self.change)

    def hold_second(self) -> None:
        """Have the second velocity, which most steps have not."""
        if self.second_velocity is None:
            self.second_velocity = ti.Vector.field(2, real, shape=self.nodes)

    def velocities(self) -> tuple[ti.Field, ...]:
        """What points may gather."""
        return tuple(one for one in (self.velocity, self.change, self.second_velocity) if one is not None)

    def forget_all(self) -> None:
        """Stand as at the beginning."""
        sums = (self.mass, self.momentum, self.force) if self.mass is not None else ()
        for field in (*sums, *self.velocities(), self.memory):
            put(field, 0.0)
        put(self.stretch, 1.0)

    def node_along(self, position_m: float) -> int:
        """Index of the node at a coordinate, along the floor or, where cells are square, a side.

        Raises
        ------
        ValueError
            if no node lies there.

        """
        cells = position_m / self.cell_size
        if abs(cells - round(cells)) > 1e-6:
            raise ValueError(f"{position_m} m is not on a grid line of {self.cell_size} m cells")
        return round(cells) + MARGIN

    @property
    def present_height(self) -> float:
        """Distance of the plates [m] (Python scope)."""
        return self.height * float(values(self.stretch)[0])

    @ti.func
    def node(self, i, j):
        """Flat index of the node in column i (any number if periodic) and row j."""
        column = i
        if ti.static(self.periodic):
            column = i % self.columns
        return j * self.columns + column

    @ti.func
    def cell_height(self, t):
        """Height of a cell [m]."""
        height = self.first_cell_height
        if ti.static(self.follows in ("top", "surface")):
            height = self.first_cell_height * self.stretch[t]
        return height

    @ti.func
    def velocity_of_origin(self, step):
        """How fast the grid as a whole moves [m/s]."""
        rides = 1.0 if ti.static(self.follows == "bottom") else 0.0
        return 0.0, rides * step.plate_velocity

    @ti.func
    def velocity_of_frame(self, step, j):
        """How fast the nodes of row j move [m/s]."""
        upwards = self.velocity_of_origin(step)[1]
        if ti.static(self.follows == "top"):
            upwards = step.plate_velocity * (j - MARGIN) / (self.top - MARGIN)
        return 0.0, upwards

    @ti.func
    def memory_of(self, k):
        """What node k remembers: means of momentum (x, y) and mass."""
        return self.memory[0, k], self.memory[1, k], self.memory[2, k]

    @ti.func
    def remember(self, k, memory):
        """Set what node k remembers."""
        for c in ti.static(range(3)):
            self.memory[c, k] = memory[c]

    @ti.func
    def forget(self, k):
        """Node k has no sand."""
        self.memory[2, k] = 0.0

    @ti.func
    def follow(self, t, step):
        """The height of thread t's grid after the step."""
        if ti.static(self.follows == "top"):
            self.stretch[t] += step.dt * step.plate_velocity / self.height
        if ti.static(self.follows == "surface"):
            self.stretch[t] += step.dt * self.velocity[self.top * self.columns][1] / self.height
