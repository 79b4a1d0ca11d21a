"""Random scenes, 200 steps each: mass exact, balance closed, void ratio within its limits, nothing outside."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from taichi_silo import runtime
from taichi_silo.scene import Averaging, Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.shapes import SHAPES
from taichi_silo.simulation import Simulation
from taichi_silo.solver import STRESS_UPDATES
from taichi_silo.transfers import TRANSFERS


@st.composite
def scenes(draw):
    """Any scene a user may give, kept small."""
    cell = draw(st.sampled_from([0.005, 0.01, 0.02, 0.05]))
    transfer = draw(st.sampled_from(sorted(TRANSFERS)))
    update = "last" if TRANSFERS[transfer].ECHO else draw(st.sampled_from(STRESS_UPDATES))
    kind = draw(st.sampled_from(["smooth", "very-rough"]))
    friction = draw(st.none() | st.floats(0.0, 60.0)) if kind == "smooth" else None
    height = cell * draw(st.integers(2, 12))
    return Scene(
        silo=Silo(width_m=cell * draw(st.integers(2, 8)), height_m=height),
        sand=Sand(
            void_ratio=draw(st.floats(0.53, 1.2)), law=draw(st.sampled_from(["gudehus-bauer", "intergranular"]))
        ),
        walls=Walls(kind=kind, friction_angle_deg=friction, bottom_friction_angle_deg=draw(st.floats(0.0, 45.0))),
        grid=Mesh(
            cell_size_m=cell, points_per_cell=draw(st.sampled_from([1, 4, 9])),
            shape=draw(st.sampled_from(sorted(SHAPES))),
        ),
        averaging=Averaging(characteristic_length_m=draw(st.sampled_from([0.0, 1.5 * cell]))),
        flow=Flow(speed_m_per_s=10.0 ** draw(st.floats(-5.0, -1.0)), displacement_m=0.5 * height),
        method=Method(
            transfer=transfer, stress_update=update, noise_control=draw(st.sampled_from(["column", "none"])),
            stress_filter=draw(st.sampled_from(["none", "null-space"])),
            mass_scaling=draw(st.sampled_from([1.0, 100.0])),
        ),
        machine=Machine(threads=1),
    )  # fmt: skip


def go(scene):
    """100 steps of filling and 100 of flow, from the scene's own weight."""
    runtime.init()
    simulation = Simulation(scene)
    mass = simulation.particles.mass.to_numpy()
    solver, g, v = simulation.solver, simulation.gravity, scene.flow.speed_m_per_s
    for stage, (low, high), (slow, fast) in (("fill", (0.0, g), (0.0, 0.0)), ("flow", (g, g), (0.0, -v))):
        before = solver.survey()
        dt = (0.2 if stage == "fill" else 0.9) * before.stable_step
        filling = simulation.control.filling_drag if stage == "fill" else 0.0
        solver.advance(100, dt, (low, high), (slow, fast), filling)
        reaction, control = solver.books.take()
        after = solver.survey()
        simulation.displacement += 50.0 * dt * (-fast)
        weight = mass.sum() * 0.5 * (low + high)
        force = reaction[:, :, 1].sum() / (100 * dt)
        rate = (after.momentum - before.momentum) / (100 * dt)
        scale = max(weight, abs(force), abs(rate))
        assert abs(force - weight - rate + control[:, 1].sum() / (100 * dt)) < 1e-9 * scale
    return simulation, mass


def holds(scene):
    simulation, mass = go(scene)
    points = simulation.points()
    assert (points["mass"] == mass).all()
    assert simulation.solver.survey().strays == 0
    assert simulation.inside(points).all()
    assert all(np.isfinite(values).all() for values in points.values())
    assert points["void_ratio"].min() > 0.9 * scene.sand.e_d0
    assert points["void_ratio"].max() <= scene.sand.e_i0 * (1 + 1e-9)


@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_random_scenes_keep_mass_balance_and_limits(scene):
    holds(scene)


@pytest.mark.long
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_many_random_scenes_do(scene):
    holds(scene)
