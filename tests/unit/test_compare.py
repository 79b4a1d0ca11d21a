"""Runs side by side: measurements are read, and differences are what a hand computes."""

import json

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from taichi_silo.errors import BadInput
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.scene.scene import Walls
from taichi_silo.scene.silo import Silo
from taichi_silo.show import beside_walls
from taichi_silo.show.figures.forces import curve
from taichi_silo.studies.compare.measured import read
from taichi_silo.studies.compare.tables import PROFILE, deviations, differences, janssen
from taichi_silo.studies.compare.whole import compare, read_runs
from tests import made_up

PASCALS = 1000.0  # wall stress of a made-up run


def leave(folder, p=100.0, factor=1.0, walls="smooth"):
    """A run with known numbers: P = p (1 + u / 10 mm) N/m, N = 2 T = 2 p, wall stresses of `factor` kPa."""
    folder.mkdir(parents=True)
    angle = 19.0 if walls == "smooth" else None
    write_parameters(folder, made_up.scene(walls=Walls(kind=walls, friction_angle_deg=angle)), {})
    u = np.linspace(0.0, 0.01, 201)
    flow = {
        "stage": "flow", "time_s": 1.0 + 50.0 * u, "displacement_m": u, "bottom_force_N_per_m": p * (1.0 + 100.0 * u),
        **{f"{wall}_normal_N_per_m": 2.0 * p for wall in ("left", "right")}, "left_shear_N_per_m": 1.2 * p,
        "right_shear_N_per_m": 0.8 * p, "wall_friction_angle_deg": 26.57, "weight_N_per_m": 1600.0,
    }  # fmt: skip
    filling = pd.DataFrame(flow).assign(stage="filling", displacement_m=0.0, time_s=np.linspace(0.0, 1.0, 201))
    filling = filling.assign(bottom_force_N_per_m=p)
    pd.concat([filling, pd.DataFrame(flow)]).to_csv(folder / "forces.csv", index=False)
    rows = [
        pd.DataFrame({"state": state, "wall": wall, "height_m": np.arange(0.0, 0.501, 0.01),
                      "normal_stress_Pa": factor * PASCALS, "shear_stress_Pa": 0.5 * factor * PASCALS})
        for state in ("filling", "maximum", "residual") for wall in ("left", "right")
    ]  # fmt: skip
    pd.concat(rows).to_csv(folder / "walls.csv", index=False)
    forces = {"bottom_N_per_m": p, "shear_N_per_m": p, "normal_N_per_m": 2.0 * p, "wall_friction_angle_deg": 26.57}
    summary = {
        "finished": True, "weight_N_per_m": 1600.0, "filling": forces,
        "peak": {"max_normal_N_per_m": {"value": 3.0 * p, "displacement_m": 0.004}},
        "residual": {name: 4.0 * value for name, value in forces.items()},
        "largest_overpressure": {"factor": 2.0 * factor},
        "janssen": {"pressure_ratio_K0": 0.4, "normal_N_per_m_K0": 160.0, "wall_friction_angle_deg": 19.0},
    }  # fmt: skip
    (folder / "summary.json").write_text(json.dumps(summary))
    return folder


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two runs that differ by half in forces and by a fifth in wall stresses."""
    place = tmp_path_factory.mktemp("compare")
    return [leave(place / "smooth"), leave(place / "very-rough", p=150.0, factor=1.2, walls="very-rough")]


def table(tmp_path, text, name="measured.csv"):
    file = tmp_path / name
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return file


# the table of differences


def at(rows, run, quantity, state):
    found = rows[(rows.run == run) & (rows.quantity == quantity) & (rows.state == state)]
    assert len(found) == 1
    return found.iloc[0]


def test_differences_are_those_of_hand_computation(runs):
    rows = differences(read_runs(runs))
    rows["run"] = rows["run"].map({"smooth": "a", "very-rough": "b"})
    filled = at(rows, "b", "wall normal N", "filled")
    numbers = [filled.value, filled.first_value, filled.difference, filled.difference_percent]
    assert numbers == [300.0, 200.0, 100.0, 50.0]
    assert filled.unit == "N/m"
    assert at(rows, "b", "bottom force P", "residual").value == 600.0
    assert at(rows, "b", "wall normal N", "peak").value == 450.0
    assert at(rows, "a", "wall normal N", "peak").difference == 0.0
    assert at(rows, "b", "wall normal N, displacement", "peak").value == 0.004
    assert at(rows, "b", "largest wall normal stress", "filled").difference_percent == pytest.approx(20.0)
    assert at(rows, "b", "over-pressure", "").difference_percent == pytest.approx(20.0)
    rms = at(rows, "b", PROFILE, "residual")
    assert rms.value == pytest.approx(200.0)
    assert rms.difference_percent == pytest.approx(20.0)
    assert at(rows, "a", PROFILE, "residual").value == 0.0
    missing = at(rows, "b", "wall friction T", "peak")
    assert missing.value is None and missing.difference is None and missing.difference_percent is None
    assert at(rows, "b", "discharge rate", "").value is None


def test_janssen_stands_beside_the_filled_state(runs):
    rows = janssen(read_runs(runs[:1]))
    assert len(rows) == 1  # only N has a theory there
    row = rows.iloc[0]
    assert (row.force, row.theory, row.value, row.difference) == ("N", 160.0, 200.0, 40.0)
    assert row.difference_percent == pytest.approx(25.0)
    assert row.origin == "K0 of the law"


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"insert_1": 400.0, "insert_2": 80.0}, "knows no inserts; of the weight after filling the inserts "
         "carry 30 %."),
        ({"hopper_left": 320.0, "hopper_right": 320.0}, "knows no hopper; of the weight after filling the hopper "
         "carries 40 %."),
        ({"hopper_right": 320.0, "insert_1": 160.0}, "knows no hopper or inserts; of the weight after filling the "
         "hopper carries 20 % and the inserts carry 10 %."),
        ({}, ""),
    ],
)  # fmt: skip
def test_what_janssen_does_not_know_is_said_with_what_it_carries(tmp_path, columns, words):
    folder = leave(tmp_path / "run")
    forces = pd.read_csv(folder / "forces.csv")
    bodies = {f"{name}_{axis}_N_per_m": value for name, value in columns.items() for axis in ("horizontal", "vertical")}
    forces.assign(**bodies).to_csv(folder / "forces.csv", index=False)
    expected = [f"run: Janssen's theory {words}"] if words else []
    assert [" ".join(remark.split()) for remark in compare(folder, janssen=True).remarks] == expected
    others = " and ".join(name for name in ("hopper", "inserts") if name in words)
    told = f"P, T of both walls and the upward forces of {others} carry its" if others else "P + T of both walls carry"
    assert told in beside_walls.lead(Result(folder))


def test_runs_of_the_same_name_are_told_apart(tmp_path):
    for place in ("one", "two"):
        leave(tmp_path / place / "run")
    assert [run.label for run in read_runs([tmp_path / "one/run", tmp_path / "two/run"])] == ["one/run", "two/run"]
    with pytest.raises(BadInput, match="given twice"):
        read_runs([tmp_path / "one/run", tmp_path / "one/../one/run"])


# reading measurements


@pytest.mark.parametrize(
    "text",
    [
        "displacement_m,P_N_per_m,N_kN_per_m\n0.001,110,0.2\n0.002,120,0.3\n",
        "displacement_mm;P_kN_per_m;N_kN_per_m\r\n1;0,110;0,2\r\n2;0,120;0,3\r\n",
        "\ufeffdisplacement_mm;bottom_force_N_per_m;n_kn_per_m;;\n2;120;0.3;;\n\n1;110;0.2;;\n",
        '"displacement_mm","P_kN_per_m","N_N_per_m"\n1,0.110,200\n2,0.120,300\n',
    ],
    ids=["SI", "decimal commas", "spreadsheet, unordered", "quoted"],
)
def test_units_and_separators_are_recognised(tmp_path, text):
    found = read(table(tmp_path, text))
    assert (found.kind, found.place, found.quantities) == ("curves", "displacement_m", ["P", "N"])
    assert found.table.displacement_m.tolist() == pytest.approx([0.001, 0.002])
    assert found.table.P.tolist() == pytest.approx([110.0, 120.0])
    assert found.table.N.tolist() == pytest.approx([200.0, 300.0])


def test_tables_of_a_laboratory_are_read_as_they_come(tmp_path):
    file = tmp_path / "lab.csv"
    file.write_bytes("# Silo 7, Prüfung 3\ndisplacement_mm;N_kN_per_m;remarks\n1;0,68;früh\n5;0,71;\n".encode("cp1252"))
    found = read(file)
    assert found.table.displacement_m.tolist() == [0.001, 0.005]
    assert found.table.N.tolist() == pytest.approx([680.0, 710.0])
    file.write_text("displacement_mm\tP_kN_per_m\n1\t0,68\n")
    assert read(file).table.P.tolist() == pytest.approx([680.0])


def test_a_profile_has_states_and_walls(tmp_path):
    text = "height_mm;normal_stress_kPa;shear_stress_Pa;state;wall\n100;1,5;300;filled;left\n50;2;400;residual;right\n"
    found = read(table(tmp_path, text))
    assert found.kind == "profile"
    rows = found.table.to_dict("list")
    assert rows["height_m"] == pytest.approx([0.05, 0.1])
    assert rows["normal_stress_Pa"] == pytest.approx([2000.0, 1500.0])
    assert rows["state"] == ["residual", "filling"]
    assert rows["wall"] == ["right", "left"]
    plain = read(table(tmp_path, "height_m,normal_stress_Pa\n0.1,5\n", "plain.csv"))
    assert plain.table.iloc[0][["state", "wall"]].tolist() == ["", "both"]


def test_gaps_are_left_out_and_doubles_are_averaged(tmp_path):
    found = read(table(tmp_path, "time_s,P_N_per_m,T_N_per_m\n1,10,\n1,20,4\n2,,6\n"))
    assert found.place == "time_s"
    assert found.table.P.tolist()[0] == 15.0
    assert np.isnan(found.table.P.tolist()[1])
    assert found.table["T"].tolist() == [4.0, 6.0]


PSI = 6894.757
AS_THEY_COME = {
    "line ends of an old machine": ("height_mm,normal_stress_kPa\r50,0.8\r100,0.6\r", "utf-8", [800, 600]),
    "depth": ("depth_m,normal_stress_kPa\n0.4,0.6\n0.45,0.8\n", "utf-8", [800, 600]),
    "German": ("Höhe_mm;Normalspannung_kPa\r\n50;0,8\r\n100;0,6\r\n", "utf-8-sig", [800, 600]),
    "per cent signs": ("% 12.5.2011\nheight_mm,normal_stress_kPa\n50,0.8\n100,0.6\n", "utf-8", [800, 600]),
    "a minus of typesetters": ("height_mm,normal_stress_kPa\n50,−0.8\n100,0.6\n", "utf-8", [-800, 600]),
    "no values": ("height_mm,normal_stress_kPa\n50,0.8\n60,NaN\n70,\n80,n/a\n100,0.6\n", "utf-8", [800, 600]),
    "inches and psi": ("height_in,normal_stress_psi\n2,0.12\n4,0.09\n", "utf-8", [0.12 * PSI, 0.09 * PSI]),
    "quoted decimal commas": ('"height_mm","normal_stress_kPa"\n"50","0,80"\n"100","0,60"\n', "utf-8", [800, 600]),
    "powers of ten": ("height_mm;normal_stress_Pa\n50;8,0E+02\n100;6,0E+02\n", "utf-8", [800, 600]),
    "a row of units": ("height,normal_stress\nmm,kPa\n50,0.8\n100,0.6\n", "utf-8", [800, 600]),
    "brackets": ("height [mm];normal stress (kPa)\n50;0,8\n100;0,6\n", "utf-8", [800, 600]),
    "spaces that do not break": ("height\u00a0(mm);normal\u00a0stress\u202f(Pa)\n50;8\u00a000\n100;600\n", "utf-8",
                                 [800, 600]),
    "millibars": ("height_mm,normal_stress_mbar\n50,8\n100,6\n", "utf-8", [800, 600]),
    "UTF-16": ("height_mm\tnormal_stress_kPa\r\n50\t0,8\r\n100\t0,6\r\n", "utf-16", [800, 600]),
}  # fmt: skip


@pytest.mark.parametrize("kind", AS_THEY_COME)
def test_wall_stresses_are_read_as_users_bring_them(tmp_path, kind):
    text, encoding, stresses = AS_THEY_COME[kind]
    found = read(table(tmp_path, text.encode(encoding))).above_bottom(0.5).table.dropna(subset=["normal_stress_Pa"])
    assert found.normal_stress_Pa.tolist() == pytest.approx(stresses)
    assert found.height_m.tolist() == pytest.approx([0.0508, 0.1016] if "inches" in kind else [0.05, 0.1])


def test_depths_are_heights_below_the_surface_of_the_silo(runs, tmp_path):
    file = table(tmp_path, "depth_m,normal_stress_kPa\n0.4,1.5\n0.3,1.5\n", "cells.csv")
    found = compare(runs[:1], tmp_path / "out", janssen=False, csv=[file]).deviations
    assert found.points.tolist() == [2, 2, 2]
    assert found.begin.tolist() == pytest.approx([0.1] * 3)
    assert found.rms.tolist() == pytest.approx([500.0] * 3)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("displacement_mm,P_kN\n1,2\n", ["unknown column P_kN", "did you mean P_kN_per_m"]),
        ("displacement_mm,force\n1,2\n", ["force", "bottom_force", "_kN_per_m", "shear_stress_kPa"]),
        ("displacement_mm;N_kN_m\n1;2\n", ["unknown column N_kN_m; did you mean N_kN_per_m?"]),
        ("displacement;N_kN_per_m\n1;2\n", ["unknown column displacement; did you mean displacement_m"]),
        ("displacement_mm;temperature\n1;2\n", ["unknown column temperature; it must have displacement_m"]),
        ("remark;note\n1;2\n", ["it must have displacement_m"]),
        ("P_kN_per_m,N_kN_per_m\n1,2\n", ["P_kN_per_m, N_kN_per_m", "displacement_m"]),
        ("displacement_mm\n1\n", ["displacement_mm", "left_normal"]),
        ("displacement_mm,time_s,P_N_per_m\n1,2,3\n", ["displacement_mm, time_s", "displacement_m or _mm, or time_s"]),
        ("displacement_mm,P_kN_per_m,bottom_force_N_per_m\n1,2,3\n", ["twice"]),
        ("displacement_mm,normal_stress_Pa\n1,2\n", ["curves", "profile"]),
        ("height_m,normal_stress_Pa,state\n1,2,emptied\n", ["line 2", "emptied", "filling", "residual"]),
        ("height_m,normal_stress_Pa,wall\n1,2,front\n", ["front", "left, right, both"]),
        ("displacement_mm,P_kN_per_m\n1,2\n3,x\n", ["line 3", "P_kN_per_m is x", "number"]),
        ("displacement_mm,P_kN_per_m\n1,inf\n", ["line 2", "inf", "number"]),
        ('displacement_mm,P_kN_per_m\n1,"1,234"\n', ["line 2", "1,234", "without a comma"]),
        ("displacement_mm,P_kN_per_m\n0,5,1,2\n", ["line 2", "4 values", "2", "semicolons"]),
        ("displacement_mm;P_kN_per_m\n1\n", ["line 2", "1 value;", "2"]),
        ("displacement_mm,P_kN_per_m\n,2\n", ["empty displacement_m"]),
        ("displacement_mm,P_kN_per_m\n", ["no rows"]),
        ("displacement_mm,,P_kN_per_m\n1,2,3\n", ["without a name"]),
        ('displacement_mm,P_kN_per_m\n1,"2\n3"\n', ["line breaks"]),
        ("\n\n", ["is empty"]),
        (b"\xff\xfe\x00d\x00i", ["cannot be read"]),
    ],
)
def test_a_file_that_is_not_right_is_refused_with_what_would_be_right(tmp_path, text, words):
    with pytest.raises(BadInput) as caught:
        read(table(tmp_path, text))
    assert all(word in str(caught.value) for word in ["measured.csv", *words]), caught.value
    assert not str(caught.value).endswith(".")


# deviations


def test_deviations_over_the_common_range_are_those_of_hand_computation(runs, tmp_path):
    text = "displacement_mm,P_N_per_m,left_shear_N_per_m\n2,110,120\n6,180,120\n10,190,120\n30,400,120\n"
    rows = deviations(read_runs(runs[:1]), [read(table(tmp_path, text))]).set_index("quantity")
    force = rows.loc["P"]  # the run has 120, 160, 200: deviations 10, -20, 10
    assert force.points == 3
    assert (force.begin, force.end) == pytest.approx((0.002, 0.010))
    assert force.rms == pytest.approx(np.sqrt(600.0 / 3.0), rel=5e-3)  # the median lags at the end
    assert force.largest == pytest.approx(-20.0, rel=1e-3)
    assert force.largest_at == pytest.approx(0.006)
    assert force.measured_peak == 400.0
    assert force.rms_percent == pytest.approx(100.0 * force.rms / 400.0)
    assert force.largest_percent == pytest.approx(-5.0, rel=1e-3)
    assert rows.loc["left_shear"].rms == pytest.approx(0.0, abs=1e-9)


def test_a_curve_in_time_counts_from_the_begin_of_the_outflow(runs, tmp_path):
    measured = read(table(tmp_path, "time_s,P_kN_per_m\n0,0.1\n0.25,0.15\n0.5,0.2\n"))
    rows = deviations(read_runs(runs[:1]), [measured])
    assert rows.points.tolist() == [3]
    assert rows.rms.iloc[0] == pytest.approx(0.0, abs=0.5)


def test_a_profile_without_a_state_is_set_beside_all_three(runs, tmp_path):
    run = read_runs([leave(tmp_path / "a", factor=2.0)])
    rows = deviations(run, [read(table(tmp_path, "height_m,normal_stress_kPa\n0.1,1.5\n0.2,1.5\n0.9,7\n"))])
    assert rows.state.tolist() == ["filling", "maximum", "residual"]
    assert rows.points.tolist() == [2, 2, 2]
    assert rows.rms.tolist() == pytest.approx([500.0] * 3)
    assert rows.rms_percent.tolist() == pytest.approx([100.0 * 500.0 / 7000.0] * 3)


def test_nothing_in_common_is_said_and_no_error(runs, tmp_path):
    rows = deviations(read_runs(runs[:1]), [read(table(tmp_path, "displacement_mm,P_N_per_m\n50,1\n60,2\n"))])
    assert rows.points.tolist() == [0]
    assert rows.rms.tolist() == [None]


def test_a_run_deviates_from_its_own_curve_by_nothing(runs, tmp_path):
    run = read_runs(runs[:1])[0]
    u, n = curve(run, "N")
    rows = [f"{1e3 * a:.9g},{1e-3 * b:.12g}" for a, b in zip(u[::7], n[::7], strict=True)]
    rows = deviations([run], [read(table(tmp_path, "displacement_mm,N_kN_per_m\n" + "\n".join(rows)))])
    assert rows.points.iloc[0] == len(u[::7])
    assert rows.largest_percent.iloc[0] == pytest.approx(0.0, abs=1e-3)


# the command


def test_the_command_leaves_tables_and_figures_and_all_numbers_in_one_object(runs, tmp_path, said):
    file = table(tmp_path, "displacement_mm,N_kN_per_m\n1,0.6\n5,0.7\n")
    profile = table(tmp_path, "height_m,normal_stress_kPa,wall\n0.1,2,left\n0.3,1,left\n", "cells.csv")
    output = tmp_path / "out"
    flags = ("--janssen", "--csv", file, "--csv", profile, "--json", "--output", output)
    code, out, shown = said("compare", *runs, *flags)
    assert code == 0
    titles = ("Differences, per cent against smooth", "wall normal N, filled", "Janssen's theory", "Deviation from")
    assert all(words in shown for words in titles)  # for a person, beside the numbers
    names = ["compare.csv", "compare_forces.png", "compare_walls.png", "deviation.csv", "janssen.csv"]
    assert sorted(file.name for file in output.iterdir()) == names
    for name in names[1:3]:
        image = np.asarray(Image.open(output / name).convert("RGB"))
        assert np.mean(np.any(image < 200, axis=2)) > 0.01
    found = json.loads(out)
    assert set(found) == {"runs", "differences", "janssen", "deviations", "remarks", "files"}
    assert found["remarks"] == []
    assert list(found["runs"]) == ["smooth", "very-rough"]
    rows = pd.read_csv(output / "compare.csv")
    assert len(rows) == len(found["differences"])
    for label, expected in (("smooth", 800.0), ("very-rough", 1200.0)):
        one = rows[(rows.run == label) & (rows.quantity == "wall normal N") & (rows.state == "residual")]
        assert one.value.tolist() == [expected]
    compare(runs, output, janssen=False, csv=[])  # an earlier comparison is replaced as a whole
    assert sorted(file.name for file in output.iterdir()) == names[:3]


def test_what_cannot_be_compare_is_refused_before_anything_is_written(runs, tmp_path, said):
    output = tmp_path / "out"
    curves = table(tmp_path, "displacement_mm,P_N_per_m\n1,2\n")
    times = table(tmp_path, "time_s,P_N_per_m\n1,2\n", "times.csv")
    for words, why in (
        ([runs[0]], "runs: there is 1"),
        ([runs[0], tmp_path], "holds no run.toml"),
        ([runs[0], runs[0]], "given twice"),
        ([*runs, "--paper"], "python -m validation.paper.against_runs"),
        ([*runs, "--csv", tmp_path / "no.csv"], "no.csv cannot be read"),
        ([*runs, "--csv", curves, "--csv", times], "over displacement and over time"),
    ):
        code, _, err = said("compare", *words, "--output", output)
        assert code == 2
        assert why in err
        assert err.count("\n") == 1
        assert not output.exists()


def test_a_pressure_that_pulls_is_compared_and_named(runs, tmp_path, said):
    """Whoever counts compression as negative reads that pressures are positive here; shear has either sign."""
    cells = table(
        tmp_path, "height_m,normal_stress_kPa,shear_stress_kPa\n0.1,-2,-1\n0.2,-1.5,-1\n0.3,1,1\n", "cells.csv"
    )
    curves = table(tmp_path, "displacement_mm,N_kN_per_m,T_kN_per_m\n1,-0.6,-1\n5,0.7,1\n")
    flags = ("--csv", cells, "--csv", curves, "--output", tmp_path / "out")
    code, out, _ = said("compare", *runs, *flags)
    assert code == 0
    assert "cells.csv: 2 of 3 values of the normal stress [Pa] are negative, the lowest -2000; pressures are" in out
    assert "measured.csv: 1 of 2 values of N [N/m] is negative, the lowest -600" in out
    assert out.count("is their sign right?") == 2
    found = json.loads(said("compare", *runs, *flags, "--json")[1])
    assert len(found["remarks"]) == 2


HOPPER = Silo.polygon([(0.04, 0), (0.16, 0), (0.2, 0.1), (0.2, 0.5), (0, 0.5), (0, 0.1)])
PURE = Silo.polygon([(0.06, 0), (0.14, 0), (0.2, 0.5), (0, 0.5)])


@pytest.mark.parametrize(
    ("silo", "words"),
    [
        (HOPPER, "2 of 3 rows are compared, as the rest, at 50 mm, is outside 100 mm to 500 mm above the bottom, where "
                 "its walls are vertical; stresses of inclined walls are in walls.csv"),
        (PURE, "0 of 3 rows are compared, as none of its walls is vertical; stresses of inclined walls are in walls."),
    ],
)  # fmt: skip
def test_what_of_the_measured_is_not_compared_is_said_with_the_reason(tmp_path, silo, words):
    """Depths, a column of remarks, a row without a value, and one beside the hopper."""
    run = leave(tmp_path / "run")
    write_parameters(run, made_up.scene(silo=silo, walls=Walls(kind="smooth", friction_angle_deg=19.0)), {})
    walls = pd.read_csv(run / "walls.csv")
    walls[walls.height_m >= 0.0999].to_csv(run / "walls.csv", index=False)
    text = "depth_mm,normal_stress_kPa,remark\n50,0.4,a\n100,0.6,b\n150,,c\n450,1.0,d\n"
    found = compare(run, csv=table(tmp_path, text, "cells.csv"))
    first, second = found.remarks
    assert first == (
        "cells.csv: column remark is passed over; 1 of 4 rows has no value of normal_stress_Pa; depths are taken below "
        "the top of the fill, 500 mm above the bottom."
    )
    assert second.startswith(f"cells.csv beside run: {words}")


def test_rows_beyond_the_flow_are_said(runs, tmp_path):
    found = compare(runs[0], csv=table(tmp_path, "displacement_mm,P_N_per_m\n5,100\n20,100\n"))
    assert found.remarks == [
        "measured.csv beside smooth: 1 of 2 rows is compared, as the rest, at 20 mm, is outside 0 mm to 10 mm of its "
        "flow."
    ]


def test_the_extreme_of_the_bottom_force_is_called_its_least(runs, tmp_path, said):
    summary = json.loads((runs[0] / "summary.json").read_text())
    peak = summary["peak"] | {"min_bottom_N_per_m": {"value": 50.0, "displacement_m": 0.001}}
    folders = [leave(tmp_path / name) for name in ("one", "two")]
    for folder in folders:
        (folder / "summary.json").write_text(json.dumps(summary | {"peak": peak}))
    out = said("compare", *folders, "--output", tmp_path / "out")[1]
    assert "bottom force P, least in flow" in out
    assert "bottom force P, peak" not in out
    assert "wall normal N, peak" in out
