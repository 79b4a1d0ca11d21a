"""Notices sand that ratchets while its force curves still look fine."""

from taichi_silo.measure.certificate import unexplained_densification
from taichi_silo.measure.matching import matched
from taichi_silo.observers import Observer

EVERY_PERIODS = 2  # of the column between two looks
MOST_LOST = 0.003  # of void ratio, without shear that explains it


class Watch(Observer):
    """Adds one sentence to `simulation.warnings` when oscillations have compacted the sand."""

    def begin(self, simulation) -> None:
        """Remember whom to look at."""
        self.simulation, self.filled_state, self.count, self.said = simulation, None, 0, False

    def state(self) -> dict:
        """All but the simulation."""
        return {"filled_state": self.filled_state, "count": self.count, "said": self.said}

    def restore(self, simulation, kept: dict) -> None:
        """As it was."""
        self.simulation = simulation
        self.filled_state, self.count, self.said = kept["filled_state"], kept["count"], kept["said"]

    def filled(self) -> None:
        """Keep the state that the flow starts from."""
        self.filled_state = self.simulation.points()

    def observe(self, record) -> None:
        """Compare the sand that has not been sheared with its state after filling."""
        self.count += 1
        if self.simulation.scene.flow.outflow == "gravity":
            return  # sand that falls is not at rest, and lands as it can
        if self.said or self.filled_state is None or self.count % (EVERY_PERIODS * self.simulation.rows_per_period):
            return
        now, scene = self.simulation.points(), self.simulation.scene
        if not len(now["mass"]):
            return
        lost, where = unexplained_densification(matched(self.filled_state, now), now, scene)
        if lost > MOST_LOST:
            self.said = True
            x, y = now["position"][where]
            cure = "switch the noise control on"
            if scene.method.noise_control != "none":
                cure = "slender silos and fine cells need more control: try larger cells or a slower bottom"
            self.simulation.warnings.append(
                f"At t = {record.time_s:.3f} s (u = {1e3 * record.displacement_m:.3f} mm) sand that has not been "
                f"sheared has lost {lost:.4f} of void ratio since the filling, most of it near x = {1e3 * x:.0f} mm, "
                f"y = {1e3 * y:.0f} mm: oscillations compact it (ratcheting), and N is too high; {cure}."
            )
