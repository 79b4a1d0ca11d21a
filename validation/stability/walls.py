"""Failure mode 9: corners, outlet edges, narrow slots, and points that are pushed onto a wall."""

import numpy as np

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.velocity_transfer import Flip
from taichi_silo.mpm.walls import Coulomb, PlaneWall
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Sand, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation
from validation.stability.bodies import block, change, solver
from validation.stability.emptying import empty
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "9 walls"


def corner(shape: str, cell: float = 0.01) -> dict[str, float]:
    """Very rough walls and a bottom that sinks between them: the corners are torn open.

    Returns
    -------
    bad: points outside or not finite; residual: of the balance, over the weight; peak: largest nodal wall stress in the
    lowest 50 mm over the largest above it; separated: share of the points without stress.

    """
    scene = Scene(
        silo=Silo(width_m=0.1, height_m=0.2), walls=Walls(kind="very-rough"), grid=Mesh(cell_size_m=cell, shape=shape),
        averaging=Averaging(characteristic_length_m=0.0), flow=Flow(speed_m_per_s=0.005, displacement_m=0.005),
        machine=Machine(threads=1),
    )  # fmt: skip
    simulation = Simulation(scene)
    records = list(simulation.run())
    weight = scene.weight_N_per_m
    stress = np.mean([record.profile[0, MARGIN:, 0] for record in records[-20:]], axis=0) / cell
    return {
        "bad": float(max(record.strays for record in records)),
        "residual": float(max(abs(record.residual_N_per_m) for record in records) / weight),
        "peak": float(stress[: round(0.05 / cell)].max() / stress[round(0.05 / cell) : round(0.2 / cell)].max()),
        "separated": records[-1].separated / scene.points,
    }  # fmt: skip


def slot(cells_across: int, shape: str = "ugimp", slenderness: float = 4.0) -> dict[str, float]:
    """A silo only a few cells wide, smooth walls: N against Janssen's, and points lost."""
    cell = 0.01
    width = cells_across * cell
    height = round(slenderness * width / cell) * cell
    scene = Scene(
        sand=Sand(), silo=Silo(width_m=width, height_m=height), walls=Walls(kind="smooth", friction_angle_deg=19.0),
        grid=Mesh(cell_size_m=cell, shape=shape), flow=Flow(speed_m_per_s=0.002, displacement_m=0.0005),
        machine=Machine(threads=1),
    )  # fmt: skip
    simulation = Simulation(scene)
    records = list(simulation.run())
    ratio = scene.sand.skeleton().rest_pressure_ratio(scene.sand.void_ratio)
    theory = janssen_of(scene, scene.walls.friction_angle_deg, ratio).normal_force_N_per_m
    normal = np.mean([record.normal_N_per_m for record in records[-20:]])
    return {
        "bad": float(max(record.strays for record in records)), "normal": abs(float(normal) / theory - 1.0)
    }  # fmt: skip


def pushed(shape_name: str, friction_deg: float = 20.0, speed: float = 1.0) -> dict[str, float]:
    """Dense sand is thrown at a wall at 1 m/s and slides down along it.

    Returns
    -------
    through: how far a point got beyond where its domain touches the wall, over its half size; bad: points not finite
    or outside.

    """
    law, shape, cell, size = GudehusBauer(), SHAPES[shape_name](0.5), 0.01, 0.05
    particles, grid = block(
        width=size, height=size, cell=cell, density=law.grain_density / 1.6, origin=(0.02, 0.05), box=(0.2, 0.2),
        extra=Particles.extras(law, shape, Flip()),
    )  # fmt: skip
    count = particles.count
    change(particles, stress=np.tile([-1.0, -1.0, -1.0, 0.0], (count, 1)), velocity=np.tile([-speed, 0.0], (count, 1)))
    rough = Coulomb(friction_deg)
    walls = (PlaneWall("left", 0, -1, MARGIN, rough), PlaneWall("floor", 1, -1, MARGIN, rough))
    body = solver(particles, grid, shape, law, walls, control=NoiseControl(relaxation=50.0))
    nearest, strays, time = np.inf, 0, 0.0
    while time < 0.3 and not strays:
        dt = min(2e-5, 0.9 * body.point_sums().stable_step)
        body.advance(50, dt, gravity=(9.81, 9.81))
        time += 50 * dt
        place = particles.arrays()["position"]
        nearest = min(nearest, float(place[:, 0].min()), float(place[:, 1].min()))
        strays = body.point_sums().strays
    return {"through": max(0.0, 0.5 * cell - nearest) / (0.5 * cell), "bad": float(strays)}


def measure(full: bool = True) -> list[Measurement]:
    """Each shape at each kind of wall."""
    names = tuple(SHAPES) if full else ("ugimp",)
    found = []

    def add(words, unit, relation, bound, cases, measure):
        values = {name: case[measure] for name, case in cases.items()}
        found.extend(measurements(words, unit, relation, bound, values))

    corners = {name: corner(name) for name in names}
    add("very rough corner: points lost", "-", "<=", 0, corners, "bad")
    add("very rough corner: residual of the balance", "of W", "<=", 1e-9, corners, "residual")
    add("very rough corner: wall stress beside it over that above", "-", "<=", 1.5, corners, "peak")
    throws = {name: pushed(name) for name in names}
    add("sand thrown at a wall: points lost", "-", "<=", 0, throws, "bad")
    add("sand thrown at a wall: depth of entry", "of half a domain", "<=", 1.0, throws, "through")
    for across in (2, 4, 8) if full else (2,):
        slots = {name: slot(across, name) for name in names}
        add(f"slot of {across} cells: points lost", "-", "<=", 0, slots, "bad")
        add(f"slot of {across} cells: N over Janssen's, distance from 1", "-", "<=", 0.1, slots, "normal")
    silos = {name: empty(0.08, name, height=0.2 if full else 0.1, longest=2.0 if full else 0.3) for name in names}
    add("emptying through an outlet: error of the mass", "-", "<=", 1e-12, silos, "mass_error")
    add("emptying through an outlet: points lost", "-", "<=", 0, silos, "bad")
    add("emptying through an outlet: least void ratio", "-", ">=", 0.9 * 0.51, silos, "void_low")
    add("emptying through an outlet: greatest void ratio", "-", "<=", 1.3 * (1 + 1e-9), silos, "void_high")
    bottoms = {name: empty(None, name, height=0.2 if full else 0.1) for name in names}
    add("emptying through the bottom: sand left", "of its mass", "<=", 0, bottoms, "left")
    add("emptying through the bottom: error of the mass", "-", "<=", 1e-12, bottoms, "mass_error")
    return found
