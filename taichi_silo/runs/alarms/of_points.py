"""Checks of the states of all points, now and then."""

from pathlib import Path

import numpy as np
import shapely

from taichi_silo.analysis.measure.deformation import Rings
from taichi_silo.analysis.measure.matching import matched
from taichi_silo.analysis.measure.wall_pressure import SURFACE
from taichi_silo.runs.alarms.of_records import Check, smaller_step
from taichi_silo.runs.certificate import inertial_number, unexplained_densification
from taichi_silo.scene import fill_shape
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation.alarm import Alarm
from taichi_silo.simulation.record import Record
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils.set_aside import SetAside

Points = dict[str, np.ndarray]  # fields of all points, see `Simulation.points`

OUTSIDE = 0.5  # of a cell that the middle of a point may be beyond a wall
BELOW, BESIDE = 2.0, 1.0  # cells below an opening and beside it: what has passed it spreads, and is soon taken out
MOST_LOST = 0.003  # of void ratio, without shear that explains it
INERTIAL = 1e-2  # dense flow below 1e-3 knows no rate; above 1e-2 friction and void ratio follow it
SHARE = 99.0  # percentile of the points below the surface


def space(scene: Scene) -> shapely.Geometry:
    """Where sand may be, in the frame of the grid: the silo and the free height above it, and the opening below it."""
    silo, h = scene.silo, scene.grid.cell_size_m
    left, right = silo.sides
    free = silo.height_m + scene.filling.drop_m + scene.flow.displacement_m
    above = shapely.box(left[-1, 0], left[-1, 1], right[-1, 0], left[-1, 1] + free)
    found = shapely.union(shapely.Polygon(np.concatenate([right, left[::-1]])), above)
    if silo.has_opening:
        for one in silo.openings:
            found = shapely.union(found, shapely.box(*one.box(0.0, BELOW * h)))
            found = shapely.union(found, shapely.box(*one.box(OUTSIDE * h, BELOW * h, BESIDE * h)))
    for insert in silo.inserts:
        found = shapely.difference(found, shapely.Polygon(insert.outline(silo.width_m)))
    return found


class CheckOfPoints(Check):
    """One kind of wrongness that the states of all points show; earlier ones wait in a folder (`SetAside`)."""

    def __init__(self, simulation: Simulation, folder: Path | None = None):
        super().__init__(simulation)
        self.folder = folder

    def filled(self, points: Points) -> None:
        """Take note of the state from which the flow starts."""


class Outside(CheckOfPoints):
    """Sand beyond the walls, the floor, or within an insert."""

    def __init__(self, simulation: Simulation, folder: Path | None = None):
        super().__init__(simulation, folder)
        self.reach = OUTSIDE * simulation.scene.grid.cell_size_m
        self.space = space(simulation.scene)
        shapely.prepare(self.space)

    def look(self, record: Record, points: Points) -> Alarm | None:
        """Find the farthest point beyond, in the frame of the grid, which sinks with a floor that sinks."""
        x, y = (points["position"] - (0.0, self.simulation.origin_m)).T
        beyond = np.flatnonzero(~shapely.contains_xy(self.space, x, y))
        if not len(beyond):
            return None
        far = shapely.distance(self.space, shapely.points(x[beyond], y[beyond]))
        if not far.max() > self.reach:
            return None
        first = beyond[int(np.argmax(far))]
        alarm = Alarm(
            "outside the walls", True,
            f"{int((far > self.reach).sum())} points are beyond the walls, the farthest{{place}} by "
            f"{1e3 * far.max():.2f} mm, more than {OUTSIDE} cells", "the wall is thinner or sharper than the cells see",
            f"smaller cells or a blunter corner help, or {smaller_step(self.simulation.scene)}", float(far.max()),
            self.reach,
        )  # fmt: skip
        return alarm.at(points["position"][first], points["identity"][first])


class _Since(CheckOfPoints):
    """Compares with an earlier state."""

    def __init__(self, simulation: Simulation, folder: Path | None = None):
        super().__init__(simulation, folder)
        self.earlier: SetAside | None = None

    def state(self) -> dict:
        """The state to compare with."""
        return {"earlier": self.earlier and self.earlier.kept}

    def restore(self, kept: dict) -> None:
        """Go on with the state to compare with."""
        if kept.get("earlier") is not None:
            self.earlier = SetAside(self.folder, kept["earlier"])


class Ratcheting(_Since):
    """Void ratio lost without shear: oscillations compact the sand while its force curves still look fine."""

    KEPT = ("position", "void_ratio", "mass", "identity")  # of the state that the flow starts from

    def __init__(self, simulation: Simulation, folder: Path | None = None):
        super().__init__(simulation, folder)
        self.rings: SetAside | None = None  # of so many points

    def filled(self, points: Points) -> None:
        """Keep the state that the flow starts from."""
        self.earlier = SetAside(self.folder, points)

    def look(self, record: Record, points: Points) -> Alarm | None:
        """Compare the sand that has not been sheared with its state after filling."""
        if self.earlier is None or self.free:  # sand that falls is not at rest, and lands as it can
            return None
        earlier = matched(self.earlier.read(), points)
        if self.rings is None or self.rings.kept["points"] != len(points["mass"]):  # else it is the same sand
            found = Rings(earlier["position"])
            self.rings = SetAside(self.folder, {"index": found.index, "points": len(found.index)})
        scene, rings = self.simulation.scene, Rings(earlier["position"], self.rings.read()["index"])
        lost, where = unexplained_densification(earlier, points, scene, rings)
        if not lost > MOST_LOST:
            return None
        cure = 'method.noise_control = "column" helps'
        if scene.method.noise_control != "none":
            cure = "the noise control holds against flow, so something else shakes the sand: see what moves in the film"
        alarm = Alarm(
            "ratcheting", False,
            f"sand that has not been sheared has lost {lost:.4f} of void ratio since the filling, most of it{{place}}",
            "oscillations compact it (ratcheting), and N is too high", cure, lost, MOST_LOST,
        )  # fmt: skip
        return alarm.at(points["position"][where], points["identity"][where])


class Inertia(_Since):
    """The inertial number of the sheared sand in controlled outflow, since the last look."""

    def look(self, record: Record, points: Points) -> Alarm | None:
        """Compare the percentile of the points below the surface with the limit."""
        before = self.earlier.read() if self.earlier else None
        known = {"identity": points["identity"], "path": points["path"], "time_s": record.time_s}
        self.earlier = SetAside(self.folder, known)
        if before is None or record.stage != "flow" or self.free:
            return None
        scene = self.simulation.scene
        path = points["path"] - matched(before, points)["path"]
        number = inertial_number(path, record.time_s - before["time_s"], points["stress"], scene)
        x, y = points["position"].T
        below = y - self.simulation.origin_m < SURFACE * fill_shape.top_m(scene.silo, x)
        if not below.any():
            return None
        found = float(np.percentile(number[below], SHARE))
        if not found > INERTIAL:
            return None
        alarm = Alarm(
            "inertia", False,
            f"the inertial number of the sheared sand is {found:.2g}, above {INERTIAL:g}, greatest{{place}}, though "
            "the outflow is controlled", "the flow is too fast to be quasi-static",
            "a smaller flow.speed_m_per_s helps", found, INERTIAL,
        )  # fmt: skip
        where = int(np.argmax(np.where(below, number, -1.0)))
        return alarm.at(points["position"][where], points["identity"][where])
