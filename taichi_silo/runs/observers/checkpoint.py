"""The state from which a run goes on: `checkpoint.npz`, and the one before it."""

import time
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.runs.observers import Observer
from taichi_silo.runs.run_folder import CHECKPOINT
from taichi_silo.scene.scene import Scene
from taichi_silo.utils import atomic_write, checked_npz
from taichi_silo.utils.schema import one_sentence

NAME, PREVIOUS = CHECKPOINT, "checkpoint.previous.npz"


class Checkpoint(Observer):
    """Written at the start, as often as the scene asks for, after filling, and by `write` wherever the run stops.

    It holds the scene, the simulation, and the state of every other observer; all of them have seen the last record. A
    state that is not finite never replaces a good one.

    Parameters
    ----------
    folder : of the run.
    observers : by name.
    begun : what an earlier process kept under "run", if this one goes on.

    """

    def __init__(self, folder: Path, observers: dict[str, Observer], begun: dict | None = None):
        begun = begun or {"filled": False, "resumed": -1, "wall_seconds": 0.0}
        self.folder, self.observers = folder, observers
        self.after_filling, self.resumed = begun["filled"], begun["resumed"] + 1
        self.started = time.monotonic() - begun["wall_seconds"]
        self.warned = False

    @property
    def wall_seconds(self) -> float:
        """Of the run, in all its processes, up to now."""
        return time.monotonic() - self.started

    def begin(self, simulation) -> None:
        """Write, so that whatever comes the run can go on; all others have begun."""
        self.simulation = simulation
        self.write()

    def restore(self, simulation, kept: dict) -> None:
        """Go on from what is there."""
        self.simulation = simulation
        self._wait()

    def observe(self, record) -> None:
        """Write when due."""
        if time.monotonic() >= self.due:
            self.write()

    def filled(self) -> None:
        """Write: the filling need not be done again."""
        self.after_filling = True
        self.write()

    def _wait(self) -> None:
        self.due = time.monotonic() + self.simulation.scene.output.checkpoint_s  # which no change of the date moves

    def write(self) -> None:
        """Write, in one piece or not at all; the run outlives one that cannot be written, with a warning.

        Raises
        ------
        OSError
            if the folder is gone, or another file cannot be brought to the disk.

        """
        self._wait()
        simulation = self.simulation.state()
        if not all(np.isfinite(values).all() for values in simulation["points"].values()):
            return
        kept = {
            "run": {"filled": self.after_filling, "resumed": self.resumed, "wall_seconds": self.wall_seconds},
            "scene": self.simulation.scene.model_dump(mode="json"),
            "simulation": simulation,
            "observers": {name: observer.state() for name, observer in self.observers.items()},
        }
        try:
            with atomic_write.written(self.folder / NAME, self.folder / PREVIOUS) as passing:
                checked_npz.write(passing, kept)
        except OSError as error:
            if not self.folder.is_dir():
                raise
            if not self.warned:
                self.warned = True
                self.simulation.warnings.append(
                    f"{self.folder / NAME} could not be written ({error.strerror or error}); an interrupted run would "
                    "go on from an earlier state."
                )


def scene_of(kept: dict, threads: int | None = None) -> Scene:
    """The scene of what a checkpoint holds; on so many threads, if they are given.

    Raises
    ------
    BadInput
        if it is not possible on this machine.

    """
    changed = {} if threads is None else {"threads": threads}
    try:
        return Scene.model_validate(kept["scene"] | {"machine": kept["scene"]["machine"] | changed})
    except ValidationError as error:
        raise BadInput(one_sentence(error)) from error


def is_there(folder: Path) -> bool:
    """Whether a folder holds a checkpoint, sound or not."""
    return any((folder / name).exists() for name in (NAME, PREVIOUS))


def latest(folder: Path) -> tuple[dict, list[str]]:
    """What the newest sound checkpoint of a folder holds, and sentences on what had to be passed over.

    Raises
    ------
    BadInput
        if there is none.

    """
    troubles = []
    for name in (NAME, PREVIOUS):
        try:
            header, kept = checked_npz.read(folder / name)
        except (checked_npz.Damaged, FileNotFoundError) as error:
            troubles.append(f"{name} is {'damaged' if isinstance(error, checked_npz.Damaged) else 'missing'}")
            continue
        clock = kept["simulation"]["clock"]
        words = [f"{troubles[0]}; the run goes on from {name}, at t = {clock['time']:.4f} s."] if troubles else []
        written, present = header["taichi_silo"], checked_npz.version("taichi-silo")
        if written != present:
            words.append(f"The run was begun with taichi-silo {written} and goes on with {present}.")
        return kept, words
    raise BadInput(f"{folder} cannot be resumed: {' and '.join(troubles)}")
