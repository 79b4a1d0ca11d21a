"""Checks of a record: numbers that every interval gives."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from taichi_silo.scene.scene import Scene
from taichi_silo.simulation.alarm import Alarm
from taichi_silo.simulation.record import Record
from taichi_silo.simulation.simulation import Simulation

LONGEST_STEP = 1.5  # over the stable one; beyond, sand ratchets long before it explodes
LONGEST_FALLING = 4.0  # the same in free outflow, where one point that lands is stiff within a few steps
DENSEST = 0.9  # of e_d0: no sand is denser
LOOSEST = 1.001  # of e_i0: no sand that carries stress is looser, and what has separated keeps it
FASTEST = 0.3  # of the wave speed: sand that falls through the whole silo stays far below
MOST_SEPARATED = 0.5  # of the points: more, and the fill is falling apart
BALANCE = 1e-6  # of the weight of the filled silo; round-off leaves 1e-15
STORED = 2.0  # how often over the sand may give back what the stiffness at its stress says that it has stored
REST = 1e-6  # of the weight times the height: error of the sums of energy that is allowed
SWIFT = 5.0  # kinetic energy of controlled outflow over that of the whole sand at the speed of the outlet


class Check:
    """One kind of wrongness in a simulation; `look` gives an alarm where it finds it."""

    def __init__(self, simulation: Simulation):
        self.simulation = simulation

    def state(self) -> dict:
        """What it has to know to go on after a break: numbers, words, arrays."""
        return {}

    def restore(self, kept: dict) -> None:
        """Go on from a `state`; empty if there was none."""

    @property
    def free(self) -> bool:
        """Whether sand moves by its weight alone."""
        return self.simulation.scene.flow.free and self.simulation.stage == "flow"

    def at_most(self, alarm: Alarm, measure: Callable[[dict[str, np.ndarray]], np.ndarray]) -> Alarm:
        """The alarm at the point where a measure of the points is greatest."""
        points = self.simulation.points()
        index = int(np.argmax(measure(points)))
        return alarm.at(points["position"][index], points["identity"][index])


def smaller_step(scene: Scene) -> str:
    """How the time step of a scene is made smaller: by the value that it has."""
    if scene.method.time_step_s is not None:
        return f"a smaller method.time_step_s than {scene.method.time_step_s:g} s, or none, helps"
    cfl = scene.method.cfl
    return "method.cfl = 0.2 helps" if cfl is None or cfl > 0.2 else f"a smaller method.cfl than {cfl:g} helps"


def quieter(scene: Scene) -> str:
    """What is said further where the noise control is off."""
    return ', and so does method.noise_control = "column"' if scene.method.noise_control == "none" else ""


def speed(points: dict[str, np.ndarray]) -> np.ndarray:
    """Of points [m/s]."""
    return np.hypot(*points["velocity"].T)


class TimeStep(Check):
    """The step of an interval against the stable one at its end: stress, and with it stiffness, rises within."""

    def look(self, record: Record) -> Alarm | None:
        """Compare the step of a record with the stable one at its end."""
        limit = LONGEST_FALLING if self.free else LONGEST_STEP
        over = record.time_step_s / record.stable_step_s
        if not over > limit:
            return None
        method, stage = self.simulation.scene.method, self.simulation.stage
        slower = "filling" if stage == "filling" else "outflow"
        cause, remedy = (
            "the stress has risen faster than the step follows",
            f"a slower {slower} or method.cfl = 0.2 helps",
        )
        for name, value in (("time step", method.time_step_s), ("cfl", method.cfl)):
            if value is not None:
                cause, remedy = f"a {name} was given", f"let the {'step' if name == 'cfl' else name} be chosen"
        return Alarm(
            "time step", True,
            f"the time step of {1e6 * record.time_step_s:.1f} us is above {limit} times the stable one of "
            f"{1e6 * record.stable_step_s:.1f} us", cause, remedy, over, limit,
        )  # fmt: skip


class Speed(Check):
    """The fastest point against waves in the sand."""

    def look(self, record: Record) -> Alarm | None:
        """Compare the fastest point of a record."""
        limit = FASTEST * self.simulation.model.wave_speed
        if not record.speed_m_per_s > limit:
            return None
        alarm = Alarm(
            "speed", True,
            f"a point{{place}} moves at {record.speed_m_per_s:.1f} m/s, more than {FASTEST} of the speed of waves in "
            "the sand", "the computation is exploding", self._calmer(),
            record.speed_m_per_s, limit,
        )  # fmt: skip
        return self.at_most(alarm, speed)

    def _calmer(self) -> str:
        scene = self.simulation.scene
        words = smaller_step(scene)
        return f'grid.shape = "ugimp" helps, or {words}' if scene.grid.shape == "linear" else words


class Density(Check):
    """The densest and the loosest point against what sand can be."""

    def look(self, record: Record) -> Alarm | None:
        """Compare the extremes of a record."""
        sands = self.simulation.scene.sand.sands
        densest, loosest = DENSEST * min(one.e_d0 for one in sands), LOOSEST * max(one.e_i0 for one in sands)
        if record.void_ratio_low < densest:
            alarm = Alarm(
                "void ratio", True,
                f"the void ratio falls to {record.void_ratio_low:.3f}{{place}}, below {densest:.3f}, denser than any "
                "packing", *self._compactor(), record.void_ratio_low, densest,
            )  # fmt: skip
            return self.at_most(alarm, lambda points: -abs(points["void_ratio"] - record.void_ratio_low))
        if record.void_ratio_high > loosest:
            alarm = Alarm(
                "void ratio", True,
                f"the void ratio rises to {record.void_ratio_high:.3f}{{place}}, above {loosest:.3f}, looser than any "
                "packing", "sand that separates has not been noticed", smaller_step(self.simulation.scene),
                record.void_ratio_high, loosest,
            )  # fmt: skip
            return self.at_most(alarm, lambda points: points["void_ratio"])
        return None

    def _compactor(self) -> tuple[str, str]:
        if self.simulation.scene.method.stress_filter == "smoothing":
            return "the smoothing filter lets sand creep under its weight", "the default, patch, does not"
        return "oscillations have compacted it", smaller_step(self.simulation.scene) + quieter(self.simulation.scene)


class Separation(Check):
    """Points without stress in a silo that should be full of sand."""

    def look(self, record: Record) -> Alarm | None:
        """Count the points of a record that carry no stress."""
        limit = MOST_SEPARATED * self.simulation.scene.points
        if record.stage != "flow" or self.free or record.separated <= limit:
            return None
        alarm = Alarm(
            "separation", True,
            f"{record.separated} of {self.simulation.scene.points} points carry no stress, the loosest{{place}}",
            "the fill is falling apart", "a slower bottom lets it follow", record.separated, limit,
        )  # fmt: skip
        return self.at_most(alarm, lambda points: points["void_ratio"])


class Balance(Check):
    """Forces, weight and inertia: what they leave over is round-off."""

    def __init__(self, simulation: Simulation):
        super().__init__(simulation)
        self.limit = BALANCE * simulation.model.mass * simulation.model.gravity  # [N/m]

    def look(self, record: Record) -> Alarm | None:
        """Compare the rest of a record."""
        residual = abs(record.residual_N_per_m)
        if residual <= self.limit:  # not so if it is no number
            return None
        return Alarm(
            "force balance", True,
            f"walls, weight and inertia are out of balance by {residual:.3g} N/m, more than {BALANCE:g} of the weight",
            "an impulse is not in the books: this is a defect of the program, or of the memory of this machine",
            "run once more, and report it if it comes again", residual, self.limit,
        )  # fmt: skip


class _Window(Check):
    """Looks at sums over the last period of the column."""

    def __init__(self, simulation: Simulation):
        super().__init__(simulation)
        self.rows: deque[tuple[float, ...]] = deque(maxlen=simulation.scene.output.records_per_period)

    def state(self) -> dict:
        """The terms of the sums."""
        return {"rows": [list(row) for row in self.rows]}

    def restore(self, kept: dict) -> None:
        """Go on with the terms that were there."""
        self.rows.extend(tuple(row) for row in kept.get("rows", ()))

    def full(self, *row: float) -> bool:
        """Add the terms of a record; whether there are those of a whole period."""
        self.rows.append(row)
        return len(self.rows) == self.rows.maxlen

    def total(self, column: int) -> float:
        """Sum of one of the terms."""
        return math.fsum(row[column] for row in self.rows)


class Energy(_Window):
    """Kinetic energy against its sources.

    Over any time sand cannot gain more of it than gravity and moving walls have done in work, and than was stored at
    the beginning in its stress and in inclined walls, which are springs.
    """

    def __init__(self, simulation: Simulation):
        super().__init__(simulation)
        self.rows = deque(maxlen=simulation.scene.output.records_per_period + 1)
        weight = simulation.model.mass * simulation.model.gravity
        self.error = REST * weight * simulation.scene.silo.height_m  # that round-off may make [J/m]

    def look(self, record: Record) -> Alarm | None:
        """Compare over the last period."""
        if not self.full(record.kinetic_gain_J_per_m, record.work_J_per_m, record.stored_J_per_m):
            return None
        begun = self.rows[0]  # ends where the period begins
        gain, stored = self.total(0) - begun[0], begun[2]
        limit = max(self.total(1) - begun[1], 0.0) + STORED * stored + self.error
        if not gain > limit:
            return None
        alarm = Alarm(
            "energy", True,
            f"the sand has gained {gain:.3g} J/m of motion within a period, the fastest{{place}}; weight, walls and "
            f"stress can have given {limit:.3g} J/m", "the computation makes energy of nothing",
            smaller_step(self.simulation.scene) + quieter(self.simulation.scene), gain, limit,
        )  # fmt: skip
        return self.at_most(alarm, speed)


class Motion(_Window):
    """Kinetic energy of controlled outflow against that of sand which follows the outlet as one body."""

    def look(self, record: Record) -> Alarm | None:
        """Compare the mean of the last period."""
        simulation = self.simulation
        if self.free or record.stage != "flow" or not self.full(record.kinetic_energy_J_per_m):
            return None
        limit = SWIFT * 0.5 * simulation.model.mass * simulation.scene.flow.speed_m_per_s**2
        mean = self.total(0) / len(self.rows)
        if mean <= limit:
            return None
        alarm = Alarm(
            "not quasi-static", False,
            f"the sand has {mean / limit * SWIFT:.3g} times the kinetic energy that it would have at the speed of the "
            "outlet, the fastest{place}, though the outflow is controlled",
            "it falls or oscillates instead of following",
            f"a smaller flow.speed_m_per_s helps{quieter(simulation.scene)}", mean, limit,
        )  # fmt: skip
        return self.at_most(alarm, speed)
