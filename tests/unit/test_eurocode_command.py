"""`taichi-silo eurocode`, the table [eurocode] of a scene, and what stands beside a run."""

import json
import re
import time

import numpy as np
import pandas as pd
import pytest

from taichi_silo.errors import BadInput
from taichi_silo.runs.eurocode import eurocode_of, solids, whose_numbers
from taichi_silo.runs.theories import theory_of
from taichi_silo.scene.design import Design, read_design
from taichi_silo.scene.eurocode import Eurocode
from taichi_silo.scene.scene import Mesh, Scene, Walls
from taichi_silo.scene.silo import Hopper, Outlet, Silo
from taichi_silo.show.report.eurocode import EurocodeReport

SILO = """
[silo]
width_m = 10
height_m = 30
section = "round"
hopper = { half_angle_deg = 30, outlet_width_m = 1 }
[eurocode]
solid = "wheat"
wall = "D3"
hopper_wall = "D1"
action_class = 3
outlet_eccentricity_m = 3.0
wall_thickness_m = 0.01
"""


@pytest.fixture
def file(tmp_path):
    place = tmp_path / "silo.toml"
    place.write_text(SILO, encoding="utf-8")
    return place


def test_it_prints_twenty_depths_and_names_solid_and_sand(said, file):
    code, out, err = said("eurocode", file)
    assert (code, err) == (0, "")
    table = out.split("Patch loads")[0]
    rows = [line.split() for line in table.splitlines() if re.match(r"\s+[\d.]+(\s+[−\d.]+){10}\s*$", line)]
    assert len(rows) == 20
    depths = [float(row[0]) for row in rows]
    assert depths == pytest.approx(np.linspace(0.0, 30.0 - 4.5 / np.tan(np.radians(30.0)), 20), rel=1e-3)
    assert "Wheat (7.5 to 9 kN/m³, internal friction 30°); the simulated sand is another one: karlsruhe" in out
    assert "critical friction angle 30°" in out and "without partial factors" in out
    assert "steep (6.1.1)" in out and "5.2.4.3" in out and "5.2.2.4" in out


def test_its_json_has_the_same_numbers(said, file):
    code, out, _ = said("eurocode", file, "--json", "--rows", 5)
    found = json.loads(out)
    report = EurocodeReport.of(read_design(file), 5)
    assert code == 0 and len(found["table"]) == 5
    assert found["table"][-1]["p_hf_Pa"] == pytest.approx(float(report.silo.filling_normal_Pa(report.silo.height_m)))
    assert found["solid"]["upper_weight_density_N_per_m3"] == 9000.0
    assert [one["contact_deg"] for one in found["channels"]][-1] == pytest.approx(22.3, abs=0.05)
    assert found["bottom"]["kind"] == "steep" and len(found["hopper"]) == 11


def test_its_folder_has_a_page_a_figure_tables_and_loads(said, file, tmp_path):
    code, out, err = said("eurocode", file, "--output", tmp_path / "out", "--quiet")
    assert (code, out, err) == (0, "", "")
    names = {one.name for one in (tmp_path / "out").iterdir()}
    assert names == {"eurocode.html", "eurocode.csv", "eurocode.png", "hopper.csv", "wall-loads"}
    table = pd.read_csv(tmp_path / "out" / "eurocode.csv")
    assert table.equals(table.astype(float)) and len(table) == 20
    assert (table["envelope_normal_Pa"] >= table["p_he_Pa"]).all()
    page = (tmp_path / "out" / "eurocode.html").read_text(encoding="utf-8")
    assert "Wheat" in page and "data:image/png" in page and "http" not in page.replace("http-equiv", "")
    code, _, err = said("eurocode", file, "--output", tmp_path / "out", "--quiet")
    assert code == 2 and "is there already" in err
    words = ("--overwrite", "--set", "eurocode.outlet_eccentricity_m=0", "--set", "eurocode.action_class=1")
    assert said("eurocode", file, "--output", tmp_path / "out", "--quiet", *words)[0] == 0
    assert not list((tmp_path / "out" / "wall-loads").glob("channel*"))  # what was there is replaced


def test_it_takes_no_grid_and_no_more_than_seconds(said, tmp_path):
    large = tmp_path / "large.toml"
    large.write_text('[silo]\nwidth_m = 37.3\nheight_m = 81.7\nsection = "round"\n[grid]\ncell_size_m = 0.005\n')
    begun = time.process_time()
    assert said("eurocode", large, "--quiet")[0] == 0
    assert time.process_time() - begun < 10.0


def test_it_lists_all_solids_of_the_table(said):
    code, out, _ = said("eurocode", "--solids")
    assert code == 0
    assert all(re.search(rf"^\s*{name} ", out, re.M) for name in solids())
    assert json.loads(said("eurocode", "--solids", "--json")[1])["wheat"]["patch_factor"] == 0.5


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["eurocode.solid=wheet"], "eurocode.solid is wheet; did you mean wheat?"),
        (["eurocode.solid=unobtainium"], "it must be one of default, aggregate"),
        (["eurocode.wall=D5"], "wall is D5; it must be 'D1', 'D2', 'D3' or 'D4'"),
        (["eurocode.action_class=4"], "action_class is 4; it must be at least 1 and at most 3"),
        (["eurocode.pressure_ratio=1.5"], "pressure_ratio is 1.5; it must be at least 0.05 and at most 0.9"),
        (["eurocode.lower_weight_density_N_per_m3=9500"], "must be at most the upper one, 9000"),
        (
            [
                "eurocode.pressure_ratio=0.9",
                "eurocode.pressure_ratio_factor=2",
                "eurocode.internal_friction_angle_deg=50",
                "eurocode.angle_of_repose_deg=50",
            ],
            "K tan(phi_i) tan(phi_r) must be below 1",
        ),
        (["eurocode.length_m=20"], "eurocode.length_m is 20.0; a round silo has none"),
        (["eurocode.outlet_eccentricity_m=6"], "must be at most half the width, 5 m"),
        (["eurocode.solids=wheat"], "eurocode.solids is not a parameter of a scene; did you mean eurocode.solid?"),
        (["silo.height_m=3"], "half angle of the hopper"),
        (["silos.height_m=3"], "silos is not a parameter"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(said, file, words, sentence):
    code, out, err = said("eurocode", file, *(part for word in words for part in ("--set", word)))
    assert code == 2 and out == "" and err.count("\n") == 1
    assert sentence in err


def test_flags_and_files_that_are_not_possible_are_refused(said, file, tmp_path):
    for words, sentence in (
        ([], "SCENE.toml is not given"), ([file, "--rows", 1], "rows is 1; it must be 2 to 1000"),
        ([tmp_path / "none.toml"], "No such file"),
        ([file, "--output", file], "output"),
    ):  # fmt: skip
        code, _, err = said("eurocode", *words)
        assert code == 2 and sentence in err and err.count("\n") == 1
    inclined = tmp_path / "inclined.toml"
    inclined.write_text("[silo]\noutline_m = [[0.06, 0], [0.14, 0], [0.2, 0.5], [0, 0.5]]\n")
    with pytest.raises(BadInput, match="outline_m has no vertical walls"):
        read_design(inclined)


def test_own_values_stand_over_those_of_the_table():
    own = Eurocode(solid="Soya beans", pressure_ratio=0.5, upper_weight_density_N_per_m3=7500.0)
    assert own.solid == "soya-beans"
    assert (own.stored["pressure_ratio"], own.stored["upper_weight_density_N_per_m3"]) == (0.5, 7500.0)
    assert own.stored["wall_friction_D2"] == solids()["soya-beans"].wall_friction_D2
    assert own.stored["title"] == "Soya beans, own values"


def test_a_run_is_compared_with_the_solid_of_its_scene():
    silo = Silo(outlet=Outlet(width_m=0.05, position="right"))
    scene = Scene(silo=silo, grid=Mesh(cell_size_m=0.01), walls=Walls(kind="smooth", friction_angle_deg=19.0),
                  eurocode=Eurocode(solid="wheat", wall="D1"))  # fmt: skip
    found = theory_of(scene, 19.0, 0.42)["eurocode"]
    code = eurocode_of(scene)
    assert (found["solid"], found["wall"], found["bottom"]) == ("Wheat", "D1", "flat")
    assert code.values("wall pressure").wall_friction == pytest.approx(0.24 / 1.16)
    assert found["discharge_normal_Pa"] == float(code.discharge_normal_Pa(0.5))
    assert found["large_eccentricity"] and found["whose_numbers"] == whose_numbers(scene)
    assert eurocode_of(scene).outlet_eccentricity_m == pytest.approx(0.075)
    assert eurocode_of(Scene()).wall == "D3"  # very rough
    assert json.dumps(found)


def test_sand_of_the_table_is_not_the_simulated_one_either():
    words = whose_numbers(Design())
    assert "its solid Sand (14 to 16 kN/m³, internal friction 36°)" in words
    assert "karlsruhe (16.2 kN/m³ at a void ratio of 0.6, critical friction angle 30°)" in words


@pytest.mark.parametrize("name", solids())
def test_every_solid_has_a_report_above_every_bottom(name):
    for half_angle, section, height, number in (
        (15.0, "round", 30.0, 1), (40.0, "plane", 60.0, 2), (70.0, "round", 14.0, 3), (None, "plane", 3.0, 2),
        (None, "round", 8.0, 3),
    ):  # fmt: skip
        hopper = half_angle and Hopper(half_angle_deg=half_angle, outlet_width_m=1.0)
        silo = Silo(width_m=10, height_m=height, section=section, hopper=hopper)
        report = EurocodeReport.of(Design(silo=silo, eurocode=Eurocode(solid=name, action_class=number, wall="D4")))
        assert json.dumps(report.as_json(), allow_nan=False)
        assert len(report.hopper_rows) == (11 if hopper else 0) and report.facts
        assert (report.frame >= -1e-9).all().all()


def test_the_scene_of_the_page_has_no_suction_and_says_why_channels_stand_beside_mass_flow(said, file):
    code, out, _ = said("eurocode", file, "--json")
    assert code == 0
    found = json.loads(out)
    assert found["table"][0]["envelope_least_normal_Pa"] == 0.0
    assert found["bottom"]["flow"] == "mass flow" and found["channels"]
    assert any("5.2.4 asks for flow channels by the place of the outlet alone" in one for one in found["notes"])
    code, out, _ = said("eurocode", file)
    assert "near the surface 0 is left" in out
    code, out, _ = said("eurocode", file, "--set", "eurocode.outlet_eccentricity_m=0", "--json")
    assert not any("flow channels" in one for one in json.loads(out)["notes"])


def test_a_solid_that_is_none_is_named_with_the_list_beside_the_guess(said, file):
    """The word is of the scene: eurocode.solid; so are those of the other values of the table."""
    code, _, err = said("eurocode", file, "--set", "eurocode.solid=weat")
    assert code == 2 and err.count("\n") == 1
    assert "eurocode.solid is weat; did you mean wheat? All: taichi-silo eurocode --solids" in err
    code, _, err = said("eurocode", file, "--set", "eurocode.solid=zzz")
    assert code == 2 and "eurocode.solid is zzz; it must be one of " in err and "wheat" in err
    for change, words in (
        ("eurocode.solid=5", "eurocode.solid is 5; it must be text"),
        ("eurocode.wall=D9", "eurocode.wall is D9; it must be"),
        ("eurocode.pressure_ratio=7", "eurocode.pressure_ratio is 7; it must be at least 0.05 and at most 0.9"),
        ("eurocode.lower_weight_density_N_per_m3=9500", "eurocode.lower_weight_density_N_per_m3 is 9500"),
    ):
        code, _, err = said("eurocode", file, "--set", change)
        assert code == 2 and words in err, err


@pytest.mark.parametrize(("section", "corners"), [
    ("plane", [[0.5, 0], [1.5, 0], [2, 1.5], [2, 8], [0, 8], [0, 1.5]]),
    ("round", [[0.9, 0], [1.1, 0], [2, 1.2], [2, 6], [0, 6], [0, 1.2]]),
])  # fmt: skip
def test_an_outline_that_is_a_hopper_has_the_hoppers_numbers(section, corners):
    """Two straight walls that are mirror images are a wedge, or a cone, however they are written down."""
    (left, _), (right, _), (wide, foot) = corners[:3]
    angle = float(np.degrees(np.arctan2(wide - right, foot)))
    hopper = Silo(width_m=wide, height_m=corners[3][1], section=section,
                  hopper=Hopper(half_angle_deg=angle, outlet_width_m=right - left))  # fmt: skip
    drawn = Silo.polygon(corners, section=section)
    eurocode = Eurocode(solid="maize", action_class=3)
    as_hopper, as_drawn = (EurocodeReport.of(Design(silo=silo, eurocode=eurocode)) for silo in (hopper, drawn))
    assert len(as_drawn.hopper_rows) == 11 and as_drawn.facts == as_hopper.facts and as_drawn.notes == as_hopper.notes
    for here, there in zip(as_drawn.hopper_rows, as_hopper.hopper_rows, strict=True):
        assert list(here.values()) == pytest.approx(list(there.values()), rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("corners", [
    [[2.5, 0], [3.5, 0], [4.2, 2], [6, 3.2], [6, 15], [0, 15], [0, 3.2], [1.8, 2]],  # expanded flow: two slopes
    [[0, 0], [1, 0], [4, 3], [4, 12], [0, 12]],  # one inclined wall
])  # fmt: skip
def test_other_inclined_walls_are_said_not_to_be_computed(corners):
    report = EurocodeReport.of(Design(silo=Silo.polygon(corners)))
    assert report.bottom is None and not report.hopper_rows
    assert any("no cone or wedge of section 6: they are not computed" in one for one in report.notes)


@pytest.mark.parametrize(("height", "clauses"), [(30.0, "2"), (15.0, "3"), (3.0, "4")])
def test_every_fact_names_the_clause_of_its_own_kind_of_silo(height, clauses):
    """5.2 is for slender silos, 5.3 for intermediate and squat ones, 5.4 for retaining ones."""
    report = EurocodeReport.of(Design(silo=Silo(width_m=10, height_m=height, section="round")))
    words = report.facts["C_h, C_w"] + report.depth_table().note.split("n_zSk, p_vf: ")[1]
    assert re.findall(r"5\.(\d)\.", words) == [clauses, clauses]


def test_a_wedge_says_how_it_departs_from_the_print_and_that_a_pyramid_is_none():
    def notes(**more):
        silo = Silo(
            width_m=4.0, height_m=14.0, hopper=Hopper(half_angle_deg=18.0, outlet_width_m=0.8), **more.pop("s", {})
        )
        return EurocodeReport.of(Design(silo=silo, eurocode=Eurocode(solid="coal", wall="D1", **more))).notes

    apart, pyramid = "the code prints -2", "a pyramid's is not computed"
    assert any(apart in one for one in notes()) and not any(pyramid in one for one in notes())
    assert any(apart in one for one in notes(length_m=6.0)) and any(pyramid in one for one in notes(length_m=6.0))
    assert not any(apart in one or pyramid in one for one in notes(s={"section": "round"}))
