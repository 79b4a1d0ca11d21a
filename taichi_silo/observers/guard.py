"""Stops a run that has gone wrong, and says when, where and why."""

import numpy as np

from taichi_silo.faults import RunFailed
from taichi_silo.observers import Observer

LONGEST_STEP = 1.5  # over the stable one; beyond, sand ratchets long before it explodes
LONGEST_FALLING = 4.0  # the same in free outflow, where one point that lands is stiff within a few steps
DENSEST = 0.9  # of e_d0: no sand is denser
FASTEST = 0.3  # of the wave speed: sand that falls through the whole silo stays far below
MOST_SEPARATED = 0.5  # of the points: more, and the fill is falling apart


class Guard(Observer):
    """Checks each record.

    Raises
    ------
    RunFailed
        from `observe`, naming the time, the place and the likely cause.

    """

    def begin(self, simulation) -> None:
        """Remember whom to look at."""
        self.simulation = simulation

    def observe(self, record) -> None:
        """Points lost or not finite, void ratio out of bounds, step too long."""
        when = f"at t = {record.time_s:.4f} s ({record.stage}, u = {1e3 * record.displacement_m:.3f} mm)"
        given = self.simulation.scene.method.time_step_s is not None
        advice = "let it be chosen, or give a smaller one" if given else "the bottom is too fast for this grid"
        free = self.simulation.scene.flow.outflow == "gravity" and record.stage == "flow"
        longest = LONGEST_FALLING if free else LONGEST_STEP
        if record.time_step_s > longest * record.stable_step_s:
            raise RunFailed(
                f"{when} the time step of {1e6 * record.time_step_s:.1f} us is above {longest} times the stable "
                f"one of {1e6 * record.stable_step_s:.1f} us; {advice}"
            )
        if record.speed_m_per_s > FASTEST * self.simulation.wave_speed:
            raise RunFailed(
                f"{when} a point near {self._where('fastest')} moves at {record.speed_m_per_s:.1f} m/s, more than "
                f"{FASTEST} of the speed of waves in the sand; the computation is exploding (a smaller time step, "
                "another shape than linear?)"
            )
        densest = DENSEST * self.simulation.scene.sand.e_d0
        if record.void_ratio_low < densest:
            raise RunFailed(
                f"{when} the void ratio falls to {record.void_ratio_low:.3f} near {self._where('densest')}, below "
                f"{densest:.3f}, denser than any packing; {self._compactor()}"
            )
        if record.stage == "flow" and not free and record.separated > MOST_SEPARATED * self.simulation.scene.points:
            raise RunFailed(
                f"{when} {record.separated} of {self.simulation.scene.points} points carry no stress, the loosest near "
                f"{self._where('loosest')}; the fill is falling apart (is the bottom too fast?)"
            )

    def _compactor(self) -> str:
        if self.simulation.scene.method.stress_filter == "smoothing":
            return "the smoothing filter lets sand creep under its weight (null-space does not)"
        return "oscillations have compacted it (is there a noise control?)"

    def _where(self, what: str) -> str:
        points = self.simulation.points()
        measure = {
            "densest": lambda: -points["void_ratio"],
            "loosest": lambda: points["void_ratio"],
            "fastest": lambda: np.hypot(*points["velocity"].T),
        }[what]
        index = int(np.argmax(measure()))
        x, y = points["position"][index]
        return f"x = {1e3 * x:.1f} mm, y = {1e3 * y:.1f} mm"
