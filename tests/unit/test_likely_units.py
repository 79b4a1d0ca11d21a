"""A value in another unit than its name says is possible, and gets a word; one that is right gets none."""

import pytest

from taichi_silo.cli.model_silo import walls
from taichi_silo.scene import likely_units
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.sands import sand
from taichi_silo.scene.scene import Scene, Walls
from taichi_silo.scene.silo import Hopper, Insert, Outlet, Silo


@pytest.mark.parametrize("name", published())
@pytest.mark.parametrize(
    ("constant", "factor", "unit"),
    [("granular_hardness_Pa", 1e-3, "kPa"), ("d50_m", 1e3, "mm"), ("grain_density_kg_per_m3", 0.01, "kN/m3")],
)
def test_a_constant_of_a_published_sand_in_another_unit_gets_a_word_and_in_its_own_none(name, constant, factor, unit):
    one = sand(name, 0.5 * (published()[name]["e_d0"] + published()[name]["e_c0"]))
    assert likely_units.of_scene(Scene(sand=one)) == []
    value = factor * getattr(one, constant)
    large = Silo(width_m=10.0, height_m=10.0)  # three grains must have room in it
    (words,) = likely_units.of_scene(Scene(silo=large, sand=Sand.model_validate(one.model_dump() | {constant: value})))
    assert words.startswith(f"sand.{constant} is {value:g} ") and words.endswith(f"is it in {unit}?")
    assert "times above" in words if factor > 1.0 else "times below" in words


def test_grains_that_do_not_fit_into_the_silo_are_refused_by_their_own_name():
    with pytest.raises(ValueError, match=r"sand.d50_m is 0.5 m, and three of it make a characteristic length of 1.5 m"):
        Scene(sand=Sand(d50_m=0.5))


def test_angles_in_radians_get_a_word_and_walls_without_friction_none():
    rough = Silo(
        hopper=Hopper(half_angle_deg=0.35, outlet_width_m=0.1, friction_angle_deg=0.3), height_m=20.0,
        inserts=(Insert(kind="cylinder", width_m=0.05, bottom_m=12.0, friction_angle_deg=0.4),),
    )  # fmt: skip
    found = likely_units.of_scene(Scene(silo=rough, walls=Walls(kind="smooth", friction_angle_deg=0.33)))
    assert [words.split()[0] for words in found] == [
        "walls.friction_angle_deg", "silo.hopper.friction_angle_deg", "silo.hopper.half_angle_deg",
        "silo.inserts.0.friction_angle_deg",
    ]  # fmt: skip
    assert "is 0.33 degrees; is it in radians? That would be 18.9 degrees." in found[0]
    still = Scene(silo=Silo(outlet=Outlet(width_m=0.1)), walls=Walls(kind="smooth", friction_angle_deg=0.0))
    assert likely_units.of_scene(still) == likely_units.of_scene(Scene(walls=walls("smooth", 0.6))) == []


def test_a_silo_of_more_than_100_m_gets_a_word():
    found = likely_units.of_scene(Scene(silo=Silo(width_m=200.0, height_m=500.0)))
    assert found == [
        "silo.width_m is 200 m; is it in mm? That would be 0.2 m.",
        "silo.height_m is 500 m; is it in mm? That would be 0.5 m.",
    ]
    assert likely_units.of_scene(Scene(silo=Silo(width_m=40.0, height_m=100.0))) == []


def test_the_check_of_a_scene_says_the_word(said, tmp_path):
    file = tmp_path / "silo.toml"
    file.write_text("[sand]\ngranular_hardness_Pa = 190e3\n[grid]\ncell_size_m = 0.05\n[machine]\nthreads = 1\n")
    code, out, _ = said("run", file, "--check")
    assert code == 0 and "Warning: sand.granular_hardness_Pa is 190000 Pa, 1e+03 times below" in out
