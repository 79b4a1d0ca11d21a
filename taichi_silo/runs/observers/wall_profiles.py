"""Wall stresses against height in the paper's three states: `walls.csv`."""

import csv
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from taichi_silo.analysis.measure.overpressure import largest_overpressure
from taichi_silo.analysis.measure.wall_pressure import Reading, cell_mean, clear_of_corner
from taichi_silo.mpm.grid import MARGIN
from taichi_silo.runs.observers import Observer
from taichi_silo.simulation.wall_forces import LEFT, RIGHT, normal_and_shear
from taichi_silo.utils import atomic_write

SIDES = {"left": LEFT, "right": RIGHT}
BLOCK_PERIODS = 5  # of the column, whose mean makes a flow profile
MOST_BLOCKS = 64  # that are kept at a time; of more, those in which a wall stress was largest
BLOCK = ("sunk", "displacement", "profile")  # what is kept of a block
ROW = (  # and of a record
    "time_s", "stage", "displacement_m", "interval_s", "left_normal_N_per_m", "right_normal_N_per_m", "profile",
)  # fmt: skip


class WallProfiles(Observer):
    """Means of the nodal wall forces at the end of filling, at the greatest wall force, and at the end of flow."""

    def __init__(self, file: Path):
        self.file = file

    def begin(self, simulation) -> None:
        """Start with no state."""
        self.simulation, silo = simulation, simulation.scene.silo
        self.reading = Reading.of(silo.width_m, silo.height_m)
        self.period = simulation.scene.output.records_per_period
        self.full = BLOCK_PERIODS * self.period
        self.states: dict[str, tuple[float, float, np.ndarray]] = {}  # state: how far the grid sank, u, profile
        self.block: list[Any] = []  # the last records,
        self.fresh, self.largest = 0, 0.0  # how many of them no block has, and the largest N of a block
        self.history: list[tuple] = []  # time, displacement and profile of blocks of flow

    def state(self) -> dict:
        """Finished blocks, and as many of the last records as a mean may need."""
        columns = enumerate(("time", *BLOCK))
        return {
            "largest": self.largest,
            "states": {name: dict(zip(BLOCK, block, strict=True)) for name, block in self.states.items()},
            "block": {name: np.array([getattr(record, name) for record in self.block]) for name in ROW},
            "fresh": self.fresh,
            "history": {name: np.array([block[k] for block in self.history]) for k, name in columns},
        }

    def restore(self, simulation, kept: dict) -> None:
        """As it was."""
        self.begin(simulation)
        self.largest, self.fresh = kept["largest"], kept["fresh"]
        columns = [kept["block"].get(name, ()) for name in ROW]  # an empty block of an earlier version has no profile
        self.block = [SimpleNamespace(**dict(zip(ROW, row, strict=True))) for row in zip(*columns, strict=True)]
        self.states = {name: tuple(block[key] for key in BLOCK) for name, block in kept["states"].items()}
        history = [list(kept["history"][name]) for name in ("time", *BLOCK)]
        self.history = list(zip(*history, strict=True))

    def observe(self, record) -> None:
        """Gather blocks of records."""
        if self.block and self.block[-1].stage != record.stage:
            self._filled()
        self.block, self.fresh = [*self.block[1 - self.full :], record], self.fresh + 1
        if record.stage == "flow" and self.fresh == self.full:
            self._flowed()

    def _filled(self) -> None:
        """The state after filling: the mean over its last period."""
        self.states["filling"], _ = self._mean(self.period)
        self.block, self.fresh = [], 0

    def _flowed(self) -> None:
        """A block of flow is full."""
        here, normal = self._mean(self.full)
        self.history.append((self.block[-1].time_s, *here))
        if normal > self.largest:
            self.largest, self.states["maximum"] = normal, here
        self.fresh = 0
        if len(self.history) > MOST_BLOCKS:  # so that a long run needs no more memory than a short one
            told = {found["time_s"] for found in (self.overpressure() | self.largest_in_flow()).values()}
            self.history = [block for block in self.history if block[0] in told]

    def _mean(self, count: int) -> tuple[tuple, float]:
        """Over the last records: sunk, displacement and profile; and the normal force."""
        recent = self.block[-count:]
        span = sum(r.interval_s for r in recent)
        profile = sum(r.profile * r.interval_s for r in recent) / span
        normal = sum(0.5 * (r.left_normal_N_per_m + r.right_normal_N_per_m) * r.interval_s for r in recent) / span
        return (-self.simulation.origin_m, recent[-1].displacement_m, profile), normal

    def end(self) -> None:
        """Write the file."""
        if self.block and self.block[-1].stage == "flow":
            if not self.history:  # too short for a block
                self._flowed()
            self.states["residual"], _ = self._mean(self.full)
        elif self.block:
            self._filled()
        with atomic_write.written(self.file) as passing, open(passing, "w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(["state", "wall", "height_m", "normal_stress_Pa", "shear_stress_Pa"])
            for state in ("filling", "maximum", "residual"):
                if state in self.states:
                    self._write(writer, state, *self.states[state])

    def _write(self, writer, state: str, sunk: float, _displacement: float, profile: np.ndarray) -> None:
        scene, model = self.simulation.scene, self.simulation.model
        rows, columns = model.grid.rows, model.section.columns
        walls = dict(zip(model.wall_forces.names, profile, strict=True))
        for name, slots, origin in (("left", rows, -sunk), ("right", rows, -sunk), ("bottom", columns, 0.0)):
            h = scene.grid.cell_size_m if name == "bottom" else scene.cell_height_m
            coordinate, stress = wall_stress(walls[name][:slots], h, closed=name == "bottom")
            lowest = -np.inf if name == "bottom" else scene.silo.feet_m[SIDES[name]] + origin - 1e-9
            for place, n, t in zip(coordinate + origin, *normal_and_shear(name, stress), strict=True):
                if place >= lowest:  # below there is the wall of a hopper
                    writer.writerow([state, name, f"{place:.6g}", f"{n:.6g}", f"{t:.6g}"])
        for number, name in enumerate(model.wall_forces.bodies):
            if name.startswith("hopper"):
                for place, n, t in zip(*surface_stress(self.simulation, number, walls[name]), strict=True):
                    writer.writerow([state, name, f"{place:.6g}", f"{n:.6g}", f"{t:.6g}"])

    def after_filling_above(self, height_m: float) -> dict[str, tuple[float, float]]:
        """Normal and shear force after filling of the left and the right wall above a height [N/m]."""
        h, rows = self.simulation.scene.cell_height_m, self.simulation.model.grid.rows
        place = (np.arange(rows) - MARGIN) * h
        share = np.clip((place + 0.5 * h - height_m) / h, 0.0, 1.0)  # of what a node stands for, that lies above
        profile, found = self.states["filling"][2], {}
        for name, row in SIDES.items():
            normal, shear = normal_and_shear(name, share @ profile[row, :rows])
            found[name] = float(normal), float(shear)
        return found

    def overpressure(self) -> dict:
        """The largest normal stress on a wall over that after filling, as a pressure cell reads it; empty if none."""
        if not self.history or "filling" not in self.states:
            return {}
        h, rows = self.simulation.scene.cell_height_m, self.simulation.model.grid.rows

        def normal(profile):
            stresses = {name: wall_stress(profile[row, :rows], h, closed=False)[1] for name, row in SIDES.items()}
            return np.stack([normal_and_shear(name, stress)[0] for name, stress in stresses.items()])

        height = wall_stress(self.states["filling"][2][LEFT, :rows], h, closed=False)[0]
        above = height >= self.simulation.scene.silo.transition_m
        found = largest_overpressure(
            np.array([time for time, *_ in self.history]), height[above],
            np.stack([normal(profile)[:, above] for *_, profile in self.history]),
            normal(self.states["filling"][2])[:, above], np.array([u for _, _, u, _ in self.history]),
            self.reading,
        )  # fmt: skip
        if found.wall < 0:
            return {}
        return {
            "largest_overpressure": {
                "factor": found.factor,
                "wall": ("left", "right")[found.wall],
                "height_m": found.height_m,
                "time_s": found.time_s,
                "displacement_m": found.displacement_m,
                "normal_stress_Pa": found.stress_Pa,
                "after_filling_Pa": found.filling_stress_Pa,
            }
        }

    def largest_in_flow(self) -> dict:
        """The largest normal stress on a vertical wall of all means of flow, as a pressure cell reads it, if any.

        Without the corner; `height_m` is above the initial bottom.
        """
        scene, rows = self.simulation.scene, self.simulation.model.grid.rows
        found: dict = {}
        for time, sunk, displacement, profile in self.history:
            for name, row in SIDES.items():
                height, stress = wall_stress(profile[row, :rows], scene.cell_height_m, closed=False)
                above = height >= scene.silo.transition_m - 1e-9
                height, stress = height[above], normal_and_shear(name, stress[above])[0]
                read = cell_mean(height, stress, self.reading.cell_m)
                clear = np.flatnonzero(clear_of_corner(height, self.reading))
                if not len(clear):  # hardly any vertical wall above a hopper
                    continue
                k = clear[np.argmax(read[clear])]
                if read[k] > found.get("normal_stress_Pa", 0.0):
                    found = {
                        "normal_stress_Pa": float(read[k]), "wall": name, "height_m": float(height[k] - sunk),
                        "time_s": time, "displacement_m": displacement, "node_Pa": float(stress[clear].max()),
                    }  # fmt: skip
        return {"largest_wall_normal_stress_in_flow": found} if found else {}


def surface_stress(simulation, number: int, force: np.ndarray):
    """Heights [m], normal and shear stress [Pa] (upwards positive on the sand) of a hopper wall, by rows of nodes.

    `force` (slots, 2) is that of the wall on the sand at each row [N/m, or per radian].
    """
    surfaces, h = simulation.solver.surfaces, simulation.scene.cell_height_m
    wall = surfaces.first_wall + number
    area = surfaces.area_by_row(wall)
    normal = surfaces.normals[surfaces.owners == wall][0]
    tangent = np.array([-normal[1], normal[0]])
    tangent = tangent if tangent[1] > 0.0 else -tangent
    rows = np.flatnonzero((area > 0.25 * area.max()) & (np.arange(len(area)) >= MARGIN))
    force, area = force[rows], area[rows]
    return (rows - MARGIN) * h, -(force @ normal) / area, (force @ tangent) / area


def wall_stress(force: np.ndarray, cell_size_m: float, closed: bool) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (n) and stresses (n, 2) [Pa] along a wall from its nodal forces (slots, 2) [N/m].

    Nodes beyond the corner belong to the corner node, whose share of the wall is half a cell. `closed` says that
    the wall ends in a corner at its far side as well; else it ends at the sand's free surface.
    """
    force = force.copy()
    force[MARGIN] += force[:MARGIN].sum(axis=0)
    share = np.full(len(force), cell_size_m)
    share[MARGIN] = 0.5 * cell_size_m
    last = len(force) - 1
    if closed:
        last = len(force) - 1 - MARGIN
        force[last] += force[last + 1 :].sum(axis=0)
        share[last] = 0.5 * cell_size_m
    chosen = slice(MARGIN, last + 1)
    return (np.arange(len(force))[chosen] - MARGIN) * cell_size_m, force[chosen] / share[chosen, None]
