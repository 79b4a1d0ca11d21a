"""Failure mode 8: small oscillations that eat stress and void ratio: a silo that is shaken, and one that flows."""

import math

import numpy as np

from taichi_silo.errors import RunFailed
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.simulation.wall_forces import LEFT, RIGHT
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "8 ratcheting"
AMPLITUDE_M, FREQUENCY_HZ, SHAKEN_S = 20e-6, 25.0, 0.24
PLAIN = {"noise_control": "none"}
METHODS = {  # method, law, noise control where it is not the scene's own
    "drag to the mean (default)": ({"noise_control": "column"}, "gudehus-bauer", None),
    "no control": (PLAIN, "gudehus-bauer", None),
    "relaxation to the grid only": (PLAIN, "gudehus-bauer", "relaxation"),
    "blend, 5 % PIC": (PLAIN | {"transfer": "blend"}, "gudehus-bauer", None),
    "PIC": (PLAIN | {"transfer": "pic"}, "gudehus-bauer", None),
    "APIC": (PLAIN | {"transfer": "apic"}, "gudehus-bauer", None),
    "XPIC": (PLAIN | {"transfer": "xpic"}, "gudehus-bauer", None),
    "gradient": (PLAIN | {"transfer": "gradient"}, "gudehus-bauer", None),
    "stress first": (PLAIN | {"stress_update": "first"}, "gudehus-bauer", None),
    "modified last": (PLAIN | {"stress_update": "modified"}, "gudehus-bauer", None),
    "stress first + default": ({"stress_update": "first"}, "gudehus-bauer", None),
    "modified last + default": ({"stress_update": "modified"}, "gudehus-bauer", None),
    "APIC + default": ({"transfer": "apic"}, "gudehus-bauer", None),
    "smoothing filter": (PLAIN | {"stress_filter": "smoothing"}, "gudehus-bauer", None),
    "intergranular strain": (PLAIN, "intergranular", None),
    "intergranular + default": ({"noise_control": "column"}, "intergranular", None),
}
LOST = dict.fromkeys(("filled", "shaken", "shaken_void", "flow_void", "flow_path", "noise", "steady"), math.inf) | {
    "shaken": -math.inf, "time": [0.0], "normal": [math.inf], "janssen": 1.0,
}  # fmt: skip
QUICK = ("drag to the mean (default)", "no control")


def silo(method: dict, law: str, control: str | None) -> Simulation:
    """The model silo on 10 mm cells, dense sand, smooth walls."""
    scene = Scene(
        silo=Silo(half="no"), sand=Sand(law=law), walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=0.01), flow=Flow(speed_m_per_s=0.005, displacement_m=0.002),
        method=Method(longest_settling_s=0.3, **method), machine=Machine(threads=1),
    )  # fmt: skip
    simulation = Simulation(scene)
    if control is None:
        return simulation
    whole = NoiseControl.for_column(simulation.model.period)
    return Simulation(scene, NoiseControl(**{control: getattr(whole, control)}))


def state(simulation: Simulation) -> dict[str, float]:
    """Mean void ratio and path length of the strain of the core: below 0.9 of the height, the middle half."""
    points = simulation.points()
    x, y = points["position"].T
    width, height = simulation.scene.silo.width_m, simulation.scene.silo.height_m
    core = (np.abs(x - 0.5 * width) < 0.25 * width) & (y < 0.9 * height)
    return {"void_ratio": float(points["void_ratio"][core].mean()), "path": float(points["path"][core].mean())}


def shaken(simulation: Simulation) -> list[float]:
    """Shake the bottom of a filled silo at rest up and down; N of both walls' mean in each period [N/m]."""
    solver, g = simulation.solver, simulation.model.gravity
    quarter, top = 0.25 / FREQUENCY_HZ, 4.0 * AMPLITUDE_M * FREQUENCY_HZ * 2.0
    found = []
    for _ in range(round(SHAKEN_S * FREQUENCY_HZ)):
        impulse = 0.0
        for pair in ((0.0, top), (top, 0.0), (0.0, -top), (-top, 0.0)):
            steps = max(1, math.ceil(quarter / (0.9 * solver.point_sums().stable_step)))
            solver.advance(steps, quarter / steps, (g, g), pair)
            reaction, _ = solver.impulses.read_and_reset()
            impulse += 0.5 * (reaction[LEFT, :, 0].sum() - reaction[RIGHT, :, 0].sum())
        found.append(float(impulse * FREQUENCY_HZ))
    return found


def history(method: dict, law: str, control: str | None) -> dict:
    """Fill a silo and shake it; filled as it was, let it flow by 2 mm.

    Returns
    -------
    filled, shaken: N before and after [N/m], `shaken_void`: change of the core's void ratio; time and N of the flow
    [s, N/m], `flow_void`, `flow_path`: changes of the core's void ratio and path length; `janssen` [N/m]; `noise`: RMS
    of N in flow over its mean; `rest`: P + 2 T over W at the end of the flow.

    """
    simulation = silo(method, law, control)
    for record in simulation.fill():
        filled = record.normal_N_per_m
    before = state(simulation)
    points, memory = simulation.model.particles.arrays(), simulation.solver.grid.memory.to_numpy()
    periods = shaken(simulation)
    after = state(simulation)
    simulation.model.particles.load(points)
    simulation.solver.grid.memory.from_numpy(memory)
    rows = [(r.time_s, r.normal_N_per_m, (r.bottom_force_N_per_m + 2 * r.shear_N_per_m) / r.weight_N_per_m)
            for r in simulation.flow()]  # fmt: skip
    end = state(simulation)
    rows = np.array(rows)
    scene = simulation.scene
    ratio = scene.sand.skeleton().rest_pressure_ratio(scene.sand.void_ratio)
    theory = janssen_of(scene, scene.walls.friction_angle_deg, ratio)
    steady = rows[len(rows) // 2 :, 1]
    return {
        "filled": float(filled), "shaken": periods[-1], "shaken_void": after["void_ratio"] - before["void_ratio"],
        "time": rows[:, 0].tolist(), "normal": rows[:, 1].tolist(), "janssen": theory.normal_force_N_per_m,
        "flow_void": end["void_ratio"] - before["void_ratio"], "flow_path": end["path"] - before["path"],
        "noise": float(steady.std() / steady.mean()), "steady": float(steady.mean()),
    }  # fmt: skip


def curves(full: bool = True) -> dict[str, dict]:
    """Histories of all methods, by name; a method whose run fails is lost."""
    found = {}
    for name in METHODS if full else QUICK:
        try:
            found[name] = history(*METHODS[name])
        except RunFailed:
            found[name] = LOST
    return found


def judge(histories: dict[str, dict]) -> list[Measurement]:
    """Measurements of each noise control and transfer, and of intergranular strain, from their histories."""
    found = []
    for words, unit, bound, value in (
        ("N after filling over Janssen's, distance from 1", "-", 0.1, lambda h: abs(h["filled"] / h["janssen"] - 1)),
        ("N in flow over Janssen's, distance from 1", "-", 0.1, lambda h: abs(h["steady"] / h["janssen"] - 1)),
        ("change of void ratio in flow", "-", 0.003, lambda h: abs(h["flow_void"])),
        ("path length of the strain in flow", "-", 5e-4, lambda h: h["flow_path"]),
        ("noise of N in flow", "of N", 0.01, lambda h: h["noise"]),
        ("shaken at rest: change of N", "of Janssen's", 0.1, lambda h: abs(h["shaken"] - h["filled"]) / h["janssen"]),
        ("shaken at rest: change of void ratio", "-", 0.003, lambda h: abs(h["shaken_void"])),
    ):
        values = {name: value(history) for name, history in histories.items()}
        found += measurements(words, unit, "<=", bound, values)
    return found
