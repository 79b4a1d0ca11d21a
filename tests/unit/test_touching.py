"""Bodies that touch a wall or the floor: what of their outline meets sand, and what is refused."""

from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from taichi_silo.mpm.walls import Coulomb, Surface
from taichi_silo.scene import known_limits, touching
from taichi_silo.scene.scene import Mesh, Scene
from taichi_silo.scene.silo import Insert, Silo
from taichi_silo.simulation import outflow
from taichi_silo.simulation.discretise import Section, surfaces_of
from taichi_silo.utils.schema import one_sentence

ROD = [(0.0, 0.15), (0.05, 0.15), (0.05, 0.17), (0.0, 0.17)]
HOPPER = [(0.06, 0.0), (0.14, 0.0), (0.2, 0.2), (0.2, 0.5), (0.0, 0.5), (0.0, 0.2)]


def length(line):
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("way", [1, -1])
def test_the_side_of_a_ledge_on_the_wall_meets_no_sand(turn, way):
    corners = np.roll(ROD, turn, axis=0)[::way]
    silo = Silo(inserts=(Insert.polygon(corners),))
    free = touching.free_outline(silo, silo.inserts[0])
    assert length(free) == pytest.approx(0.05 + 0.02 + 0.05, abs=1e-6)
    assert free[0] == pytest.approx([0.0, 0.15], abs=1e-6)  # anticlockwise: along the lower side first
    assert free[-1] == pytest.approx([0.0, 0.17], abs=1e-6)
    assert silo.area_m2 == pytest.approx(0.1 - 0.05 * 0.02)
    x, y, _ = silo.lattice(0.005)
    assert not ((x < 0.05) & (y > 0.15) & (y < 0.17)).any()


def test_a_body_that_stands_free_keeps_its_whole_outline():
    silo = Silo(inserts=(Insert(kind="roof", width_m=0.06, bottom_m=0.1),))
    free = touching.free_outline(silo, silo.inserts[0])
    assert free[0].tolist() == free[-1].tolist()
    assert not touching.touches(silo, silo.inserts[0])


@pytest.mark.parametrize(
    ("corners", "free_m"),
    [
        ([(0.2, 0.15), (0.15, 0.15), (0.2, 0.2)], 0.05 + 0.05 * 2**0.5),  # a bracket on the right wall
        ([(0.0, 0.2), (0.05, 0.15), (0.1, 0.2), (0.05, 0.25)], 4 * 0.05 * 2**0.5),  # only a corner touches
    ],
)
def test_brackets_and_bodies_that_touch_with_a_corner(corners, free_m):
    silo = Silo(inserts=(Insert.polygon(corners),))
    assert length(touching.free_outline(silo, silo.inserts[0])) == pytest.approx(free_m, abs=1e-5)


def test_a_block_may_stand_on_the_floor_beside_the_outlet():
    block = Insert.polygon([(0.0, 0.0), (0.05, 0.0), (0.0, 0.1)])
    silo = Silo(outlet={"width_m": 0.06, "position": "right"}, inserts=(block,))
    assert length(touching.free_outline(silo, block)) == pytest.approx(np.hypot(0.05, 0.1), abs=1e-6)
    with pytest.raises(ValidationError, match=r"stands in an outlet \(the outlet is from 0 to 0.06 m\)"):
        Silo(outlet={"width_m": 0.06, "position": "left"}, inserts=(block,))
    with pytest.raises(ValidationError, match="its whole floor is the outlet.*above the floor at 0"):
        Silo(inserts=(block,))


def test_the_wall_of_a_hopper_ends_where_a_body_covers_it():
    body = Insert.polygon([(0.03, 0.1), (0.06, 0.1), (0.018, 0.14)])  # from the wall at y = 0.1 to 0.14
    silo = Silo(outline_m=HOPPER, inserts=(body,))
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.01))
    left = next(one for one in surfaces_of(scene, Section.of(scene)) if one.name == "hopper_left")
    places, _, lengths = left.stations(0.01)
    assert not ((places[:, 1] > 0.1) & (places[:, 1] < 0.14)).any()
    slant = np.hypot(0.06, 0.2) * (1.0 + 0.01 / 0.2 - 0.04 / 0.2)  # it goes on by a cell below the outlet
    assert lengths.sum() == pytest.approx(slant, rel=1e-4)


def test_a_line_with_a_gap_has_no_stations_there():
    line = Surface("wall", ((0.0, 0.0), (0.1, 0.0), (0.2, 0.0), (0.3, 0.0)), Coulomb(), gaps=(1,))
    places, _, lengths = line.stations(0.02)
    assert lengths.sum() == pytest.approx(0.2)
    assert not ((places[:, 0] > 0.1) & (places[:, 0] < 0.2)).any()


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([(0.0, 0.15), (0.2, 0.15), (0.2, 0.2), (0.0, 0.2)], "touches the walls in two places"),
        ([(-0.01, 0.15), (0.05, 0.15), (0.05, 0.2)], "reaches beyond a wall.*free of the walls of a silo 0.2 m wide"),
        ([(0.05, -0.01), (0.1, 0.1), (0.0, 0.1)], "reaches down to -0.01 m"),
    ],
)
def test_bodies_that_close_the_silo_or_reach_beyond_it_are_refused(corners, words):
    with pytest.raises(ValidationError, match=words):
        Silo(inserts=(Insert.polygon(corners),))


def test_a_ledge_round_a_cylinder_is_a_ring():
    silo = Silo(section="round", inserts=(Insert.polygon(ROD), Insert.polygon([(0.2 - x, y) for x, y in ROD])))
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.01))
    right = surfaces_of(scene, Section.of(scene))[1]
    assert sum(right.stations(0.01)[2]) == pytest.approx(0.12, abs=1e-5)
    with pytest.raises(ValidationError, match="ring"):
        Silo(section="round", inserts=(Insert.polygon(ROD),))


@pytest.mark.parametrize(("cell_m", "told"), [(0.01, False), (0.0125, True), (0.025, True)])
def test_a_body_thinner_than_two_cells_gets_a_word_before_the_run(cell_m, told):
    """Sand reaches a cell into it from each side."""
    scene = Scene(silo=Silo(inserts=(Insert.polygon(ROD),)), grid=Mesh(cell_size_m=cell_m))
    words = [one for one in known_limits.of_method(scene) if one.startswith("Insert 1, a polygon, is less than 2")]
    assert bool(words) == told


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([[(0.02, 0.001), (0.18, 0.001), (0.18, 0.05), (0.02, 0.05)]], ["the walls or the floor is a gap of 1 mm"]),
        ([[(0.06, 0.1), (0.09, 0.1), (0.09, 0.2), (0.06, 0.2)], [(0.1, 0.1), (0.13, 0.1), (0.13, 0.2), (0.1, 0.2)]],
         ["Between insert 2 and insert 1 is a gap of 10 mm, less than 2 cells of 10 mm"]),
        ([[(0.06, 0.1), (0.09, 0.1), (0.09, 0.2), (0.06, 0.2)]], []),
        ([[(0.0, 0.1), (0.05, 0.1), (0.05, 0.2), (0.0, 0.2)]], []),
    ],
)  # fmt: skip
def test_gaps_of_less_than_two_cells_are_told(corners, words):
    silo = Silo(outlet={"width_m": 0.1}, inserts=tuple(Insert.polygon(one) for one in corners))
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.01))
    found = [one for one in known_limits.of_method(scene) if "gap" in one]
    assert len(found) == len(words) and all(word in one for word, one in zip(words, found, strict=True))


def test_one_pair_of_brackets_too_few_is_told():
    with pytest.raises(ValidationError) as error:
        Scene(silo={"inserts": {"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}})
    assert "each table of which begins with [[silo.inserts]]" in one_sentence(error.value)


@pytest.mark.parametrize(
    ("inserts", "advice"),
    [((Insert(kind="roof", width_m=0.16, bottom_m=0.1),), "the gap of 20 mm between insert 1 and the walls or the"),
     ((), "a wider outlet or smoother walls")],
)  # fmt: skip
def test_sand_that_bridges_a_body_is_told_of_the_gap(inserts, advice):
    scene = Scene(silo=Silo(outlet={"width_m": 0.1}, inserts=inserts), grid=Mesh(cell_size_m=0.01))
    assert outflow._advice(SimpleNamespace(scene=scene)).startswith(advice)
