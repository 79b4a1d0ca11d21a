"""Cells that fit a silo: chosen where their size is not given, named where the one that is given does not fit."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from taichi_silo.runs.method_choices import cell_size
from taichi_silo.scene import cell_sizes
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Mesh, Scene
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.utils.schema import one_sentence


def refused(**tables):
    with pytest.raises(ValidationError) as caught:
        Scene.model_validate(tables)
    return one_sentence(caught.value)


@pytest.mark.parametrize(
    "silo", [{}, {"outlet": {"width_m": 0.05}}, {"outlet": {"width_m": 0.08, "position": "left"}}, {"height_m": 1.0},
             {"hopper": {"half_angle_deg": 20, "outlet_width_m": 0.043}}, {"section": "round"}]
)  # fmt: skip
def test_cells_of_5_mm_stay_where_they_make_some_40_across(silo):
    assert Scene(silo=Silo(**silo)).grid.cell_size_m == 0.005


@pytest.mark.parametrize(
    ("silo", "across"),
    [
        ({"width_m": 0.2032, "height_m": 0.3048}, 40),  # 8 in x 12 in
        ({"width_m": 0.3048, "height_m": 0.6096}, 40),
        ({"width_m": 12.192, "height_m": 24.384}, 40),  # 40 ft x 80 ft
        ({"width_m": 0.195, "height_m": 0.3}, 39),
        ({"width_m": 4.0, "height_m": 12.0}, 40),
        ({"width_m": 2.0, "height_m": 0.04}, 500),  # ten rows
        ({"width_m": 3.0, "height_m": 9.0, "outlet": {"width_m": 0.25}}, 48),  # its edges on the grid
        ({"width_m": 0.78, "height_m": 0.9, "section": "round"}, 52),  # its axis, too: 39 or 65 across have none
    ],
)
def test_where_no_size_is_given_cells_fit_and_about_40_go_across(silo, across):
    scene = Scene(silo=Silo(**silo))
    assert scene.silo.width_m / scene.grid.cell_size_m == pytest.approx(across, rel=1e-6)
    assert cell_size(scene).because.startswith(f"Not given, so chosen to fit: {across} cells across")
    again = Scene(silo=scene.silo, grid=Mesh(cell_size_m=scene.grid.cell_size_m))  # as run.toml has it
    assert again == scene
    assert cell_size(again).because.startswith(f"As given: {across} cells across")


def test_a_size_that_was_chosen_is_chosen_anew_for_another_silo():
    feet = {"silo.width_m": 0.3048, "silo.height_m": 0.6096}
    assert changed(Scene(), feet).grid.cell_size_m == pytest.approx(0.00762)
    assert changed(Scene(), feet | {"grid.cell_size_m": 0.0381}).grid.cell_size_m == 0.0381
    assert "would do" in refused(silo={"width_m": 0.3048, "height_m": 0.6096}, grid={"cell_size_m": 0.005})


@pytest.mark.parametrize(
    ("silo", "size", "sizes"),
    [
        ({"width_m": 0.195, "height_m": 0.3}, 0.01, "0.00975, 0.008125 or 0.0078 m would do"),
        ({"width_m": 0.2, "height_m": 0.5, "outlet": {"width_m": 0.083}}, 0.005, "0.0005, 0.00025 or 0.000125 m would"),
        ({"width_m": 0.21, "height_m": 0.6, "section": "round"}, 0.03, "0.035, 0.02625 or 0.021 m would do"),
    ],
)
def test_a_size_that_does_not_fit_is_refused_with_some_that_do(silo, size, sizes):
    words = refused(silo=silo, grid={"cell_size_m": size})
    found = re.search(r"([\d.e-]+, )+[\d.e-]+ or [\d.e-]+(?= m would do)", words)[0]
    for one in re.findall(r"[\d.][\d.e-]*", found):
        assert Scene(silo=Silo(**silo), grid=Mesh(cell_size_m=float(one))).points > 0
    assert sizes in words
    assert "cell size" in words or "lie on the grid" in words


@settings(max_examples=40, deadline=None)
@given(wide=st.integers(20, 900), high=st.integers(20, 900), b=st.integers(10, 19), round_=st.booleans())
def test_a_silo_without_a_cell_size_is_a_scene_or_refused_with_one_that_fits(wide, high, b, round_):
    silo = {"width_m": wide / 1e3, "height_m": high / 1e3, "section": "round" if round_ else "plane"}
    silo |= {"outlet": Outlet(width_m=b / 1e3)}
    try:
        scene = Scene(silo=Silo(**silo), flow={"displacement_m": 1e-3})
    except ValidationError as error:
        words = one_sentence(error)
        assert re.search(r"would do|but cells of .* have lines|lengths are in metres|points", words), words
        return
    assert scene.silo.width_m / scene.grid.cell_size_m == pytest.approx(round(wide / 1e3 / scene.grid.cell_size_m))


@pytest.mark.parametrize(
    "wide, high", [(0.2037, 0.51113), (0.217, 0.503), (0.1999, math.pi), (7.013, 0.5 * math.sqrt(2.0))]
)
@pytest.mark.parametrize("section", ["plane", "round"])
def test_a_silo_of_any_size_is_met_exactly(wide, high, section):
    """Cells divide the width, their rows the height: they are nearly square, and hold as much sand as the silo."""
    scene = Scene(silo=Silo(width_m=wide, height_m=high, section=section))
    size = scene.grid.cell_size_m
    assert cell_sizes.whole(wide, size)
    x, y, area = scene.silo.lattice(scene.spacing_m, scene.rise_m)
    assert len(x) == scene.points and 400 <= scene.points <= 70_000
    rise = np.diff(np.unique(y.round(9)))
    assert rise == pytest.approx(scene.cell_height_m) and scene.cell_height_m == pytest.approx(size, rel=0.05)
    assert (y.min(), high - y.max()) == pytest.approx((0.5 * scene.rise_m, 0.5 * scene.rise_m))
    assert area.sum() == pytest.approx(wide * high, rel=1e-12)


@pytest.mark.parametrize(
    ("silo", "across"),
    [
        ({"width_m": 0.3048, "height_m": 0.6096, "outlet": {"width_m": 0.08}}, 40),
        ({"width_m": 0.3048, "height_m": 0.6096, "outlet": {"width_m": 0.08}, "section": "round"}, 40),
        ({"width_m": 0.211, "height_m": 0.5, "outlet": {"width_m": 0.06, "position": "right"}}, 40),
        ({"width_m": 0.211, "height_m": 0.5, "outlet": {"width_m": 0.06, "position": 0.09}}, 40),
    ],
)
def test_a_size_that_nobody_gave_is_not_blamed_for_the_edges_of_an_outlet(silo, across):
    words = refused(silo=silo)
    assert words.startswith("no cells of about ") and "the edges of the outlet, but cells of" in words
    assert not re.search(r"cell size|divide", words)
    found = re.search(r"cells of (\S+) m have lines at (\S+), (\S+) m \(a width of (\S+) m\)", words).groups()
    size, low, high, wide = map(float, found)
    assert silo["width_m"] / size == pytest.approx(across) and high - low == pytest.approx(wide)
    position = silo["outlet"].get("position", "centre")
    near = {"width_m": wide, "position": position if isinstance(position, str) else 0.5 * (low + high)}
    assert Scene.model_validate({"silo": silo | {"outlet": near}}).grid.cell_size_m == pytest.approx(size)


def test_a_bed_that_no_cells_are_fine_enough_for_is_refused_with_its_height():
    assert "fine enough for a height of 0.01 m" in refused(silo={"width_m": 90.0, "height_m": 0.01})


def test_edges_that_no_cells_meet_are_refused_with_places_that_they_would():
    silo = {"width_m": 0.2037, "height_m": 0.5, "outlet": {"width_m": 0.08013}}
    for grid in ({}, {"cell_size_m": 0.005}):
        words = refused(silo=silo, grid=grid)
        size, low, high = map(float, re.search(r"cells of (\S+) m have lines at (\S+), (\S+) m", words).groups())
        near = {"width_m": high - low, "position": 0.5 * (low + high)}
        assert Scene(silo=silo | {"outlet": near}, grid={"cell_size_m": size}).points > 1000
