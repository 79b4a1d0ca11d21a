"""Measured curves of element tests, with the columns of computed ones, so that both are drawn alike."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.studies.calibrate.lab_files import LabFile
from taichi_silo.studies.element_tests import COLUMNS, TESTS

KINDS = ("oedometer", "triaxial", "plane-strain", "simple-shear", "simple-shear-constant-volume")
FEWEST = 3  # points of a curve
OPPOSITE = -0.5  # correlation with the computed volume strain, below which the measured one has the other sign
COMPARED = {  # what deviations are told of: words, unit, places
    "friction_angle_deg": ("friction angle", " deg", 2), "void_ratio": ("void ratio", "", 4),
}  # fmt: skip


@dataclass(frozen=True)
class Measured:
    """A measured curve.

    Attributes
    ----------
    name : of the file.
    curve : the columns of `COLUMNS`, of which those not measured are nan.
    pressure_Pa : kept on the free sides; None if the file does not say, or nothing is kept.
    void_ratio : at the begin; None if the file does not say.
    sure : whether the sign of a volume strain is plain.

    """

    name: str
    curve: pd.DataFrame
    pressure_Pa: float | None = None
    void_ratio: float | None = None
    sure: bool = True

    def beside(self, computed: pd.DataFrame) -> "Measured":
        """The curve, its volume turned if it is plainly the other way than the computed one."""
        if self.sure or self.void_ratio is None:
            return self
        e, e_0 = self.curve.void_ratio.to_numpy(), self.void_ratio
        known = np.isfinite(e)
        first = computed.void_ratio.iloc[0]
        there = (e[known] - e_0) / (1.0 + e_0)
        given = np.interp(self.curve.strain[known], computed.strain.abs(), computed.void_ratio - first) / (1.0 + first)
        if np.sum(given * there) >= OPPOSITE * np.sqrt(np.sum(given**2) * np.sum(there**2)):
            return self
        return Measured(self.name, self.curve.assign(void_ratio=2.0 * e_0 - e), self.pressure_Pa, e_0)

    def deviations(self, computed: pd.DataFrame) -> dict[str, float]:
        """Root of the mean square of computed less measured, of each quantity of `COMPARED` that was measured."""
        found = {}
        for name in COMPARED:
            known = np.isfinite(self.curve[name]) & (self.curve.strain <= computed.strain.abs().max())
            if known.sum() >= FEWEST:
                there = np.interp(self.curve.strain[known], computed.strain.abs(), computed[name])
                found[name] = float(np.sqrt(np.mean((there - self.curve[name][known]) ** 2)))
        return found


def read_measured(test: str, file: Path, void_ratio: float | None) -> Measured:
    """A measured curve of a test, from a CSV file as laboratories leave it, with units in the titles.

    Parameters
    ----------
    test : one of `KINDS`.
    file : with the columns that `taichi-silo calibrate` reads, or of a shear test `shear strain` with `shear stress`.
    void_ratio : at the begin of the computed test, from which the strain of an oedometer test counts; None: the
        largest of the file.

    Raises
    ------
    BadInput
        if the file cannot be understood, or such a test cannot be drawn.

    """
    if test not in KINDS:
        raise BadInput(f"test is {test}; measured curves are drawn beside {', '.join(KINDS)}")
    lab = LabFile(file)
    if TESTS[test].sheared:
        return _sheared(lab)
    return _oedometer(lab, void_ratio) if test == "oedometer" else _compressed(lab, test)


def _frame(**columns: np.ndarray) -> pd.DataFrame:
    frame = pd.DataFrame(columns)
    return frame.reindex(columns=list(COLUMNS))


def _oedometer(lab: LabFile, void_ratio: float | None) -> Measured:
    """The axial strain counts from the computed void ratio at the begin, so that equal void ratios stand together."""
    if not lab.has("axial_stress"):
        raise BadInput(f"{lab.file} has no axial stress [kPa]; an oedometer test has it, with void ratio")
    found = lab.oedometer()
    first = float(found.void_ratio.max()) if void_ratio is None else void_ratio
    strain = np.log((1.0 + first) / (1.0 + found.void_ratio))
    return Measured(
        found.name, _frame(strain=strain, sigma_11_Pa=found.stress_Pa, void_ratio=found.void_ratio), None, first
    )


def _compressed(lab: LabFile, test: str) -> Measured:
    """Of axial compression under a kept pressure."""
    if not (lab.has("axial_strain", "log_strain") and lab.has("deviator", "axial_stress")):
        raise BadInput(f"{lab.file} has no axial strain [%] with q [kPa] or sigma1 [kPa]; a {test} test has both")
    found = lab.triaxial()
    kept = np.full(len(found.strain), found.cell_Pa)
    curve = _frame(
        strain=found.strain, sigma_11_Pa=found.deviator_Pa + kept, sigma_22_Pa=kept,
        sigma_33_Pa=kept if test == "triaxial" else np.nan * kept, friction_angle_deg=found.friction_angle_deg,
        void_ratio=(1.0 + found.void_ratio) * (1.0 - found.volume_strain) - 1.0,
    )  # fmt: skip
    return Measured(found.name, curve, found.cell_Pa, found.void_ratio, found.sign_known)


def _sheared(lab: LabFile) -> Measured:
    """Of simple shear: gamma and the stresses of the plate."""
    if not (lab.has("shear_strain") and lab.has("shear_stress")):
        raise BadInput(f"{lab.file} has no shear strain [%] with shear stress [kPa]; a shear test has both")
    empty = np.full(len(lab.columns["shear_strain"]), np.nan)
    shear, normal = lab.columns["shear_stress"], np.abs(lab.columns.get("axial_stress", empty))
    curve = _frame(
        strain=np.abs(lab.columns["shear_strain"]), sigma_12_Pa=np.abs(shear), sigma_22_Pa=normal,
        void_ratio=lab.columns.get("void_ratio", empty),
    )  # fmt: skip
    known = curve[np.isfinite(curve.strain) & np.isfinite(curve.sigma_12_Pa)]
    if len(known) < FEWEST:
        raise BadInput(f"{lab.file} has {len(known)} points of shear; it must have at least {FEWEST}")
    e = known.void_ratio.dropna()
    pressure = normal[np.isfinite(normal)]
    return Measured(
        lab.file.name, known, float(pressure[0]) if len(pressure) else None, float(e.iloc[0]) if len(e) else None
    )
