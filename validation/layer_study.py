"""The sheared layer on finer and finer cells: errors of the shear stress against the one-dimensional solution.

Leaves `layer.csv`, the errors, and `layer.png`, the curves of the first case. Cost: about ten minutes on two cores.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.mpm import runtime
from taichi_silo.scene.method_options import MethodOptions
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures.style import BLUE, GREEN, ORANGE, STYLE, VERMILLION, new_figure

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # as a plain script, too
from validation.layer import SHAPE, layer, sheared  # noqa: E402

REFERENCE = Path(__file__).parents[1] / "tests" / "data" / "layer"
CASES = {  # pressure [Pa], void ratio, characteristic length [m]; the names of the reference's files
    "a": (2e3, 0.60, 0.005), "b_10kPa": (1e4, 0.60, 0.005),
    "c_loose": (2e3, 0.85, 0.005), "d_short": (2e3, 0.60, 0.0025),
}  # fmt: skip
TITLES = {"a": "2 kPa, dense", "b_10kPa": "10 kPa", "c_loose": "loose", "d_short": "half the length"}
OTHERS = [(case, SHAPE) for case in CASES if case != "a"] + [(case, "ugimp") for case in ("a", "d_short")]
FINENESS = (0.5, 1.0, 2.0, 4.0)  # cells along the length
COLORS = dict(zip(FINENESS, (VERMILLION, ORANGE, GREEN, BLUE), strict=True))
AT_MM = (1.0, 2.0, 4.0)


def compute(case: str, cells: float, points: int, stress_filter: str, shape: str = SHAPE) -> tuple[np.ndarray, float]:
    """Displacements and shear stresses (2, rows), and the least vertical stress of a point over the pressure."""
    runtime.init()
    piece = layer(*CASES[case], cells, points, MethodOptions(stress_filter=stress_filter), shape)
    u, tau, _height = np.array(list(sheared(piece, 1e-3 * AT_MM[-1]))).T
    return np.stack([u, tau]), float(-piece.particles.arrays()["stress"][:, 1].max() / CASES[case][0])


def reference(case: str) -> np.ndarray:
    """Displacements and shear stresses of the solution."""
    table = pd.read_csv(REFERENCE / f"{case}.csv", comment="#")
    return np.stack([table["displacement_m"], table["shear_stress_Pa"]])


def study(
    output: Annotated[Path, Option(help="folder, for layer.csv and layer.png")] = Path("outputs/layer_study"),
):
    """Shear the layer on four grids with one and with four points a cell."""
    output.mkdir(parents=True, exist_ok=True)
    wanted = [("a", cells, points, "patch", SHAPE) for cells in FINENESS for points in (1, 4)]
    wanted += [("a", cells, points, "none", SHAPE) for cells in FINENESS[1:3] for points in (1, 4)]
    wanted += [
        (case, cells, points, "patch", shape) for case, shape in OTHERS for cells in (1.0, 2.0) for points in (1, 4)
    ]
    with ProcessPoolExecutor(max_workers=cores()) as pool:
        found = list(pool.map(compute, *zip(*wanted, strict=True)))
    rows = []
    for (case, cells, points, stress_filter, shape), (curve, least) in zip(wanted, found, strict=True):
        at = 1e-3 * np.array(AT_MM)
        errors = np.interp(at, *curve) / np.interp(at, *reference(case)) - 1.0
        rows.append((TITLES[case], shape, stress_filter, points, 1.0 / cells, *(100.0 * errors), least))
    errors_at = [f"error_{u:g}mm_percent" for u in AT_MM]
    columns = ["case", "shape", "filter", "points", "h_over_lc", *errors_at, "least_stress"]
    table = pd.DataFrame(rows, columns=columns)
    table.to_csv(output / "layer.csv", index=False, float_format="%.3g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    draw({want: curve for want, (curve, _) in zip(wanted, found, strict=True)}).savefig(output / "layer.png", dpi=150)


def draw(curves: dict):
    """Curves of the first case: one point a cell, four points, and both without the filter."""
    with rc_context(STYLE):
        figure = new_figure(11.0, 4.2)
        panels = figure.subplots(1, 3, sharey=True)
        kinds = (
            (1, "patch", "one point a cell"),
            (4, "patch", "four points a cell"),
            (4, "none", "four, without the filter"),
        )
        for panel, (points, stress_filter, title) in zip(panels, kinds, strict=True):
            u, tau = reference("a")
            panel.plot(1e3 * u, 1e-3 * tau, color="black", linewidth=2.5, label="one-dimensional solution")
            for (case, cells, number, kind, shape), (u, tau) in curves.items():
                if (case, number, kind, shape) == ("a", points, stress_filter, SHAPE):
                    label = f"h = {1.0 / cells:g} $l_c$"
                    panel.plot(1e3 * u, 1e-3 * tau, color=COLORS[cells], linewidth=1.2, label=label)
            panel.set(title=title, xlabel="displacement u (mm)", xlim=(0.0, AT_MM[-1]), ylim=(0.0, 2.2))
            panel.legend(loc="lower right")
        panels[0].set_ylabel("shear stress (kPa)")
    return figure


if __name__ == "__main__":
    command_line.command(study)
