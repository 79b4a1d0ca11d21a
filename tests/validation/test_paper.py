"""The paper's statements: the file, the measures on made-up runs, and the verdicts."""

import json

import numpy as np
import pandas as pd
import pytest

from taichi_silo.errors import BadInput
from taichi_silo.runs import snapshot
from taichi_silo.runs.run_folder import parameters, write_parameters
from validation.paper import check, measures, statements
from validation.paper.against_runs import against_paper, against_runs, of_case
from validation.paper.cases import CASES, OUTLETS
from validation.paper.measures import MEASURES, CaseRun, NotRun
from validation.paper.recognise import recognised
from validation.paper.scenes import scene_of

WIDTH, HEIGHT, SPACING, WEIGHT = 0.2, 0.5, 0.005, 1600.0
HEADER = """
[tolerances.read]
share = 0.25
why = "read from a figure"
[tolerances.none]
share = 0.0
why = "nothing"
"""


def write_run(
    folder, name, *, e=None, velocity=None, normal=None, shear=None, forces=None, finished=True, gravity=False
):  # fmt: skip
    """A run in a folder: fields of (x, y), stresses of (state, wall, height), forces of (stage, progress)."""
    case = CASES[name]
    run = folder / name
    (run / "snapshots").mkdir(parents=True)
    write_parameters(run, scene_of(case), {})
    normal = normal or (lambda state, wall, y: 2e3 * (1.0 - y / HEIGHT))
    shear = shear or (lambda state, wall, y: 0.3 * normal(state, wall, y))
    forces = forces or (lambda stage, s: {"P": 1000.0, "T": 300.0, "N": 600.0})
    rows, speed = [], 0.002
    for stage, count in (("filling", 40), ("flow", 400)):
        for k in range(count):
            s = (k + 1) / count if stage == "flow" else 0.0
            one = forces(stage, s)
            u = 0.0 if gravity else 0.02 * s
            rows.append({
                "time_s": len(rows) * 0.02 / speed / 400, "stage": stage, "displacement_m": u,
                "bottom_force_N_per_m": one["P"], "left_normal_N_per_m": one["N"], "left_shear_N_per_m": one["T"],
                "right_normal_N_per_m": one["N"], "right_shear_N_per_m": one["T"],
                "wall_friction_angle_deg": one.get("angle", np.degrees(np.arctan(one["T"] / one["N"]))),
                "weight_N_per_m": WEIGHT, "discharged_kg_per_m": 0.0, "kinetic_energy_J_per_m": 0.0,
            })  # fmt: skip
    pd.DataFrame(rows).to_csv(run / "forces.csv", index=False)
    y = np.arange(0.0, HEIGHT + 1e-9, SPACING)
    walls = []
    for state in ("filling", "maximum", "residual"):
        sunk = 0.02 if state == "residual" and case.opening.whole else 0.0
        for wall in ("left", "right"):
            stresses = {"normal_stress_Pa": normal(state, wall, y), "shear_stress_Pa": shear(state, wall, y)}
            walls.append(pd.DataFrame({"state": state, "wall": wall, "height_m": y - sunk} | stresses))
    pd.concat(walls).to_csv(run / "walls.csv", index=False)
    x, z = (place.ravel() for place in np.meshgrid(*(np.arange(0.5 * SPACING, a, SPACING) for a in (WIDTH, HEIGHT))))
    index = []
    for file, stage, u in (
        ("start", "filling", 0.0), ("filled", "filling", 0.0), ("flow_002", "flow", 0.002), ("flow_010", "flow", 0.01),
        ("flow_020", "flow", 0.02),
    ):  # fmt: skip
        field = np.full(len(x), case.void_ratio)
        if stage == "flow" and e is not None:
            field = field + np.broadcast_to(e(x, z, u), field.shape)
        still = np.zeros((len(x), 2))
        fall = speed if velocity is None else velocity(x, z)
        still[:, 1] = -fall if stage == "flow" else 0.0
        sunk = u if case.opening.whole else 0.0
        points = {
            "position": np.column_stack([x, z - sunk]), "velocity": still, "void_ratio": field,
            "volume": np.full(len(x), SPACING**2), "path": 1e-3 + np.abs(field - case.void_ratio),
            "stress": np.zeros((len(x), 4)), "mass": np.ones(len(x)), "identity": np.arange(len(x)),
        }  # fmt: skip
        snapshot.write(run / f"snapshots/{file}.vtu", points)
        index.append({"file": f"{file}.vtu", "stage": stage, "time_s": u / speed, "displacement_m": u})
    pd.DataFrame(index).to_csv(run / "snapshots/index.csv", index=False)
    summary = {"finished": finished, "certificate": {"inertial_number_99th_percentile": 1e-4}}
    (run / "summary.json").write_text(json.dumps(summary | ({} if finished else {"failure": "it stopped"})))
    return CaseRun(run)


def verdicts(folder, text):
    """Verdict of each statement of a file that is made up."""
    file = folder / "statements.toml"
    file.write_text(HEADER + text)
    return check.evaluate(folder, file).set_index("id")


def statement(name, kind="number", cases="dense_smooth_bottom", more="", section="6.1"):
    return (
        f'\n[[statement]]\nid = "{name}"\nsection = "{section}"\nkind = "{kind}"\ncases = ["{cases}"]\n'
        f'states = "words"\npaper = "a number"\n{more}\n'
    )


# cases and statements


def test_there_are_seventeen_cases():
    assert len(CASES) == 17
    assert CASES["loose_smooth_right-50"].wall_friction_angle_deg == 12.3
    assert CASES["dense_very-rough_bottom"].wall_friction_angle_deg is None
    assert CASES["gravity_dense_very-rough_centre-80"].gravity
    assert OUTLETS["centre-80"].symmetric and not OUTLETS["right-150"].symmetric
    assert all(abs(outlet.right_m - 0.2) < 1e-12 for name, outlet in OUTLETS.items() if name.startswith("right"))


def test_the_file_of_statements_is_valid():
    found, tolerances = statements.read()
    assert len({one.id for one in found}) == len(found) >= 40
    for one in found:
        assert one.id.startswith(one.section + "-")
        assert set(one.needs) <= set(CASES)
        assert one.kind in ("figure", "not checkable here") or one.tolerance != "none", one.id
        for test in one.tests:
            terms = [(test.measure, test.given), *((t.measure or test.measure, t.given) for t in test.terms)]
            for measure, given in terms:
                known = MEASURES[measure].__annotations__
                assert set(given) <= set(known), f"{one.id}: {measure} has no {set(given) - set(known)}"
    assert {case for one in found for case in one.needs} == set(CASES)
    assert all(tolerance.why for tolerance in tolerances.values())


FINISHED = 'tests = [{measure = "finished", low = 1}]'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (statement("a"), "a number with 0 tests"),
        (statement("a", more='tests = [{measure = "finished"}]'), "neither low nor high"),
        (
            statement("a", more='tests = [{measure = "finished", low = 1, over = {swap = ["smooth", "icy"]}}]'),
            "no case",
        ),
        (statement("a", more=FINISHED + '\ntolerance = "unknown"'), "the tolerance unknown"),
        (statement("a", cases="dense_icy_*", more=FINISHED), "no case"),
        (2 * statement("a", more=FINISHED), "twice"),
    ],
    ids=range(6),
)
def test_bad_statements_are_refused(tmp_path, text, words):
    with pytest.raises(ValueError, match=words):
        verdicts(tmp_path, text)


# measures


def test_forces(tmp_path):
    def curve(stage, s):
        turn = 500.0 if stage == "flow" and 0.2 < s < 0.5 else 800.0
        return {"P": 1000.0 if stage == "filling" else turn, "T": 300.0, "N": 600.0}

    run = write_run(tmp_path, "dense_smooth_bottom", forces=curve)
    assert measures.force(run, "P", "filling") == pytest.approx(1000.0)
    assert measures.force(run, "P", "least") == pytest.approx(500.0)
    assert measures.force(run, "P") == pytest.approx(800.0)
    assert measures.force_change(run, "P", "filling", "least") == pytest.approx(-500.0 / WEIGHT)
    assert measures.force_drift(run, "P") == pytest.approx(0.0)
    assert run.outlet_speed == pytest.approx(0.002, rel=0.01)


def test_wall_stresses_leave_out_the_corner_and_sink_with_the_bottom(tmp_path):
    def normal(state, wall, y):
        return 2e3 * (1.0 - y / HEIGHT) + 9e3 * (y < 0.011)

    run = write_run(tmp_path, "dense_smooth_bottom", normal=normal)
    assert measures.largest_stress_kPa(run) == pytest.approx(2.0 * (1 - 0.015 / HEIGHT))
    assert measures.largest_stress_kPa(run, reading="cell") < measures.largest_stress_kPa(run)
    assert measures.largest_stress_kPa(run, part="upper") == pytest.approx(1.0)
    assert measures.stress_ratio(run) == pytest.approx(1.0)
    assert measures.profile_change(run, state="residual") == pytest.approx(0.0, abs=1e-6)
    assert measures.linearity(run) == pytest.approx(1.0)


def test_transition_and_oscillation(tmp_path):
    def normal(state, wall, y):
        base = 2e3 * (1.0 - 0.5 * y / HEIGHT)
        if state == "filling" or wall == "left":
            return base
        return base * np.where(y < 0.2, 0.6, 1.3) * (1.0 + 0.2 * (-1.0) ** np.arange(len(y)))

    run = write_run(tmp_path, "dense_smooth_right-50", normal=normal)
    assert measures.transition_mm(run, wall="right") == pytest.approx(200.0, abs=10.0)
    assert np.isnan(measures.transition_mm(run, wall="left"))
    assert np.isnan(measures.stress_ratio(run, wall="left", part="above"))
    assert measures.stress_ratio(run, wall="right", part="above") == pytest.approx(1.3, abs=0.03)
    assert measures.stress_ratio(run, wall="right", part="below") == pytest.approx(0.6, abs=0.06)
    assert measures.stress_ratio(run, wall="right", part="lower") < 1.0
    assert measures.stress_ratio(run, wall="right", part="upper") > 1.2
    assert measures.profile_change(run, wall="left") == pytest.approx(0.0, abs=1e-6)
    assert measures.oscillation(run) > 0.15
    assert measures.oscillation(run, wall="left") < 0.01


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_wall_zones(tmp_path, sign):
    name = "dense_very-rough_bottom"
    run = write_run(tmp_path, name, e=lambda x, y, u: sign * 0.2 * (np.minimum(x, WIDTH - x) < 0.015))
    assert MEASURES["wall_zone_mm"](run, wall="right") == pytest.approx(15.0, abs=2.5)
    assert sign * MEASURES["wall_change"](run) == pytest.approx(0.2)
    assert sign * MEASURES["mean_change"](run) == pytest.approx(0.03)
    assert MEASURES["interior_zones"](run) == 0.0
    assert MEASURES["core_scatter"](run) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("thick", [0.015, 0.02])
def test_thickness_and_number_of_interior_zones(tmp_path, thick):
    def bands(x, y, u):
        across = ((y - 0.1 - 0.5 * x) % 0.2) / np.hypot(1.0, 0.5)
        return 0.2 * (across < thick)

    run = write_run(tmp_path, "dense_very-rough_bottom", e=bands)
    assert MEASURES["interior_zones"](run) >= 1.0
    assert MEASURES["interior_zone_mm"](run) == pytest.approx(1e3 * thick, rel=0.25)
    assert MEASURES["sheared_change"](run) > 0.1


def test_no_interior_zone_has_no_thickness(tmp_path):
    assert np.isnan(MEASURES["interior_zone_mm"](write_run(tmp_path, "dense_smooth_bottom")))


def test_outlets_loosen_and_leave_dead_sand(tmp_path):
    inside = OUTLETS["right-50"].left_m
    run = write_run(
        tmp_path,
        "dense_smooth_right-50",
        e=lambda x, y, u: 0.1 * ((x > inside) & (y < 0.2)),
        velocity=lambda x, y: np.where((x > inside) | (y > 0.4), 0.002, 0.0),
    )
    assert MEASURES["outlet_change"](run) == pytest.approx(0.1)
    assert MEASURES["dead_share"](run, wall="left") == pytest.approx(0.8, abs=0.05)
    assert MEASURES["dead_share"](run, wall="right") == 0.0
    assert MEASURES["dead_share"](run, wall="left", above_mm=400.0) == 0.0
    assert MEASURES["sheared_height_mm"](run) == pytest.approx(180.0, abs=15.0)


# verdicts


def test_numbers_of_both_readings_agree_disagree_or_partly(tmp_path):
    write_run(tmp_path, "dense_smooth_bottom")  # largest: 1.94 kPa at a node, 1.9 in a cell
    tests = 'tests = [{{measure = "largest_stress_kPa", low = {0}, high = {0}, says = "kPa"}}]\n'
    read = tests + 'tolerance = "read"'
    text = "".join(statement(name, more=read.format(value)) for name, value in (("a", 1.9), ("b", 4.0), ("c", 1.535)))
    table = verdicts(tmp_path, text)
    assert list(table.agrees) == ["yes", "no", "partly"]
    assert table.ours["a"] == "1.94 (cell 1.9) kPa"
    assert "wanted 3 to 5" in table.why["b"] and not table.why["a"]


def test_relations_between_cases(tmp_path):
    write_run(tmp_path, "dense_smooth_bottom", forces=lambda stage, s: {"P": 1.0, "T": 100.0, "N": 500.0})
    write_run(tmp_path, "dense_very-rough_bottom", forces=lambda stage, s: {"P": 1.0, "T": 400.0, "N": 500.0})
    more = 'tests = [{{measure = "force", given = {{name = "T"}}, {}, says = "rough / smooth"}}]'
    pair = 'over = {swap = ["very-rough", "smooth"]}, low = '
    less = 'minus = {case = "dense_smooth_bottom"}, high = '
    text = "".join(
        statement(name, "relation", "dense_very-rough_bottom", more.format(end))
        for name, end in (("a", pair + "1.0"), ("b", pair + "5.0"), ("c", less + "300.0"), ("d", less + "200.0"))
    )
    table = verdicts(tmp_path, text)
    assert list(table.agrees) == ["yes", "no", "yes", "no"]
    assert table.ours["a"] == "rough / smooth: 4"


def test_a_hand_written_reason_and_eye_count(tmp_path):
    write_run(tmp_path, "dense_smooth_bottom")
    text = statement("a", more='reason = "known"\ntests = [{measure = "force", given = {name = "N"}, low = 1e6}]')
    text += statement("b", "figure", more='figure = "figures/void_ratio.png"')
    text += statement("c", "figure", more='figure = "figures/void_ratio.png"\nseen = "partly"\nreason = "few"')
    text += statement("d", "not checkable here", more='reason = "no data"')
    table = verdicts(tmp_path, text)
    assert list(table.agrees) == ["no", "by eye", "partly", "not checkable"]
    assert list(table.why) == ["known", "look at figures/void_ratio.png of dense_smooth_bottom", "few", "no data"]


def test_missing_and_damaged_runs_say_so(tmp_path):
    write_run(tmp_path, "dense_smooth_bottom", finished=False)
    write_run(tmp_path, "loose_smooth_bottom")
    (tmp_path / "loose_smooth_bottom/forces.csv").write_text("nothing,good\n1,2\n")
    write_run(tmp_path, "loose_very-rough_bottom")
    (tmp_path / "loose_very-rough_bottom/snapshots/flow_020.vtu").write_text("<broken")
    write_run(tmp_path, "dense_smooth_right-50")
    (tmp_path / "dense_smooth_right-50/summary.json").unlink()
    test = 'tests = [{measure = "force", given = {name = "N"}, low = 1.0}, {measure = "mean_change", low = -1.0}]'
    cases = ("dense_smooth_bottom", "loose_smooth_bottom", "loose_very-rough_bottom", "dense_smooth_right-50",
             "dense_smooth_right-150")  # fmt: skip
    table = verdicts(tmp_path, "".join(statement(name, cases=name, more=test) for name in cases))
    assert set(table.agrees) == {"not run"}
    said = ("it stopped", "forces.csv", "flow_020.vtu", "not ended", "not been run")
    for name, words in zip(cases, said, strict=True):
        assert words in table.why[name]
    text = statement("a", "relation", more='tests = [{measure = "finished", low = 1}]')
    assert verdicts(tmp_path, text).agrees["a"] == "no"
    with pytest.raises(NotRun, match="not been run"):
        CaseRun(tmp_path / "dense_smooth_right-150").check()
    with pytest.raises(NotRun, match="it stopped"):
        CaseRun(tmp_path / "dense_smooth_bottom").check()


def test_without_any_run_all_is_said_and_written(tmp_path):
    table = check.evaluate(tmp_path / "nothing")
    assert set(table.agrees) == {"not run", "not checkable"}
    files = check.write(table, tmp_path / "out")
    assert [file.name for file in files] == ["table.csv", "table.md"]
    assert len(pd.read_csv(files[0])) == len(table)
    lines = [line for line in files[1].read_text().splitlines() if line.startswith("| ")]
    assert all(line.replace("\\|", "").count("|") == 7 for line in lines)
    assert sum(check.count(table).values()) == len(table)
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput):
        check.write(table, tmp_path / "file")


@pytest.mark.long
def test_the_real_statements_on_all_cases(tmp_path):
    """Every test of the file runs on a folder that has what it needs."""
    for name, case in CASES.items():
        write_run(tmp_path, name, e=lambda x, y, u: 0.1 * ((x > 0.15) & (y < 0.2)), gravity=case.gravity)
    table = check.evaluate(tmp_path)
    assert not (table.agrees == "not run").any(), table[table.agrees == "not run"].why.to_list()
    assert {"yes", "no", "partly", "by eye", "not checkable"} == set(table.agrees)


# any run against the paper


def test_each_of_the_papers_cases_is_recognised_from_its_parameters():
    for name, case in CASES.items():
        found = recognised(parameters(scene_of(case)))
        assert found.case is case, name
        assert found.differences == ()


def test_what_was_computed_otherwise_is_named():
    found = recognised(parameters(scene_of(CASES["dense_smooth_bottom"], cell_size_m=0.01, speed_m_per_s=0.005)))
    assert found.case is CASES["dense_smooth_bottom"]
    assert set(found.differences) == {("grid.cell_size_m", 0.01, 0.005), ("flow.speed_m_per_s", 0.005, 0.002)}


@pytest.mark.parametrize(
    ("path", "value"),
    [("silo.width_m", 0.25), ("sand.void_ratio", 0.65), ("sand.e_c0", 0.83), ("walls.friction_angle_deg", 20.0)],
)
def test_another_silo_is_none_of_the_papers(path, value):
    tables = parameters(scene_of(CASES["dense_smooth_bottom"]))
    name, key = path.split(".")
    tables[name] = tables[name] | {key: value}
    found = recognised(tables)
    assert found.case is None
    assert [one[0] for one in found.differences] == [path]


@pytest.mark.long
def test_relations_need_the_other_run_too(tmp_path, capsys):
    names = ("dense_smooth_bottom", "dense_very-rough_bottom")
    runs = [write_run(tmp_path, name).result for name in names]
    alone = against_paper(runs[1:])[0]
    both = against_paper(runs)[1]
    assert alone.known.case is CASES[names[1]]
    assert alone.others > both.others > 0
    assert "6.1-start-rougher" in set(both.rows.id) - set(alone.rows.id)
    assert set(both.rows.agrees) <= {"yes", "partly", "no", "by eye"}
    assert set(both.rows.case) == {names[1]}
    assert len(both.rows) + both.others == len(alone.rows) + alone.others
    against_runs([tmp_path / name for name in names], tmp_path / "out")
    said = capsys.readouterr().out
    assert "the paper's dense sand, very rough walls, whole bottom" in said
    assert f"{both.others} more compare it with other cases" in said
    assert len(pd.read_csv(tmp_path / "out" / "paper.csv")) == sum(len(one.rows) for one in against_paper(runs))


def test_a_statement_is_judged_for_one_case_alone_without_the_reasons_of_other_runs():
    one = next(one for one in statements.read()[0] if one.id == "6.1-start-rougher")
    assert of_case(one, "dense_very-rough_bottom", {"dense_very-rough_bottom"}) is None
    own = of_case(one, "dense_very-rough_bottom", {"dense_very-rough_bottom", "dense_smooth_bottom"})
    assert own.needs == ["dense_very-rough_bottom", "dense_smooth_bottom"]
    assert own.reason == "" and own.seen == ""
