"""The walls' forces on the sand: names and signs, and those of the part of a silo that is not computed."""

from dataclasses import fields

import numpy as np
import pytest

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.runs.observers.forces import BALANCE, FORCES
from taichi_silo.simulation.record import Record
from taichi_silo.simulation.section import Section
from taichi_silo.simulation.wall_forces import BOTTOM, LEFT, RIGHT, WallForces, mirrored

CELLS, SLOTS = 6, 12
COLUMNS = CELLS + 1 + 2 * MARGIN
WHOLE = Section(width=0.2, shift=0.0, half=False, round=False, columns=COLUMNS)
HALF = Section(width=0.1, shift=0.0, half=True, round=False, columns=COLUMNS)
ROUND = Section(width=0.1, shift=0.1, half=False, round=True, columns=COLUMNS)


def paces(*walls):
    """Of walls that move at the same pace everywhere (walls, SLOTS)."""
    return np.repeat(np.array(walls)[:, None], SLOTS, axis=1)


SINKING = paces(0.0, 0.0, 1.0)  # left, right, bottom


def impulses(**walls) -> np.ndarray:
    """Of the solver's walls in their order: (x, y) at two slots that differ."""
    found = np.zeros((len(walls), SLOTS, 2))
    for row, impulse in zip(found, walls.values(), strict=True):
        row[MARGIN], row[MARGIN + 2] = 0.25 * np.array(impulse), 0.75 * np.array(impulse)
    return found


def carried(forces) -> float:
    """P + 2 T, and what bodies carry [N/m]."""
    shear = forces["left_shear_N_per_m"] + forces["right_shear_N_per_m"]
    return forces["bottom_force_N_per_m"] + shear + sum(force[1] for force in forces["bodies_N_per_m"].values())


def test_walls_press_on_the_sand_and_bottom_and_walls_together_carry_its_weight():
    impulse = impulses(left=(2.0, 0.5), right=(-1.0, 0.75), bottom=(0.125, 3.0), insert_1=(0.0, 4.0))
    forces, profile = WallForces(WHOLE, SINKING, ("insert_1",)).read(impulse, duration=0.5)
    assert forces == {
        "bottom_force_N_per_m": 6.0,
        "left_normal_N_per_m": 4.0,
        "left_shear_N_per_m": 1.0,
        "right_normal_N_per_m": 2.0,
        "right_shear_N_per_m": 1.5,
        "bodies_N_per_m": {"insert_1": [0.0, 8.0]},
    }
    assert carried(forces) == impulse[:, :, 1].sum() / 0.5
    assert (profile == impulse / 0.5).all()


def test_floor_edges_and_gate_are_one_bottom_and_only_what_moves_works():
    impulse = impulses(
        left=(1.0, 0.0), right=(-1.0, 0.0), floor=(0.0, 2.0), edges=(0.0, 1.0), gate=(0.0, 3.0), insert_1=(0.0, 1.0)
    )
    walls = WallForces(WHOLE, paces(0.0, 0.0, 0.0, 0.5, 1.0), ("insert_1",))
    forces, profile = walls.read(impulse, duration=1.0)
    assert walls.names == ("left", "right", "bottom", "insert_1") and len(profile) == 4
    assert forces["bottom_force_N_per_m"] == 6.0 and forces["bodies_N_per_m"] == {"insert_1": [0.0, 1.0]}
    assert walls.push(impulse) == 3.5


def test_a_half_and_its_image_have_the_forces_of_the_whole():
    impulse = impulses(left=(2.0, 0.5), axis=(-7.0, 0.0), bottom=(0.25, 3.0))
    forces, profile = WallForces(HALF, SINKING, ()).read(impulse, duration=1.0)
    assert forces["left_normal_N_per_m"] == forces["right_normal_N_per_m"] == 2.0
    assert forces["left_shear_N_per_m"] == forces["right_shear_N_per_m"] == 0.5
    assert carried(forces) == 2.0 * (0.5 + 3.0)
    assert profile.sum(axis=(0, 1)) == pytest.approx([0.0, carried(forces)]), "nothing is pushed aside"


def test_a_metre_of_girth_on_either_side_carries_the_weight_of_a_round_silo():
    impulse = impulses(axis=(0.0, 0.0), right=(-2.0, 0.5), bottom=(0.25, 3.0))  # per radian
    forces, profile = WallForces(ROUND, SINKING, ()).read(impulse, duration=1.0)
    assert forces["left_normal_N_per_m"] == forces["right_normal_N_per_m"] == pytest.approx(2.0 / 0.1)
    assert carried(forces) == pytest.approx(2.0 / 0.1 * (0.5 + 3.0))
    assert profile[LEFT, :, 0] == pytest.approx(-profile[RIGHT, :, 0])


def test_the_bottoms_node_on_the_axis_bears_both_halves():
    half = np.zeros((3, SLOTS, 2))
    half[LEFT, :, 0], half[LEFT, :, 1] = 2.0, 3.0
    half[BOTTOM, MARGIN : MARGIN + CELLS // 2 + 1] = [[0.1, 4.0], [0.2, 5.0], [0.3, 6.0], [0.0, 7.0]]
    whole = mirrored(half, COLUMNS)
    bottom = whole[BOTTOM, MARGIN : MARGIN + CELLS + 1]
    assert list(bottom[:, 1]) == [4.0, 5.0, 6.0, 14.0, 6.0, 5.0, 4.0]
    assert list(bottom[:, 0]) == [0.1, 0.2, 0.3, 0.0, -0.3, -0.2, -0.1]
    assert whole[BOTTOM].sum(axis=0) == pytest.approx([0.0, 2.0 * half[BOTTOM, :, 1].sum()])
    assert (whole[RIGHT, :SLOTS] == whole[LEFT, :SLOTS] * [-1.0, 1.0]).all()


def test_a_record_has_the_names_of_the_columns_that_are_written():
    names = {field.name for field in fields(Record)} | set(vars(Record))
    assert {*FORCES, *BALANCE} <= names
