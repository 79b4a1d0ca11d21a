"""Oedometer and drained triaxial compression by the law alone, for many sets of constants at once.

Rows are tests, columns sets of constants. The strain that a kept or given stress asks for follows in closed form, since
the law is linear in D and in ||D||; the path is integrated in steps whose error is controlled.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.on_arrays import law_on_arrays

Law: Callable[..., Any] = law_on_arrays(GudehusBauer)
# error of a step, of stress and void ratio: 1e-4 of both after a whole path (a test)
COMPRESSING, SHEARING = 2e-5, 2e-6
FIRST, SMALLEST = 1e-4, 1e-5  # share of the way from turn to turn in a step
MOST_STEPS = 2000  # of a path; those of sand take about 100
STIFFEST = 1e-3  # least share of the linear stiffness that is left in loading


class Curve(NamedTuple):
    """A path at its nodes; first axis nodes, then tests, then sets of constants."""

    control: np.ndarray  # ln of the axial stress, or axial logarithmic strain: nodes x tests
    stress_Pa: np.ndarray  # radial in the oedometer, axial in the triaxial test, compression positive
    void_ratio: np.ndarray
    stress_slope: np.ndarray  # of both by the control
    void_ratio_slope: np.ndarray

    def at(self, test: int, control: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stress [Pa] and void ratio of a test that never turns at values of its control: values x sets of constants.

        By cubic polynomials between the nodes.
        """
        x = self.control[:, test]
        k = np.clip(np.searchsorted(x, control) - 1, 0, len(x) - 2)
        h = (x[k + 1] - x[k])[:, None]
        t = (control - x[k])[:, None] / h
        found = []
        for value, slope in ((self.stress_Pa, self.stress_slope), (self.void_ratio, self.void_ratio_slope)):
            a, b, da, db = value[k, test], value[k + 1, test], h * slope[k, test], h * slope[k + 1, test]
            found.append(a + t * (da + t * (3.0 * (b - a) - 2.0 * da - db + t * (2.0 * (a - b) + da + db))))
        return found[0], found[1]


def oedometer(law: Any, turns: np.ndarray, pressure_ratio: np.ndarray, void_ratio: np.ndarray) -> Curve:
    """One-dimensional compression, and unloading where the control falls.

    Parameters
    ----------
    law : its constants are numbers, or one a column.
    turns : ln of the axial stress [Pa] at which the path begins, turns and ends, a row each; a column for each test.
    pressure_ratio : radial over axial stress at the begin.
    void_ratio : at the begin, tests x sets of constants.

    """

    def rates(log_stress: np.ndarray, radial: np.ndarray, e: np.ndarray, turn: np.ndarray) -> tuple:
        axial = -np.exp(log_stress)
        isotropic, f_s, (side, along, _, _), (N_side, N_along, _, _) = _operators(law, axial, radial, e)
        linear = isotropic + f_s * along * along
        strain = axial / np.maximum(linear - turn * N_along, STIFFEST * linear)
        return strain * (f_s * side * along - turn * N_side), (1.0 + e) * strain

    start = -pressure_ratio * np.exp(turns[0])[:, None]
    found = _follow(rates, turns, np.broadcast_to(start, void_ratio.shape), void_ratio, COMPRESSING)
    return found._replace(stress_Pa=-found.stress_Pa, stress_slope=-found.stress_slope)


def triaxial(law: Any, turns: np.ndarray, cell_Pa: np.ndarray, void_ratio: np.ndarray) -> Curve:
    """Drained triaxial compression from an isotropic state, and unloading where the control falls.

    Parameters
    ----------
    law : its constants are numbers, or one a column.
    turns : axial logarithmic strain at which the path begins, turns and ends, a row each; a column for each test.
    cell_Pa : kept radial stress of each test.
    void_ratio : at the begin, tests x sets of constants.

    """
    radial = -np.broadcast_to(np.asarray(cell_Pa, float)[:, None], void_ratio.shape)

    def rates(_: np.ndarray, axial: np.ndarray, e: np.ndarray, turn: np.ndarray) -> tuple:
        isotropic, f_s, (side, along, _, _), (N_side, N_along, _, _) = _operators(law, axial, radial, e)
        # radial stress kept: a x + b + N sqrt(1 + 2 x^2) = 0 of the radial strain x, the axial one being -1 or 1
        a, b = isotropic + 2.0 * f_s * side * side, -turn * f_s * side * along
        square = np.maximum(a * a - 2.0 * N_side * N_side, STIFFEST * a * a)
        x = -(a * b + N_side * np.sqrt(np.maximum(square + 2.0 * b * b, 0.0))) / square
        stress = along * f_s * (2.0 * side * x - turn * along) - turn * isotropic + N_along * np.sqrt(1.0 + 2.0 * x * x)
        return turn * stress, turn * (1.0 + e) * (2.0 * x - turn)

    found = _follow(rates, turns, radial, void_ratio, SHEARING)
    return found._replace(stress_Pa=-found.stress_Pa, stress_slope=-found.stress_slope)


def _operators(law: Any, axial: np.ndarray, radial: np.ndarray, e: np.ndarray) -> tuple:
    """The law's operators at a state of axial symmetry, tension positive."""
    stress = (radial, axial, radial, np.zeros_like(axial))
    return law.operators(stress, law.factors(stress, e))


def _follow(
    rates: Callable[..., tuple], turns: np.ndarray, stress: np.ndarray, e: np.ndarray, tolerance: float
) -> Curve:
    """A path by its rates, which take control, stress, void ratio, and 1 in loading, -1 in unloading.

    The rule of third order by Bogacki and Shampine (1989) and its error estimate; all paths take the same share of
    their way in a step, so that neighbouring sets of constants have the same error. A path of too many steps ends as
    what is no number.
    """
    found: list[tuple] = []
    tries = 0
    with np.errstate(all="ignore"):  # what is no number is left to the caller
        for begin, end in zip(turns[:-1, :, None], turns[1:, :, None], strict=True):
            way, turn = end - begin, np.where(end < begin, -1.0, 1.0)

            def slopes(done: float, y: tuple, begin=begin, way=way, turn=turn) -> tuple:
                return rates(begin + done * way, *y, turn)

            y, done, part = (stress, e), 0.0, FIRST
            now = slopes(done, y)
            found.append((begin[:, 0], *y, *now))
            while done < 1.0:
                tries += 1
                if tries > MOST_STEPS:  # no path of sand
                    lost = np.full_like(stress, np.nan)
                    found.append((end[:, 0], lost, lost, lost, lost))
                    return Curve(*(np.stack(one) for one in zip(*found, strict=True)))
                h = min(part, 1.0 - done)
                two = slopes(done + 0.5 * h, _moved(y, 0.5 * h * way, now))
                three = slopes(done + 0.75 * h, _moved(y, 0.75 * h * way, two))
                tried = _moved(
                    y,
                    h * way / 9.0,
                    tuple(2.0 * a + 3.0 * b + 4.0 * c for a, b, c in zip(now, two, three, strict=True)),
                )
                four = slopes(done + h, tried)
                miss = [
                    h * way / 72.0 * (-5.0 * a + 6.0 * b + 8.0 * c - 9.0 * d)
                    for a, b, c, d in zip(now, two, three, four, strict=True)
                ]
                error = max(_largest(miss[0] / tried[0]), _largest(miss[1])) / tolerance
                if error <= 1.0 or h <= SMALLEST:
                    done, y, now = done + h, tried, four
                    found.append(((begin + done * way)[:, 0], *y, *now))
                part = max(h * min(max(0.9 * (error + 1e-9) ** (-1.0 / 3.0), 0.2), 4.0), SMALLEST)
            stress, e = y
    return Curve(*(np.stack(one) for one in zip(*found, strict=True)))


def _moved(y: tuple, step: np.ndarray, slopes: tuple) -> tuple:
    return tuple(value + step * slope for value, slope in zip(y, slopes, strict=True))


def _largest(x: np.ndarray) -> float:
    """The largest size; paths that have become no number do not count."""
    return float(np.max(np.abs(x), where=np.isfinite(x), initial=0.0))
