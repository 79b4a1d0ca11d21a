"""The chart: errors, front, dials, runs that are kept, and its table."""

import json
import math
import tomllib

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taichi_silo.errors import BadInput
from taichi_silo.scene.fidelity import fidelities
from taichi_silo.scene.scene import Scene
from taichi_silo.utils import process_pool
from taichi_silo.utils.console import Console
from validation.accuracy import __main__ as command
from validation.accuracy import limit, parameter_set, plan, table, varied_settings, workers
from validation.accuracy.curves import Curves
from validation.accuracy.errors import ERRORS, errors, pareto_front, relative_difference, scatter
from validation.accuracy.fidelities import choose, write
from validation.accuracy.figures import error_figure, speed_figure
from validation.accuracy.varied_settings import FULL, SHORT, Program, VariedSetting, known_to_the_scene, words

TINY = Program(
    base={"grid.cell_size_m": 0.05, "flow.speed_m_per_s": 0.02, "flow.displacement_m": 0.002},
    reference={"flow.speed_m_per_s": 0.01},
    varied={
        "very-rough": [
            VariedSetting(name="rounding", settings=[{"nudge": 1}]),
            VariedSetting(name="bottom speed", settings=[{"flow.speed_m_per_s": v} for v in (0.02, 0.04)]),
            VariedSetting(name="precision", settings=[{"precision": "f32"}]),
            VariedSetting(
                name="speed: as it is", settings=[{"flow.speed_m_per_s": v} for v in (0.02, 0.04)], purpose="speed"
            ),
        ]
    },
)


def made_up(factor: float = 1.0, cost: float = 1.0, zone: float = 0.02) -> dict:
    """What a run leaves, its forces `factor` times those of another."""
    u = np.linspace(0.1, 5.0, 50)
    forces = {"P": 300.0 + u, "T": 700.0 - u, "N": 800.0 + 10.0 * u}
    return {
        "format": parameter_set.FORMAT,
        "failure": None,
        "curves": {"displacement_m": list(u)} | {name: list(factor * force) for name, force in forces.items()},
        "profile": {"height_m": [0.1, 0.2], "normal_stress_Pa": [factor * 2e3, factor * 1e3]},
        "zone_thickness_m": factor * zone,
        "residual": {name: float(factor * force[-1]) for name, force in forces.items()},
        "certificate": {"inertial_number_99th_percentile": 1e-4},
        "cost": {
            "points": 40, "steps": 100, "time_step_s": 1e-4, "core_seconds": cost, "predicted_steps": 100,
            "predicted_core_seconds": cost,
        },
    }  # fmt: skip


def test_errors_are_relative_differences():
    assert set(errors(made_up(), made_up()).values()) == {0.0}
    assert all(math.isclose(error, 0.1, rel_tol=1e-12) for error in errors(made_up(1.1), made_up()).values())
    assert relative_difference(np.zeros(5), np.arange(5.0)) == 1.0
    with pytest.raises(ValueError, match="cannot be compared"):
        relative_difference([1.0, 2.0], [1.0])


def test_a_failed_run_and_walls_without_a_zone_have_no_error_at_all():
    assert all(math.isnan(error) for error in errors({"failure": "points lost"}, made_up()).values())
    found = errors(made_up(), made_up(zone=0.0))
    assert math.isnan(found["error_zone"]) and found["error_N"] == 0.0


def test_scatter_is_the_greatest_difference_of_any_two():
    runs = [made_up(1.0), made_up(1.01), made_up(0.99)]
    assert math.isclose(scatter(runs)["error_N"], 1.01 / 0.99 - 1.0, rel_tol=1e-12)
    assert math.isnan(scatter(runs[:1])["error_N"])


def test_means_over_the_displacement_lose_no_impulse():
    """However unevenly records lie, the parts together carry the impulse of the flow."""
    rng = np.random.default_rng(1)
    interval = rng.uniform(0.5, 1.5, 400) * 1e-3
    speed = rng.uniform(0.5, 1.5, 400)
    travel = np.cumsum(speed * interval)
    force = 700.0 + 50.0 * rng.standard_normal(400)
    flow = pd.DataFrame({"displacement_m": travel, "interval_s": interval})
    for name in ("bottom_force_N_per_m", "shear_N_per_m", "normal_N_per_m"):
        flow[name] = force
    curves = Curves.of(flow, travel[-1])
    edges = np.linspace(0.02, 1.0, 99) * travel[-1]
    seconds = np.diff(np.interp(edges, np.append(0.0, travel), np.append(0.0, np.cumsum(interval))))
    whole = np.interp(edges[[0, -1]], np.append(0.0, travel), np.append(0.0, np.cumsum(force * interval)))
    assert math.isclose((curves.N * seconds).sum(), whole[1] - whole[0], rel_tol=1e-12)


NUMBERS = st.floats(0.1, 100.0).map(lambda x: round(x, 1)) | st.just(math.nan)


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=30))
def test_a_point_is_on_the_front_if_and_only_if_no_other_beats_it(pairs):
    chosen = pareto_front([p[0] for p in pairs], [p[1] for p in pairs])

    def beaten(one, other) -> bool:
        return other[0] <= one[0] and other[1] <= one[1] and other != one and not any(map(math.isnan, other))

    for one, on in zip(pairs, chosen, strict=True):
        sound = not any(map(math.isnan, one))
        assert on == (sound and not any(beaten(one, other) for other in pairs))


def test_what_the_scene_does_not_know_is_left_out():
    unknown = VariedSetting(name="colour", settings=[{"flow.colour": 1.0}])
    shape = VariedSetting(name="shape", settings=[{"grid.shape": "cpdi"}])
    assert known_to_the_scene([unknown, shape]) == [shape]


@pytest.mark.parametrize("program", [SHORT, FULL], ids=["short", "full"])
def test_every_setting_of_the_chart_makes_a_scene(program):
    planned = plan.chart_rows(program)
    assert {entry.walls for entry in planned} == {"very-rough", "smooth"}
    assert len({(e.walls, e.varied, e.setting) for e in planned}) == len(planned), "a dial has a setting twice"
    assert len(plan.runs(planned)) < len(planned), "the base is shared by all dials"


def test_settings_are_named_in_the_units_of_the_field():
    assert words({"flow.speed_m_per_s": 0.0005, "grid.cell_size_m": 0.00125}) == "0.5 mm/s, 1.25 mm"
    assert words({"grid.shape": "cpdi", "method.cfl": 0.27}) == "cpdi, 0.27"


def test_unknown_walls_and_dials_are_refused():
    with pytest.raises(BadInput, match="walls is round"):
        plan.chart_rows(TINY, walls="round")
    with pytest.raises(BadInput, match="dial is weather; it must be all, or some of bottom speed"):
        plan.chart_rows(TINY, varied="weather")


def test_a_run_is_known_by_what_changes_its_result_and_not_by_the_machine():
    one = parameter_set.parameter_set(Scene(), {})
    assert parameter_set.parameter_set(Scene(machine={"threads": 1}), {}).key == one.key
    assert (
        len({one.key, *(parameter_set.parameter_set(Scene(), s).key for s in ({"nudge": 1}, {"precision": "f32"}))})
        == 3
    )


def test_only_what_is_missing_or_broken_is_run_again(tmp_path, monkeypatch):
    planned = plan.runs(plan.chart_rows(TINY))
    keys = list(planned)
    for key in keys[:-2]:
        (tmp_path / f"{key}.json").write_text(json.dumps(made_up()))
    (tmp_path / f"{keys[-2]}.json").write_text('{"format": 1, "cur')
    begun = []

    def one(task, *_):
        key = parameter_set.ParameterSet.model_validate_json(task.line).key
        begun.append(key)
        (tmp_path / f"{key}.json").write_text(json.dumps(made_up()))
        return ""

    monkeypatch.setattr(process_pool, "run_task", one)
    for expected in (set(keys[-2:]), set()):
        begun.clear()
        assert workers.run_missing(planned, dict.fromkeys(keys, ""), 1e-7, tmp_path, 1, Console(quiet=True)) == {}
        assert set(begun) == expected


def rows_of(program) -> tuple[pd.DataFrame, pd.DataFrame]:
    planned = plan.chart_rows(program)
    keys = list(plan.runs(planned))
    found = {key: made_up(1.0 + 0.01 * k, 100.0 - k) for k, key in enumerate(keys)}
    return table.chart(planned, found, plan.paths(planned)), table.floors(planned, found)


def test_the_table_has_every_dial_cost_errors_and_certificate():
    rows, floors = rows_of(TINY)
    settings = ["grid.cell_size_m", "flow.speed_m_per_s", "precision", "nudge", "walls.kind"]
    wanted = ["walls", "dial", "setting", *settings, "cost_core_seconds", *ERRORS, "on_front"]
    assert set(wanted) <= set(rows)
    assert set(table.CERTIFICATE) <= set(rows)
    assert rows.error_N[rows.dial == "reference"].tolist() == [0.0]
    assert rows.reference.unique().tolist() == ["10 mm/s"]
    assert floors.error_N.gt(0.0).all()


def test_the_reference_is_not_on_the_front_under_another_dial_s_name_either():
    same = VariedSetting(name="slower", settings=[TINY.reference])
    rows, _ = rows_of(TINY.model_copy(update={"varied": {"very-rough": [*TINY.varied["very-rough"], same]}}))
    reference = rows[rows.key == rows.key[0]]
    assert set(reference.dial) == {"reference", "slower"} and not reference.on_front.any()
    assert rows.on_front.any()


def test_a_run_that_is_not_there_yet_leaves_no_row_and_without_reference_there_is_no_error():
    planned = plan.chart_rows(TINY)
    base = next(entry for entry in planned if entry.varied == plan.ROUNDING)
    rows = table.chart(planned, {base.parameters.key: made_up()}, plan.paths(planned))
    assert set(rows.key) == {base.parameters.key}
    assert rows.error_N.isna().all() and not rows.on_front.any()


def test_a_force_that_settles_has_a_limit_and_one_that_grows_with_every_decade_has_none():
    speed = [0.02, 0.01, 0.005, 0.002, 0.001]
    settles = limit.limit(speed, [700.0, 850.0, 898.0, 899.0, 900.0])
    assert settles.reached and settles.fastest_same_m_per_s == 0.005
    grows = limit.limit(speed, [800.0 - 80.0 * math.log10(v) for v in speed])
    assert not grows.reached and grows.fastest_same_m_per_s == 0.001
    assert math.isclose(grows.change_per_decade, 80.0 / 1040.0, rel_tol=1e-9)
    assert limit.limit(speed, [800.0 - 80.0 * math.log10(v) for v in speed], scatter=0.2).reached
    assert limit.limit([0.01, 0.02], [1.0, math.nan]) is None


def test_named_settings_are_the_cheapest_within_their_error_and_read_back(tmp_path):
    rows, _ = rows_of(SHORT)
    rows = rows[rows.walls == "very-rough"].copy()
    rows["error_N"] = 0.9
    for key, error, cost in zip(rows.key[rows.dial == "cell size"], [0.14, 0.04, 0.019], [1, 10, 100], strict=True):
        rows.loc[rows.key == key, ["error_N", "cost_core_seconds"]] = error, float(cost)  # 20, 10, 5 mm
    chosen = choose(rows, floor=0.001)
    assert [one.settings["grid.cell_size_m"] for one in chosen.values()] == [0.02, 0.01, 0.005]
    write(chosen, tmp_path / "fidelity.toml")
    assert fidelities(tmp_path / "fidelity.toml") == chosen
    assert choose(rows, floor=0.05)["converged"] == chosen["standard"], "within the scatter all is the same"


@pytest.mark.long
def test_figures_are_drawn_for_every_dial_also_where_runs_failed(tmp_path):
    rows, floors = rows_of(SHORT)
    rough = rows[rows.walls == "very-rough"].copy()
    rough.loc[rough.dial == "shape", list(ERRORS)] = math.nan
    error_figure(rough, floors.iloc[0]).savefig(tmp_path / "error.png")
    speed_figure(rough[rough.purpose == "speed"], 0.01).savefig(tmp_path / "speed.png")
    smooth = rows[rows.walls == "smooth"]
    error_figure(smooth, pd.Series({"error_N": math.nan})).savefig(tmp_path / "smooth.png")
    assert len(list(tmp_path.glob("*.png"))) == 3


@pytest.mark.long
def test_a_coarse_chart_from_beginning_to_end_and_again_without_a_run(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "SHORT", TINY)
    command.chart(walls="very-rough", jobs=1, output=tmp_path)
    said = capsys.readouterr().out
    assert "0 runs are there, 5 to do" in said
    rows, floors = pd.read_csv(tmp_path / "chart.csv"), pd.read_csv(tmp_path / "scatter.csv")
    assert rows.failure.isna().all()
    fine = rows[rows.dial == "bottom speed"].set_index("setting")
    assert 0.0 < fine.error_N["20 mm/s"] < fine.error_N["40 mm/s"] < 1.0
    assert 0.0 <= floors.error_N[0] < fine.error_N["20 mm/s"], "rounding matters less than speed"
    assert rows.force_balance_residual_over_weight[rows.precision == "f64"].max() < 1e-9
    assert (abs(rows.predicted_steps / rows.steps - 1.0) < 0.1).all()
    assert set(tomllib.loads((tmp_path / "fidelity.toml").read_text())) == {"draft", "standard", "converged"}
    assert (tmp_path / "error_cost_very-rough.png").exists() and (tmp_path / "speed_very-rough.png").exists()
    files = {file: file.stat().st_mtime_ns for file in (tmp_path / "points").iterdir()}
    assert len(files) == 5
    command.chart(walls="very-rough", jobs=1, output=tmp_path)
    assert "5 runs are there, 0 to do" in capsys.readouterr().out
    assert {file: file.stat().st_mtime_ns for file in files} == files
    assert varied_settings.SHORT is SHORT
