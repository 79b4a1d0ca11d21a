"""One run of the biaxial test with what it leaves in its folder, and the studies of the paper's section 5."""

import dataclasses
import json
import math
import time
from dataclasses import dataclass, field
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
from matplotlib import rc_context
from rich.console import Console

from taichi_silo import runtime
from taichi_silo.biaxial import Biaxial, BiaxialScene
from taichi_silo.element import TESTS, friction_angle_deg, through_point
from taichi_silo.faults import RunFailed
from taichi_silo.folder import claim, write_tables
from taichi_silo.laws.stress_point import StressPoint
from taichi_silo.measure.band import Band, shear_band
from taichi_silo.plots.biaxial import load_figure, specimens_figure
from taichi_silo.plots.style import STYLE
from taichi_silo.theory.bifurcation import first_bifurcation

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
    runtime.init(scene.machine.arch, scene.machine.threads)
    folder = claim(folder, overwrite)
    (folder / "scene.json").write_text(json.dumps(_portable(tables)))
    tables["averaging"]["characteristic_length_m"] = scene.characteristic_length_m
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
    mesh = meshio.Mesh(
        np.column_stack([points["position"], np.zeros(count)]), [("vertex", np.arange(count)[:, None])],
        point_data={
            "void_ratio": points["void_ratio"], "strain_path": points["path"], "stress_Pa": points["stress"],
            "velocity": np.column_stack([points["velocity"], np.zeros(count)]),
        },
    )  # fmt: skip
    mesh.write(folder / "points.vtu", file_format="vtu")
    band = band_of(points, scene) if np.isfinite(points["stress"]).all() else None
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
            f"$l_c$ = {1e3 * scene.characteristic_length_m:g} mm"
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
    plain = {
        "found": band.found, "inclination_deg": band.inclination_deg,
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


# --- theory -----------------------------------------------------------------------------------------------------------


def theory(void_ratio: float, pressure_Pa: float, scene: BiaxialScene) -> dict:
    """What the law alone gives: homogeneous peak and dilatancy there, first bifurcation, and Roscoe's angle."""
    law = scene.sand.model_copy(update={"void_ratio": void_ratio}).constitutive_law()
    test = TESTS["plane-strain"]
    rows = np.array(list(through_point(test, law, void_ratio, pressure_Pa, 0.1)))
    peak = int(np.argmax(rows[:, 6]))
    has_peak = peak < len(rows) - 1
    # the dilatancy angle at the peak, from volume and axial strain: sin psi = -(d1 + d3) / (d1 - d3)
    found = {"homogeneous_peak_deg": float(rows[peak, 6]), "homogeneous_peak_at": 1.0 - math.exp(-rows[peak, 0])}
    if has_peak:
        swell = np.log((1.0 + rows[peak + 1, 5]) / (1.0 + rows[peak - 1, 5]))
        axial = rows[peak + 1, 0] - rows[peak - 1, 0]
        lateral = axial + swell
        found["roscoe_deg"] = 45.0 + 0.5 * math.degrees(math.asin((lateral - axial) / (lateral + axial)))
    first = first_bifurcation(_path(law, void_ratio, pressure_Pa))
    if first is not None:
        (strain, angle), band = first
        found |= {"bifurcation_deg": angle, "bifurcation_at": 1.0 - math.exp(-strain), "bifurcation_band_deg": band}
    return found


def _path(law, void_ratio: float, pressure_Pa: float):
    """States of homogeneous compression: ((strain, friction angle), point)."""
    point = StressPoint(law, (-pressure_Pa, -pressure_Pa, -pressure_Pa, 0.0), void_ratio)
    for number in range(1, 1001):
        point.step_mixed((3e-5, -1e-4, 0.0, 0.0), 0.0, 0, -pressure_Pa)
        yield (1e-4 * number, friction_angle_deg(point.stress)), point


# --- studies ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Study:
    """Cases of one figure: label -> what differs from the usual scene, as dotted names."""

    title: str
    cases: dict[str, dict]
    paper: dict[str, dict] = field(default_factory=dict)  # label -> the paper's numbers

    def scene(self, base: BiaxialScene, changes: dict) -> BiaxialScene:
        """The scene of a case."""
        tables = base.model_dump()
        tables["machine"] = {"threads": 1}
        for name, value in changes.items():
            *groups, last = name.split(".")
            table = tables
            for group in groups:
                table = table[group]
            table[last] = value
        return BiaxialScene.model_validate(tables)

    def folder(self, root: Path, label: str) -> Path:
        """Of a case; cases with the same changes share it."""
        changes = self.cases[label]
        words = [f"{name.split('.')[-1]}={value:g}" if isinstance(value, float) else f"{name.split('.')[-1]}={value}"
                 for name, value in sorted(changes.items())]  # fmt: skip
        return root / "runs" / ("_".join(words) or "usual")

    def is_there(self, root: Path) -> bool:
        """Whether all cases have been run."""
        return all((self.folder(root, label) / "summary.json").exists() for label in self.cases)


def _usual(**paper) -> dict:
    return paper


LENGTHS = (0.0, 1.5e-3, 1.75e-3, 2e-3, 2.5e-3, 3e-3, 4e-3)
STUDIES = {
    "time-step": Study(
        "time step, 24 x 84 points",
        {
            "from the stiffness": {"points_across": 24},
            **{f"{1e6 * dt:g} us": {"points_across": 24, "time_step_s": dt} for dt in (1e-6, 5e-7, 2e-7)},
            **{f"{1e6 * dt:g} us": {"points_across": 24, "time_step_s": dt} for dt in (4e-6, 6e-6)},
        },
    ),
    "points": Study(
        "number of points, $l_c$ = 1.5 mm",
        {f"{n} x {round(3.5 * n)}": {} if n == 32 else {"points_across": n} for n in (16, 24, 32, 40, 48)},
        {"24 x 84": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0}},
    ),
    "points-local": Study(
        "number of points, local law",
        {
            f"{n} x {round(3.5 * n)}": {"averaging.characteristic_length_m": 0.0}
            | ({} if n == 32 else {"points_across": n})
            for n in (16, 24, 32, 40, 48)
        },
    ),
    "points-per-cell": Study(
        "points per cell, 32 x 112 points",
        {"4 points a cell": {}, "1 point a cell": {"points_per_cell": 1}},
    ),
    "length": Study(
        "characteristic length, 32 x 112 points",
        {f"{1e3 * l:g} mm": {} if l == 1.5e-3 else {"averaging.characteristic_length_m": l} for l in LENGTHS},  # noqa: E741
        {"1.5 mm": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0}, "4 mm": {"phi_peak": 60.0}},
    ),
    "weight": Study(
        "weight function, $l_c$ = 1.5 mm, 24 x 84 points",
        {
            "Gaussian": {"points_across": 24},
            "exponential, as printed": {"points_across": 24, "averaging.weight": "exponential"},
        },
    ),
    "pressure": Study(
        "pressure",
        {f"{p:g} kPa": {} if p == 50 else {"pressure_Pa": 1e3 * p} for p in (50.0, 200.0, 500.0)},
        {
            "50 kPa": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0},
            "200 kPa": {"phi_peak": 50.0, "t_s_mm": 9.5, "theta": 54.0},
            "500 kPa": {"phi_peak": 47.0, "t_s_mm": 11.0, "theta": 52.0},
        },
    ),
    "void-ratio": Study(
        "void ratio",
        {f"e0 = {e:.2f}": {} if e == 0.55 else {"sand.void_ratio": e} for e in (0.55, 0.75, 0.90)},
        {
            "e0 = 0.55": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0},
            "e0 = 0.75": {"phi_peak": 40.0, "t_s_mm": 9.0, "theta": 50.0},
            "e0 = 0.90": {"phi_peak": 30.0},
        },
    ),
    "rate": Study(
        "speed of the plate and noise control",
        {
            "100 mm/s": {"speed_m_per_s": 0.1},
            "50 mm/s": {},
            "25 mm/s": {"speed_m_per_s": 0.025},
            "12.5 mm/s": {"speed_m_per_s": 0.0125},
            "50 mm/s, no control": {"noise_control": "none"},
            "25 mm/s, no control": {"noise_control": "none", "speed_m_per_s": 0.025},
        },
    ),
    "weak-height": Study(
        "height of the weak element",
        {f"{x:.2f} of the height": {} if x == 0.55 else {"weak_height": x} for x in (0.45, 0.50, 0.55, 0.60)},
    ),
}


def table_of(name: str, root: Path, base: BiaxialScene | None = None) -> pd.DataFrame:
    """One row a case: the paper, the equations and what was computed."""
    study, base = STUDIES[name], base or BiaxialScene()
    rows = []
    for label, changes in study.cases.items():
        summary, scene = summary_of(study.folder(root, label)), study.scene(base, changes)
        band, paper = summary["band"] or {"found": False}, study.paper.get(label, {})
        length = scene.characteristic_length_m
        row = {
            "study": name, "case": label,
            "phi_peak_deg": summary.get("peak_friction_angle_deg"),
            "peak_at_percent": 100 * summary.get("peak_at_shortening", math.nan),
            "phi_res_deg": summary.get("residual_friction_angle_deg"),
            "t_s_mm": 1e3 * band["loose_thickness_m"]["median"] if band["found"] else None,
            "t_s_lower_mm": 1e3 * band["loose_thickness_m"]["lower"] if band["found"] else None,
            "t_s_upper_mm": 1e3 * band["loose_thickness_m"]["upper"] if band["found"] else None,
            "half_width_mm": 1e3 * band["thickness_m"]["median"] if band["found"] else None,
            "half_width_lower_mm": 1e3 * band["thickness_m"]["lower"] if band["found"] else None,
            "half_width_upper_mm": 1e3 * band["thickness_m"]["upper"] if band["found"] else None,
            "theta_deg": band["inclination_deg"] if band["found"] else None,
            "theta_error_deg": band["inclination_error_deg"] if band["found"] else None,
            "t_s_over_l_c": 1e3 * band["loose_thickness_m"]["median"] / (1e3 * length)
            if band["found"] and length else None,
            "paper_phi_peak_deg": paper.get("phi_peak"), "paper_t_s_mm": paper.get("t_s_mm"),
            "paper_theta_deg": paper.get("theta"),
            "failure": summary.get("failure", ""),
        }  # fmt: skip
        if summary.get("peak_is_last"):
            row["peak_at_percent"] = None  # the angle still rises at the end: no peak
        rows.append(row)
    return pd.DataFrame(rows)


def draw_study(name: str, root: Path) -> list[Path]:
    """Figures of a study: load curves, and the specimens at the end by void ratio and by shear strain."""
    study, base = STUDIES[name], BiaxialScene()
    curves, specimens = {}, {}
    for label, changes in study.cases.items():
        folder, scene = study.folder(root, label), study.scene(base, changes)
        failed = "failure" in summary_of(folder)
        curves[label + (" (fails)" if failed else "")] = pd.read_csv(folder / "curve.csv")
        if not failed:
            points = dict(np.load(folder / "points.npz"))
            specimens[label] = (points, scene.spacing_m, band_of(points, scene))
    (root / "figures").mkdir(parents=True, exist_ok=True)
    files = []
    title = f"Plane strain compression: {study.title}"
    with rc_context(STYLE):
        references = ((29.87, "one critical band (29.9 deg)"),)
        for kind, figure in (
            ("load", load_figure(curves, title, references)),
            ("void_ratio", specimens_figure(specimens, "void_ratio", title)),
            ("shear", specimens_figure(specimens, "path", title)),
        ):
            files.append(root / "figures" / f"{name}_{kind}.png")
            figure.savefig(files[-1])
    return files
