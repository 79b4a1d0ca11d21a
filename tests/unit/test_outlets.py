"""Several outlets, outlets of a side wall, gates that open and close: what is refused, and how sand is counted."""

import numpy as np
import pytest
from pydantic import ValidationError

from taichi_silo.mpm.particles import Particles
from taichi_silo.scene import dotted_paths, known_limits
from taichi_silo.scene.outlets import Opening, mirrored
from taichi_silo.scene.scene import Flow, Mesh, Scene
from taichi_silo.scene.scene_files import read_scene, scene_of
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.simulation import gates
from taichi_silo.simulation.discharge import Discharge
from taichi_silo.utils.schema import one_sentence

LEFT = {"width_m": 0.05, "position": 0.05}
RIGHT = {"width_m": 0.05, "position": 0.15, "opens_at_s": 0.5, "closes_at_s": 2.0}
BESIDE = {"width_m": 0.05, "position": 0.125, "wall": "right"}

REFUSED = [
    ({"outlet": []}, ["silo.outlet", "no entries"]),
    ({"outlet": [LEFT] * 21}, ["silo.outlet", "at most 20"]),
    ({"outlet": [LEFT, 3]}, ["silo.outlet.1 is 3", "table"]),
    ({"outlet": [LEFT, RIGHT | {"width_m": -1}]}, ["silo.outlet.1.width_m is -1", "0.0001"]),
    ({"outlet": [LEFT, RIGHT | {"opens": 1}]}, ["silo.outlet.1.opens", "opens_at_s"]),
    ({"outlet": [LEFT, LEFT]}, ["outlet 2", "outlet 1", "apart"]),
    ({"outlet": [LEFT, RIGHT | {"position": 0.1}]}, ["from 0.075 to 0.125 m", "apart"]),
    ({"outlet": RIGHT | {"closes_at_s": 0.4}}, ["closes_at_s is 0.4 s", "0.5 s"]),
    ({"outlet": BESIDE | {"position": "centre"}}, ["position is centre", "right wall", "height"]),
    ({"outlet": BESIDE | {"position": 0.49}}, ["right wall", "0.515", "surface", "0.5 m"]),
    ({"outlet": BESIDE, "surface_m": [[0, 0.5], [0.2, 0.14]]}, ["right wall", "0.15", "surface", "0.14 m"]),
    ({"outlet": BESIDE | {"wall": "top"}}, ["wall is top", "floor"]),
    ({"outlet": BESIDE, "hopper": {"half_angle_deg": 20, "outlet_width_m": 0.05}}, ["outlet", "hopper", "not both"]),
    ({"outlet": BESIDE, "section": "round"}, ["round", "middle of its floor"]),
    ({"outlet": [LEFT, RIGHT], "section": "round"}, ["round", "single outlet"]),
    ({"outlet": [LEFT, RIGHT], "half": "yes"}, ["half is yes", "several outlets"]),
]


@pytest.mark.parametrize(("silo", "words"), REFUSED, ids=lambda value: "")
def test_outlets_that_cannot_be_are_refused_in_one_sentence(silo, words):
    with pytest.raises(ValidationError) as caught:
        scene_of({"silo": silo})
    sentence = one_sentence(caught.value)
    assert all(word in sentence for word in words), sentence


def test_an_outlet_that_never_opens_is_refused():
    late = [LEFT, RIGHT | {"opens_at_s": 30.0, "closes_at_s": None}]
    for flow in ({"speed_m_per_s": 0.002, "displacement_m": 0.02}, {"outflow": "gravity", "longest_s": 5.0}):
        with pytest.raises(ValidationError, match=r"outlet 2 opens at 30 s.*must open before"):
            scene_of({"silo": {"outlet": late}, "flow": flow})


def test_edges_of_all_outlets_lie_on_the_grid():
    with pytest.raises(ValidationError, match=r"edge at y = 0\.15 m must lie on the grid, whose lines are 0\.02 m"):
        Scene(silo=Silo(outlet=Outlet(**BESIDE)), grid=Mesh(cell_size_m=0.02))
    assert Scene(silo=Silo(outlet=(Outlet(**LEFT), Outlet(**BESIDE)))).grid.cell_size_m == 0.005


def test_one_table_and_an_array_of_one_are_the_same_silo():
    one, several = Silo(outlet=LEFT), Silo(outlet=[LEFT])
    assert one.outlet.width_m == 0.05
    assert one.openings == several.openings
    assert one.one_opening and several.one_opening
    assert not Silo(outlet=RIGHT).one_opening
    assert not Silo(outlet=BESIDE).one_opening


def test_scene_files_and_dotted_paths_know_both_forms(tmp_path):
    file = tmp_path / "silo.toml"
    file.write_text(
        "[silo]\n[[silo.outlet]]\nwidth_m=0.05\nposition=0.05\n[[silo.outlet]]\nwidth_m=0.05\nposition=0.15\n"
    )
    scene = read_scene(file, ["silo.outlet.1.width_m=0.06", "silo.outlet.1.opens_at_s=1"])
    assert [one.width_m for one in scene.silo.outlets] == [0.05, 0.06]
    assert dotted_paths.value(scene, "silo.outlet.1.opens_at_s") == 1.0
    assert dotted_paths.value(scene, "silo.outlet.width_m") is None
    changed = dotted_paths.changed(scene, {"silo.outlet.0.width_m": 0.04})
    assert [one.width_m for one in changed.silo.outlets] == [0.04, 0.06]
    assert dotted_paths.known("silo.outlet.width_m")
    assert Scene.model_validate(scene.model_dump()) == scene


def test_openings_stand_where_they_were_put():
    floor, side = Silo(outlet=[LEFT, BESIDE]).openings
    np.testing.assert_allclose(floor.ends, ((0.025, 0.0), (0.075, 0.0)))
    assert side.ends == ((0.2, 0.1), (0.2, 0.15))
    assert side.outwards == (1.0, 0.0)
    assert side.box(0.0, 0.01) == pytest.approx((0.2, 0.1, 0.21, 0.15))
    assert floor.box(0.0, 0.01, beside_m=0.005) == pytest.approx((0.02, -0.01, 0.08, 0.0))
    assert Silo(outlet=[LEFT, BESIDE]).eccentricity_m == pytest.approx(0.1)
    assert Silo(outlet=[LEFT, BESIDE]).outlet_share_m == pytest.approx(0.1)


def test_openings_that_are_their_own_mirror_image():
    timed = {"opens_at_s": 0.0, "closes_at_s": None}
    assert mirrored(Silo(outlet=[LEFT, RIGHT | timed]).openings, 0.2)
    assert not mirrored(Silo(outlet=[LEFT, RIGHT]).openings, 0.2)  # one opens later
    assert not mirrored(Silo(outlet=BESIDE).openings, 0.2)
    assert mirrored(Silo(outlet=[BESIDE, BESIDE | {"wall": "left"}]).openings, 0.2)


def test_gates_open_and_close_smoothly_and_at_once_in_free_outflow():
    openings = Silo(outlet=[LEFT, RIGHT]).openings
    assert gates.shares(openings, 0.49, 0.1) == (1.0, 0.0)
    assert gates.shares(openings, 0.55, 0.1) == pytest.approx((1.0, 0.5))
    assert gates.shares(openings, 1.0, 0.1) == (1.0, 1.0)
    assert gates.shares(openings, 2.05, 0.1) == pytest.approx((1.0, 0.5))
    assert gates.shares(openings, 2.2, 0.1) == (1.0, 0.0)
    assert [gates.shares(openings, t, 0.0)[1] for t in (0.4, 0.5, 1.9, 2.0)] == [0.0, 1.0, 1.0, 0.0]
    assert [gates.next_change(openings, t) for t in (0.0, 0.5, 2.0)] == [0.5, 2.0, np.inf]


def grains(*places):
    """Points of a mass of 1, 2, 4, ... at these places."""
    particles = Particles(len(places))
    mass = 2.0 ** np.arange(len(places))
    particles.load(
        {
            "position": np.array(places), "velocity": np.zeros((len(places), 2)), "stress": np.zeros((len(places), 4)),
            "mass": mass, "volume": np.ones(len(places)), "path": np.zeros(len(places)),
        }
    )  # fmt: skip
    return particles


def test_each_opening_has_the_mass_that_has_passed_it():
    openings = (Opening("floor", 0.0, 0.1), Opening("floor", 0.2, 0.3), Opening("left", 0.1, 0.2))
    particles = grains((0.05, -0.02), (0.25, -0.02), (-0.02, 0.15), (0.15, 0.1), (0.05, 0.0), (-0.001, 0.12))
    gone = Discharge(particles, exit_m=-0.011, openings=openings, spacing_m=0.02)
    kept = gone.take_out()
    assert kept.tolist() == [False, False, False, True, True, True]
    assert gone.masses.tolist() == [1.0, 2.0, 4.0]
    assert gone.passing_each == pytest.approx([8.0, 0.0, 0.55 * 32.0])  # half, and 0.55, beyond the plane
    assert gone.passed == pytest.approx(gone.passed_each.sum())


def test_a_gate_that_closes_cuts_the_sand_that_falls():
    openings = (Opening("floor", 0.0, 0.1), Opening("floor", 0.2, 0.3))
    particles = grains((0.05, -0.002), (0.25, -0.002), (0.25, 0.001))
    gone = Discharge(particles, exit_m=-0.011, openings=openings, spacing_m=0.002, closed=np.array([False, False]))
    kept = gone.shut(np.array([False, True]))
    assert kept.tolist() == [True, False, True]
    assert gone.masses.tolist() == [0.0, 2.0]
    assert gone.shut(np.array([False, True])) is None  # it has been closed before


def test_a_narrow_outlet_gets_a_word_before_the_run():
    """The narrowest of several counts."""
    outlets = ({"width_m": 0.1, "position": 0.06}, {"width_m": 0.04, "position": 0.16})
    scene = Scene(silo=Silo(outlet=outlets), grid=Mesh(cell_size_m=0.01), flow=Flow(outflow="gravity"))
    assert any("4 cells wide" in word for word in known_limits.of_method(scene))


@pytest.mark.parametrize(
    ("width_m", "flow", "given", "points"),
    [
        (0.08, {"outflow": "gravity"}, {}, 4), (0.16, {"outflow": "gravity"}, {}, 1), (0.08, {}, {}, 1),
        (0.08, {"outflow": "gravity"}, {"points_per_cell": 1}, 1),
    ],
)  # fmt: skip
def test_sand_that_falls_through_few_cells_has_four_points_in_each(width_m, flow, given, points):
    """Six cells let 0.59 rho sqrt(g D^3) pass with one point in each, 0.91 with four (`validation/beverloo.py`)."""
    silo = Silo(width_m=0.4, outlet={"width_m": width_m})
    scene = Scene(silo=silo, grid={"cell_size_m": 0.01} | given, flow=flow)
    assert scene.grid.points_per_cell == points
    again = Scene.model_validate(scene.model_dump(exclude={"grid": set(scene.grid.chosen)}))
    assert again.grid == scene.grid
