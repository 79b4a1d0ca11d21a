"""Numbers in the theory pages follow from the code."""

import math

import numpy as np
import pytest
from written import DOCS

from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.runs.eurocode import solids

SAND = solids()["sand"]
FRICTIONS = (SAND.wall_friction_D1, SAND.wall_friction_D2, SAND.wall_friction_D3)


def table(page: str, heading: str) -> dict[str, str]:
    """Rows of the two-column table that begins with a heading."""
    text = (DOCS / page).read_text(encoding="utf-8")
    rows = text[text.index(f"| {heading} |") :].split("\n\n")[0].splitlines()[2:]
    return dict(tuple(cell.strip() for cell in row.strip("|").split("|")) for row in rows)


def critical(law, stress_of) -> tuple[float, np.ndarray]:
    """||T^*|| and T^ where the pressure no longer changes in shear of constant volume, in a family of stresses.

    With D along -T^* the trace of the rate is that of T^ (a1 - ||T^*||), at the critical void ratio.
    """
    e = law.e_c0 * math.exp(-((3.0 * 10e3 / law.granular_hardness_Pa) ** law.n))

    def shear(x):
        stress = stress_of(x)
        relative = stress / stress[:3].sum()
        deviator = relative - np.array([1.0, 1.0, 1.0, 0.0]) / 3.0
        size = math.sqrt(deviator[:3] @ deviator[:3] + 2.0 * deviator[3] ** 2)
        start = -30e3 * relative
        return (StressPoint(law, start, e).trial(-1e-9 * deviator / size)[:3] - start[:3]).sum(), size, relative

    low, high = 0.01, 0.99
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if shear(middle)[0] * shear(0.01)[0] > 0.0 else (low, middle)
    return shear(low)[1:]


def mobilised(stress) -> float:
    """asin((s1 - s3) / (s1 + s3)) in degrees."""
    middle, radius = 0.5 * (stress[0] + stress[1]), math.hypot(0.5 * (stress[0] - stress[1]), stress[3])
    high, low = max(middle + radius, stress[2]), min(middle - radius, stress[2])
    return math.degrees(math.asin((high - low) / (high + low)))


def test_the_numbers_to_check_against_are_those_of_the_code():
    law, given = GudehusBauer(), table("theory/law.md", "quantity")
    compression = critical(law, lambda x: -np.array([1.0 - x, 1.0, 1.0 - x, 0.0]))
    extension = critical(law, lambda x: -np.array([1.0, 1.0 - x, 1.0, 0.0]))
    shear = critical(law, lambda x: -np.array([1.0, 1.0, 1.0, x]))
    found = {
        "c1": law.c1, "c2": law.c2, "h_i": law.h_i,
        "K0 at 3 kPa, e = 0.60": law.rest_pressure_ratio(0.60),
        "K0 at 3 kPa, e = 0.90": law.rest_pressure_ratio(0.90),
        "e_d at 1 kPa": law.void_ratio_limits(1e3)[0], "e_d at 50 kPa": law.void_ratio_limits(50e3)[0],
        "a1 in critical triaxial compression": compression[0], "a1 in critical triaxial extension": extension[0],
        "critical angle, triaxial compression": mobilised(compression[1]),
        "critical angle, triaxial extension": mobilised(extension[1]),
        "critical angle, plane strain": mobilised(shear[1]),
        "arctan(σ12/σ22) in critical simple shear": math.degrees(math.atan(shear[1][3] / shear[1][1])),
    }  # fmt: skip
    assert set(found) == set(given)
    for name, text in given.items():
        digits = len(text.rstrip("°").partition(".")[2])
        assert float(text.rstrip("°")) == pytest.approx(found[name], abs=0.51 * 10.0**-digits), name


@pytest.mark.parametrize(("name", "text"), table("theory/step.md", "shape").items())
def test_the_stable_fractions_are_those_of_the_code(name, text):
    shape = {"linear": "linear", "uGIMP": "ugimp", "CPDI": "cpdi", "B-spline": "bspline"}[name.split(",")[0]]
    half = 0.25 if "four" in name else 0.5
    assert float(text) == pytest.approx(SHAPES[shape](half).stable_fraction, abs=5.1e-4)


def test_the_angles_of_the_code_s_walls_are_right():
    for page in ("how-to/walls.md", "coming-from/eurocode.md"):
        text = (DOCS / page).read_text(encoding="utf-8")
        angles = [math.degrees(math.atan(mu)) for mu in FRICTIONS]
        assert ", ".join(f"{angle:.1f}°" for angle in angles) in text
        assert ", ".join(f"{mu:g}" for mu in FRICTIONS) in text


def test_the_values_of_the_code_s_sand_are_right():
    text = (DOCS / "theory" / "silos.md").read_text(encoding="utf-8")
    for words in (
        f"{SAND.lower_weight_density_N_per_m3 / 1e3:g} to {SAND.upper_weight_density_N_per_m3 / 1e3:g} kN/m³",
        f"$\\varphi_r$ = {SAND.angle_of_repose_deg:g}°",
        f"$\\varphi_i$ = {SAND.internal_friction_angle_deg:g}° (factor {SAND.internal_friction_factor:g})",
        f"$K$ = {SAND.pressure_ratio:g} ({SAND.pressure_ratio_factor:g})", f"({SAND.wall_friction_factor:g})",
    ):  # fmt: skip
        assert words in text, words
