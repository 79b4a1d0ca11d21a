"""The film of a run: `void_ratio.mp4`."""

from pathlib import Path

import numpy as np

from taichi_silo.observers import Observer
from taichi_silo.observers.canvas import Course
from taichi_silo.observers.film import Film

FRAMES_PER_SECOND = 30
FLOW_FRAMES, FILLING_FRAMES = 405, 45  # 15 s


class Movie(Observer):
    """A frame each time the bottom has moved, or the filling has taken, a fixed share of the whole."""

    def __init__(self, file: Path):
        self.file = file

    def begin(self, simulation) -> None:
        """Open the film."""
        self.simulation, scene = simulation, simulation.scene
        settling = 10.0 * simulation.period  # an estimate; a longer rest adds no frames
        self.filling_span = simulation.filling_time + settling
        self.drawn, self.curves = {"filling": 0, "flow": 0}, []
        self.course = course(scene)
        self.film = Film(
            self.file,
            width_m=scene.silo.width_m,
            height_m=scene.silo.height_m,
            displacement_m=scene.flow.displacement_m,
            spacing_m=simulation.spacing,
            weight_N_per_m=scene.weight_N_per_m,
            void_ratio_range=void_ratio_range(scene),
            title=title(scene),
            frames_per_second=FRAMES_PER_SECOND,
            course=self.course,
            solids=None if scene.silo.sinks else floors(scene.silo) + scene.silo.solids(),
        )

    def state(self) -> dict:
        """The curves, how many frames are drawn, and the pieces of film that hold them."""
        return {"curves": np.array(self.curves), "drawn": self.drawn, "pieces": self.film.segments.cut()}

    def restore(self, simulation, kept: dict) -> None:
        """Draw the curves once more, and go on after the pieces."""
        self.begin(simulation)
        self.drawn, self.curves = kept["drawn"], kept["curves"].tolist()
        for row in self.curves:
            self.film.add_forces(*row)
        self.film.segments.go_on(kept["pieces"])

    def observe(self, record) -> None:
        """Extend the curves, and draw when a frame is due."""
        progress = self._progress(record)
        self.curves.append((progress, record.bottom_N_per_m, record.shear_N_per_m, record.normal_N_per_m))
        self.film.add_forces(*self.curves[-1])
        flowing = record.stage == "flow"
        frames = FLOW_FRAMES if flowing else FILLING_FRAMES
        part = progress / self.course.end if flowing else record.time_s / self.filling_span
        due = min(frames, int(part * frames + 1e-9))
        if due > self.drawn[record.stage]:
            points = self.simulation.points()
            for _ in range(due - self.drawn[record.stage]):  # a fast bottom: frames repeat, the film keeps its length
                self.film.add_frame(
                    points["position"], points["void_ratio"], time_s=record.time_s, stage=record.stage,
                    displacement_m=progress,
                )  # fmt: skip
            self.drawn[record.stage] = due

    def _progress(self, record) -> float:
        """Place on the course: the displacement, or of free outflow the time since the gate opened."""
        if self.simulation.scene.flow.outflow == "gravity":
            return record.time_s - self.simulation.flow_start if record.stage == "flow" else 0.0
        return record.displacement_m

    def end(self) -> None:
        """Join the film, also a short one; its pieces stay, for a run that goes on."""
        self.film.segments.close(keep=True)


def course(scene) -> Course:
    """What the curves are drawn against."""
    if scene.flow.outflow == "gravity":
        return Course(scene.flow.longest_s, "time since the outlet opened (s)", "open since", "s", 1.0)
    if scene.silo.sinks:
        return Course(scene.flow.displacement_m)
    return Course(scene.flow.displacement_m, "displacement u of the outlet (mm)")


def floors(silo) -> list[np.ndarray]:
    """Outlines of the floor beside the outlet [m]."""
    left, right = silo.outlet_m
    deep = -0.1 * silo.height_m
    spans = ((0.0, left), (right, silo.width_m))
    return [np.array([[a, 0.0], [b, 0.0], [b, deep], [a, deep]]) for a, b in spans if b > a]


def void_ratio_range(scene) -> tuple[float, float]:
    """Ends of the colours: from the initial to the critical void ratio, and a little beyond."""
    low, high = sorted((scene.sand.void_ratio, scene.sand.e_c0))
    margin = max(0.1 * (high - low), 0.02)
    return low - margin, high + margin


def title(scene) -> str:
    """What is seen."""
    walls = "very rough walls"
    if scene.walls.kind == "smooth":
        walls = f"smooth walls ({scene.wall_friction_angle_deg:g}°)"
    silo = scene.silo.words()
    words = [f"{scene.sand.name.capitalize()} sand, e₀ = {scene.sand.void_ratio:.2f}", walls, silo]
    return ", ".join(word for word in words if word)
