"""The report of a run: what stands in it, and what becomes of it when files are missing or damaged."""

import json
import os
import re
import shutil
import sys
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest

from taichi_silo.cli import app
from taichi_silo.errors import BadInput
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.runs.theories import hopper_of
from taichi_silo.scene import known_limits
from taichi_silo.scene.scene import Averaging, Flow, Mesh, Scene, Walls
from taichi_silo.scene.silo import Hopper, Insert, Outlet, Silo
from taichi_silo.show import theory
from taichi_silo.show.report.drawing import drawing
from taichi_silo.show.report.key import key_numbers
from taichi_silo.show.report.page import page, report
from taichi_silo.show.report.parameters import parameter_tables
from taichi_silo.show.report.states import (
    discharge_rate_kg_per_s_m,
    forces_of,
    largest_hopper_stress,
    largest_wall_stress,
)
from taichi_silo.show.report.tables import hopper_table, stress_table
from taichi_silo.show.report.trust import verdict
from taichi_silo.show.report.words import kN, mm, number, per_cent, plain

HOPPER = Silo(hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.1))


@pytest.fixture(scope="module")
def run(small_run, tmp_path_factory):
    return small_run(tmp_path_factory.mktemp("report") / "smooth", film=True)


@pytest.fixture
def copy(run, tmp_path):
    return shutil.copytree(run, tmp_path / "copy")


class Outline(HTMLParser):
    """Counts tags, and keeps addresses and words."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.said, self.skip = {}, [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags[tag] = self.tags.get(tag, 0) + 1
        self.addresses += [value for name, value in attrs if name in ("src", "href", "poster", "xlink:href")]
        self.skip = tag == "style"

    def handle_endtag(self, tag):
        self.skip = False

    def handle_data(self, data):
        if not self.skip:
            self.said.append(data)

    @property
    def words(self):
        return " ".join(" ".join(self.said).split())


def outline(folder):
    return Outline(report(folder).read_text(encoding="utf-8"))


def test_the_page_needs_no_other_file_and_holds_film_figures_and_drawing(run):
    text = report(run).read_text(encoding="utf-8")
    found = Outline(text)
    assert all(address.startswith(("data:", "#")) for address in found.addresses)
    assert not re.search(r"url\(|@import|https?://", text)
    assert not list(run.glob("*.part"))
    assert found.tags["video"] == 1
    assert found.tags["svg"] == 1
    assert found.tags["img"] == 1 + len(list((run / "figures").glob("*.png")))  # and the film as a still for paper
    kinds = ("data:video/mp4", "data:image/jpeg")
    film, poster = (next(a for a in found.addresses if a.startswith(kind)) for kind in kinds)
    assert len(film) > (run / "void_ratio.mp4").stat().st_size
    assert len(poster) > 10_000


def test_key_numbers_are_those_of_the_summary(run):
    summary, words = json.loads((run / "summary.json").read_text()), outline(run).words
    largest = max(one["pressure_cell"] for one in summary["largest_wall_normal_stress_Pa"].values())
    assert largest_wall_stress(Result(run)).stress_Pa == pytest.approx(largest, rel=1e-9)
    peak = summary["peak"]
    for value in (
        largest, peak["max_normal_N_per_m"]["value"], peak["max_shear_N_per_m"]["value"],
        peak["min_bottom_N_per_m"]["value"], summary["filling"]["normal_N_per_m"],
        summary["residual"]["normal_N_per_m"], summary["janssen"]["normal_N_per_m_K0"],
    ):  # fmt: skip
        assert kN(value) in words
    assert f"× {number(summary['largest_overpressure']['factor'])}" in words
    assert "Mass flow" in words
    assert f"taichi-silo run {run.as_posix()}/run.toml" in words


def test_the_largest_pressure_is_that_of_the_whole_flow(run, copy):
    summary = json.loads((run / "summary.json").read_text())
    found, states = summary["largest_wall_normal_stress_in_flow"], summary["largest_wall_normal_stress_Pa"]
    largest = max(states[name]["pressure_cell"] for name in ("maximum", "residual"))
    assert found["normal_stress_Pa"] >= (1.0 - 1e-4) * largest
    assert 0.0 < found["height_m"] < 0.5
    assert 0.0 < found["displacement_m"] <= 0.01
    found |= {"normal_stress_Pa": 9876.0, "displacement_m": 0.003}
    changed_summary(copy, largest_wall_normal_stress_in_flow=found)
    first = key_numbers(Result(copy))[0]
    assert (first.name, first.value) == ("Largest wall pressure", "9.88")
    assert "in flow at u = 3 mm" in first.words


def test_every_parameter_stands_with_its_unit(run):
    found, tables = outline(run).words, Result(run).parameters
    rows = {f"{title}.{row.name}": row for title, rows in parameter_tables(tables) for row in rows}
    assert rows["Grid and points.cell_size_m"].value == "0.05"
    assert rows["Grid and points.cell_size_m"].unit == "m"
    assert rows["Sand.intergranular.m_R"].unit == rows["Sand.n"].unit == ""
    assert rows["Sand.grain_density_kg_per_m3"].unit == "kg/m³" and rows["Method.gravity_m_per_s2"].unit == "m/s²"
    assert not [name for name, row in rows.items() if not row.means]
    assert all(row.name in found for row in rows.values())

    def leaves(inner):
        return sum(leaves(value) if isinstance(value, dict) else 1 for value in inner.values())

    assert len(rows) == leaves(tables)


def test_each_part_and_each_check_is_explained(run):
    summary, words = json.loads((run / "summary.json").read_text()), outline(run).words
    assert all(part["because"] in words for part in summary["parts"])
    checks = verdict(Result(run)).checks
    assert len(checks) >= 10
    assert all(check.means in words and check.limit in words for check in checks)


def test_no_part_looks_as_if_somebody_had_overruled_it(run):
    """The flags that could decide otherwise were not given: a page of what was done does not name them."""
    parts = json.loads((run / "summary.json").read_text())["parts"]
    table = re.search(r'<section id="model">.*?</section>', report(run).read_text(encoding="utf-8"), re.DOTALL)[0]
    assert any(part["flag"] for part in parts) and "overruled" not in table
    assert not [part["flag"] for part in parts if part["flag"] and f"<code>{part['flag']}</code>" in table]


def test_theory_stands_beside_the_stresses_of_the_run(run):
    files = Result(run)
    table = stress_table(files)
    assert table.head[:3] == ("height (mm)", "after filling", "Janssen, K₀ of the law")
    middle = next(row for row in table.rows if row[0] == "250")
    law = theory.janssen(files, theory.pressure_ratios(files)["K0 of the law"]).normal_stress_Pa(0.25)
    code = theory.eurocode(files).discharge_normal_Pa(0.25)
    assert middle[2] == kN(float(law))
    assert middle[-1] == kN(float(code))
    assert float(middle[1]) == pytest.approx(float(law) / 1e3, rel=0.1)


def test_what_inserts_carry_counts_in_the_weight_and_is_unknown_to_janssen(copy):
    forces = pd.read_csv(copy / "forces.csv")
    forces["insert_1_vertical_N_per_m"] = 0.25 * forces["weight_N_per_m"]
    forces.to_csv(copy / "forces.csv", index=False)
    words = outline(copy).words
    assert "P, T of both walls and the upward forces of inserts carry its weight." in words
    assert "Janssen's theory knows no inserts; of the weight after filling the inserts carry 25 %." in words


def test_the_code_stands_on_a_sheet_of_its_own_and_says_whose_numbers_they_are(tmp_path):
    scene = Scene(walls=Walls(kind="smooth", friction_angle_deg=15.0), eurocode={"solid": "barley", "wall": "D1"})
    words = outline(written(tmp_path / "run", scene)).words
    assert "Barley (7 to 8 kN/m³, internal friction 28°); the simulated sand is another one: karlsruhe" in words
    assert (
        "Characteristic values" in words
        and words.count("discharge pressure (5.2.2.1)") == 1
        and "slender (5.1)" in words
    )
    inclined = Scene(silo={"outline_m": [(0.06, 0), (0.14, 0), (0.2, 0.5), (0, 0.5)]}, grid=Mesh(cell_size_m=0.01))
    assert "Characteristic values" not in outline(written(tmp_path / "inclined", inclined)).words


def test_a_hopper_has_walkers_theory_and_its_own_pressure(tmp_path):
    run = written(tmp_path / "run", Scene(silo=HOPPER, walls=Walls(kind="smooth", friction_angle_deg=15.0)))
    height = np.linspace(0.0, 0.13, 14)
    walls = [
        pd.DataFrame({"state": state, "wall": f"hopper_{side}", "height_m": height, "normal_stress_Pa": 3e3 * height,
                      "shear_stress_Pa": 0.0})
        for state in ("filling", "maximum", "residual") for side in ("left", "right")
    ]  # fmt: skip
    pd.concat(walls).to_csv(run / "walls.csv", index=False)
    ratios = {"janssen": {"wall_friction_angle_deg": 15.0, "pressure_ratio_K0": 0.4}}
    (run / "summary.json").write_text(json.dumps({"finished": True, **ratios}))
    found, run = outline(run), Result(run)
    assert "On the walls of the hopper" in found.words and "Largest pressure, hopper" in found.words
    assert found.tags.get("video") is None and "no film" in found.words
    assert 0.9 * 3e3 * 0.13 * 0.8 < largest_hopper_stress(run).stress_Pa <= 3e3 * 0.13
    middle = hopper_table(run).rows[2]
    above = theory.janssen(run, 0.4).vertical_stress_Pa(theory.straight_m(run))
    law = hopper_of(run.scene, 15.0, 0.4, float(above), "discharge")
    place = 0.5 * run.scene.silo.transition_m
    assert middle[1] == kN(3e3 * place)
    assert middle[5] == kN(float(law.normal_stress_Pa(law.outlet_height_m + place)))


def changed_summary(folder, **values):
    file = folder / "summary.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | values))


def changed_certificate(folder, **values):
    certificate = json.loads((folder / "summary.json").read_text())["certificate"]
    changed_summary(folder, certificate=certificate | values)
    return verdict(Result(folder))


CLEAN = {
    "inertial_number_99th_percentile": 1e-6, "noise_of_normal_force": 1e-4, "mean_void_ratio_drift": -1e-5,
    "largest_noise_control_force_over_weight": 1e-4, "core_strain_path": 1e-5, "settled_before_flow": True,
    "left_right_difference_over_weight": 1e-9, "unexplained_densification": 1e-5,
    "kinetic_energy_over_rigid_motion": [0.99, 1.01],
}  # fmt: skip


def test_the_verdict_follows_the_certificate(copy):
    assert changed_certificate(copy, **CLEAN).level == "good"
    care = changed_certificate(copy, noise_of_normal_force=0.011)
    assert care.level == "care"
    assert "noise of N" in care.words
    assert changed_certificate(copy, noise_of_normal_force=1e-4, mean_void_ratio_drift=-0.004).level == "care"
    wrong = changed_certificate(copy, force_balance_residual_over_weight=1e-6)
    assert wrong.level == "bad"
    assert "balance of forces" in wrong.words


def test_that_the_flow_has_jammed_is_said_once(copy):
    jam = "The flow has jammed: the gate has sunk by 20 mm; give it a wider outlet."
    changed_summary(copy, ledger={"outflow_ended": "jam"}, warnings=[jam])
    said = verdict(Result(copy))
    assert said.title == "The flow has jammed"
    assert said.words.startswith("The gate has sunk by 20 mm; give it a wider outlet. ")


def test_a_run_whose_sand_lags_behind_or_that_raised_an_alarm_is_not_called_clean(copy):
    """Each number may be within its limit all the same."""
    assert changed_certificate(copy, **CLEAN).level == "good"
    lags = "The sand lags behind: the gate has sunk by 20 mm, and 16% of the sand that it made room for has left."
    changed_summary(copy, warnings=[lags])
    said = verdict(Result(copy))
    assert (said.level, said.title) == ("care", "The sand lags behind")
    assert "16% of the sand" in said.words
    changed_summary(copy, warnings=[], alarms=[{"name": "inertia"}, {"name": "ratcheting"}])
    said = verdict(Result(copy))
    assert said.level == "care"
    assert said.words.endswith("; alarms in run.log: inertia, ratcheting.")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"failure": "at t = 0.3 s a point was lost"}, ["This run failed", "at t = 0.3 s a point was lost"]),
        ({"failure": "KeyboardInterrupt"}, ["This run was stopped", "It had reached u = 10 mm of 10 mm"]),
        ({"failure": "x", "warnings": ["<script>alert(1)</script>"]}, ["<script>alert(1)</script>"]),  # as text
    ],
)
def test_a_run_that_did_not_end_well_says_so_first(copy, change, words):
    changed_summary(copy, finished=False, **change)
    text = report(copy).read_text(encoding="utf-8")
    said = Outline(text).words
    assert all(one in said for one in ["The run did not come to its end", *words])
    assert said.index("This run") < said.index("Largest wall pressure")
    assert "<script" not in text


def test_a_run_that_still_goes_on_has_a_report(copy):
    for name in ("summary.json", "walls.csv", "void_ratio.mp4"):
        (copy / name).unlink()
    shutil.rmtree(copy / "figures")
    forces = pd.read_csv(copy / "forces.csv")
    forces[forces.stage == "filling"].head(30).to_csv(copy / "forces.csv", index=False)
    words = outline(copy).words
    assert all(one in words for one in ("This run has not ended", "still being filled", "No certificate"))
    assert (copy / "figures" / "forces.png").exists()  # drawn from what is there


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("summary.json", b"{ no"), ("forces.csv", b"\xff\xfe\x00\x01"), ("walls.csv", b"state,wall\nfilling,left\n"),
        ("snapshots/index.csv", b"nothing\n1\n"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_named_and_left_out(copy, name, content):
    (copy / name).write_bytes(content)
    assert f"{name.rpartition('/')[2]} is damaged and was left out." in outline(copy).words


def test_forces_whose_rows_are_lost_are_named(copy):
    forces = pd.read_csv(copy / "forces.csv")
    changed_summary(copy, records=len(forces))
    assert "rows are lost" not in outline(copy).words
    forces.head(30).to_csv(copy / "forces.csv", index=False)
    assert f"forces.csv has 30 of the {len(forces)} records of the run" in outline(copy).words


@pytest.mark.parametrize(("name", "films", "images"), [("void_ratio.mp4", 0, 4), ("figures/forces.png", 1, 4)])
def test_a_film_or_a_figure_that_was_cut_off_is_left_out(copy, name, films, images):
    file = copy / name
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 3])
    found = outline(copy)
    assert (found.tags.get("video", 0), found.tags["img"]) == (films, images)


def test_words_in_place_of_numbers_read_as_none(copy):
    forces = pd.read_csv(copy / "forces.csv").astype(object)
    forces.iloc[-1, 3] = "garbage"
    forces.to_csv(copy / "forces.csv", index=False)
    assert np.isnan(Result(copy).forces.P.iloc[-1])
    assert "video" in outline(copy).tags


def refused(folder, *words, output=None):
    with pytest.raises(BadInput) as caught:
        report(folder, output)
    assert all(word in str(caught.value) for word in words), caught.value


def test_what_is_no_run_of_a_silo_is_refused(tmp_path, copy):
    refused(tmp_path / "nowhere", "nowhere", "no such folder")
    refused(tmp_path, "run.toml")
    (copy / "run.toml").write_text("[silo")
    refused(copy, "run.toml cannot be read as a run")
    (copy / "run.toml").write_text('test = "oedometer"')
    refused(copy, "names no silo")
    (copy / "run.toml").write_text("[silo]\nwidth_m = -1.0")
    refused(copy, "run.toml", "width_m")


def test_an_output_that_cannot_be_written_is_refused_and_leaves_nothing(copy, tmp_path):
    refused(copy, "a folder", output=tmp_path)
    (tmp_path / "file").write_text("")
    refused(copy, "cannot be written", output=tmp_path / "file" / "report.html")
    assert report(copy, tmp_path / "new" / "page.html") == tmp_path / "new" / "page.html"
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["page.html"]


def written(folder, scene):
    folder.mkdir(parents=True)
    write_parameters(folder, scene, {})
    return Result(folder)


@pytest.mark.parametrize(
    ("silo", "words"),
    [
        (Silo(), ["200 mm", "500 mm", "bottom: 20 mm at 2 mm/s"]),
        (Silo(outlet=Outlet(width_m=0.08, position="right")), ["80 mm", "gate: 20 mm at 2 mm/s"]),
        (HOPPER, ["20° from", "137.4 mm", "100 mm"]),
        (Silo(section="round", outlet=Outlet(width_m=0.1)), ["⌀ 200 mm", "100 mm"]),
        (Silo(width_m=12.0, height_m=30.0), ["12 m", "30 m"]),
        (
            Silo(outlet=Outlet(width_m=0.08), inserts=(Insert(kind="cylinder", width_m=0.06, bottom_m=0.15),)),
            ["60 mm", "150 mm"],
        ),
        (
            Silo.polygon(
                [(0.06, 0.0), (0.14, 0.0), (0.2, 0.2), (0.2, 0.5), (0.0, 0.5), (0.0, 0.1)],
                inserts=(Insert.polygon([(0.075, 0.24), (0.125, 0.24), (0.1, 0.29)]),),
            ),
            ["80 mm", "200 mm", "50 mm", "240 mm"],
        ),
    ],
)
def test_a_drawing_has_the_silos_dimensions(tmp_path, silo, words):
    run = written(tmp_path / "run", Scene(silo=silo, grid=Mesh(cell_size_m=silo.width_m / 40)))
    text = drawing(run)
    assert all(f">{word}</text>" in text for word in words), text
    wide, high = map(float, re.search(r'viewBox="0 0 (\d+) (\d+)"', text).groups())
    for kind, values in re.findall(r'\b(x\d?|y\d?)="([-\d.]+)"', text):
        assert 0.0 <= float(values) <= (wide if kind.startswith("x") else high)
    for points in re.findall(r'points="([^"]+)"', text):
        for x, y in (point.split(",") for point in points.split()):
            assert 0.0 <= float(x) <= wide
            assert 0.0 <= float(y) <= high
    assert text.count('class="solid"') == len(silo.solids())


def test_free_outflow_has_a_rate_and_no_quasi_static_limits(tmp_path):
    silo = Silo(outlet=Outlet(width_m=0.1))
    run = written(tmp_path / "run", Scene(silo=silo, grid=Mesh(cell_size_m=0.01), flow=Flow(outflow="gravity")))
    time = np.linspace(0.0, 2.0, 201)
    gone = np.minimum(100.0 * np.maximum(time - 0.2, 0.0), 160.0)  # of 165.6 kg/m
    forces = pd.DataFrame(dict.fromkeys(Result(tmp_path / "run").forces.columns, 0.0), index=range(201))
    forces = forces.assign(stage="flow", time_s=time, weight_N_per_m=9.81 * (165.625 - gone), discharged_kg_per_m=gone)
    forces.to_csv(tmp_path / "run" / "forces.csv", index=False)
    summary = {"finished": True, "certificate": {"inertial_number_99th_percentile": 0.4}}
    (tmp_path / "run" / "summary.json").write_text(json.dumps(summary))
    run = Result(tmp_path / "run")
    assert discharge_rate_kg_per_s_m(run) == pytest.approx(100.0, rel=1e-6)
    assert [check.passed for check in verdict(run).checks] == [None]
    assert "opened, sand falls out" in page(run)


def test_known_limits_are_those_of_the_kind_of_run(tmp_path):
    rough = written(tmp_path / "rough", Scene(grid=Mesh(cell_size_m=0.01)))
    assert any("is not resolved by the grid" in words for words in known_limits.of_results(rough.scene))
    local = Scene(grid=Mesh(cell_size_m=0.01), averaging=Averaging(characteristic_length_m=0.0015))
    assert any("not converged" in words for words in known_limits.of_results(local))
    scene = Scene(silo=Silo(outlet=Outlet(width_m=0.06)), grid=Mesh(cell_size_m=0.01), flow=Flow(speed_m_per_s=0.02))
    narrow = written(tmp_path / "narrow", scene)
    (words,) = known_limits.of_method(narrow.scene)
    assert "6 cells wide: less sand follows the gate" in words and "a cell size of 6 mm." in words
    assert any("driven at 20 mm/s" in words for words in known_limits.of_results(narrow.scene))
    falling = scene.model_copy(update={"flow": Flow(outflow="gravity")})
    (words,) = known_limits.of_method(falling)
    assert "6 cells wide: sand falls out at 61%" in words and "a cell size of 3.75 mm, or four points" in words
    more = falling.model_copy(update={"grid": Mesh(cell_size_m=0.01, points_per_cell=4)})
    (words,) = known_limits.of_method(more)
    assert "6 cells wide: sand falls out at 95%" in words and "a cell size of 6 mm." in words
    wide = Scene(silo=Silo(outlet=Outlet(width_m=0.1)), grid=Mesh(cell_size_m=0.01))
    assert not known_limits.of_method(wide)
    two = tuple(Outlet(width_m=0.1, position=x) for x in (0.06, 0.34))  # a twentieth of one of them is 5 mm
    for sunk, told in ((0.0045, 1), (0.0055, 0)):
        silo, flow = Silo(width_m=0.4, outlet=two), Flow(speed_m_per_s=0.01, displacement_m=sunk)
        pair = Scene(silo=silo, grid=Mesh(cell_size_m=0.01), flow=flow)
        assert sum("no flow pattern" in words for words in known_limits.of_method(pair)) == told
    smooth = written(tmp_path / "smooth", Scene(walls={"kind": "smooth", "friction_angle_deg": 19.0}))
    (words,) = [one for one in known_limits.of_results(smooth.scene) if "fidelity" not in one]
    assert "no length of its own on this grid" in words
    dense = Scene(silo=Silo(hopper=Hopper(half_angle_deg=15.0, outlet_width_m=0.1)), grid=Mesh(cell_size_m=0.01))
    advised = dense.model_copy(update={"averaging": Averaging(characteristic_length_m=0.01)})
    assert any("bands from wall to wall" in words and "(10 mm)" in words for words in known_limits.of_results(dense))
    assert not any("bands from wall to wall" in words for words in known_limits.of_results(advised))


def test_a_run_without_anything_has_no_key_numbers_but_a_page(tmp_path):
    run = written(tmp_path / "run", Scene(silo=Silo(outlet=Outlet(width_m=0.1)), grid=Mesh(cell_size_m=0.01)))
    assert key_numbers(run) == []
    assert all(force.filled is None for force in forces_of(run).values())
    assert "The run has left none yet." in page(run)


def test_numbers_are_read_as_people_read_them():
    words = [number(x) for x in (1234.5, 0.54, 0.0, None, float("nan"), -2.0)]
    assert words == ["1,230", "0.540", "0", "–", "–", "−2.00"]
    assert number(1.3e-9, 2) == "1.3·10⁻⁹"
    assert number(0.9999) == "1.00"
    assert [plain(x) for x in (20.0, 0.0015, 1e-9, 2.5e-7)] == ["20", "0.0015", "10⁻⁹", "2.5·10⁻⁷"]
    assert [per_cent(x, signed=True) for x in (0.123, -0.5, 1.5)] == ["+12 %", "−50 %", "+150 %"]
    assert [mm(x) for x in (0.2, 0.0005, 12.0)] == ["200 mm", "0.5 mm", "12 m"]


def test_the_command_says_where_the_page_is(run, tmp_path, monkeypatch, capsys):
    for words, code, out, err in (
        ([run, "--output", tmp_path / "page.html", "--json"], 0, f'"report": "{tmp_path / "page.html"}"', "page.html"),
        ([run, "--quiet"], 0, "", ""),
        ([tmp_path], 2, "", "holds no run.toml"),
    ):
        monkeypatch.setattr(sys, "argv", ["taichi-silo", "report", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            app.main()
        said = capsys.readouterr()
        assert ended.value.code == code and out in said.out and err in said.err


@pytest.mark.skipif(sys.platform != "linux", reason="names there are no bytes")
def test_a_folder_may_have_a_name_that_is_no_utf_8(run, tmp_path):
    folder = shutil.copytree(run, tmp_path / os.fsdecode(b"S\xfcd"))
    assert "S?d" in report(folder).read_text(encoding="utf-8")
