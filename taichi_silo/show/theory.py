"""The theories that figures and reports set beside a run: Janssen, EN 1991-4, and friction in critical simple shear."""

from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.runs.eurocode import eurocode_of
from taichi_silo.runs.result import Result
from taichi_silo.runs.theories import critical_simple_shear_angle_deg, janssen_of

TABLE_PRESSURE_RATIO = 0.45  # sand, EN 1991-4 table E.1
ORIGINS = {"K0": "K0 of the law", "measured": "measured K"}  # ends of names in summary.json: origins of K


def straight_m(run: Result) -> float:
    """Height of sand between vertical walls [m]."""
    return run.scene.silo.straight_m


def wall_angle_deg(run: Result) -> float:
    """Friction angle along the walls: the wall's own, or of critical simple shear at walls that have none.

    Of walls with bands it is arctan(T / N) after Janssen.
    """
    if run.scene.walls.bands and straight_m(run):
        ratio = next(iter(pressure_ratios(run).values()))
        return janssen_of(run.scene, 0.0, ratio).wall_friction_angle_deg
    if run.scene.walls.friction_angle_deg is not None:
        return run.scene.walls.friction_angle_deg
    return critical_simple_shear_angle_deg(run.scene.sand.critical_friction_angle_deg)


def pressure_ratios(run: Result) -> dict[str, float]:
    """Pressure ratios for Janssen's theory by origin: the law's and the measured one, or a table's."""
    stored = run.summary.get("janssen") or {}
    known = {origin: stored.get(f"pressure_ratio_{key}") or 0.0 for key, origin in ORIGINS.items()}
    return {origin: ratio for origin, ratio in known.items() if ratio > 0.0} or {"K of EN 1991-4": TABLE_PRESSURE_RATIO}


def janssen(run: Result, pressure_ratio: float) -> Janssen | None:
    """Janssen's theory of the vertical walls of a run's silo; None without such walls.

    Its friction angle is the one stored with the pressure ratios, for very rough walls the mobilised one.
    """
    if not straight_m(run):
        return None
    stored = (run.summary.get("janssen") or {}).get("wall_friction_angle_deg")
    angle = stored if stored is not None and 0.0 <= stored < 90.0 else wall_angle_deg(run)
    return janssen_of(run.scene, angle, pressure_ratio)


def filled_beside_janssen(theory: dict, name: str, filled: float | None) -> float | None:
    """P, T or N after filling as Janssen's theory counts it: of walls that are not alike above the higher foot.

    `theory` is that of the summary, `filled` the force of the whole walls.
    """
    walls, key = theory.get("walls"), {"T": "shear_N_per_m", "N": "normal_N_per_m"}.get(name)
    return filled if not walls or key is None else sum(wall[key] for wall in walls.values()) / len(walls)


def eurocode(run: Result) -> EurocodeSilo | None:
    """The code's silo of this shape, with the solid of the scene; None without vertical walls."""
    return eurocode_of(run.scene)
