"""Half of a symmetric silo is the half of the whole: same points, same forces, to round-off."""

import numpy as np
import pytest

from taichi_silo.cli import model_silo
from taichi_silo.mpm import runtime
from taichi_silo.mpm.solver import Solver
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.scene.symmetry import half_model
from taichi_silo.simulation import model
from taichi_silo.simulation.simulation import Simulation
from taichi_silo.simulation.wall_forces import mirrored

CELL, ACROSS, HIGH = 0.02, 6, 8
VARIANTS = [
    {"walls": "smooth", "law": "intergranular"},
    {"walls": "very-rough", "shape": "cpdi", "per_cell": 4},
    {"walls": "smooth", "shape": "bspline", "per_cell": 4, "transfer": "apic"},
    {"walls": "very-rough", "transfer": "xpic"},
    {"walls": "smooth", "shape": "linear", "stress_update": "first"},
    {"walls": "very-rough", "shape": "cpgimp", "stress_update": "modified", "transfer": "gradient"},
    {"walls": "very-rough", "averaging": 2.0 * CELL},
]


def scene(half, walls="smooth", shape="ugimp", per_cell=1, law="auto", threads=1, averaging=0.0, means=None, **method):
    return Scene(
        silo=Silo(width_m=ACROSS * CELL, height_m=HIGH * CELL, half=half),
        sand=Sand(law=law), walls=model_silo.walls(walls, 0.60),
        grid=Mesh(cell_size_m=CELL, shape=shape, points_per_cell=per_cell),
        averaging=Averaging(characteristic_length_m=averaging, means=means),
        flow=Flow(speed_m_per_s=0.02, displacement_m=0.002), machine=Machine(threads=threads),
        method=Method(filling_time_s=0.2, longest_settling_s=0.1, **method),
    )  # fmt: skip


def started(half, **choices):
    what = scene(half, **choices)
    runtime.init(threads=what.machine.threads)
    return Simulation(what)


def points_after(steps, half, **choices):
    """Points of the whole silo by rows from below, and the forces of the walls by node."""
    silo = started(half, **choices)
    silo.solver.advance(steps, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
    points = silo.points()
    del points["identity"]  # images have numbers of their own
    rows = round(silo.scene.silo.height_m / silo.model.spacing)
    if silo.model.section.half:  # the images of a row follow its points, from right to left
        points = {
            name: np.concatenate(
                [values[: len(values) // 2].reshape(rows, -1, *values.shape[1:]),
                 values[len(values) // 2 :].reshape(rows, -1, *values.shape[1:])[:, ::-1]], axis=1
            ).reshape(values.shape)
            for name, values in points.items()
        }  # fmt: skip
    reaction = silo.solver.impulses.read_and_reset()[0]
    return points, mirrored(reaction, silo.model.section.columns) if silo.model.section.half else reaction


@pytest.mark.parametrize("choices", VARIANTS, ids=lambda v: " ".join(str(value) for value in v.values()))
def test_every_point_and_every_wall_node_is_that_of_the_whole(choices):
    whole, forces = points_after(300, "no", **choices)
    half, forces_half = points_after(300, "yes", **choices)
    for name, field in whole.items():
        assert np.abs(field - half[name]).max() <= 1e-9 * np.abs(field).max(), name
    assert np.abs(forces - forces_half).max() < 1e-9 * np.abs(forces).max()


def forces(silo):
    return np.array([[r.bottom_N_per_m, r.shear_N_per_m, r.normal_N_per_m] for r in silo.run()])


@pytest.mark.parametrize("walls", ["smooth", "very-rough"])
def test_P_T_N_and_the_balance_of_a_run_are_those_of_the_whole(walls):
    whole, half = (list(started(choice, walls=walls).run()) for choice in ("no", "yes"))
    weight = whole[-1].weight_N_per_m
    assert len(whole) == len(half)
    for a, b in zip(whole, half, strict=True):
        for name in ("bottom_N_per_m", "shear_N_per_m", "normal_N_per_m", "noise_control_force_N_per_m"):
            assert getattr(b, name) == pytest.approx(getattr(a, name), abs=1e-9 * weight), name
        assert b.kinetic_energy_J_per_m == pytest.approx(a.kinetic_energy_J_per_m, rel=1e-6)
        assert b.weight_N_per_m == pytest.approx(a.weight_N_per_m, rel=1e-12)
        assert abs(b.residual_N_per_m) < 1e-9 * weight
        assert b.left_normal_N_per_m == b.right_normal_N_per_m
        assert b.left_shear_N_per_m == b.right_shear_N_per_m


def test_a_smooth_plate_along_the_axis_alone_would_not_do(monkeypatch):
    """Nodes beyond the axis that do not know of the other half cost a thousandth of the forces."""
    whole = forces(started("no"))
    monkeypatch.setattr(model, "MirroredSolver", Solver)
    plate = forces(started("yes"))
    count = min(len(whole), len(plate))
    assert np.abs(plate[:count] - whole[:count]).max() > 1e-4 * whole[-1, 0]


SMOOTH = Walls(kind="smooth", friction_angle_deg=19.0)


@pytest.mark.parametrize(
    ("what", "word"),
    [
        (Scene(silo=Silo(width_m=0.1), grid=Mesh(cell_size_m=0.02), walls=SMOOTH), "5 cells"),
        # its sand may sway
        (Scene(silo=Silo(width_m=0.04), grid=Mesh(cell_size_m=0.005), walls=SMOOTH), "12.5 times as high as wide"),
        (scene("auto", averaging=0.02, means="rows"), "average, 20 mm long"),  # over neighbours across the axis
        (scene("auto", stress_filter="null-space"), "null-space filter"),
    ],
    ids=["odd", "slender", "average", "filter"],
)
def test_smooth_walls_are_halved_by_themselves_and_what_cannot_be_says_why(what, word):
    assert half_model(scene("auto"))[0]
    on, because = half_model(what)
    assert not on
    assert word in because


@pytest.mark.parametrize(
    ("choices", "word"),
    [
        ({"averaging": 0.02, "means": "rows"}, "average, 20 mm long"),
        ({"stress_filter": "null-space"}, "null-space filter"),
    ],
)
def test_a_half_that_cannot_be_is_refused(choices, word):
    with pytest.raises(ValueError, match=f"half is yes; .*{word}"):
        scene("yes", **choices)
