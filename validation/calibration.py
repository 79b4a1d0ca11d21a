"""Made-up laboratory tests whose constants are known: how often the intervals of a calibration hold them.

Two oedometer and four drained triaxial tests, an angle of repose and limit densities are computed with the constants of
a published sand and disturbed by noise: 0.001 of the void ratio and 0.005 of that of each specimen, 1 % of the largest
q, 0.0005 of the volume strain, 1 deg, 0.02 of the limit void ratios. Case k takes the sands in turn and seeds its noise
with k. Every constant should lie within its interval of 95 % in 95 of 100 cases.

Cost: some five seconds a case on one core.
"""

import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.scene import cores
from taichi_silo.studies.calibrate.closed_formulas import first_guess, jaky
from taichi_silo.studies.calibrate.constants import NAMES, SHOWN
from taichi_silo.studies.calibrate.fit import fitted
from taichi_silo.studies.calibrate.lab_tests import IndexTests, Laboratory, Oedometer, Triaxial
from taichi_silo.studies.calibrate.paths import Law, oedometer, triaxial

VOID, SPECIMEN, DEVIATOR, VOLUME, REPOSE_DEG, LIMIT = 0.001, 0.005, 0.01, 0.0005, 1.0, 0.02  # standard deviations
OEDOMETERS = (0.95, 0.25)  # void ratio between e_d0 (0) and e_c0 (1)
TRIAXIALS = ((0.2, 100e3), (0.2, 400e3), (0.6, 200e3), (0.9, 100e3))  # likewise, and cell pressure [Pa]
STRESSES_Pa, STRAINS = np.geomspace(10e3, 1600e3, 16), np.linspace(0.0, 0.18, 46)[1:]


def true_constants(number: int) -> tuple[str, dict[str, float]]:
    """Name and constants of the sand of a case."""
    name, sand = list(published().items())[number % len(published())]
    return name, {constant: sand[constant] for constant in NAMES}


def laboratory(constants: dict[str, float], seed: int, noise: float = 1.0) -> Laboratory:
    """The tests of a sand, with so many times the usual noise."""
    random = np.random.default_rng(seed)
    law, ratio = Law(**constants), np.array([[jaky(constants["critical_friction_angle_deg"])]])

    def disturbed(value, deviation):
        return value + noise * deviation * random.standard_normal(np.shape(value))

    def void_ratio(share):
        return constants["e_d0"] + share * (constants["e_c0"] - constants["e_d0"])

    oedometers, triaxials = [], []
    for number, share in enumerate(OEDOMETERS, 1):
        turns, first = np.log(STRESSES_Pa[[0, -1]])[:, None], np.array([[void_ratio(share)]])
        e = oedometer(law, turns, ratio, first).at(0, np.log(STRESSES_Pa))[1][:, 0]
        found = disturbed(e, VOID) + disturbed(0.0, SPECIMEN)
        oedometers.append(Oedometer(f"oedometer_{number}.csv", STRESSES_Pa, found))
    for number, (share, cell) in enumerate(TRIAXIALS, 1):
        first = void_ratio(share)
        path = triaxial(law, np.array([[0.0], STRAINS[-1:]]), np.array([cell]), np.array([[first]]))
        axial, e = (one[:, 0] for one in path.at(0, STRAINS))
        q, volume = (
            disturbed(axial - cell, DEVIATOR * (axial.max() - cell)),
            disturbed(1.0 - (1.0 + e) / (1.0 + first), VOLUME),
        )
        triaxials.append(
            Triaxial(f"triaxial_{number}.csv", cell, float(disturbed(first, SPECIMEN)), STRAINS, q, volume)
        )
    index = IndexTests(
        [float(disturbed(constants["critical_friction_angle_deg"], REPOSE_DEG))],
        [float(disturbed(constants["e_d0"], LIMIT))], [float(disturbed(constants["e_c0"], LIMIT))], [2650.0], [0.5e-3],
    )  # fmt: skip
    return Laboratory(oedometers, triaxials, index)


def case(number: int) -> list[dict]:
    """A row for each constant: what is true, what was found, its interval, and the time [s]."""
    sand, constants = true_constants(number)
    lab, begun = laboratory(constants, number), time.process_time()
    fit = fitted(lab, first_guess(lab))
    seconds = time.process_time() - begun
    return [
        {
            "case": number, "sand": sand, "constant": name, "true": constants[name], "found": fit.constants[name],
            "low": fit.intervals[name][0], "high": fit.intervals[name][1], "known": name not in fit.undetermined,
            "seconds": round(seconds, 1),
        }
        for name in SHOWN
    ]  # fmt: skip


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """By constant: cases, how many intervals hold the true value, how wide they and how large the errors are."""
    rows = rows.assign(
        inside=(rows.low <= rows.true) & (rows.true <= rows.high), width=(rows.high - rows.low) / rows.true,
        error=np.abs(rows.found / rows.true - 1.0),
    )  # fmt: skip
    found = []
    for name, one in [*rows.groupby("constant", sort=False), ("all", rows)]:
        found.append({
            "constant": name, "cases": len(one), "inside": int(one.inside.sum()),
            "inside_percent": round(100.0 * one.inside.mean(), 1), "known": int(one.known.sum()),
            "median_width_percent": round(100.0 * one.width.median(), 1),
            "median_error_percent": round(100.0 * one.error.median(), 2),
        })  # fmt: skip
    return pd.DataFrame(found)


def calibration(
    cases: Annotated[int, Option(help="how many", min=1)] = 40,
    output: Annotated[Path, Option(help="folder of calibration.csv and calibration_cases.csv")] = Path(
        "outputs/calibration"
    ),
):
    """Calibrate made-up tests; leaves a table by constant and one of all cases."""
    output.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(cores()) as workers:
        rows = pd.DataFrame([row for found in workers.map(case, range(cases)) for row in found])
    rows.to_csv(output / "calibration_cases.csv", index=False, float_format="%.5g")
    table = summary(rows)
    table.to_csv(output / "calibration.csv", index=False)
    print(table.to_string(index=False))
    print(f"median {rows.seconds.median():g} s, at most {rows.seconds.max():g} s of one core")


if __name__ == "__main__":
    command_line.command(calibration)
