"""The quasi-static certificate: numbers for how far to trust a run."""

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.deformation import Rings
from taichi_silo.analysis.measure.matching import matched
from taichi_silo.analysis.measure.wall_pressure import SURFACE
from taichi_silo.scene import fill_shape
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation.simulation import Simulation

ALIKE = 1e-9  # difference of the walls' N over the weight that round-off makes
UNSHEARED = 0.005  # net shear strain up to which shear explains no densification
MEAN_SPAN_PERIODS = (
    3  # of the moving mean that noise is measured against: whole periods of the column, or its mode stays
)
STEADY_AFTER_PERIODS = 7.5  # since the bottom began to move: its start, five periods, and the noise control's memory


def certificate(records: pd.DataFrame, filled: dict | None, final: dict, simulation: Simulation) -> dict:
    """Measure how quasi-static a run was; what it did not get far enough for is absent.

    Parameters
    ----------
    records : one row an interval, the columns named as the attributes of `Record`.
    filled, final : states of the points after filling (None before) and at the end (`Simulation.points` plus
        `displacement_m` and `time_s`).
    simulation : the run, at its end.

    """
    weight = simulation.scene.weight_N_per_m
    filled = matched(filled, final) if filled is not None else None
    found = {
        "force_balance_residual_over_weight": float(records.residual_N_per_m.abs().max() / weight),
        "largest_time_step_over_stable": float((records.time_step_s / records.stable_step_s).max()),
        "settled_before_flow": bool(simulation.clock.settled),
    }
    flow = records[records.stage == "flow"]
    if flow.empty or filled is None:
        return found
    if simulation.model.section.points_per_computed == 1:  # else they are equal because one is the other's image
        found |= _left_right(records, weight)
    if simulation.scene.flow.outflow == "controlled":
        work = weight * flow.displacement_m
        found["largest_kinetic_energy_over_work"] = float((flow.kinetic_energy_J_per_m / work).max())
        found |= _steady_measures(flow, simulation)
    return found | _state_measures(filled, final, simulation.scene) if len(final["mass"]) else found


def _left_right(records: pd.DataFrame, weight: float) -> dict:
    """Largest difference of the walls' N in flow over the weight, and from where on it stays above round-off.

    The latter is absent where it has fallen below again, and 0 where it was there before the flow.
    """
    difference = (records.left_normal_N_per_m - records.right_normal_N_per_m).abs() / weight
    flow = records.stage == "flow"
    found = {"left_right_difference_over_weight": float(difference[flow].max())}
    alike = np.flatnonzero(difference <= ALIKE)
    first = alike[-1] + 1 if len(alike) else 0
    if first < len(records):
        found["left_right_difference_from_displacement_m"] = float(records.displacement_m.iloc[first])
    return found


def _steady_measures(flow: pd.DataFrame, simulation: Simulation) -> dict:
    """Noise and kinetic energy, once the oscillation from the start of the bottom has decayed."""
    period, weight = simulation.model.period, simulation.scene.weight_N_per_m
    steady = flow[flow.time_s > (simulation.clock.flow_start or 0.0) + STEADY_AFTER_PERIODS * period]
    if len(steady) < 2 * MEAN_SPAN_PERIODS * period / flow.interval_s.median():
        return {}
    # means over a swing as long as it is under the control, which answers single swings by design
    swing = period * simulation.model.control.slows()
    control = _rolling(steady.noise_control_force_N_per_m, steady.interval_s, swing).abs() / weight
    rigid = 0.5 * simulation.model.mass * simulation.scene.flow.speed_m_per_s**2
    energy = steady.kinetic_energy_J_per_m / rigid
    moving: dict[str, float | list[float]] = {}
    if simulation.scene.silo.floor_is_outlet:  # else the sand does not move as one body
        moving["kinetic_energy_over_rigid_motion"] = [float(energy.min()), float(energy.max())]
    if steady.normal_N_per_m.mean() > 0.0:  # else inclined walls lead up to the surface
        span = MEAN_SPAN_PERIODS * period
        moving["noise_of_normal_force"] = noise(steady.normal_N_per_m, steady.interval_s, span)
    return moving | {
        "noise_control_force_over_weight_99th_percentile": float(control.quantile(0.99)),
        "largest_noise_control_force_over_weight": float(control.max()),
    }


def _state_measures(filled: dict, final: dict, scene: Scene) -> dict:
    """Change of void ratio, strain path and inertial number between two states of the same points."""
    width = scene.silo.width_m
    left, right = fill_shape.sides_m(scene.silo)
    x, y = filled["position"].T
    below = y < SURFACE * fill_shape.top_m(scene.silo, x)
    core = below & (np.abs(x - 0.5 * (left + right)) <= 0.25 * (right - left) * (1.0 + 1e-9))
    mass = filled["mass"]
    if scene.silo.section == "round":  # per metre of the point's own girth
        mass = mass * np.abs(x - 0.5 * width)
    if not below.any() or not core.any():
        return {}
    growth = final["void_ratio"] - filled["void_ratio"]
    path = final["path"] - filled["path"]
    still = _unsheared(filled, final, below)
    found = {
        "mean_void_ratio_drift": float(np.average(growth[below], weights=mass[below])),
        "core_strain_path": float(np.average(path[core], weights=mass[core])),
        "unsheared_share": float(still.sum() / below.sum()),
    }
    if still.any():
        found["unexplained_densification"] = unexplained_densification(filled, final, scene)[0]
    inertial = inertial_number(path, final["time_s"] - filled["time_s"], final["stress"], scene)
    found["inertial_number_99th_percentile"] = float(np.percentile(inertial[below], 99))
    return found


def inertial_number(path: np.ndarray, seconds: float, stress: np.ndarray, scene: Scene) -> np.ndarray:
    """Inertial number (n,): shear rate times grain size over the root of pressure over grain density [-].

    `path` is the path length of the strain within so many seconds (n,), `stress` the present one (n, 4) [Pa].
    """
    pressure = np.maximum(-stress[:, :3].sum(axis=1) / 3.0, 1.0)
    rate = np.sqrt(2.0) * path / seconds
    return rate * scene.sand.d50_m * np.sqrt(scene.sand.grain_density_kg_per_m3 / pressure)


def _unsheared(filled: dict, now: dict, below: np.ndarray, rings: Rings | None = None) -> np.ndarray:
    """Which of the points `below` the surface (n,) have a net shear strain under 0.005 since `filled`."""
    rings = rings or Rings(filled["position"])
    return below & (rings.net_shear(now["position"]) < UNSHEARED)


def unexplained_densification(filled: dict, now: dict, scene: Scene, rings: Rings | None = None) -> tuple[float, int]:
    """Mean loss of void ratio of the sand that has not been sheared since `filled`, and the point that lost most.

    Both are states of the points (`Simulation.points`); `rings` those of the first, computed here if not given. 0 where
    all sand has been sheared.
    """
    x, y = filled["position"].T
    still = _unsheared(filled, now, y < SURFACE * fill_shape.top_m(scene.silo, x), rings)
    if not still.any():
        return 0.0, 0
    loss = np.where(still, filled["void_ratio"] - now["void_ratio"], -np.inf)
    return float(np.average(loss[still], weights=filled["mass"][still])), int(np.argmax(loss))


def noise(force: pd.Series, interval_s: pd.Series, span_s: float) -> float:
    """RMS of a force about its moving mean over `span_s`, over its mean [-]."""
    smooth = _rolling(force, interval_s, span_s)
    return float(np.sqrt(((force - smooth) ** 2).mean()) / force.mean())


def _rolling(values: pd.Series, interval_s: pd.Series, span_s: float) -> pd.Series:
    """Centred moving mean over a time span."""
    rows = max(1, round(span_s / interval_s.median()))
    return values.rolling(rows, center=True, min_periods=rows).mean()
