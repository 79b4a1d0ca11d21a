"""The element tests of the paper: figures 1 and 2, every void ratio and pressure, and the others that it mentions.

Source: Krzyzanowski et al. (2020), section 4. Each curve is computed through the law alone and through the whole method
(one cell); a table sets the largest, the final and the paper's friction angles side by side.

Cost: about four minutes on two cores.
"""

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure
from typer import Option

from taichi_silo.cli import command_line, flags
from taichi_silo.errors import BadInput
from taichi_silo.mpm import runtime
from taichi_silo.scene import sands
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures.element import wall_angle_deg
from taichi_silo.show.figures.style import STYLE, new_figure
from taichi_silo.show.figures.style import WORDS as COLORS
from taichi_silo.studies.element_tests import COLUMNS, ElementScene, curve_of

# test -> pressures [Pa], strain at the end
FIGURES = {
    "triaxial": ((500e3, 50e3), 0.36),
    "simple-shear": ((200e3, 50e3), 0.30),
    "triaxial-extension": ((500e3, 50e3), 0.20),
    "plane-strain": ((200e3, 50e3), 0.36),
    "oedometer": ((1e3,), 0.05),
    "simple-shear-constant-volume": ((200e3, 50e3), 0.20),
}
TITLES = {
    "triaxial": "Triaxial compression (figure 1 of the paper)",
    "simple-shear": "Simple shear with free dilatancy (figure 2 of the paper)",
    "triaxial-extension": "Triaxial extension",
    "plane-strain": "Plane strain compression, homogeneous",
    "oedometer": "Oedometric compression",
    "simple-shear-constant-volume": "Simple shear at constant volume",
}


def paper_element_tests(
    sand: flags.SandFlag = "karlsruhe",
    void_ratios: Annotated[str, Option(help="initial void ratios [-], separated by commas")] = "0.60,0.75,0.90",
    shape: flags.ShapeFlag = "ugimp",
    method: flags.MethodFlags = None,
    output: Annotated[Path, Option(help="folder; one CSV a curve, figures and a table")] = Path(
        "outputs/element_tests"
    ),
):
    """Run all element tests of the paper and draw its figures 1 and 2."""
    try:
        wanted = [float(word) for word in void_ratios.split(",")]
    except ValueError as error:
        raise BadInput(f"void ratios are {void_ratios}; they must be numbers separated by commas") from error
    for e in wanted:  # refused before anything is written
        for test, (pressures, _) in FIGURES.items():
            for p in pressures:
                ElementScene(
                    test=test, sand=sands.sand(sand, e), pressure_Pa=p, strain=FIGURES[test][1], shape=shape, **method
                )
    (output / "curves").mkdir(parents=True, exist_ok=True)
    (output / "figures").mkdir(exist_ok=True)
    cases = [
        (test, e, p, through)
        for test, (pressures, _) in FIGURES.items()
        for e in wanted
        for p in pressures
        for through in ("point", "mpm")
    ]
    with ProcessPoolExecutor(cores()) as workers:
        variants = [{"shape": shape, **method}] * len(cases)
        curves = dict(zip(cases, workers.map(compute, cases, [sand] * len(cases), variants), strict=True))
    for (test, e, p, through), curve in curves.items():
        name = f"{test}_e{e:.2f}_{p / 1e3:g}kPa_{through}.csv"
        curve.to_csv(output / "curves" / name, index=False, float_format="%.9g")
    with rc_context(STYLE):
        for test in FIGURES:
            draw(test, curves, sand).savefig(output / "figures" / f"{test}.png")
    table = pd.DataFrame([row(case, curves) for case in cases if case[3] == "point"])
    table.to_csv(output / "table.csv", index=False, float_format="%.4g")
    print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
    for file in sorted((output / "figures").glob("*.png")):
        print(file)


def compute(case: tuple, sand: str, method: dict) -> pd.DataFrame:
    """One curve."""
    test, e, p, through = case
    runtime.init()
    scene = ElementScene(
        test=test, sand=sands.sand(sand, e), pressure_Pa=p, strain=FIGURES[test][1], through=through, **method
    )  # fmt: skip
    return pd.DataFrame(curve_of(scene), columns=COLUMNS)


def draw(test: str, curves: dict, sand: str):
    """Friction by principal stresses, on the plate where there is one, and void ratio."""
    ours = {
        (e, p, through): curve.assign(strain=curve.strain.abs())
        for (name, e, p, through), curve in curves.items()
        if name == test
    }
    rows = [(lambda c: c.friction_angle_deg, "friction angle\nby principal stresses (deg)")]
    ours_too = sand == "karlsruhe"  # the paper's sand; the lines are its critical angles
    references = [(0, 30.0, "30 deg")] if ours_too else []
    if test.startswith("simple"):
        rows.append((wall_angle_deg, r"atan $\sigma_{12}/\sigma_{22}$ (deg)"))
        references += [(1, 29.431, "29.4 deg, exact")] if ours_too else []
    if test == "oedometer":
        rows = [(lambda c: 1e-3 * c.sigma_11_Pa, "vertical stress (kPa)")]
        references = []
    if test != "simple-shear-constant-volume":
        rows.append((lambda c: c.void_ratio, "void ratio"))
    else:
        rows.append((lambda c: 1e-3 * c.sigma_22_Pa, "normal stress (kPa)"))
    sheared = test.startswith("simple")
    label = "shear strain (%)" if sheared else "axial logarithmic strain (%)"
    title = TITLES[test] if ours_too else f"{TITLES[test].split(' (')[0]}, {sand}"
    return paper_figure(ours, rows, label, title, tuple(references))


def paper_figure(curves: dict, column, label: str, title: str, references: tuple = ()) -> Figure:
    """Curves of several void ratios (colours), one panel a pressure, law alone (lines) and method (dots).

    Parameters
    ----------
    curves : (void ratio, pressure [Pa], "point" or "mpm") -> table.
    column : function of a table that returns what to draw; a list of (function, label) draws rows of panels.
    label : of the strain axis.
    title : of the figure.
    references : (row, value, words) of dashed lines.

    """
    pressures = sorted({key[1] for key in curves}, reverse=True)
    void_ratios = sorted({key[0] for key in curves})
    figure = new_figure(5.6 * len(pressures), 3.9 * len(column) + 0.5)
    panels = figure.subplots(len(column), len(pressures), sharex=True, sharey="row", squeeze=False)
    for k, (read, name) in enumerate(column):
        for panel, pressure in zip(panels[k], pressures, strict=True):
            for color, e in zip(COLORS, void_ratios, strict=False):
                exact, method = curves[e, pressure, "point"], curves[e, pressure, "mpm"]
                panel.plot(100 * exact.strain, read(exact), color=color, label=f"$e_0$ = {e:.2f}")
                some = method.iloc[:: max(1, len(method) // 25)]
                panel.plot(100 * some.strain, read(some), "o", color=color, markersize=4)
            for row, value, words in references:
                if row == k:
                    panel.axhline(value, color="#555555", linestyle="--", linewidth=1.2, label=words)
            panel.set_title(f"{pressure / 1e3:g} kPa")
        panels[k][0].set_ylabel(name)
    for panel in panels[-1]:
        panel.set_xlabel(label)
    panels[0][0].legend(loc="lower right", title="line: law alone, dots: MPM")
    figure.suptitle(title)
    return figure


def row(case: tuple, curves: dict) -> dict:
    """Largest and last friction angles of a case, and how far the method is from the law."""
    test, e, p, _ = case
    exact, method = curves[case], curves[(*case[:3], "mpm")]
    best = exact.friction_angle_deg.idxmax()
    strain = exact.strain.abs()
    near = method[method.strain.abs() <= 0.2]
    stresses = [name for name in COLUMNS if name.startswith("sigma")]
    size = exact[stresses].abs().max(axis=1)
    error = max(
        np.max(
            np.abs(near[name] - np.interp(near.strain.abs(), strain, exact[name]))
            / np.interp(near.strain.abs(), strain, size)
        )
        for name in stresses
    )
    found = {
        "test": test, "e0": e, "pressure_kPa": p / 1e3, "phi_peak_deg": exact.friction_angle_deg[best],
        "at_strain_percent": 100 * strain[best] if best < len(exact) - 1 else np.nan,
        "phi_end_deg": exact.friction_angle_deg.iloc[-1], "e_end": exact.void_ratio.iloc[-1],
        "strain_end_percent": 100 * strain.iloc[-1],
    }  # fmt: skip
    if test.startswith("simple"):
        angle = wall_angle_deg(exact)
        found |= {"plate_peak_deg": angle.max(), "plate_end_deg": angle.iloc[-1]}
    return found | {"method_error_percent": 100 * error}


if __name__ == "__main__":
    command_line.command(paper_element_tests)
