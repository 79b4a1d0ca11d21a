"""The silo that a user gives: geometry that agrees with itself, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from taichi_silo.analysis.measure.matching import matched
from taichi_silo.mpm.walls.surfaces import Surfaces
from taichi_silo.runs.theories import theory_of
from taichi_silo.scene import polygons
from taichi_silo.scene.scene import Mesh, Scene
from taichi_silo.scene.silo import Hopper, Insert, Outlet, Silo
from taichi_silo.simulation.discretise import Section, grid_of, surfaces_of
from taichi_silo.utils.schema import one_sentence

BUNKER = ((0.06, 0.0), (0.12, 0.0), (0.16, 0.14), (0.2, 0.14), (0.2, 0.4), (0.0, 0.4), (0.0, 0.2))


@settings(max_examples=30, deadline=None)
@given(angle=st.floats(15.0, 60.0), outlet=st.floats(0.03, 0.15), round_=st.booleans())
def test_the_points_of_a_hopper_have_its_area(angle, outlet, round_):
    hopper = Hopper(half_angle_deg=angle, outlet_width_m=outlet)
    silo = Silo(hopper=hopper, section="round" if round_ else "plane")
    x, _y, area = silo.lattice(0.0025)
    found = float((area * np.abs(x - 0.1)).sum() / 0.1) if round_ else float(area.sum())
    assert found == pytest.approx(silo.area_m2, rel=0.004)


def test_the_content_of_a_cone_is_that_of_geometry():
    silo = Silo(section="round", hopper=Hopper(half_angle_deg=30.0, outlet_width_m=0.1), height_m=0.5)
    high = 0.05 / math.tan(math.radians(30.0))
    cone = math.pi * high / 3.0 * (0.1**2 + 0.1 * 0.05 + 0.05**2)
    volume = cone + math.pi * 0.1**2 * (0.5 - high)
    assert silo.area_m2 == pytest.approx(volume / (2.0 * math.pi) * 2.0 / 0.1, rel=1e-3)


@pytest.mark.parametrize("kind", ["roof", "cylinder"])
def test_an_insert_takes_the_place_of_its_area(kind):
    insert = Insert(kind=kind, width_m=0.06, bottom_m=0.1, height_m=0.05 if kind == "roof" else None)
    outline = insert.outline(0.2, corners=2000)
    assert polygons.area(outline) == pytest.approx(insert.area_m2(), rel=1e-4)
    silo = Silo(inserts=(insert,))
    _x, _y, area = silo.lattice(0.001)
    assert area.sum() == pytest.approx(0.1 - insert.area_m2(), rel=2e-3)
    assert silo.area_m2 == pytest.approx(0.1 - insert.area_m2(), rel=1e-12)


@pytest.mark.parametrize(
    ("position", "left"), [("left", 0.0), ("centre", 0.075), ("right", 0.15), (0.065, 0.04), ("0.065", 0.04)]
)
def test_an_outlet_stands_where_it_was_put(position, left):
    silo = Silo(outlet={"width_m": 0.05, "position": position})
    assert silo.outlet_m == pytest.approx((left, left + 0.05))


def test_a_silo_without_anything_sinks_as_a_whole_and_one_with_something_does_not():
    assert Silo().floor_is_outlet
    assert not Silo(outlet=Outlet(width_m=0.08)).floor_is_outlet
    assert not Silo(hopper=Hopper(half_angle_deg=20, outlet_width_m=0.08)).floor_is_outlet
    assert not Silo(inserts=(ROOF,)).floor_is_outlet


ROOF = {"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}
POLYGONS = [
    ({"outline_m": [[0, 0], [0.2, 0.5], [0.2, 0], [0, 0.5]]}, ["outline", "cross each other at (0.1, 0.25) m"]),
    ({"outline_m": [[0, 0], [0.2, 0]]}, ["outline", "2 corners", "3"]),
    ({"outline_m": [[0.1, 0], [0.2, 0.5], [0, 0.5]]}, ["no level floor"]),
    ({"outline_m": [[0, 0], [0.2, 0], [0.1, 0.5]]}, ["no level top"]),
    ({"outline_m": [[0.1, 0], [0.2, 0], [0.2, 0.5], [0.1, 0.5]]}, ["0.1", "leftmost"]),
    (
        {"outline_m": [[0, 0], [0.1, 0], [0.1, 0.3], [0.2, 0.2], [0.2, 0.5], [0, 0.5]]},
        ["right side turns down", "once"],
    ),
    ({"outline_m": [[0, 0], [0.2, 0], [0.2, 0.5], [0, 0.5]], "width_m": 0.3}, ["width is 0.3", "0.2"]),
    ({"outline_m": [[0, 0], [0.2, 0], [0.2, 0.5], [0, 0.5]], "height_m": 0.6}, ["height is 0.6", "0.5"]),
    ({"outline_m": [[0, 0], ["a", 0]]}, ["outline_m.1.0 is a", "number"]),
    ({"outline_m": [[0, 0], [1, 0, 3]]}, ["outline_m.1"]),
    ({"outline_m": BUNKER, "hopper": {"half_angle_deg": 20, "outlet_width_m": 0.05}}, ["outline or a hopper"]),
    ({"outline_m": BUNKER, "section": "round"}, ["round", "symmetric"]),
    ({"outline_m": BUNKER, "outlet": {"width_m": 0.08}}, ["outlet width is 0.08", "floor", "0.06"]),
    ({"outlet": {"width_m": 0.08, "position": 0.18}}, ["position is 0.18", "0.04", "0.16"]),
    ({"inserts": [{"kind": "polygon"}]}, ["polygon", "corners_m"]),
    ({"inserts": [{"kind": "roof", "width_m": 0.06}]}, ["roof", "bottom_m"]),
    ({"inserts": [{"kind": "polygon", "corners_m": [[0.1, 0.1], [0.3, 0.1], [0.1, 0.2]]}]}, ["free of the walls"]),
    ({"inserts": [{"kind": "polygon", "corners_m": [[0.1, -0.1], [0.15, 0.1], [0.1, 0.2]]}]}, ["-0.1", "floor"]),
    ({"inserts": [ROOF, ROOF | {"bottom_m": 0.12}]}, ["inserts 1 and 2 meet", "stand apart"]),
]


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"silo": {"outlet": {"width_m": 0.3}}}, ["outlet width is 0.3", "0.2"]),
        (
            {"silo": {"outlet": {"width_m": 0.005}}, "grid": {"cell_size_m": 0.005}},
            ["outlet width is 0.005", "at least 0.01"],
        ),
        (
            {"silo": {"outlet": {"width_m": 0.083}}},
            ["at 0.0585, 0.1415 m, the edges of the outlet", "a width of 0.08 m"],
        ),
        ({"silo": {"outlet": {"width_m": 0.08, "position": "top"}}}, ["position is top", "centre"]),
        ({"silo": {"section": "round", "outlet": {"width_m": 0.08, "position": "left"}}}, ["left", "round", "centre"]),
        (
            {"silo": {"outlet": {"width_m": 0.08}, "hopper": {"half_angle_deg": 20, "outlet_width_m": 0.05}}},
            ["an outlet", "a hopper", "not both"],
        ),
        ({"silo": {"hopper": {"half_angle_deg": 5, "outlet_width_m": 0.05}}}, ["half angle", "5.0 deg", "0.5"]),
        ({"silo": {"hopper": {"half_angle_deg": 85, "outlet_width_m": 0.05}}}, ["85", "below 80"]),
        ({"silo": {"inserts": [ROOF | {"width_m": 0.25}]}}, ["roof", "walls", "0.2"]),
        ({"silo": {"inserts": [ROOF | {"bottom_m": 0.48}]}}, ["roof", "0.54", "0.5"]),
        ({"silo": {"section": "round", "inserts": [ROOF | {"position_m": 0.06}]}}, ["0.06", "axis", "0.1"]),
        ({"flow": {"outflow": "gravity"}}, ["gravity", "outlet", "hopper"]),
        ({"silo": {"outlet": {"width_m": 0.08}}, "flow": {"displacement_m": 2.0}}, ["displacement is 2.0", "1.25"]),
        ({"silo": {"half": "yes", "outlet": {"width_m": 0.08, "position": "right"}}}, ["half is yes", "right"]),
        ({"filling": {"kind": "snow"}}, ["snow", "rain"]),
        ({"silo": {"section": "round", "width_m": 0.21, "height_m": 0.6}, "grid": {"cell_size_m": 0.03}}, ["radius"]),
        ({"walls": {"kind": "smooth"}}, ["walls.friction_angle_deg is not given; smooth walls need"]),
        ({"walls": {"friction_angle_deg": 20}}, ["wall friction angle is 20", "very rough"]),
        *(({"silo": silo}, words) for silo, words in POLYGONS),
    ],
    ids=lambda value: "",
)
def test_impossible_silos_are_refused_in_one_sentence(tables, words):
    with pytest.raises(ValidationError) as caught:
        Scene.model_validate(tables)
    sentence = one_sentence(caught.value)
    assert all(word in sentence for word in words), sentence


def test_points_are_found_again_by_their_identity():
    before = {"identity": np.array([4, 2, 7, 1]), "mass": np.array([40.0, 20.0, 70.0, 10.0]), "time_s": 1.0}
    now = {"identity": np.array([7, 4])}
    assert matched(before, now)["mass"].tolist() == [70.0, 40.0]
    assert matched(before, now)["time_s"] == 1.0


def test_an_insert_of_a_round_silo_ends_at_the_axis():
    silo = Silo(section="round", outlet=Outlet(width_m=0.08), inserts=(ROOF,))
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.02))
    section = Section.of(scene)
    grid = grid_of(scene, section, 1)
    found = Surfaces(surfaces_of(scene, section), grid, 1000.0, 4, section.geometry.depth)
    assert (found.places[:, 0] > 0.0).all()
    assert (found.areas > 0.0).all()
    slant = math.hypot(0.03, 0.06)
    lateral = (0.5 * 0.03) * slant + 0.5 * 0.03**2  # per radian: the cone and its base
    assert found.areas.sum() == pytest.approx(lateral, rel=0.02)
    rows = found.area_by_row(4)
    assert rows.sum() == pytest.approx(found.areas.sum(), rel=1e-12)


def test_a_round_silo_is_empty_when_its_outlet_has_let_out_its_content():
    silo = Silo(section="round", outlet=Outlet(width_m=0.08))
    content, opening = math.pi * 0.1**2 * 0.5, math.pi * 0.04**2
    assert silo.area_m2 / silo.outlet_share_m == pytest.approx(content / opening, rel=1e-6)


@pytest.mark.parametrize(
    "silo", [Silo(width_m=0.5, height_m=0.2), Silo(hopper=Hopper(half_angle_deg=11, outlet_width_m=0.02))]
)
def test_theories_are_silent_where_they_do_not_hold(silo):
    found = theory_of(Scene(silo=silo, grid=Mesh(cell_size_m=0.01)), 19.0, 0.42)
    assert found["eurocode"]["slenderness"] == ("squat" if silo.hopper else "retaining")
    assert found["eurocode"]["discharge_factors"] == [1.0, 1.0]


# --- silos and inserts from polygons ----------------------------------------------------------------------------------


def hopper(angle=20.0, opening=0.08):
    return Silo(hopper=Hopper(half_angle_deg=angle, outlet_width_m=opening))


def drawn(silo, turn=0, backwards=False):
    """The same silo as a polygon, whose corners begin anywhere and go either way."""
    left, right = silo.sides
    corners = np.roll(np.concatenate([right, left[::-1]]), turn, axis=0)
    return Silo.polygon(corners[::-1] if backwards else corners)


@settings(max_examples=20, deadline=None)
@given(angle=st.floats(10, 60), opening=st.floats(0.03, 0.15), turn=st.integers(0, 5), backwards=st.booleans())
def test_a_hopper_drawn_as_a_polygon_is_that_hopper(angle, opening, turn, backwards):
    silo = hopper(angle, opening) if (0.1 - 0.5 * opening) / np.tan(np.radians(angle)) < 0.45 else hopper()
    polygon = drawn(silo, turn, backwards)
    assert (polygon.width_m, polygon.height_m) == (silo.width_m, silo.height_m)
    assert polygon.outlet_m == pytest.approx(silo.outlet_m, abs=1e-12)
    assert polygon.transition_m == pytest.approx(silo.transition_m, abs=1e-12)
    assert polygon.area_m2 == pytest.approx(silo.area_m2, rel=1e-12)
    for one, other in zip(polygon.lattice(0.01), silo.lattice(0.01), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    scenes = [Scene(silo=silo, grid=Mesh(cell_size_m=0.01)) for silo in (polygon, silo)]
    for one, other in zip(*(surfaces_of(scene, Section.of(scene)) for scene in scenes), strict=True):
        assert (one.name, one.contact) == (other.name, other.contact)
        np.testing.assert_allclose(one.corners, other.corners, atol=1e-12)


def test_a_rectangle_with_an_outlet_is_that_silo():
    plain = Silo(outlet=Outlet(width_m=0.08, position="right"))
    polygon = Silo.polygon([(0, 0), (0.2, 0), (0.2, 0.5), (0, 0.5)], outlet=Outlet(width_m=0.08, position="right"))
    assert polygon.outlet_m == plain.outlet_m
    assert polygon.feet_m == (0.0, 0.0)
    scene = Scene(silo=polygon)
    assert surfaces_of(scene, Section.of(scene)) == ()


def test_points_fill_a_bunker_with_a_ledge_and_no_more():
    silo = Silo.polygon(BUNKER)
    exact = 0.2 * 0.4 - 0.5 * 0.06 * 0.2 - (0.04 + 0.08) / 2.0 * 0.14
    assert silo.area_m2 == pytest.approx(exact, rel=1e-12)
    x, y, area = silo.lattice(0.002)
    assert area.sum() == pytest.approx(exact, rel=1e-3)
    assert not ((x > 0.16) & (y < 0.14)).any()
    assert silo.feet_m == (0.2, 0.14)
    assert silo.floor_m == (0.06, 0.12)


def test_the_fill_may_end_below_the_outline():
    silo = Silo.polygon(BUNKER, height_m=0.3)
    assert silo.area_m2 == pytest.approx(Silo.polygon(BUNKER).area_m2 - 0.2 * 0.1)
    assert silo.lattice(0.01)[1].max() < 0.3


def test_walls_may_converge_up_to_the_surface():
    silo = Silo.polygon([(0.06, 0), (0.14, 0), (0.2, 0.5), (0, 0.5)])
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.01))
    left, right = surfaces_of(scene, Section.of(scene))
    assert silo.transition_m == 0.5
    assert left.corners[0] == (0.0, 0.5)  # the sand lies to the left of the line
    assert right.corners[-1] == (0.2, 0.5)
    assert left.corners[-1][1] == pytest.approx(-0.01)  # the wall goes on below the outlet


@pytest.mark.parametrize("kind", ["roof", "cylinder"])
def test_an_insert_drawn_as_a_polygon_is_that_body(kind):
    body = Insert(kind=kind, width_m=0.06, bottom_m=0.1)
    polygon = Insert.polygon(body.outline(0.2)[::-1])
    assert polygon.area_m2() == pytest.approx(body.area_m2(), rel=0.01)  # a circle of 48 corners
    assert (polygon.breadth_m, polygon.rise_m) == pytest.approx((0.06, 0.06), rel=1e-12)
    np.testing.assert_allclose(
        sorted(map(tuple, polygon.outline(0.2).round(12))), sorted(map(tuple, body.outline(0.2).round(12)))
    )


def test_a_side_with_a_level_part_is_passed_at_once():
    _, right = polygons.sides(BUNKER)
    assert polygons.place(right, [0.0, 0.07, 0.1399999, 0.1400001, 0.3]) == pytest.approx(
        [0.12, 0.14, 0.16, 0.2, 0.2], abs=1e-6
    )


@pytest.mark.parametrize("extra", [(0.09, 0.0), (0.1, 0.4), (0.18, 0.14), (0.0, 0.3), (0.03, 0.1)])
def test_corners_on_a_straight_line_change_nothing(extra):
    at = {(0.09, 0.0): 1, (0.1, 0.4): 5, (0.18, 0.14): 3, (0.0, 0.3): 6, (0.03, 0.1): 7}[extra]
    silo, plain = Silo.polygon([*BUNKER[:at], extra, *BUNKER[at:]]), Silo.polygon(BUNKER)
    assert silo.feet_m == plain.feet_m
    for one, other in zip(silo.sides, plain.sides, strict=True):
        assert one.tolist() == other.tolist()


@pytest.mark.parametrize("corners", [[(0.05, 0.1), (0.15, 0.1), (0.07, 0.2)], [(0.05, 0.1), (0.15, 0.1), (0.15, 0.2)]])
def test_a_body_on_the_axis_of_a_round_silo_is_symmetric(corners):
    with pytest.raises(ValidationError, match=r"polygon at x = 0.1 m is not symmetric about the axis .* 0.1 m"):
        Silo(section="round", inserts=(Insert.polygon(corners),))
    Silo(inserts=(Insert.polygon(corners),))
    Silo(section="round", inserts=(Insert.polygon([(0.05, 0.1), (0.15, 0.1), (0.1, 0.2)]),))


RING = {"kind": "cylinder", "width_m": 0.03, "bottom_m": 0.1}


def test_a_body_and_its_mirror_image_are_a_ring():
    silo = Silo(section="round", inserts=(RING | {"position_m": 0.15}, RING | {"position_m": 0.05}))
    torus = 2.0 * math.pi**2 * 0.05 * 0.015**2
    content = math.pi * 0.1**2 * 0.5 - torus
    assert silo.area_m2 == pytest.approx(content / math.pi / 0.1, rel=1e-4)
    section = Section.of(scene := Scene(silo=silo))
    grid = grid_of(scene, section, 1)
    found = Surfaces(surfaces_of(scene, section), grid, 1000.0, 4, section.geometry.depth)
    assert found.areas.sum() == pytest.approx(0.05 * 2.0 * math.pi * 0.015, rel=0.02)  # of the torus, per radian


@pytest.mark.parametrize(
    "others", [(), (RING | {"position_m": 0.06},), (RING | {"position_m": 0.05, "friction_angle_deg": 9},)]
)
def test_a_ring_has_both_of_its_sections(others):
    with pytest.raises(ValidationError, match=r"position of the cylinder is 0.15 m; .* axis at 0.1 m.*0.05 m.*ring"):
        Silo(section="round", inserts=(RING | {"position_m": 0.15}, *others))
