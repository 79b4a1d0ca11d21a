"""What a run left, for Python: tables as frames, states of the sand as arrays, the film."""

import base64
import os
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.run_folder import MADE
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import shown

FILM = "void_ratio.mp4"


class Result(os.PathLike):
    """A run's folder, whose files are read when they are asked for; it stands for its path wherever one is wanted.

    Parameters
    ----------
    folder : of a run.

    Raises
    ------
    BadInput
        if it holds no run.

    """

    def __init__(self, folder: str | os.PathLike):
        self.folder = bounded_reading.place(folder, "folder")
        if not (self.folder / MADE).is_file():
            raise BadInput(f"folder is {self.folder}; it must be that of a run, which has a {MADE}")

    def __fspath__(self) -> str:
        return str(self.folder)

    def __truediv__(self, name: str) -> Path:
        return self.folder / name

    def __repr__(self) -> str:
        state = "finished" if self.finished else "not finished"
        return f"Result({str(self.folder)!r}: {state})"

    @cached_property
    def scene(self) -> Scene:
        """What was run."""
        return read_scene(self.folder / MADE)

    @cached_property
    def program(self) -> dict:
        """Versions and time: what computed it."""
        return bounded_reading.toml(self.folder / MADE, "a run").get("program", {})

    @cached_property
    def summary(self) -> dict:
        """Peaks, residuals, certificate, measures; empty if the run has not ended."""
        file = self.folder / "summary.json"
        return bounded_reading.tables(file) if file.exists() else {}

    @property
    def finished(self) -> bool:
        """Whether the run came to its end."""
        return bool(self.summary.get("finished", False))

    @cached_property
    def forces(self) -> pd.DataFrame:
        """`forces.csv`: a row an interval; normals positive in compression, shears where the wall carries weight."""
        return bounded_reading.frame(self.folder / "forces.csv")

    @property
    def flow(self) -> pd.DataFrame:
        """The rows of flow."""
        return self.forces[self.forces.stage == "flow"].reset_index(drop=True)

    @cached_property
    def balance(self) -> pd.DataFrame:
        """`balance.csv`: how far forces, weight and momentum balance."""
        return bounded_reading.frame(self.folder / "balance.csv")

    @cached_property
    def walls(self) -> pd.DataFrame:
        """`walls.csv`: wall stresses after filling, at the largest N, and at the end."""
        return bounded_reading.frame(self.folder / "walls.csv")

    @cached_property
    def snapshots(self) -> pd.DataFrame:
        """Stored states: file, stage, time_s, displacement_m."""
        return bounded_reading.frame(self.folder / "snapshots" / "index.csv")

    def state(self, which: str | int = -1) -> dict[str, np.ndarray]:
        """All points of a stored state, as `Simulation.points` gives them.

        `position` (n, 2) [m], `velocity` (n, 2) [m/s], `void_ratio`, `stress` (xx, yy, zz, xy; tension positive) [Pa],
        `volume` [m2/m], `mass` [kg/m], `path` of the strain, `identity`.

        Parameters
        ----------
        which : the row of `snapshots`, from the end if negative, or the file's name without its suffix ("filled").

        Raises
        ------
        BadInput
            if there is no such state.

        """
        names = [Path(file).stem for file in self.snapshots.file]
        numbers = range(-len(names), len(names))
        if isinstance(which, bool) or which not in (names if isinstance(which, str) else numbers):
            named = [name for name in names if not name.startswith(snapshot.BETWEEN)]
            right = f"one of {', '.join(named)}, or its number in `snapshots`"
            raise BadInput(f"state is {shown(which)}; it must be {right}")
        name = which if isinstance(which, str) else names[which]
        return snapshot.read(self.folder / "snapshots" / f"{name}.vtu")

    @property
    def film(self) -> Path | None:
        """The film of void ratio, if one was drawn."""
        file = self.folder / FILM
        return file if file.exists() else None

    @property
    def figures(self) -> dict[str, Path]:
        """Figures by their names."""
        return {file.stem: file for file in sorted((self.folder / "figures").glob("*.png"))}

    def _repr_html_(self) -> str:
        """In a notebook: the film, or else the force curves, and the numbers that matter."""
        residual = self.summary.get("residual", {})
        names = {"P": "bottom_N_per_m", "T": "shear_N_per_m", "N": "normal_N_per_m"}
        known = {p: residual[n] / 1e3 for p, n in names.items() if residual.get(n) is not None}
        numbers = ", ".join(f"{p} = {value:.3f} kN/m" for p, value in known.items())
        shown = f"<p><code>{self.folder}</code> {'at the end: ' + numbers if numbers else 'has not ended'}</p>"
        if self.film is not None:
            data = base64.b64encode(self.film.read_bytes()).decode()
            return f'{shown}<video controls width="720" src="data:video/mp4;base64,{data}"></video>'
        if "forces" in self.figures:
            data = base64.b64encode(self.figures["forces"].read_bytes()).decode()
            return f'{shown}<img width="720" alt="forces" src="data:image/png;base64,{data}">'
        return shown
