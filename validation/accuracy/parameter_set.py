"""A parameter set of the chart: a scene, run in a process of its own, and the few numbers that are kept of it.

Run as a program, it reads a parameter set from its input and leaves a file; the environment variable
TAICHI_SILO_PRECISION says in which precision.
"""

import dataclasses
import hashlib
import json
import sys
import time
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd
from pydantic_core import to_json

from taichi_silo.analysis.measure.void_ratio_zones import wall_zone_thickness_m
from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.runs.certificate import certificate
from taichi_silo.runs.cost_estimate import predict
from taichi_silo.runs.observers import Observer
from taichi_silo.runs.observers.guard import Guard
from taichi_silo.scene.dotted_paths import OUTSIDE, changed
from taichi_silo.scene.scene import Machine, Scene
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.utils import atomic_write
from taichi_silo.utils.child_process import given
from taichi_silo.utils.schema import Options
from validation.accuracy.curves import Curves, WallProfile

FORMAT = 1  # of the files; those of another one are made anew
NUDGE = 1e-12  # of the places at the start, over the spacing: what rounding might do


class ParameterSet(Options):
    """Scene of a run, precision of its numbers, and number of the perturbation of its start (0: none)."""

    scene: Scene
    precision: Literal["f64", "f32", "mixed"] = "f64"
    nudge: int = 0

    @property
    def key(self) -> str:
        """Hash of all that changes the result."""
        tables = self.model_dump(mode="json", exclude={"scene": {"machine"}})
        return hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16]


def parameter_set(scene: Scene, settings: dict) -> ParameterSet:
    """A scene with some settings changed; on one thread, so that it repeats itself."""
    tables = changed(scene, settings).model_copy(update={"machine": Machine(arch=scene.machine.arch, threads=1)})
    return ParameterSet(scene=tables, **{name: settings[name] for name in OUTSIDE if name in settings})


def file_of(one: ParameterSet, folder: Path) -> Path:
    """Where the numbers of a run are kept."""
    return folder / f"{one.key}.json"


def kept(one: ParameterSet, folder: Path) -> dict | None:
    """The numbers of a finished run; None if there are none that can be read."""
    try:
        found = json.loads(file_of(one, folder).read_text())
        return found if found["format"] == FORMAT else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


class Records(Observer):
    """Everything of the records but their profiles, and the state after filling."""

    def begin(self, simulation) -> None:
        """Start with nothing."""
        self.simulation, self.rows, self.after_filling = simulation, [], None

    def observe(self, record) -> None:
        """Keep the numbers."""
        row = {f.name: getattr(record, f.name) for f in dataclasses.fields(record) if f.name != "profile"}
        derived = ("normal_N_per_m", "shear_N_per_m", "residual_N_per_m")
        self.rows.append(row | {name: getattr(record, name) for name in derived})

    def filled(self) -> None:
        """Keep the state."""
        self.after_filling = self.state()

    def state(self) -> dict:
        """Present state of the points, with displacement and time."""
        simulation = self.simulation
        return simulation.points() | {"displacement_m": simulation.displacement, "time_s": simulation.time}


def simulate(one: ParameterSet) -> dict:
    """Run a parameter set and return what is kept of it; Taichi has been started.

    Returns
    -------
    curves: P, T, N over the bottom displacement; profile: wall normal stress over height; zone_thickness_m; residual:
    means over the last fifth of the displacement; certificate; cost; failure: why the run went wrong, or None.

    """
    scene, failure = one.scene, None
    simulation = Simulation(scene)
    if one.nudge:
        model, random = simulation.model, np.random.default_rng(one.nudge)
        arrays = model.particles.arrays()
        shift = NUDGE * model.spacing * random.standard_normal(arrays["position"].shape)
        model.particles.load(arrays | {"position": arrays["position"] + shift})
    expected = predict(simulation)
    begun = time.process_time()
    records, profile = Records(), WallProfile()
    observers = (records, profile, Guard())
    for observer in observers:
        observer.begin(simulation)
    try:
        for stage in (simulation.fill, simulation.flow):
            for record in stage():
                for observer in observers:
                    observer.observe(record)
            if stage == simulation.fill:
                for observer in observers:
                    observer.filled()
    except RunFailed as error:
        failure = str(error)
    # on a quiet machine the first; on one that others use or halt, the processor's own time
    spent = min(simulation.clock.stepping_seconds * runtime.threads(), time.process_time() - begun)
    rows = pd.DataFrame(records.rows)
    found = {
        "format": FORMAT,
        "point": one.model_dump(mode="json"),
        "failure": failure,
        "warnings": simulation.warnings,
        "cost": {
            "points": scene.points,
            "steps": simulation.clock.steps,
            "time_step_s": simulation.time / max(simulation.clock.steps, 1),
            "core_seconds": spent,
            "predicted_steps": expected.steps,
            "predicted_core_seconds": expected.core_seconds,
        },
    }
    if failure is None:
        curves = Curves.of(rows[rows.stage == "flow"], scene.flow.displacement_m)
        found |= {
            "curves": dataclasses.asdict(curves),
            "residual": curves.residual(),
            "profile": profile.smooth(),
            "zone_thickness_m": zone_thickness_m(records.after_filling, records.state(), scene),
            "certificate": certificate(rows, records.after_filling, records.state(), simulation),
        }
    return found


def zone_thickness_m(filled: dict, now: dict, scene: Scene) -> float:
    """Mean of both walls' shear zones (medians over the rows of points); 0 where there is none."""
    position = now["position"] + [0.0, now["displacement_m"]]
    sides = [
        wall_zone_thickness_m(position, now["void_ratio"], filled["void_ratio"], scene.silo.width_m, side=side)
        for side in ("left", "right")
    ]
    return float(np.mean([zone.median_m for zone in sides]))


def leave(one: ParameterSet, folder: Path) -> None:
    """Run a parameter set and leave its file, whole or not at all."""
    found = simulate(one)
    with atomic_write.written(file_of(one, folder)) as passing:  # null for what is not finite
        passing.write_bytes(to_json(found, inf_nan_mode="null", fallback=lambda value: value.tolist()))


if __name__ == "__main__":
    try:
        wanted = ParameterSet.model_validate_json(given())
        runtime.init(wanted.scene.machine.arch, wanted.scene.machine.threads)
        leave(wanted, Path(sys.argv[1]))
    except KeyboardInterrupt:
        sys.exit(130)
