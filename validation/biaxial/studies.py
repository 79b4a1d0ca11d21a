"""The studies of the paper's section 5: cases, table and figures."""

import functools
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import rc_context

from taichi_silo.mpm.nonlocal_average import WEIGHTS
from taichi_silo.show.figures.style import STYLE
from validation.biaxial.bounds import bounds
from validation.biaxial.figures import load_figure, specimens_figure
from validation.biaxial.run import band_of, summary_of
from validation.biaxial.scene import BiaxialScene


@dataclass(frozen=True)
class BiaxialStudy:
    """Cases of one figure: what differs from the usual scene, by dotted path, for each label."""

    title: str
    cases: dict[str, dict]
    paper: dict[str, dict] = field(default_factory=dict)  # label -> the paper's numbers

    def scene(self, changes: dict) -> BiaxialScene:
        """The scene of a case."""
        tables = BiaxialScene().model_dump()
        tables["machine"] = {"threads": 1}
        for name, value in changes.items():
            *groups, last = name.split(".")
            table = tables
            for group in groups:
                table = table[group]
            table[last] = value
        return BiaxialScene.model_validate(tables)

    def folder(self, root: Path, label: str) -> Path:
        """Folder of a case; cases with the same changes share it."""
        changes = self.cases[label]
        words = [f"{name.split('.')[-1]}={value:g}" if isinstance(value, float) else f"{name.split('.')[-1]}={value}"
                 for name, value in sorted(changes.items())]  # fmt: skip
        return root / "runs" / ("_".join(words) or "usual")

    def is_there(self, root: Path) -> bool:
        """Whether all cases have been run."""
        return all((self.folder(root, label) / "summary.json").exists() for label in self.cases)


def cost(scene: BiaxialScene) -> float:
    """How long a case takes, in a unit of its own."""
    step = scene.time_step_s or 8e-4 * scene.cell_size_m
    steps = scene.shortening * scene.height_m / scene.speed_m_per_s / step
    reach = WEIGHTS[scene.averaging.weight].CUT * scene.averaging.length_m(scene.sand)
    return steps * scene.points_across**2 * (1.0 + 0.015 * (reach / scene.spacing_m) ** 2)


LENGTHS = (0.0, 1.5e-3, 1.75e-3, 2e-3, 2.5e-3, 3e-3, 4e-3)
STUDIES = {
    "time-step": BiaxialStudy(
        "time step, 24 x 84 points",
        {
            "from the stiffness": {"points_across": 24},
            **{f"{1e6 * dt:g} us": {"points_across": 24, "time_step_s": dt} for dt in (1e-6, 5e-7, 2e-7)},
            **{f"{1e6 * dt:g} us": {"points_across": 24, "time_step_s": dt} for dt in (4e-6, 6e-6)},
        },
    ),
    "points": BiaxialStudy(
        "number of points, $l_c$ = 1.5 mm",
        {f"{n} x {round(3.5 * n)}": {} if n == 32 else {"points_across": n} for n in (16, 24, 32, 40, 48)},
        {"24 x 84": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0}},
    ),
    "points-local": BiaxialStudy(
        "number of points, local law",
        {
            f"{n} x {round(3.5 * n)}": {"averaging.characteristic_length_m": 0.0}
            | ({} if n == 32 else {"points_across": n})
            for n in (16, 24, 32, 40, 48)
        },
    ),
    "points-per-cell": BiaxialStudy(
        "points per cell, 32 x 112 points",
        {"4 points a cell": {}, "1 point a cell": {"points_per_cell": 1}},
    ),
    "length": BiaxialStudy(
        "characteristic length, 32 x 112 points",
        {f"{1e3 * l:g} mm": {} if l == 1.5e-3 else {"averaging.characteristic_length_m": l} for l in LENGTHS},  # noqa: E741
        {"1.5 mm": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0}, "4 mm": {"phi_peak": 60.0}},
    ),
    "weight": BiaxialStudy(
        "weight function, $l_c$ = 1.5 mm, 24 x 84 points",
        {
            "Gaussian": {"points_across": 24},
            "exponential, as printed": {"points_across": 24, "averaging.weight": "exponential"},
        },
    ),
    "pressure": BiaxialStudy(
        "pressure",
        {f"{p:g} kPa": {} if p == 50 else {"pressure_Pa": 1e3 * p} for p in (50.0, 200.0, 500.0)},
        {
            "50 kPa": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0},
            "200 kPa": {"phi_peak": 50.0, "t_s_mm": 9.5, "theta": 54.0},
            "500 kPa": {"phi_peak": 47.0, "t_s_mm": 11.0, "theta": 52.0},
        },
    ),
    "void-ratio": BiaxialStudy(
        "void ratio",
        {f"e0 = {e:.2f}": {} if e == 0.55 else {"sand.void_ratio": e} for e in (0.55, 0.75, 0.90)},
        {
            "e0 = 0.55": {"phi_peak": 55.0, "t_s_mm": 7.5, "theta": 55.0},
            "e0 = 0.75": {"phi_peak": 40.0, "t_s_mm": 9.0, "theta": 50.0},
            "e0 = 0.90": {"phi_peak": 30.0},
        },
    ),
    "rate": BiaxialStudy(
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
    "weak-height": BiaxialStudy(
        "height of the weak element",
        {f"{x:.2f} of the height": {} if x == 0.55 else {"weak_height": x} for x in (0.45, 0.50, 0.55, 0.60)},
    ),
}


def table_of(name: str, root: Path) -> pd.DataFrame:
    """One row a case: the paper, the equations and what was computed."""
    study, rows = STUDIES[name], []
    for label, changes in study.cases.items():
        summary, scene = summary_of(study.folder(root, label)), study.scene(changes)
        paper, length = study.paper.get(label, {}), scene.averaging.length_m(scene.sand)
        band = summary["band"] if summary["band"] and summary["band"]["found"] else None
        row = {
            "study": name, "case": label,
            "phi_peak_deg": summary.get("peak_friction_angle_deg"),
            "peak_at_percent": 100 * summary.get("peak_at_shortening", math.nan),
            "phi_res_deg": summary.get("residual_friction_angle_deg"),
            **_spread("t_s", band and band["loose_thickness_m"]), **_spread("half_width", band and band["thickness_m"]),
            "theta_deg": band and band["inclination_deg"], "theta_error_deg": band and band["inclination_error_deg"],
            "t_s_over_l_c": band["loose_thickness_m"]["median"] / length if band and length else None,
            "paper_phi_peak_deg": paper.get("phi_peak"), "paper_t_s_mm": paper.get("t_s_mm"),
            "paper_theta_deg": paper.get("theta"),
            "failure": summary.get("failure", ""),
        }  # fmt: skip
        row |= _bounds(scene.sand.void_ratio, scene.pressure_Pa)
        if summary.get("peak_is_last"):
            row["phi_peak_deg"] = row["peak_at_percent"] = None  # the angle still rises at the end: no peak
        thickness = row["t_s_mm"]
        if thickness is not None and not 0.0 < thickness < 1e3 * scene.width_m:  # not dilated to 0.70, or all of it
            row |= dict.fromkeys(("t_s_mm", "t_s_lower_mm", "t_s_upper_mm", "t_s_over_l_c"))
        rows.append(row)
    return pd.DataFrame(rows)


def _spread(name: str, found: dict | None) -> dict:
    """Median and quartiles in mm."""
    keys = {"": "median", "_lower": "lower", "_upper": "upper"}
    return {f"{name}{suffix}_mm": found and 1e3 * found[key] for suffix, key in keys.items()}


@functools.cache
def _bounds(void_ratio: float, pressure_Pa: float) -> dict:
    """Bounds from the law alone, in the table's units."""
    found = bounds(void_ratio, pressure_Pa, BiaxialScene())
    return {
        "homogeneous_peak_deg": found.get("homogeneous_peak_deg"),
        "bifurcation_deg": found.get("bifurcation_deg"),
        "bifurcation_at_percent": 100.0 * found.get("bifurcation_at", math.nan),
        "bifurcation_band_deg": found.get("bifurcation_band_deg"),
        "roscoe_deg": found.get("roscoe_deg"),
    }


# pairs whose curves are compared: study, finer or slower case, other case
PAIRS = (
    ("points", "48 x 168", "40 x 140"), ("points", "40 x 140", "32 x 112"), ("points", "32 x 112", "24 x 84"),
    ("points-local", "48 x 168", "40 x 140"), ("points-local", "40 x 140", "32 x 112"),
    ("rate", "50 mm/s", "100 mm/s"), ("rate", "25 mm/s", "50 mm/s"), ("rate", "12.5 mm/s", "25 mm/s"),
    ("time-step", "0.2 us", "from the stiffness"), ("time-step", "0.2 us", "1 us"),
)  # fmt: skip


def differences(root: Path) -> pd.DataFrame:
    """How far the curves of PAIRS are apart.

    Columns: largest difference of the friction angle over the peak; the same where the curve falls by less than 10 deg
    in one per cent of shortening; largest shift along the strain axis where it falls faster [% of shortening]; largest
    difference of the plate's load over the load.
    """
    rows = []
    for name, fine, coarse in PAIRS:
        study = STUDIES[name]
        if not study.is_there(root):
            continue
        one, other = (pd.read_csv(study.folder(root, label) / "curve.csv") for label in (fine, coarse))
        strain = np.arange(0.002, min(one.shortening.max(), other.shortening.max()), 1e-4)
        angle, angle_other = (np.interp(strain, c.shortening, c.friction_angle_deg) for c in (one, other))
        load, load_other = (np.interp(strain, c.shortening, c.axial_stress_Pa) for c in (one, other))
        difference = np.abs(angle - angle_other)
        slope = np.abs(np.gradient(angle, 100.0 * strain))
        falling = (strain > strain[np.argmax(angle)]) & (slope > 10.0)
        peak = angle.max()
        rows.append(
            {
                "study": name, "case": fine, "other": coarse,
                "angle_over_peak_percent": 100 * difference.max() / peak,
                "angle_over_peak_outside_the_drop_percent": 100 * difference[~falling].max() / peak,
                "shift_of_the_drop_percent_of_shortening": np.max((difference / slope)[falling], initial=0.0),
                "load_percent": 100 * np.max(np.abs(load - load_other) / load),
                "load_outside_the_drop_percent": 100 * np.max((np.abs(load - load_other) / load)[~falling]),
                "peak_percent": 100 * abs(peak - angle_other.max()) / peak,
            }
        )  # fmt: skip
    return pd.DataFrame(rows)


def draw_study(name: str, root: Path) -> list[Path]:
    """Figures of a study: load curves, and the specimens at the end by void ratio and by shear strain."""
    study, curves, specimens = STUDIES[name], {}, {}
    for label, changes in study.cases.items():
        folder, scene = study.folder(root, label), study.scene(changes)
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
