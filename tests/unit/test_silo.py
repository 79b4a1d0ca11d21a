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
from taichi_silo.scene.scene import Mesh, Scene
from taichi_silo.scene.silo import Hopper, Insert, Outlet, Silo
from taichi_silo.simulation.discretise import Section, grid_of, surfaces_of
from taichi_silo.utils.schema import one_sentence


def area_of(outline):
    x, y = outline.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


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
    assert area_of(outline) == pytest.approx(insert.area_m2(), rel=1e-4)
    silo = Silo(inserts=(insert,))
    _x, _y, area = silo.lattice(0.001)
    assert area.sum() == pytest.approx(0.1 - insert.area_m2(), rel=2e-3)
    assert silo.area_m2 == pytest.approx(0.1 - insert.area_m2(), rel=1e-12)


@pytest.mark.parametrize(
    ("position", "edges"), [("left", (0.0, 0.05)), ("centre", (0.075, 0.125)), ("right", (0.15, 0.2))]
)
def test_an_outlet_stands_where_it_was_put(position, edges):
    assert Silo(outlet=Outlet(width_m=0.05, position=position)).outlet_m == pytest.approx(edges)


def test_a_silo_without_anything_sinks_as_a_whole_and_one_with_something_does_not():
    assert Silo().floor_is_outlet
    assert not Silo(outlet=Outlet(width_m=0.08)).floor_is_outlet
    assert not Silo(hopper=Hopper(half_angle_deg=20, outlet_width_m=0.08)).floor_is_outlet
    assert not Silo(inserts=(Insert(kind="roof", width_m=0.06, bottom_m=0.1),)).floor_is_outlet


ROOF = {"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"silo": {"outlet": {"width_m": 0.3}}}, ["outlet width is 0.3", "0.2"]),
        ({"silo": {"outlet": {"width_m": 0.005}}}, ["outlet width is 0.005", "at least 0.01"]),
        ({"silo": {"outlet": {"width_m": 0.083}}}, ["outlet width is 0.083", "grid"]),
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
    ],
    ids=lambda value: "",
)
def test_impossible_silos_are_refused_in_one_sentence(tables, words):
    with pytest.raises(ValidationError) as caught:
        Scene.model_validate(tables)
    sentence = one_sentence(caught.value)
    for word in words:
        assert word in sentence, sentence


def test_a_round_silo_has_an_axis_on_the_grid():
    with pytest.raises(ValidationError, match="radius"):
        Scene(silo=Silo(section="round", width_m=0.21, height_m=0.6), grid=Mesh(cell_size_m=0.03))


def test_points_are_found_again_by_their_identity():
    before = {"identity": np.array([4, 2, 7, 1]), "mass": np.array([40.0, 20.0, 70.0, 10.0]), "time_s": 1.0}
    now = {"identity": np.array([7, 4])}
    assert matched(before, now)["mass"].tolist() == [70.0, 40.0]
    assert matched(before, now)["time_s"] == 1.0


def test_an_insert_of_a_round_silo_ends_at_the_axis():
    silo = Silo(
        section="round", outlet=Outlet(width_m=0.08), inserts=(Insert(kind="roof", width_m=0.06, bottom_m=0.1),)
    )
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
    assert found["eurocode"]["slenderness"] == "retaining"
    assert "discharge_normal_Pa" not in found["eurocode"]
