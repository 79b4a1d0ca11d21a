"""Walls whose friction changes: bands that cannot be, means along a wall, and Janssen's theory through them."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from taichi_silo.analysis.theory.banded_janssen import BandedJanssen
from taichi_silo.analysis.theory.janssen import Janssen
from taichi_silo.mpm.walls import Coulomb, NoSlip, Surface
from taichi_silo.runs.theories import janssen_of
from taichi_silo.scene import bands
from taichi_silo.scene.scene import Scene, Walls
from taichi_silo.scene.scene_files import scene_of
from taichi_silo.scene.silo import Silo
from taichi_silo.scene.symmetry import half_model
from taichi_silo.simulation.wall_friction import of_surface
from taichi_silo.utils.schema import one_sentence

SMOOTH = {"kind": "smooth", "friction_angle_deg": 25.0}
LINER = {"to_m": 0.2, "friction_angle_deg": 10.0}
NAMES = ("normal_force_N_per_m", "shear_force_N_per_m", "bottom_force_N_per_m")


@pytest.mark.parametrize(
    ("bands", "words"),
    [
        ([{}], ["friction_angle_deg is missing"]),
        ([{"friction_angle_deg": 95}], ["walls.bands.0.friction_angle_deg is 95", "below 90"]),
        ([LINER | {"from_m": 0.3}], ["0.3 to 0.2 m", "above"]),
        ([LINER, {"from_m": 0.1, "friction_angle_deg": 5}], ["overlap", "apart"]),
        ([LINER, LINER | {"wall": "left"}], ["overlap", "apart"]),
        ([{"from_m": 0.5, "friction_angle_deg": 5}], ["begins at 0.5 m", "surface"]),
        ([LINER | {"wall": "bottom"}], ["wall is bottom", "both"]),
        ([LINER | {"height": 1}], ["walls.bands.0.height"]),
    ],
    ids=lambda value: "",
)
def test_bands_that_cannot_be_are_refused_in_one_sentence(bands, words):
    with pytest.raises(ValidationError) as caught:
        scene_of({"walls": SMOOTH | {"bands": bands}})
    sentence = one_sentence(caught.value)
    assert all(word in sentence for word in words), sentence


def test_a_round_silo_has_one_wall():
    with pytest.raises(ValidationError, match="band's wall is left; a round silo has one wall: it must be both"):
        scene_of({"silo": {"section": "round"}, "walls": SMOOTH | {"bands": [LINER | {"wall": "left"}]}})
    scene_of({"silo": {"section": "round"}, "walls": SMOOTH | {"bands": [LINER]}})


def test_walls_that_differ_are_computed_whole():
    alike = scene_of({"walls": SMOOTH | {"bands": [LINER]}})
    assert half_model(alike)[0]
    unlike = scene_of({"walls": SMOOTH | {"bands": [LINER | {"wall": "left"}]}})
    assert half_model(unlike)[1] == ("The whole silo is computed: the walls are not alike (10° left from 0 to 200 mm).")
    assert not half_model(unlike)[0]


def test_a_node_has_the_mean_friction_of_what_it_stands_for():
    walls = Walls(**SMOOTH, bands=[LINER, {"from_m": 0.3, "wall": "right", "friction_angle_deg": 0.0}])
    low, high = np.array([0.0, 0.15, 0.25, 0.6, -0.1]), np.array([0.1, 0.25, 0.35, 0.7, 0.0])
    ten, own = math.tan(math.radians(10.0)), math.tan(math.radians(25.0))
    assert bands.coefficient(walls, "left", low, high) == pytest.approx([ten, 0.5 * (ten + own), own, own, ten])
    assert bands.coefficient(walls, "right", low, high) == pytest.approx(
        [ten, 0.5 * (ten + own), 0.5 * own, 0.0, ten], abs=1e-12
    )


def test_a_liner_on_a_very_rough_wall():
    walls = Walls(kind="very-rough", bands=[LINER])
    found = bands.coefficient(walls, "left", [0.1, 0.16, 0.18, 0.3], [0.2, 0.22, 0.24, 0.4])
    ten = math.tan(math.radians(10.0))
    assert found == pytest.approx([ten, ten, bands.VERY_ROUGH, bands.VERY_ROUGH])


def test_an_inclined_wall_has_the_bands_of_its_side():
    walls = Walls(**SMOOTH, bands=[LINER | {"wall": "left"}])
    line = Surface("hopper_left", ((0.0, 0.4), (0.1, 0.0)), Coulomb(25.0))
    ten, own = math.tan(math.radians(10.0)), math.tan(math.radians(25.0))
    height = np.array([-0.01, 0.1, 0.3])
    assert of_surface(line, "left", walls).friction(height) == pytest.approx([ten, ten, own])
    assert of_surface(line, "right", walls).friction(height) == pytest.approx([own] * 3)
    assert Surface("wall", line.corners, NoSlip()).friction(height).tolist() == [-1.0] * 3


@settings(max_examples=30, deadline=None)
@given(
    mu=st.floats(0.0, 1.0), ratio=st.floats(0.1, 2.0), parts=st.lists(st.floats(0.01, 2.0), min_size=1, max_size=4),
    section=st.sampled_from(["plane", "round"]),
)  # fmt: skip
def test_layers_of_one_friction_are_janssens_theory(mu, ratio, parts, section):
    one = Janssen(0.3, sum(parts), 15e3, math.degrees(math.atan(mu)), ratio, section)
    found = BandedJanssen.through(0.3, 15e3, ratio, section, tuple((part, mu) for part in parts))
    for name in NAMES:
        assert getattr(found, name) == pytest.approx(getattr(one, name), rel=1e-9, abs=1e-9)
    depth = np.linspace(0.0, one.height_m, 7)
    np.testing.assert_allclose(found.vertical_stress_Pa(depth), one.vertical_stress_Pa(depth), rtol=1e-9)
    assert found.wall_friction_angle_deg == pytest.approx(one.wall_friction_angle_deg, abs=1e-6)


@pytest.mark.parametrize(("section", "walls"), [("plane", 2), ("round", 1)])
def test_layers_carry_the_weight_and_their_stresses_add_up_to_the_forces(section, walls):
    found = BandedJanssen.through(0.2, 16e3, 0.42, section, ((0.2, 0.5), (0.1, 0.0), (0.2, 0.1)))
    carried = found.bottom_force_N_per_m + walls * found.shear_force_N_per_m
    assert carried == pytest.approx(found.weight_N_per_m, rel=1e-12)
    z = np.linspace(0.0, 0.5, 100_001)
    normal, shear = (float(np.trapezoid(f(z), z)) for f in (found.normal_stress_Pa, found.shear_stress_Pa))
    assert normal == pytest.approx(found.normal_force_N_per_m, rel=1e-8)
    assert shear == pytest.approx(found.shear_force_N_per_m, rel=1e-4)  # the stress jumps between the layers
    assert found.fitted(found.normal_force_N_per_m) == pytest.approx(0.42, rel=1e-9)
    with pytest.raises(ValueError, match="no pressure ratio"):
        found.fitted(-1.0)


def test_the_theory_beside_a_run_goes_through_its_bands():
    upper = {"from_m": 0.4, "wall": "left", "friction_angle_deg": 10.0}
    scene = Scene(silo=Silo(height_m=0.6), walls=Walls(**SMOOTH, bands=[LINER, upper]))
    found = janssen_of(scene, 25.0, 0.45)
    ten, own = math.tan(math.radians(10.0)), math.tan(math.radians(25.0))
    assert isinstance(found, BandedJanssen)
    assert found.layers == tuple(
        (pytest.approx(height), pytest.approx(mu)) for height, mu in ((0.2, 0.5 * (ten + own)), (0.2, own), (0.2, ten))
    )
    assert not isinstance(janssen_of(Scene(), 25.0, 0.45), BandedJanssen)
