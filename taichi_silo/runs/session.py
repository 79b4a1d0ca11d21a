"""One run: a scene, its observers, and the folder they leave; and the same run, resumed after it was left."""

import functools
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from taichi_silo.errors import BadInput, MachineFailed, Stopped
from taichi_silo.mpm import one_taichi, runtime
from taichi_silo.runs import run_folder, snapshot
from taichi_silo.runs.observers import Observer, checkpoint
from taichi_silo.runs.observers.checkpoint import Checkpoint
from taichi_silo.runs.observers.forces import BALANCE, FORCES, Table
from taichi_silo.runs.observers.guard import Guard
from taichi_silo.runs.observers.log import Log
from taichi_silo.runs.observers.outflow import Outflow
from taichi_silo.runs.observers.snapshots import Snapshots
from taichi_silo.runs.observers.summary import Summary
from taichi_silo.runs.observers.wall_profiles import WallProfiles
from taichi_silo.scene import memory_need
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils import bounded_reading, checked_npz, file_lock
from taichi_silo.utils.machine_faults import of_machine
from taichi_silo.utils.signals import BEFORE, Stops, heard

STILL = "stopped before the run went on; nothing has changed, and `%s` goes on with it"
DRAWING = "stopped while film and figures were drawn; all else is there, and `%s` draws them"

Draw = Callable[[Path], str | None]  # makes pictures of what a folder holds; returns a sentence if it could not


def run(
    scene: Scene, folder: Path, *, overwrite: bool = False, extra: tuple[Observer, ...] = (),
    drawing: tuple[Draw, ...] = (),
) -> Path:  # fmt: skip
    """Simulate a scene and leave its folder; `api.run` says more.

    Parameters
    ----------
    scene, folder, overwrite : what to simulate, where to leave it, and whether to replace a run that is there.
    extra : further observers.
    drawing : what draws the run at its end, one after the other.

    """
    with one_taichi.held(), heard() as stops, run_folder.none_left_empty(folder):
        with stops.at_once(BEFORE):
            memory_need.check(scene)
            scene.machine.start()
            folder = run_folder.free(folder, overwrite)
        with file_lock.held(folder):
            with stops.at_once(BEFORE):
                session = _Session(scene, run_folder.free(folder, overwrite), _named(extra), drawing)
                session.prepare()
            run_folder.claim(folder, overwrite)
            session.go(stops)
    return folder


def resume(
    folder: Path, *, threads: int | None = None, extra: tuple[Observer, ...] = (), drawing: tuple[Draw, ...] = ()
) -> Path:
    """Go on with a run that was left, however it ended; `api.resume` says more.

    Parameters
    ----------
    folder, threads : of the run; as many CPU threads as before if not given.
    extra : further observers; each takes up what one of its kind kept, see `Observer.joins`.
    drawing : as in `run`.

    """
    folder = bounded_reading.place(folder, "folder")
    if run_folder.finished(folder):
        return folder
    if not checkpoint.is_there(folder):
        what = "holds no checkpoint to go on from" if folder.is_dir() else "does not exist"
        raise BadInput(f"folder is {folder}; it must be that of a run that was begun, but it {what}")
    with one_taichi.held(), heard() as stops, file_lock.held(run_folder.own(folder)):
        with stops.at_once(STILL % run_folder.go_on(folder)):
            with checked_npz.understood(folder):
                kept, words = checkpoint.latest(folder)
                checked_npz.need(kept, "run.filled", "run.resumed", "run.wall_seconds", "observers.forces",
                             "simulation.points", "simulation.clock.time")  # fmt: skip
                scene, states = checkpoint.scene_of(kept, threads), kept["observers"]
                joining = {name: one for name, one in _named(extra).items() if one.joins(states.get(name))}
            run_folder.same_scene(folder, scene)
            memory_need.check(scene)
            scene.machine.start()
            session = _Session(scene, folder, joining, drawing, kept, words)
        session.go(stops)
    return folder


def _named(extra: tuple[Observer, ...]) -> dict[str, Observer]:
    """Observers by the names under which a checkpoint keeps their states: class, and number within the class."""
    count: Counter[str] = Counter()
    named: dict[str, Observer] = {}
    for one in extra:
        kind = type(one).__name__
        named[f"{kind}_{count[kind]}"] = one
        count[kind] += 1
    return named


class _Session:
    """The part of a run that one process does.

    Parameters
    ----------
    scene, folder, drawing : see `run`.
    extra : further observers by their names.
    kept : what a checkpoint holds, if the run goes on from one.
    words : warnings that belong to it.

    """

    def __init__(
        self, scene: Scene, folder: Path, extra: dict[str, Observer], drawing: tuple[Draw, ...],
        kept: dict | None = None, words: list[str] | tuple = (),
    ):  # fmt: skip
        self.folder, self.drawing, self.kept = folder, drawing, kept
        self.simulation = Simulation(scene)
        if kept:
            with checked_npz.understood(folder):
                self.simulation.restore(kept.pop("simulation"))
        self.simulation.warnings += words
        profiles = WallProfiles(folder / "walls.csv")
        self.summary = Summary(folder / "summary.json", profiles)
        self.log = Log(folder / "run.log")
        model = self.simulation.model
        self.observers: dict[str, Observer] = {
            "forces": Table(folder / "forces.csv", FORCES, bodies=True),
            "balance": Table(folder / "balance.csv", BALANCE),
            **({} if model.gates is None else {"outflow": Outflow(folder / "outflow.csv", len(model.openings))}),
            "profiles": profiles,
            "snapshots": Snapshots(folder, snapshot.shown_displacements(scene.flow), scene.snapshots),
            "summary": self.summary,  # after those whose files it reads
            **extra,
            "guard": Guard(folder),  # after the others: they have seen what it stops at
            "log": self.log,
        }
        self.checkpoint = Checkpoint(folder, self.observers, kept["run"] if kept else None)

    def prepare(self) -> None:
        """What is done and asked before anything is written."""
        for observer in self.observers.values():
            observer.prepare(self.simulation)

    def go(self, stops: Stops) -> None:
        """Begin, or go on, and leave everything that a run leaves."""
        begun: list[Observer] = []
        ended = None
        try:
            self._work(begun, stops)
        except BaseException as error:  # noqa: BLE001 - whatever ends it, its files are put in order first
            ended = self._in_words(error)
            for observer in begun:
                observer.failed(str(ended) or type(ended).__name__)
        troubles = self._end(begun, stops, draw=not isinstance(ended, Stopped))
        if self.folder.is_dir():
            try:
                self._note(finished=ended is None and not troubles)
            except OSError as error:
                troubles.append(error)
        if ended is not None or troubles:
            raise ended or self._in_words(troubles[0])

    def _work(self, begun: list[Observer], stops: Stops) -> None:
        """All that may go wrong midway; `begun` gathers the observers that have begun."""
        for name, observer in (self.observers | {"checkpoint": self.checkpoint}).items():
            begun.append(observer)
            if self.kept is None:
                observer.begin(self.simulation)
            else:
                with checked_npz.understood(self.folder):
                    observer.restore(self.simulation, self.kept["observers"].pop(name, {}))
        self._note()
        self._simulate(begun, stops.check)

    def _simulate(self, observers: list[Observer], check: Callable) -> None:
        """Fill and flow, as far as that is not done yet."""

        def show(record) -> None:
            for observer in observers:
                observer.observe(record)
            check(lambda: f"stopped at {self._when()}; `{run_folder.go_on(self.folder)}` goes on from there")

        try:
            for record in self.simulation.fill():
                show(record)
            if not self.checkpoint.after_filling:
                for observer in observers:
                    observer.filled()
            for record in self.simulation.flow():
                show(record)
        except Stopped:
            self.checkpoint.write()
            raise
        self.checkpoint.write()

    def _end(self, begun: list[Observer], stops: Stops, draw: bool) -> list[BaseException]:
        """End all observers, draw, and end the log; returns what went wrong.

        A run that was stopped is not drawn, so that it ends at once; `taichi-silo report` and `resume` draw it.
        """
        troubles = _tried(*(observer.end for observer in begun if observer is not self.log))
        if draw and self.folder.is_dir():
            troubles += self._draw(stops)
        return troubles + _tried(*(observer.end for observer in begun if observer is self.log))

    def _draw(self, stops: Stops) -> list[BaseException]:
        """Draw what can be drawn; sentences on the rest become warnings. A stop leaves out what is not drawn yet.

        On the processor: pictures take whole numbers of 64 bits, which not every graphics card adds up.
        """
        troubles: list[BaseException] = []
        warnings: list[str | None] = []

        def attempt(draw: Draw) -> None:
            warnings.append(draw(self.folder))

        try:
            with stops.at_once(DRAWING % run_folder.go_on(self.folder)):
                if self.drawing and not runtime.is_cpu():
                    runtime.init("cpu", runtime.threads())
                for draw in self.drawing:
                    troubles += _tried(functools.partial(attempt, draw))
        except Stopped as stop:
            troubles.append(stop)
        if told := [sentence for sentence in warnings if sentence]:
            self.simulation.warnings.extend(told)
            troubles += _tried(self.summary.tell_warnings)
        return troubles

    def _in_words(self, error: BaseException) -> BaseException:
        """The error; of the machine, one that says when, what, and what to do."""
        found = of_machine(error)
        if found is None:
            return error
        what, remedy = found
        further = f"`{run_folder.go_on(self.folder)}` goes on from its last checkpoint"
        if not self.folder.is_dir():
            what = f"the folder {self.folder} was gone, and {what}"
            further = "`taichi-silo resume` goes on; if it was removed, begin again"
        elif not checkpoint.is_there(self.folder):
            further = "begin again"
        failed = MachineFailed(f"stopped at {self._when()} because {what}; {remedy}, then {further}")
        failed.__cause__ = error
        return failed

    def _when(self) -> str:
        s = self.simulation
        return f"t = {s.time:.4f} s ({s.stage}, u = {1e3 * s.displacement:.3f} mm)"

    def _note(self, finished: bool = False) -> None:
        """Write run.toml."""
        done = {"wall_seconds": round(self.checkpoint.wall_seconds, 3), "finished": finished}
        run_folder.write_parameters(self.folder, self.simulation.scene, done | {"resumed": self.checkpoint.resumed})


def _tried(*steps: Callable[[], object]) -> list[BaseException]:
    """Do all steps; one that goes wrong does not keep the others from it. Returns what went wrong."""
    troubles: list[BaseException] = []
    for step in steps:
        try:
            step()
        except Exception as error:  # noqa: BLE001 - told by the caller
            troubles.append(error)
    return troubles
