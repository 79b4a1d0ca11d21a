"""One run of the biaxial test, and what it leaves in its folder."""

import dataclasses
import json
import math
import time
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import rc_context
from rich.console import Console

from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.runs.run_folder import claim, write_tables
from taichi_silo.show.figures.style import STYLE
from taichi_silo.utils import vtu
from validation.biaxial.band import Band, shear_band
from validation.biaxial.compression import Biaxial
from validation.biaxial.figures import load_figure, specimens_figure
from validation.biaxial.scene import BiaxialScene

RESIDUAL_SHARE = 0.1  # of the shortening: the last part, whose mean is the residual angle


def leave(scene: BiaxialScene, folder: Path, overwrite: bool = False, keep: bool = False, say: bool = False) -> Path:
    """Run a scene and leave run.toml, curve.csv, points.npz, points.vtu, summary.json and figures.

    Parameters
    ----------
    scene : what to run.
    folder : where to leave it.
    overwrite : replace a run that is there.
    keep : leave a finished run of the same scene as it is.
    say : show the progress.

    Returns
    -------
    The folder.

    Raises
    ------
    BadInput
        before any work, if the folder cannot be used.
    RunFailed
        if the run went wrong, unless `keep`: a study shows where a method fails.

    """
    tables = scene.model_dump(mode="json", exclude_none=True)
    if keep and (folder / "scene.json").exists() and (folder / "summary.json").exists():
        same = json.loads((folder / "scene.json").read_text()) == _portable(tables)
        if same and "unfinished" not in summary_of(folder):
            return folder
    scene.machine.start()
    folder = claim(folder, overwrite)
    (folder / "scene.json").write_text(json.dumps(_portable(tables)))
    tables["averaging"]["characteristic_length_m"] = scene.averaging.length_m(scene.sand)
    write_tables(folder, tables, {"wall_seconds": 0.0})
    test, begun, rows, failure = Biaxial(scene), time.monotonic(), [], None
    console = Console(stderr=True)
    if say:
        console.print(test.about_averaging, highlight=False, soft_wrap=True)
    finished = False
    try:
        for number, row in enumerate(test.run()):
            rows.append(row)
            if say and number % 20 == 0:
                part = row.shortening / scene.shortening
                left = (time.monotonic() - begun) * (1.0 - part) / max(part, 1e-9)
                console.print(
                    f"{100 * part:5.1f} %  u/h = {100 * row.shortening:5.2f} %  friction angle "
                    f"{row.friction_angle_deg:5.2f} deg  {left:4.0f} s left", highlight=False,
                )  # fmt: skip
        finished = True
    except RunFailed as error:
        failure = error
        finished = keep
    finally:
        seconds = time.monotonic() - begun
        write_tables(folder, tables, {"wall_seconds": round(seconds, 3)})
        _write(folder, test, rows, seconds, failure, finished)
    if failure is not None and not keep:
        raise failure
    return folder


def run_case(scene: BiaxialScene, place: Path) -> str:
    """Run one case, unless it is there; says so, or why it cannot be run."""
    try:
        leave(scene, place, overwrite=True, keep=True)
    except BadInput as error:
        return str(error)
    return "done"


def _portable(tables: dict) -> dict:
    """Parameters less those of the machine: what decides whether a run is the same."""
    return {name: value for name, value in tables.items() if name != "machine"}


def _write(folder: Path, test: Biaxial, rows: list, seconds: float, failure, finished: bool) -> None:
    scene, points = test.scene, test.points()
    names = [f.name for f in dataclasses.fields(rows[0])] if rows else ["shortening", "friction_angle_deg"]
    curve = pd.DataFrame([dataclasses.asdict(row) for row in rows], columns=names)
    curve.to_csv(folder / "curve.csv", index=False, float_format="%.9g")
    np.savez_compressed(folder / "points.npz", **points)
    count = len(points["mass"])
    arrays = {
        "void_ratio": points["void_ratio"], "strain_path": points["path"], "stress_Pa": points["stress"],
        "velocity": vtu.spatial(points["velocity"]),
    }  # fmt: skip
    vtu.write(folder / "points.vtu", vtu.spatial(points["position"]), arrays)
    band = band_of(points, scene) if failure is None and np.isfinite(points["stress"]).all() else None
    steps = test.specimen.steps
    summary = {
        **({} if finished else {"unfinished": True}),
        **({} if failure is None else {"failure": str(failure)}),
        "averaging": test.about_averaging,
        **angles(curve),
        "band": None if band is None else _plain(band),
        "cost": {
            "points": count, "steps": steps, "seconds": seconds,
            "nanoseconds_per_particle_step": 1e9 * seconds / max(steps * count, 1),
        },
    }  # fmt: skip
    (folder / "summary.json").write_text(json.dumps(summary, indent=2, default=float) + "\n")
    if len(curve) < 2:
        return
    with rc_context(STYLE):
        (folder / "figures").mkdir(exist_ok=True)
        title = (
            f"Plane strain compression, $e_0$ = {scene.sand.void_ratio:.2f}, {scene.pressure_Pa / 1e3:g} kPa, "
            f"$l_c$ = {1e3 * scene.averaging.length_m(scene.sand):g} mm"
        )
        load_figure({"computed": curve}, title).savefig(folder / "figures" / "curve.png")
        for name in ("void_ratio", "path"):
            figure = specimens_figure({"": (points, scene.spacing_m, band)}, name, "")
            figure.savefig(folder / "figures" / f"{name}.png")


def angles(curve: pd.DataFrame) -> dict:
    """Peak and residual friction angle of a load curve."""
    if len(curve) < 2:
        return {}
    best = curve.friction_angle_deg.idxmax()
    last = curve.shortening >= curve.shortening.max() * (1.0 - RESIDUAL_SHARE)
    return {
        "peak_friction_angle_deg": float(curve.friction_angle_deg[best]),
        "peak_at_shortening": float(curve.shortening[best]),
        "residual_friction_angle_deg": float(curve.friction_angle_deg[last].mean()),
        "peak_is_last": bool(best > 0.97 * len(curve)),
    }


def _plain(band: Band) -> dict:
    if not band.found:
        return {"found": False}
    plain = {
        "found": True, "inclination_deg": band.inclination_deg,
        "inclination_error_deg": band.inclination_error_deg,
    }  # fmt: skip
    for name in ("thickness_m", "loose_thickness_m", "strain"):
        plain[name] = dataclasses.asdict(getattr(band, name))
    return {key: None if isinstance(v, float) and math.isnan(v) else v for key, v in plain.items()}


def band_of(points: dict, scene: BiaxialScene) -> Band:
    """The shear band; the weak element, loose from the start, is left out."""
    ours = points["initial_void_ratio"] < 0.5 * (scene.sand.void_ratio + scene.weak_void_ratio)
    if scene.weak_void_ratio <= scene.sand.void_ratio:
        ours = np.ones(len(points["mass"]), dtype=bool)
    return shear_band(
        points["position"][ours], points["path"][ours], points["void_ratio"][ours], scene.spacing_m
    )  # fmt: skip


def summary_of(folder: Path) -> dict:
    """The summary.json of a run."""
    return json.loads((folder / "summary.json").read_text())
