"""Named sands: complete, ordered, and at the stress point what their constants say."""

import numpy as np
import pytest

from taichi_silo.errors import BadInput
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.scene import sands
from taichi_silo.scene.published_sands import published
from taichi_silo.scene.scene_files import scene_of
from taichi_silo.studies.element_tests import TESTS, start_strain, through_point

NAMES = list(published())
OWN = (
    "critical_friction_angle_deg = 31.0\ngranular_hardness_Pa = 1e9\nn = 0.3\nalpha = 0.2\nbeta = 1.5\n"
    "e_i0 = 1.1\ne_c0 = 0.95\ne_d0 = 0.6\ngrain_density_kg_per_m3 = 2650.0\nd50_m = 0.3e-3\n"
)


def of(name, share=0.5):
    """A sand at a void ratio between e_d0 (0) and e_c0 (1)."""
    constants = published()[name]
    return sands.sand(name, constants["e_d0"] + share * (constants["e_c0"] - constants["e_d0"]))


def test_there_are_the_papers_sand_and_at_least_five_more_each_with_a_source():
    assert NAMES[0] == "karlsruhe"
    assert len(NAMES) >= 6
    assert all(entry["source"] and entry["read_in"] for entry in published().values())


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("pressure", [1e3, 1e5, 1e6])
def test_limits_of_the_void_ratio_are_ordered_and_fall_with_pressure(name, pressure):
    law = of(name).skeleton()
    e_d, e_c, e_i = law.void_ratio_limits(pressure)
    assert 0.0 < e_d < e_c < e_i
    assert law.void_ratio_limits(2.0 * pressure)[1] < e_c


@pytest.mark.parametrize("name", NAMES)
def test_isotropic_compression_from_the_loosest_state_follows_its_line(name):
    """Bauer's law, e = e_i0 exp(-(3p/h_s)^n): what fixes h_i."""
    sand = of(name)
    law = sand.skeleton()
    point = StressPoint(law, [-1e3] * 3 + [0.0], law.void_ratio_limits(1e3)[2])
    for _ in range(40):
        point.step([-2e-5, -2e-5, -2e-5, 0.0], count=20)
    pressure = -point.stress[:3].mean()
    assert pressure > 3e3
    assert point.void_ratio == pytest.approx(law.void_ratio_limits(pressure)[2], rel=1e-5)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("test", ["triaxial", "triaxial-extension"])
def test_sand_is_sheared_towards_its_critical_void_ratio_and_friction_angle(name, test):
    """Sand of e_c0 and looser densifies towards e_c; some half of the way within a strain of 0.5, and slowly after."""
    for share in (0.9, 1.08):
        sand = of(name, share)
        law, pressure = sand.constitutive_law(), 100e3
        *_, last = through_point(TESTS[test], law, sand.void_ratio, pressure, 0.5)
        mean = (last[1] + last[2] + last[3]) / 3.0
        before = sand.void_ratio - law.void_ratio_limits(pressure)[1]
        assert abs(last[5] - law.void_ratio_limits(mean)[1]) < max(0.55 * abs(before), 0.002)
        assert abs(last[6] - sand.critical_friction_angle_deg) < 1.5


@pytest.mark.parametrize("name", NAMES)
def test_at_the_critical_state_nothing_changes_any_more(name):
    """T = 0 under D along -T^*, at e = e_c, where the ratio of stresses is (1 + sin phi_c) / (1 - sin phi_c)."""
    sand = of(name)
    law = sand.skeleton()
    s = np.sin(np.radians(sand.critical_friction_angle_deg))
    side = 100e3
    axial = side * (1 + s) / (1 - s)
    mean = (axial + 2 * side) / 3.0
    point = StressPoint(law, [-side, -axial, -side, 0.0], law.void_ratio_limits(mean)[1])
    after = point.trial([0.5e-9, -1e-9, 0.5e-9, 0.0])[:4]
    elastic = point.trial([-1e-9, -1e-9, -1e-9, 0.0])[:4]
    assert np.abs(after - point.stress).max() < 1e-5 * np.abs(elastic - point.stress).max()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("share", "peaks"), [(0.25, True), (1.05, False)], ids=["dense", "loose"])
def test_dense_sand_has_a_peak_and_loose_sand_none(name, share, peaks):
    sand = of(name, share)
    rows = list(through_point(TESTS["triaxial"], sand.constitutive_law(), sand.void_ratio, 50e3, 0.3))
    assert (np.array(rows)[:, 6].max() > sand.critical_friction_angle_deg + 3.0) == peaks


def test_sand_with_memory_starts_along_the_filling():
    law = sands.sand("hochstetten", 0.7, law="intergranular").constitutive_law()
    h = np.array(start_strain(law))
    assert np.sqrt(h @ h) == pytest.approx(law.radius)
    assert (h[:3] < 0).all()


def test_ones_own_sand_from_a_file(tmp_path):
    file = tmp_path / "dune.toml"
    file.write_text(OWN)
    sand = sands.sand(str(file), 0.8)
    assert (sand.name, sand.n, sand.void_ratio) == ("dune", 0.3, 0.8)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("e_c0 = 0.95", "e_c0 = 1.2"), "e_d0 < e_c0 < e_i0"),
        (("n = 0.3", "n = 1.5"), "at most 0.99"),
        (("alpha = 0.2", "alpha = 4.9"), "h_i"),
        (("alpha = 0.2", "alpah = 0.2"), "lacks alpha"),
        (("d50_m = 0.3e-3", "d50_m = 0.3e-3\ncolour = 1"), "colour"),
        (("beta = 1.5", 'beta = "much"'), "beta"),
        (("beta = 1.5", "beta = "), "cannot be read"),
    ],
    ids=lambda change: change[1] if isinstance(change, tuple) else "",
)
def test_an_impossible_sand_is_refused_with_what_is_violated(tmp_path, change, words):
    file = tmp_path / "dune.toml"
    file.write_text(OWN.replace(*change))
    with pytest.raises(BadInput, match=words):
        sands.sand(str(file), 0.8)


@pytest.mark.parametrize(("name", "words"), [("toyuora", "toyoura"), ("", "must be"), ("none.toml", "cannot be read")])
def test_an_unknown_sand_is_refused_with_those_there_are(name, words):
    with pytest.raises(BadInput, match=words):
        sands.sand(name, 0.7)


@pytest.mark.parametrize("name", ["wheat", "Cement", "soya beans"])
def test_a_stored_solid_that_is_no_sand_is_said_to_have_only_theory(name):
    """No constants of the law are known of a solid of EN 1991-4; the sentence says where its pressures are."""
    key = name.lower().replace(" ", "-")
    for ask in (lambda: sands.sand(name, 0.6), lambda: scene_of({"sand": {"name": name, "void_ratio": 0.6}})):
        with pytest.raises(BadInput) as said:
            ask()
        assert f"{key} is a solid of EN 1991-4" in str(said.value) and "only theory applies" in str(said.value)
        assert "taichi-silo eurocode" in str(said.value) and "\n" not in str(said.value)
    with pytest.raises(BadInput) as said:
        sands.sand("gravel", 0.6)
    assert "EN 1991-4" not in str(said.value)
