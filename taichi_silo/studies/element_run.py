"""One element test: computed, set beside measured curves, and left in a folder."""

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import ValidationError

from taichi_silo.errors import BadInput
from taichi_silo.mpm import runtime
from taichi_silo.runs.run_folder import claim, write_tables
from taichi_silo.scene.sand import Sand
from taichi_silo.show.figures import draw_all
from taichi_silo.show.figures.element import element_figure
from taichi_silo.studies.element_tests import COLUMNS, TESTS, ElementScene, curve_of
from taichi_silo.studies.measured_element import COMPARED, Measured, read_measured
from taichi_silo.utils.schema import one_sentence

PRESSURES_APART = 0.02  # of each other, from where on a word is due
VOID_RATIO = 0.60  # if neither given nor measured
CURVE = "curve.csv"
Paths = str | os.PathLike | Sequence[str | os.PathLike]


@dataclass(frozen=True)
class ElementCurve:
    """An element test.

    Attributes
    ----------
    scene : what was computed.
    curve : a row a state; strain, stresses [Pa] (compression positive, 11 axial), void ratio, friction angle [deg].
    measured : curves of files, with the same columns.
    files : what was written; empty without a folder.

    """

    scene: ElementScene
    curve: pd.DataFrame
    measured: list[Measured]
    files: list[Path]

    @property
    def words(self) -> list[str]:
        """What came out, and how far it is from what was measured; a sentence each."""
        curve, last = self.curve, self.curve.iloc[-1]
        best = curve.friction_angle_deg.idxmax()
        found = [
            f"largest friction angle {curve.friction_angle_deg[best]:.2f} deg at a strain of "
            f"{100 * abs(curve.strain[best]):.2f} %, at the end {last.friction_angle_deg:.2f} deg; void ratio at the "
            f"end {last.void_ratio:.4f}"
        ]
        for one in self.measured:
            away = [
                f"{COMPARED[name][0]} by {value:.{COMPARED[name][2]}f}{COMPARED[name][1]}"
                for name, value in one.deviations(curve).items()
            ]
            found.append(f"{one.name}: the computed curve is off (rms) in {', '.join(away) or 'nothing in common'}")
            here = self.scene.pressure_Pa
            if one.pressure_Pa is not None and abs(one.pressure_Pa - here) > PRESSURES_APART * here:
                found.append(
                    f"{one.name} was measured at {one.pressure_Pa / 1e3:g} kPa, computed is {here / 1e3:g} kPa"
                )
            if one.void_ratio is not None and abs(one.void_ratio - self.scene.sand.void_ratio) > 1e-3:
                there = self.scene.sand.void_ratio
                found.append(
                    f"{one.name} begins at a void ratio of {one.void_ratio:.4g}, the computed one at {there:.4g}"
                )
        return found

    def figure(self) -> Any:
        """A figure of matplotlib: stresses, friction angle, void ratio against strain, measured points over curves."""
        scene = self.scene
        title = f"{scene.test.replace('-', ' ').capitalize()}: {scene.sand.name.capitalize()} sand, "
        title += f"$e_0$ = {scene.sand.void_ratio:.2f}, {scene.pressure_Pa / 1e3:g} kPa"
        points = {one.name: one.curve for one in self.measured}
        return element_figure(self.curve, title, TESTS[scene.test].sheared, points)


def element_test(
    test: str,
    sand: Sand | None = None,
    folder: str | os.PathLike | None = None,
    *,
    pressure_Pa: float | None = None,
    strain: float | None = None,
    through: str = "point",
    measured: Paths = (),
    overwrite: bool = False,
    **method: Any,
) -> ElementCurve:
    """Strain one piece of sand alike everywhere, and set the curve beside measured ones. Starts Taichi anew.

    Parameters
    ----------
    test : "oedometer", "triaxial", "triaxial-extension", "plane-strain", "simple-shear" or
        "simple-shear-constant-volume".
    sand : its constants, void ratio and law; the paper's at 0.60, or at the void ratio of the first measured curve.
    folder : for curve.csv, run.toml and figures/curve.png; nothing is written without it.
    pressure_Pa : isotropic at the start, kept on the free sides; that of the first measured curve, or 50e3, oedometer
        1e3.
    strain : at the end, logarithmic axial strain or shear gamma; 0.2, oedometer 0.04.
    through : "point", the law alone, or "mpm", the whole method.
    measured : CSV files of the same test, as laboratories leave them.
    overwrite : replace a test in the folder.
    method : shape, transfer, stress_filter and the like, of the method.

    Returns
    -------
    Curve, measured curves, `words` on both, and `figure()`.

    Raises
    ------
    BadInput
        before any work, if a value or a file is not possible.
    RunFailed
        if the law cannot follow the path.

    """
    if test not in TESTS:
        raise BadInput(f"test is {test}; it must be one of {', '.join(TESTS)}")
    files = [Path(one) for one in ([measured] if isinstance(measured, str | os.PathLike) else measured)]
    points = [read_measured(test, file, None if sand is None else sand.void_ratio) for file in files]
    chosen = sand or first_sand(points)
    usual = next((one.pressure_Pa for one in points if one.pressure_Pa is not None), None)
    values = {"pressure_Pa": usual if pressure_Pa is None else pressure_Pa, "strain": strain}
    given = {name: value for name, value in values.items() if value is not None}
    try:
        scene = ElementScene(test=test, sand=chosen, through=through, **given, **method)  # type: ignore[arg-type]
    except ValidationError as error:
        raise BadInput(one_sentence(error)) from error
    runtime.init()
    return _computed(scene, points, None if folder is None else claim(Path(folder), overwrite))


def first_sand(points: Sequence[Measured], **more: Any) -> Sand:
    """The default sand at the void ratio of the first measured curve that has one, or at 0.60."""
    return Sand(void_ratio=next((one.void_ratio for one in points if one.void_ratio is not None), VOID_RATIO), **more)


def _computed(scene: ElementScene, points: list[Measured], folder: Path | None) -> ElementCurve:
    """The test, and its files if there is a folder: one that fails keeps what it has reached."""
    begun, rows = time.time(), []
    try:
        for row in curve_of(scene):
            rows.append(row)
    finally:
        curve = pd.DataFrame(rows, columns=list(COLUMNS))
        if folder is not None:
            curve.to_csv(folder / CURVE, index=False, float_format="%.9g")
            write_tables(folder, scene.model_dump(exclude_none=True), {"wall_seconds": round(time.time() - begun, 3)})
    found = ElementCurve(scene, curve, [one.beside(curve) for one in points], [])
    if folder is None:
        return found
    figures = draw_all({"curve": lambda test: test.figure()}, found, folder / "figures")
    return ElementCurve(scene, curve, found.measured, [folder / CURVE, *figures])
