"""The eight constants as the unknowns of a fit: ranges, and scales on which a fit is close to linear."""

from typing import Any

import numpy as np

NAMES = (
    "critical_friction_angle_deg", "granular_hardness_Pa", "n", "e_c0", "e_d0", "e_i0", "alpha", "beta",
)  # fmt: skip
SYMBOLS = {
    "critical_friction_angle_deg": "φ_c", "granular_hardness_Pa": "h_s", "n": "n", "e_i0": "e_i0", "e_c0": "e_c0",
    "e_d0": "e_d0", "alpha": "α", "beta": "β",
}  # fmt: skip
SHOWN = ("critical_friction_angle_deg", "granular_hardness_Pa", "n", "e_i0", "e_c0", "e_d0", "alpha", "beta")
# range of each unknown: angle; logarithm of h_s; n; logarithm of e_c0; shares of e_c0; logarithms of the exponents
LOW = np.array([15.0, np.log(1e6), 0.05, np.log(0.2), 0.3, 1.01, np.log(0.01), np.log(0.1)])
HIGH = np.array([50.0, np.log(2e11), 0.95, np.log(3.0), 0.95, 2.0, np.log(1.0), np.log(8.0)])
SPAN = HIGH - LOW
WELL = 0.1  # of its range, up to which an interval tells a constant: 3.5 deg, 0.09 of n, a factor of 3.4 of h_s
RELATIVE = {"e_d0": (4, 0.3, 0.95), "e_i0": (5, 1.01, 2.0)}  # unknowns that are shares of e_c0, and their ranges


def constants_of(unknowns: np.ndarray) -> dict[str, Any]:
    """Constants by their names; unknowns are 8, or 8 x sets."""
    phi, log_h, n, log_e, dense, loose, log_alpha, log_beta = unknowns
    e_c0 = np.exp(log_e)
    values = (phi, np.exp(log_h), n, e_c0, dense * e_c0, loose * e_c0, np.exp(log_alpha), np.exp(log_beta))
    return dict(zip(NAMES, values, strict=True))


def unknowns_of(constants: dict[str, float]) -> np.ndarray:
    """The unknowns of constants, within their ranges."""
    phi, h_s, n, e_c0, e_d0, e_i0, alpha, beta = (constants[name] for name in NAMES)
    found = np.array([phi, np.log(h_s), n, np.log(e_c0), e_d0 / e_c0, e_i0 / e_c0, np.log(alpha), np.log(beta)])
    return np.clip(found, LOW + 1e-6 * SPAN, HIGH - 1e-6 * SPAN)


def _reach(name: str, unknowns: np.ndarray, covariance: np.ndarray, factor: float) -> float:
    """So many standard deviations of a constant on its scale: of the logarithm of e_d0 and e_i0, not of their share."""
    row = np.zeros(len(covariance))
    row[NAMES.index(name)] = 1.0
    if name in RELATIVE:
        share = RELATIVE[name][0]
        row[3], row[share] = 1.0, 1.0 / unknowns[share]
    return factor * float(np.sqrt(row @ covariance @ row))


def width(name: str, unknowns: np.ndarray, covariance: np.ndarray, factor: float) -> float:
    """Width of the interval of a constant on its scale, over its range there; above 1 where it is wider than that."""
    span = float(SPAN[NAMES.index(name)])
    if name in RELATIVE:
        _, low, high = RELATIVE[name]
        span = float(np.log(high / low))
    return 2.0 * _reach(name, unknowns, covariance, factor) / span


def how_known(width_over_range: float) -> str:
    """Whether the tests determine a constant, by the width of its interval over its range."""
    return "yes" if width_over_range <= WELL else "poorly" if width_over_range <= 1.0 else "no"


def interval(name: str, unknowns: np.ndarray, covariance: np.ndarray, factor: float) -> tuple[float, float]:
    """Ends of the interval of a constant: so many standard deviations to both sides, on its scale, within its range."""
    k, reach = NAMES.index(name), _reach(name, unknowns, covariance, factor)
    if name in RELATIVE:
        share, low, high = RELATIVE[name]
        middle = unknowns[3] + np.log(unknowns[share])
        e_c0 = np.exp(unknowns[3])
        return float(max(np.exp(middle - reach), low * e_c0)), float(
            min(np.exp(min(middle + reach, 50.0)), high * e_c0)
        )
    ends = (max(unknowns[k] - reach, LOW[k]), min(unknowns[k] + reach, HIGH[k]))
    low, high = (float(np.exp(end)) if name not in ("critical_friction_angle_deg", "n") else float(end) for end in ends)
    return low, high
