"""What all scenarios of a silo share: the flags of sand, walls, grid, flow and method, and what is done with them."""

from dataclasses import dataclass
from pathlib import Path

from taichi_silo.cli import flags, model_silo
from taichi_silo.cli.command_line import explain, tell
from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.runs.observers.progress import ProgressLine
from taichi_silo.runs.run_folder import free_name
from taichi_silo.runs.session import run
from taichi_silo.scene import fidelity as fidelities
from taichi_silo.scene import sands
from taichi_silo.scene.scene import Averaging, Filling, Flow, Machine, Mesh, Method, Output, Scene, Walls
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.console import Console

SAND_FLAGS = {
    "void_ratio": (float, 0.60, "initial void ratio of the sand [-], between e_d0 and e_i0"),
    "sand": (flags.SandFlag, "karlsruhe", ""),
    "law": (flags.LawFlag, "auto", ""),
    "walls": (str, "very-rough", "smooth | very-rough"),
    "wall_friction_angle": (
        float | None, None,
        "of smooth walls [deg]; 19 for dense and 12.3 for loose sand (from e = 0.75) if not given",
    ),
    "bottom_friction_angle": (float, 0.0, "of the bottom plate or floor [deg]"),
    "filling": (str, "gravity-ramp", "gravity-ramp (all sand in place, its weight grows) | layers | rain"),
    "layers": (int, 20, "number of layers, with --filling layers"),
    "drop": (float, 0.02, "height of fall, with --filling rain [m]"),
}  # fmt: skip
FLOW_FLAGS = {
    "speed": (float | None, None, "of the bottom or the gate [m/s]; 0.002 in standard fidelity"),
    "displacement": (float, 0.02, "of the bottom or the gate at the end [m]"),
}
GRID_FLAGS = {
    "half": (str, "auto", "auto | yes | no: compute one half of a symmetric silo and mirror it"),
    "fidelity": (str, "standard", "draft | standard | converged: cell size and speed where they are not given"),
    "cell_size": (float | None, None, "of the grid [m]; divides width and height; 0.005 in standard fidelity"),
    "points_per_cell": (int | None, None, "1, 4, 9, ...; 1 if not given"),
    "shape": (flags.ShapeFlag, "ugimp", ""),
    "characteristic_length": (flags.LengthFlag, None, ""),
    "weight": (flags.WeightFlag, "gaussian", ""),
    "noise_control": (str, "column", "column | none; none is the paper's 'no damping'"),
}  # fmt: skip
RUN_FLAGS = {
    "threads": (int | None, None, "CPU threads; all up to 2 if not given"),
    "arch": (str, "cpu", "cpu | cuda"),
    "output": (Path | None, None, "folder of the run; outputs/... if not given"),
    "overwrite": (bool, False, ("--overwrite", "replace a run in the output folder")),
    "film": (bool, True, "draw void_ratio.mp4"),
    "records_per_period": (int, 10, "rows of forces.csv in one period of the column, 4 to 100"),
    "snapshots": (
        int | None,
        None,
        "states of all points over the flow, for films of them; 100 (fewer of more than 100,000 points) if not given",
    ),
    "explain": (flags.ExplainFlag, False, ""),
    "quiet": (QuietFlag, False, ""),
    "json": (JsonFlag, False, ""),
}


@dataclass(frozen=True)
class Common:
    """The values of these flags.

    Attributes
    ----------
    values : by name.

    """

    values: dict

    def __getattr__(self, name: str):
        if name == "values" or name not in self.values:
            raise AttributeError(name)
        return self.values[name]

    def scene(self, silo: Silo, flow: Flow | None = None) -> Scene:
        """The scene of a silo; `flow` stands for the flags of controlled flow."""
        machine = {"arch": self.arch} | ({} if self.threads is None else {"threads": self.threads})
        chosen = fidelities.fidelity(self.fidelity)
        speed, angle = self.values.get("speed"), self.wall_friction_angle
        if self.walls == "smooth" and angle is None:
            angle = model_silo.smooth_angle_deg(self.void_ratio)
        return Scene(
            silo=silo,
            sand=sands.sand(self.sand, self.void_ratio, law=self.law),
            walls=Walls(
                kind=self.walls,
                friction_angle_deg=angle,
                bottom_friction_angle_deg=self.bottom_friction_angle,
            ),
            grid=Mesh(
                shape=self.shape,
                **chosen.values("grid", cell_size_m=self.cell_size, points_per_cell=self.points_per_cell),
            ),
            averaging=Averaging(characteristic_length_m=self.characteristic_length, weight=self.weight),
            filling=Filling(kind=self.filling, layers=self.layers, drop_m=self.drop),
            flow=flow or Flow(displacement_m=self.displacement, **chosen.values("flow", speed_m_per_s=speed)),
            method=Method(noise_control=self.noise_control, **flags.method(self.values)),
            output=Output(records_per_period=self.records_per_period, snapshots=self.snapshots),
            machine=Machine(**machine),
        )

    def run(self, silo: Silo, name: str, flow: Flow | None = None) -> Path | None:
        """Run it, or explain it; the folder is outputs/NAME_e..._walls unless it is given."""
        scene, console = self.scene(silo, flow), Console(self.quiet, self.json)
        if self.cell_size is None and self.points_per_cell is None and self.values.get("speed") is None:
            console.say(f"Fidelity {self.fidelity}: {fidelities.fidelity(self.fidelity).words()}.")
        if self.explain:
            explain(scene)
            return None
        folder = self.output.expanduser() if self.output else None
        folder = folder or free_name(Path("outputs") / f"{name}_e{self.void_ratio:.2f}_{self.walls}")
        console.say(f"The run goes to {folder}.")
        lines = ProgressLine(console.terminal)
        tell(run(scene, folder, overwrite=self.overwrite, film=self.film, extra=(lines,)), console)
        return folder


class Controlled(Common):
    """With those of controlled flow."""


class Free(Common):
    """Without."""


_OTHERS = {**GRID_FLAGS, **RUN_FLAGS, **flags.METHOD_FLAGS}
flags.GROUPS[Controlled] = flags.Group({**SAND_FLAGS, **FLOW_FLAGS, **_OTHERS}, Controlled)
flags.GROUPS[Free] = flags.Group({**SAND_FLAGS, **_OTHERS}, Free)
