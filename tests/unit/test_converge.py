"""The ladder of a scene, and its numbers with error bars."""

import json
import math
import re
import subprocess
import sys

import pandas as pd
import pytest
import tomli_w
from matplotlib.backends.backend_agg import FigureCanvasAgg

from taichi_silo.errors import BadInput
from taichi_silo.runs.cost_estimate import Cost
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.scene import Machine, Scene
from taichi_silo.show.figures.convergence import convergence_figure
from taichi_silo.show.report.convergence import with_error
from taichi_silo.simulation import outflow
from taichi_silo.studies.converge.estimate import estimate
from taichi_silo.studies.converge.ladder import LEAST_FINER, MOST_FINER, Ladder, Rung
from taichi_silo.studies.converge.plan import Plan, seconds, share
from taichi_silo.studies.converge.quantities import Quantity, words
from taichi_silo.studies.converge.study import Study
from tests.smallest import TABLES

SCENE = Scene(machine=Machine(threads=1))
SMOOTH = {"walls__kind": "smooth", "walls__friction_angle_deg": 22.0}


def ladder(**values):
    return Ladder(changed(SCENE, {path.replace("__", "."): value for path, value in values.items()}))


def test_the_cells_of_each_step_divide_the_scene_and_are_finer_by_a_ratio_that_shows_an_order():
    one = ladder()
    sizes = [one.cell(step) for step in range(6)]
    for size in sizes:
        assert 0.2 / size == pytest.approx(round(0.2 / size)) and 0.5 / size == pytest.approx(round(0.5 / size))
    assert all(LEAST_FINER <= coarse / fine <= MOST_FINER for coarse, fine in zip(sizes, sizes[1:], strict=False))
    assert sizes[0] == 0.02


def test_an_outlet_has_cells_enough_on_the_coarsest_grid_and_its_edges_on_every_one():
    one = ladder(silo__outlet__width_m=0.04)
    for step in range(4):
        assert 0.08 / one.cell(step) == pytest.approx(round(0.08 / one.cell(step)))
    assert 0.04 / one.cell(0) >= 4.0 - 1e-9


def test_a_column_that_stands_free_has_cells_enough_on_the_coarsest_grid():
    """It is the sand that is resolved, not the room that it falls into."""
    for left, right in ((0.08, 0.12), (0.0, 0.05)):
        one = ladder(silo__column_m=(left, right), silo__height_m=0.2, flow__outflow="collapse", **SMOOTH)
        assert (right - left) / one.cell(0) >= 10.0 - 1e-9


def test_a_silo_whose_sides_have_no_common_cell_is_refined_all_the_same():
    one = ladder(silo__width_m=0.217, silo__height_m=0.5 * math.sqrt(2.0))
    sizes = [one.cell(step) for step in range(5)]
    assert [0.217 / size for size in sizes] == pytest.approx([round(0.217 / size) for size in sizes])
    assert all(LEAST_FINER <= coarse / fine <= MOST_FINER for coarse, fine in zip(sizes, sizes[1:], strict=False))


def test_between_very_rough_walls_the_length_is_that_of_the_law_or_part_of_a_cell_and_elsewhere_that_of_the_law():
    one = ladder(averaging__characteristic_length_m=0.0055)
    assert [one.length(step) for step in range(3)] == pytest.approx([0.01, 0.00625, 0.0055])
    smooth = ladder(walls__kind="smooth", walls__friction_angle_deg=19.0)
    assert [smooth.length(step) for step in range(3)] == pytest.approx([0.0015] * 3)


def test_the_bottom_is_never_slower_than_the_scene_and_runs_faster_where_sand_still_follows_slowly():
    assert ladder().speed_m_per_s == pytest.approx(0.008)
    assert ladder().speeds == pytest.approx([0.032, 0.016, 0.008])
    assert ladder(flow__speed_m_per_s=0.02).speeds == [0.02]


def made_up(one, steps, cells=0.0, length=0.0, speed=0.0, truth=800.0):
    """Results with known effects of each parameter."""
    own, aim = one.scene.flow.speed_m_per_s, one.aim_m
    found = {}
    for step in range(steps):
        for name, rung in one.step(step).items():
            value = truth + cells * (rung.cell_m / 0.02) ** 2 + length * (rung.length_m - aim) / 0.02
            value += speed * (rung.speed_m_per_s - own) / 0.008
            found[name] = {"N_residual": Quantity(value, "N/m", 1600.0)}
    return found


@pytest.mark.parametrize(("effects", "decisive"), [
    ({"cells": 80.0}, "grid"), ({"length": 80.0}, "length"), ({"speed": 40.0}, "speed"),
    ({"cells": -50.0, "length": 200.0, "speed": 10.0}, "length"),
])  # fmt: skip
def test_each_numerical_parameter_is_extrapolated_by_itself(effects, decisive):
    one = ladder()
    number = estimate(one, 3, made_up(one, 3, **effects))["N_residual"]
    assert number.value == pytest.approx(800.0, abs=0.5)
    assert number.decisive == decisive
    assert abs(number.value - 800.0) < number.error
    assert number.relative == pytest.approx(number.error / 1600.0)


def test_the_error_falls_with_each_step():
    one = ladder()
    errors = [estimate(one, steps, made_up(one, steps, cells=80.0, length=80.0))["N_residual"].error
              for steps in (2, 3, 4)]  # fmt: skip
    assert errors[0] > errors[1] > errors[2] > 0.0


def test_one_step_gives_no_error_bar():
    one = ladder()
    number = estimate(one, 1, made_up(one, 1, cells=1.0))["N_residual"]
    assert math.isnan(number.error) and number.as_json()["error"] is None


def test_numbers_are_plain_json():
    one = ladder()
    number = estimate(one, 3, made_up(one, 3, cells=10.0))["N_residual"].as_json()
    assert json.loads(json.dumps(number, allow_nan=False))["unit"] == "N/m"
    assert number["order"] == pytest.approx(2.0, abs=0.05)


def test_the_plan_reads_per_cents_and_times_as_people_write_them():
    assert share("2%") == share("0.02") == share(0.02) == 0.02
    assert seconds("20min") == seconds("1200s") == seconds(1200.0) == 1200.0
    assert seconds("1.5h") == 5400.0


@pytest.mark.parametrize("text", ["", "two", "2 percent", "%"])
def test_an_error_that_is_no_number_is_refused(text):
    with pytest.raises(BadInput, match="must be an error such as 2%"):
        share(text)


@pytest.mark.parametrize("text", ["", "soon", "3 weeks", "min"])
def test_a_time_that_is_none_is_refused(text):
    with pytest.raises(BadInput, match="must be a time such as 20min"):
        seconds(text)


def test_a_number_that_no_run_has_is_refused_with_the_one_that_was_meant():
    one = ladder()
    numbers = estimate(one, 3, made_up(one, 3, cells=10.0))
    with pytest.raises(BadInput, match="did you mean N_residual"):
        Plan(of=("N_residal",)).asked(numbers)


def test_the_worst_of_the_numbers_asked_for_decides():
    one = ladder()
    numbers = estimate(one, 3, made_up(one, 3, cells=10.0))
    assert Plan().worst(numbers)[0] == "N_residual"


def test_a_number_known_to_round_off_has_five_digits_and_a_panel_with_short_numbers():
    """Friction that is mobilised to its limit is the same on all cells but for the last digits of a number."""
    assert with_error(0.3249196962329, 1.4e-14, "") == ("0.32492 ± 0.00000", "")
    assert with_error(0.3249196962329, 1.4e-4, "") == ("0.32492 ± 0.00014", "")
    cells = [0.01, 0.005, 0.0025]
    runs = pd.DataFrame({"main": True, "speed_m_per_s": 0.01, "cell_size_m": cells,
                         "TN_residual": [0.3249196962329, 0.3249196962328, 0.324919696233]})  # fmt: skip
    numbers = pd.DataFrame([{"quantity": "TN_residual", "value": 0.3249196962329, "error": 1.4e-14, "unit": ""}])
    figure = convergence_figure((runs, numbers))
    FigureCanvasAgg(figure).draw()
    assert all(len(label.get_text()) <= 7 for label in figure.axes[0].get_yticklabels())


def test_quantities_have_words():
    assert words("N_residual") == "normal force on a wall, at the end"
    assert words("pressure_filled_0.5") == "wall normal stress at 50 % of the height, after filling"


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Two steps of the smallest silo, asked for by the command."""
    folder = tmp_path_factory.mktemp("converge")
    scene = TABLES | {"flow": {"speed_m_per_s": 0.04, "displacement_m": 0.002}}
    (folder / "silo.toml").write_text(tomli_w.dumps(scene))
    words = [str(folder / "silo.toml"), "--steps", "2", "--output", str(folder / "out"), "--json", "--jobs", "1"]
    return folder / "out", command("converge", *words)


def command(*words):
    done = subprocess.run([sys.executable, "-m", "taichi_silo.cli.app", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def test_the_command_gives_each_number_as_value_error_unit_and_order(studied):
    folder, done = studied
    found = json.loads(done.stdout)
    assert found["steps"] == 2 and not found["met"] and "after 2 steps" in found["ended"]
    number = found["quantities"]["N_filled"]
    assert number["unit"] == "N/m" and number["error"] > 0.0 and "order" in number
    assert found == json.loads((folder / "converge.json").read_text())


def test_the_weight_of_the_sand_is_carried_by_bottom_and_walls_in_the_limit_too(studied):
    found = json.loads((studied[0] / "converge.json").read_text())["quantities"]
    P, T = (found[f"{name}_filled"] for name in "PT")
    summary = json.loads(next(studied[0].glob("cell-*/summary.json")).read_text())
    assert P["value"] + 2.0 * T["value"] == pytest.approx(summary["weight_N_per_m"], rel=1e-3)


def test_it_leaves_tables_figures_and_a_report(studied):
    names = ["converge.csv", "runs.csv", "report.html", "figures/convergence.png", "figures/cost.png"]
    assert all((studied[0] / name).stat().st_size > 500 for name in names)
    runs = pd.read_csv(studied[0] / "runs.csv")
    assert set(runs["step"]) == {1, 2} and runs["main"].sum() == 2


def test_the_cost_of_each_step_is_told_before_it(studied):
    assert "step 1: cells of 20 mm, 10 across: 1 run, about" in studied[1].stderr


def test_what_is_there_is_kept(studied):
    folder, _ = studied
    before = {file: file.stat().st_mtime for file in folder.glob("cell-*/forces.csv")}
    again = command("converge", str(folder.parent / "silo.toml"), "--steps", "2", "--output", str(folder))
    assert "step 2: cells of 12.5 mm, 16 across: there already" in again.stdout
    assert {file: file.stat().st_mtime for file in folder.glob("cell-*/forces.csv")} == before


def test_a_folder_that_holds_other_runs_is_refused(studied, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "run.toml").write_text("")
    with pytest.raises(BadInput, match="holds other runs, such as mine"):
        Study(SCENE, tmp_path)


def test_no_time_for_a_step_is_said_with_the_budget_that_would_do(tmp_path, monkeypatch):
    study = Study(SCENE, tmp_path, Plan(budget_s=1.0))
    monkeypatch.setattr(Study, "costs", lambda *_: {"one": Cost(1000, 1000, 300.0)})
    study.run()
    assert not study.numbers and re.search(r"takes about 5.1 min, .* --budget 6min goes on", study.ended)


@pytest.mark.parametrize(("displacement", "scaling"), [(0.02, 1.0), (0.002, 1.0), (0.005, 100.0)])
def test_the_bottom_reaches_every_speed_of_a_ladder_within_half_of_its_way(displacement, scaling):
    """Else runs at several speeds would all be runs of the start."""
    one = ladder(flow__displacement_m=displacement, method__mass_scaling=scaling)
    for speed in one.speeds[:-1]:
        rung = one.made(Rung(one.cell(1), one.length(1), speed))
        assert 0.5 * speed * outflow.start(rung, 0.0) <= 0.5 * displacement * (1.0 + 1e-9)
    slow = 6.1e-3 * math.sqrt(9.81 * 0.2 / scaling)
    assert SCENE.flow.speed_m_per_s <= one.speed_m_per_s
    assert one.speed_m_per_s <= slow or one.speeds == [SCENE.flow.speed_m_per_s]
