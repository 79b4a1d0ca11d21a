"""What no sand does: a test that shows it was read or written wrongly, and is refused before any fit."""

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.studies.calibrate.lab_tests import IndexTests, Oedometer, Triaxial

RISE = 0.02  # of the void ratio from one point of first loading to the next, which is no noise
STEEPEST_DEG = 70.0  # mobilised friction angle; that of dense sand at a few kPa is about 60
DRAINED = 0.05  # largest change of the pore pressure over the cell pressure; a back pressure is kept nearly so well
DILATION, NOISE = 1.5, 0.02  # largest change of volume over axial strain, twice that of dense sand, and what is added


def check_oedometer(file: object, test: Oedometer) -> None:
    """Refuse a void ratio that does not fall in first loading."""
    stress, e = test.stress_Pa[test.loading] / 1e3, test.void_ratio[test.loading]
    rises = np.flatnonzero(np.diff(e) > RISE)
    if len(rises):
        k = int(rises[0])
        raise BadInput(
            f"{file}: the void ratio rises from {e[k]:.4g} at {stress[k]:g} kPa to {e[k + 1]:.4g} at "
            f"{stress[k + 1]:g} kPa; it must fall as the stress rises; are columns and signs right?"
        )
    if not e[-1] < e[0]:
        raise BadInput(
            f"{file}: the void ratio is {e[0]:.4g} at {stress[0]:g} kPa and {e[-1]:.4g} at {stress[-1]:g} kPa; it must "
            "fall as the stress rises; are columns and signs right?"
        )


def check_pore_pressure(file: object, cell_Pa: float, pore_Pa: np.ndarray) -> None:
    """Refuse a pore pressure that changes; one that stays is a back pressure."""
    if len(pore_Pa) and np.ptp(pore_Pa) > DRAINED * cell_Pa:
        raise BadInput(
            f"{file}: the pore pressure changes by {np.ptp(pore_Pa) / 1e3:g} kPa at a cell pressure of "
            f"{cell_Pa / 1e3:g} kPa, as in an undrained test; it must be a drained test in compression"
        )


def check_compression(file: object, cell_Pa: float, deviator_Pa: np.ndarray) -> None:
    """Refuse a test with negative strains, a positive cell pressure and a q below it: compression has a greater q."""
    q = float(np.nanmax(np.abs(deviator_Pa)))
    if q < cell_Pa:
        raise BadInput(
            f"{file}: the axial strain is negative, the cell pressure of {cell_Pa / 1e3:g} kPa is positive, and q of "
            f"{q / 1e3:g} kPa is below it, which means extension; it must be a drained test in compression (if it is "
            "one, give strain, q and cell pressure one sign)"
        )


def check_triaxial(file: object, test: Triaxial) -> None:
    """Refuse a shear strength and a change of volume that no sand has, whatever the sign of the latter."""
    known = np.isfinite(test.deviator_Pa)
    q = float(test.deviator_Pa[known].max())
    angle = float(np.degrees(np.arcsin(q / (q + 2.0 * test.cell_Pa))))
    if angle >= STEEPEST_DEG:
        raise BadInput(
            f"{file}: q is {q / 1e3:g} kPa at a cell pressure of {test.cell_Pa / 1e3:g} kPa, a friction angle of "
            f"{angle:.0f} deg; it must be below {STEEPEST_DEG:g}; are both units right?"
        )
    volume = test.volume_strain[np.isfinite(test.volume_strain) & (test.strain > 0.0)]
    if len(volume) > 1 and np.ptp(volume) == 0.0:
        raise BadInput(
            f"{file}: the volume strain is {volume[0]:.4g} in every row; is the test undrained? It must be a drained "
            "one; if the volume was not measured, leave out its column"
        )
    size, strain = np.abs(np.nan_to_num(test.volume_strain)), np.abs(test.strain)
    wrong = np.flatnonzero(size > DILATION * strain + NOISE)
    if len(wrong):
        k = int(wrong[0])
        raise BadInput(
            f"{file}: the volume strain is {test.volume_strain[k]:.4g} at an axial strain of {test.strain[k]:.4g}; it "
            f"must be at most {DILATION:g} times that; are both units right?"
        )


def check_index(folder: object, index: IndexTests) -> None:
    """Refuse a densest state that is not denser than the loosest."""
    if index.e_min and index.e_max and not np.mean(index.e_min) < np.mean(index.e_max):
        raise BadInput(
            f"{folder}: e_min is {np.mean(index.e_min):.4g} and e_max {np.mean(index.e_max):.4g}; e_min must be below "
            "e_max; are they the right way round?"
        )
