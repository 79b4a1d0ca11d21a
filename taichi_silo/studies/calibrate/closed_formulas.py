"""First values of the constants by closed formulas.

Sources: E. Bauer, Soils Found. 36 (1996) 13-26, for the compression curve; I. Herle, G. Gudehus, Mech. Cohes.-Frict.
Mater. 4 (1999) 461-486, for the rest. Their formulas of alpha and beta are for another version of the law; here both
are derived anew from this law's own operators.
"""

import math
from typing import NamedTuple

import numpy as np

from taichi_silo.studies.calibrate.lab_tests import Laboratory, Oedometer, Triaxial
from taichi_silo.studies.calibrate.paths import Law
from taichi_silo.utils.messages import counted

USUAL = {  # where no test says anything: about the middle of the published sands
    "critical_friction_angle_deg": 32.0, "granular_hardness_Pa": 1.5e9, "n": 0.3, "e_c0": 0.9, "alpha": 0.15,
    "beta": 1.3,
}  # fmt: skip
LOOSEST, DENSEST = 1.15, 0.62  # e_i0 over e_max after Herle and Gudehus; mean e_d0 over e_c0 of the published sands
CLEAR = 1.0  # [deg] by which a peak must be above the critical angle
APART = 0.03  # void ratios of two oedometer tests that tell beta
EXPONENTS = np.linspace(0.1, 0.9, 81)


class Guess(NamedTuple):
    """A first value and where it comes from."""

    value: float
    source: str
    typical: bool = False  # of sands, not told by any test


def first_guess(lab: Laboratory) -> dict[str, Guess]:
    """First values of the eight constants."""
    found = {"critical_friction_angle_deg": friction_angle(lab)}
    phi = found["critical_friction_angle_deg"].value
    found |= compression(lab, phi)
    h_s, n = found["granular_hardness_Pa"].value, found["n"].value
    found |= void_ratios(lab, h_s, n)
    found["alpha"] = Guess(USUAL["alpha"], "usual of sands; no test of dense sand with a peak", True)
    found["beta"] = Guess(USUAL["beta"], "usual of sands; no two oedometer tests of different density", True)
    plain = {name: one.value for name, one in found.items()}
    if peaks := [value for test in lab.triaxials if (value := alpha_of_peak(test, plain)) is not None]:
        found["alpha"] = Guess(
            float(np.clip(np.median(peaks), 0.03, 0.6)), f"peaks of {counted(len(peaks), 'triaxial test')}"
        )
    plain["alpha"] = found["alpha"].value
    if (value := beta_of_stiffness(lab.oedometers, plain)) is not None:
        found["beta"] = Guess(value, "stiffness of the loosest and the densest oedometer test")
    return found


def friction_angle(lab: Laboratory) -> Guess:
    """Critical friction angle: angle of repose, else what the loosest triaxial test tends to."""
    if lab.index.friction_angle_deg:
        return Guess(float(np.mean(lab.index.friction_angle_deg)), "angle of repose")
    if lab.triaxials:
        test = max(lab.triaxials, key=lambda one: one.void_ratio)
        angles = test.friction_angle_deg[np.isfinite(test.deviator_Pa)]
        return Guess(float(np.clip(angles[-3:].mean(), 16.0, 49.0)), f"end of {test.name}")
    return Guess(USUAL["critical_friction_angle_deg"], "usual of sands", True)


def compression(lab: Laboratory, phi_deg: float) -> dict[str, Guess]:
    """h_s and n from the loosest oedometer test: the curve ln e = ln e_0 - (3p/h_s)^n that is nearest to it.

    The mean stress follows from K0 = 1 - sin phi_c (Jaky). For a given n the curve is a straight line over p^n.
    """
    if not lab.oedometers:
        return {
            name: Guess(USUAL[name], "usual of sands; no oedometer test", True)
            for name in ("granular_hardness_Pa", "n")
        }
    test = max(lab.oedometers, key=lambda one: one.void_ratio[0])
    p = test.stress_Pa[test.loading] * (1.0 + 2.0 * jaky(phi_deg)) / 3.0
    log_e = np.log(test.void_ratio[test.loading])
    best = (np.inf, 1.0, USUAL["n"])
    for n in EXPONENTS:
        x = p**n
        slope = -np.cov(x, log_e)[0, 1] / np.var(x, ddof=1)
        miss = float(np.var(log_e + slope * x))
        best = min(best, (miss, float(slope), float(n)))
    _, slope, n = best
    h_s = 3.0 * slope ** (-1.0 / n) if slope > 0.0 else USUAL["granular_hardness_Pa"]
    source = f"compression curve of {test.name}"
    return {"granular_hardness_Pa": Guess(float(np.clip(h_s, 2e6, 1e11)), source), "n": Guess(n, source)}


def void_ratios(lab: Laboratory, h_s: float, n: float) -> dict[str, Guess]:
    """e_d0, e_c0, e_i0: limit densities, else the ends of triaxial tests; so that all specimens lie between them."""
    if lab.index.e_max:
        e_c0 = Guess(float(np.mean(lab.index.e_max)), "e_max")
    elif ends := [end for test in lab.triaxials if (end := critical_void_ratio(test, h_s, n)) is not None]:
        e_c0 = Guess(max(ends), "ends of triaxial tests")
    else:
        firsts = [float(one.void_ratio[0]) for one in lab.oedometers]
        e_c0 = Guess(max(firsts, default=USUAL["e_c0"]), "loosest specimen" if firsts else "usual of sands", True)
    if lab.index.e_min:
        e_d0 = Guess(float(np.mean(lab.index.e_min)), "e_min")
    else:
        e_d0 = Guess(DENSEST * e_c0.value, f"{DENSEST:g} e_c0, mean of published sands", True)
    e_i0 = Guess(LOOSEST * e_c0.value, f"{LOOSEST:g} e_c0", True)
    given = [*(float(one.void_ratio.min()) for one in lab.oedometers), *(one.void_ratio for one in lab.triaxials)]
    most = [*(float(one.void_ratio[0]) for one in lab.oedometers), *(one.void_ratio for one in lab.triaxials)]
    if given and e_d0.value > 0.97 * min(given):
        e_d0 = Guess(0.97 * min(given), "just below the densest specimen", True)
    if most and e_i0.value < 1.03 * max(most):
        e_i0 = Guess(1.03 * max(most), "just above the loosest specimen", True)
    return {"e_c0": e_c0, "e_d0": e_d0, "e_i0": e_i0}


def critical_void_ratio(test: Triaxial, h_s: float, n: float) -> float | None:
    """Void ratio at the end of a triaxial test, without pressure; None if volume or stress was not measured there."""
    known = np.isfinite(test.volume_strain) & np.isfinite(test.deviator_Pa)
    if not known.any():
        return None
    e = (1.0 + test.void_ratio) * (1.0 - test.volume_strain[known][-1]) - 1.0
    p = test.cell_Pa + test.deviator_Pa[known][-1] / 3.0
    return float(e * np.exp((3.0 * p / h_s) ** n))


def alpha_of_peak(test: Triaxial, constants: dict[str, float]) -> float | None:
    """Alpha from the peak of a triaxial test; None if it has none, or its volume was not measured.

    At a peak the rate vanishes: L : D = -f_d N ||D||, so f_d = 1 / ||L^-1 N||, with N at f_d = 1.
    """
    known = np.isfinite(test.volume_strain) & np.isfinite(test.deviator_Pa)
    if known.sum() < 3:
        return None
    q, volume = test.deviator_Pa[known], test.volume_strain[known]
    k = int(np.argmax(q))
    phi = math.degrees(math.asin(q[k] / (q[k] + 2.0 * test.cell_Pa)))
    if phi < constants["critical_friction_angle_deg"] + CLEAR:
        return None
    axial, radial = test.cell_Pa + q[k], test.cell_Pa
    a1_squared, along, side, N_along, N_side = _normalised(axial, radial, constants)
    size = along * along + 2.0 * side * side
    inner = (along * N_along + 2.0 * side * N_side) / (a1_squared + size)
    f_d = 1.0 / math.hypot(
        *((N - t * inner) / a1_squared * w for N, t, w in ((N_along, along, 1.0), (N_side, side, math.sqrt(2.0))))
    )
    e = (1.0 + test.void_ratio) * (1.0 - volume[k]) - 1.0
    shrink = math.exp(-((3.0 * (axial + 2.0 * radial) / 3.0 / constants["granular_hardness_Pa"]) ** constants["n"]))
    share = (e / shrink - constants["e_d0"]) / (constants["e_c0"] - constants["e_d0"])
    return math.log(f_d) / math.log(share) if 0.02 < share < 0.9 and f_d < 1.0 else None


def beta_of_stiffness(tests: list[Oedometer], constants: dict[str, float]) -> float | None:
    """Beta from the stiffness of two oedometer tests at one stress; None without two of different density.

    At K0 = 1 - sin phi_c the stiffness is f_s (a1^2 + T_a^2 - f_d N_a), where f_s holds (e_i / e)^beta.
    """
    if len(tests) < 2:
        return None
    loose, dense = max(tests, key=lambda one: one.void_ratio[0]), min(tests, key=lambda one: one.void_ratio[0])
    stress = min(float(one.stress_Pa.max()) for one in (loose, dense)) / 2.0
    found = []
    for test in (loose, dense):
        s, e = test.stress_Pa[test.loading], test.void_ratio[test.loading]
        near = np.abs(np.log(s / stress)) < math.log(3.0)
        if near.sum() < 3:
            return None
        slope, e_there = np.polyfit(np.log(s[near] / stress), e[near], 1)
        a1_squared, along, _, N_along, _ = _normalised(
            stress, jaky(constants["critical_friction_angle_deg"]) * stress, constants
        )
        share = (e_there - constants["e_d0"]) / (constants["e_c0"] - constants["e_d0"])
        unit = a1_squared + along * along - max(share, 0.0) ** constants["alpha"] * N_along
        if slope >= 0.0 or unit <= 0.0:
            return None
        found.append((e_there, (1.0 + e_there) / -slope / unit))
    (e_loose, E_loose), (e_dense, E_dense) = found
    if e_loose - e_dense < APART:
        return None
    return float(np.clip(math.log(E_dense / E_loose) / math.log(e_loose / e_dense), 0.3, 4.0))


def jaky(phi_deg: float) -> float:
    """Pressure ratio at rest, 1 - sin phi_c."""
    return 1.0 - math.sin(math.radians(phi_deg))


def _normalised(axial_Pa: float, radial_Pa: float, constants: dict[str, float]) -> tuple[float, ...]:
    """a1^2, and axial and radial members of T^ and of N at f_s = f_d = 1, by the law's own operators."""
    law = Law(**constants)
    stress = (-radial_Pa, -axial_Pa, -radial_Pa, 0.0)
    _, _, *others = law.factors(stress, constants["e_c0"])
    a1_squared, _, relative, N = law.operators(stress, (1.0, 1.0, *others))
    return float(a1_squared), float(relative[1]), float(relative[0]), float(N[1]), float(N[0])
