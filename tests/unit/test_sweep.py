"""Sweeps: what a file or flags say, what is refused, which runs are kept, the table, the figure, and the cluster."""

import json
import sys
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from taichi_silo import Scene
from taichi_silo.cli.commands.sweep import sweep as command
from taichi_silo.errors import BadInput
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import write_parameters
from taichi_silo.scene.dotted_paths import changed, default, known, value, whole
from taichi_silo.show.figures import plot_response
from taichi_silo.show.figures.batch import COLORS, batch_figure
from taichi_silo.show.figures.response import label, response_figure
from taichi_silo.studies.sweep import variations
from taichi_silo.studies.sweep.clusters import Local, Scheduler, Slurm
from taichi_silo.studies.sweep.hypercube import Choices, LatinHypercube, Span
from taichi_silo.studies.sweep.plan import from_command_line, from_flags, from_tables, read
from taichi_silo.studies.sweep.processes import simulate
from taichi_silo.studies.sweep.runs import LOCK, Run
from taichi_silo.studies.sweep.study import TABLE, Study
from taichi_silo.studies.sweep.table import PRESSURE, Response, found, row
from taichi_silo.studies.sweep.table import leave as leave_table
from taichi_silo.studies.sweep.variations import bases, differences, product, variation
from taichi_silo.studies.sweep.variations import scenes as combined
from taichi_silo.utils.console import Console
from taichi_silo.utils.file_lock import alone
from taichi_silo.utils.process_pool import ProcessPool

NOTHING = {"fidelity": None, "film": None, "jobs": None, "scheduler": None, "slurm": False}
LATIN = "[latin_hypercube]\nruns = 2\nbetween.flow."


def scenes(text: str) -> dict[str, Scene]:
    return from_tables(tomllib.loads(text), Path()).scenes()


def made(*texts: str, files: tuple = ()) -> dict[str, Scene]:
    return combined(bases(list(files)), product([variation(text) for text in texts]))


def line(files=(), file=None, vary=(), **flags):
    return from_command_line(file, list(files), list(vary), NOTHING | flags)


# --- paths through tables and lists that a scene may lack -------------------------------------------------------------


def test_a_path_makes_the_tables_and_the_list_entries_on_its_way():
    scene = changed(Scene(), {"silo.outlet.position": "right", "silo.outlet.width_m": 0.08})
    assert (scene.silo.outlet.width_m, scene.silo.outlet.position) == (0.08, "right")
    roof = {"kind": "roof", "width_m": 0.06, "bottom_m": 0.1}
    scene = changed(scene, {f"silo.inserts.0.{name}": one for name, one in roof.items()})
    assert value(scene, "silo.inserts.0.width_m") == 0.06 and value(scene, "silo.inserts.1.width_m") is None
    assert changed(scene, {"silo.inserts.0.width_m": 0.08}).silo.inserts[0].kind == "roof"
    with pytest.raises(BadInput, match="silo.inserts.2.width_m; 1 are there, so the next has number 1"):
        changed(scene, {"silo.inserts.2.width_m": 0.08})


def test_a_path_is_known_by_what_it_leads_to():
    assert all(map(known, ("silo.outlet", "silo.outlet.width_m", "silo.inserts", "silo.inserts.3.kind")))
    assert not any(map(known, ("silo.outlet.0", "silo.inserts.kind", "silo.width_m.0", "silo", "silo.inserts.0")))
    assert changed(Scene(), {"silo.outlet.width_m": None, "silo.inserts.0.width_m": None}) == Scene()
    assert default("silo.outlet.width_m") is None and default("silo.outlet.position") == "centre"
    assert whole("filling.layers") and whole("grid.points_per_cell") and not whole("sand.beta")


# --- scenes and their names -------------------------------------------------------------------------------------------


def test_a_grid_is_every_combination_of_an_inline_scene():
    found = scenes("""
        fidelity = "draft"
        [scene]
        sand = "hostun"
        "sand.void_ratio" = 0.7
        walls = {kind = "smooth", friction_angle_deg = 19}
        machine.threads = 4096
        [grid]
        "silo.outlet.width_m" = ["default", 0.08]
        flow.displacement_m = [0.005, 0.01]
    """)
    assert list(found) == [
        "width-default_displacement-0.005", "width-default_displacement-0.01",
        "width-0.08_displacement-0.005", "width-0.08_displacement-0.01",
    ]  # fmt: skip
    assert [scene.silo.outlet and scene.silo.outlet.width_m for scene in found.values()] == [None, None, 0.08, 0.08]
    for scene in found.values():
        assert (scene.sand.granular_hardness_Pa, scene.sand.void_ratio, scene.walls.kind) == (1000e6, 0.7, "smooth")
        assert scene.flow.speed_m_per_s == 0.008 and scene.machine.threads == 1


def test_a_scene_and_a_sand_are_found_beside_the_sweeps_file(tmp_path):
    (tmp_path / "silo.toml").write_text("[sand]\nvoid_ratio = 0.9\n")
    (tmp_path / "mine.toml").write_text("""
        critical_friction_angle_deg = 33.0\ngranular_hardness_Pa = 1e9\nn = 0.3\nalpha = 0.2\nbeta = 1.0
        e_i0 = 1.3\ne_c0 = 0.8\ne_d0 = 0.5\ngrain_density_kg_per_m3 = 2650.0\nd50_m = 1e-3\n""")
    (tmp_path / "s.toml").write_text('scene = "silo.toml"\n[grid]\nsand = ["karlsruhe", "mine.toml"]\n')
    found = read(tmp_path / "s.toml").scenes()
    assert list(found) == ["sand-karlsruhe", "sand-mine"]
    assert [scene.sand.critical_friction_angle_deg for scene in found.values()] == [30.0, 33.0]
    assert {scene.sand.void_ratio for scene in found.values()} == {0.9}
    assert list(read(tmp_path / "s.toml").model_copy(update={"scene": (tmp_path / "silo.toml",) * 2}).scenes()) == [
        "silo_sand-karlsruhe", "silo_sand-mine", "silo-2_sand-karlsruhe", "silo-2_sand-mine",
    ]  # fmt: skip


def test_names_are_unique_where_paths_end_alike_and_where_files_are_called_alike(tmp_path):
    assert len(made("sand.n=0.4,0.5", "sand.alpha=0.2,0.3", "sand.beta=1,1.5", "method.cfl=0.2,0.4")) == 16
    for place in ("a", "b"):
        (tmp_path / place).mkdir()
        (tmp_path / place / "dense.toml").write_text("[sand]\nvoid_ratio = 0.6\n")
    found = made("filling.kind=rain", files=(tmp_path / "a" / "dense.toml", tmp_path / "b" / "dense.toml"))
    assert list(found) == ["dense_filling-rain", "dense-2_filling-rain"]


def test_a_file_takes_defaults_for_what_it_leaves_out_and_a_run_has_the_name_of_its_folder(tmp_path):
    (tmp_path / "wide").mkdir()
    (tmp_path / "wide" / "run.toml").write_text("[silo]\nwidth_m = 0.3\n[machine]\nthreads = 4096\n")
    found = made(files=(tmp_path / "wide" / "run.toml",))
    assert found == {"wide": changed(Scene(machine={"threads": 1}), {"silo.width_m": 0.3})}


def test_a_sand_by_name_brings_its_constants_and_default_is_what_is_not_given():
    found = made("sand=karlsruhe,hostun", "sand.void_ratio=0.7")
    assert [scene.sand.granular_hardness_Pa for scene in found.values()] == [190e6, 1000e6]
    assert {scene.sand.void_ratio for scene in found.values()} == {0.7}
    found = made("walls.kind=smooth", "walls.friction_angle_deg=19,15")
    assert [scene.walls.friction_angle_deg for scene in found.values()] == [19.0, 15.0]


def test_the_default_of_what_follows_the_silo_is_what_follows_from_it():
    hopper = {"half_angle_deg": 20.0, "outlet_width_m": 0.08}
    base = Scene.model_validate({"silo": {"hopper": hopper}, "grid": {"points_per_cell": 9, "cell_size_m": 0.01}})
    found = variations.made(base, {"grid.points_per_cell": "default"}).grid
    assert (found.points_per_cell, found.cell_size_m) == (4, 0.01)
    wide = Scene.model_validate({"silo": {"width_m": 6.0, "height_m": 20.0}, "flow": {"speed_m_per_s": 0.5}})
    untold = Scene.model_validate({"silo": {"width_m": 6.0, "height_m": 20.0}})
    assert variations.made(wide, {"flow.speed_m_per_s": "default"}).flow == untold.flow


def test_the_friction_angle_of_smooth_walls_is_left_out_where_walls_are_very_rough():
    found = made("walls.kind=smooth,very-rough", "walls.friction_angle_deg=19")
    assert [scene.walls.friction_angle_deg for scene in found.values()] == [19.0, None]


def test_columns_are_what_was_asked_for_and_what_differs(tmp_path):
    loose = "[sand]\nvoid_ratio = 0.9\n[walls]\nkind = 'smooth'\nfriction_angle_deg = 12.3\n"
    (tmp_path / "loose.toml").write_text(loose)
    (tmp_path / "dense.toml").write_text("")
    found = made("method.cfl=0.2", files=(tmp_path / "loose.toml", tmp_path / "dense.toml"))
    # dense sand is between very rough walls here, of which no half is computed
    columns = {"method.cfl", "sand.void_ratio", "walls.kind", "walls.friction_angle_deg", "silo.half"}
    columns.add("averaging.characteristic_length_m")  # half a cell between very rough walls
    assert set(differences(found, ["method.cfl"])) == columns


def test_flags_stand_for_a_file():
    plan = line(vary=["filling.kind=rain,layers"], fidelity="draft", film=True, jobs=1)
    assert list(plan.scenes()) == ["filling-rain", "filling-layers"]
    assert plan.film and plan.cluster == Local(jobs=1)
    assert {scene.flow.speed_m_per_s for scene in plan.scenes().values()} == {0.008}
    assert line(vary=["sand=hostun"], slurm=True).cluster == Slurm()
    assert line(vary=["sand=hostun"], scheduler="tcp://a:1").cluster == Scheduler(address="tcp://a:1")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("gird = {}", "gird is not a parameter of a sweep; did you mean grid?"),
        ("retries = -1", "retries is -1; it must be at least 0"),
        ("scene = 3", "scene is 3; it must be a file, a list of files, or a table"),
        ("grid = 3", "grid is 3; it must be a table"),
        ("", "nothing varies; a sweep needs a table grid or latin_hypercube"),
        ('[grid]\n"flow.speed_m_per_s" = 1.0', r"grid.flow.speed_m_per_s is 1.0; it must be a list of values"),
        ('[grid]\n"flow.speed_m_per_s" = []', "flow.speed_m_per_s varies; it must have a value"),
        ('[grid]\n"silo.inserts.0.width_m" = [0.05]', r"silo.inserts.0.kind is missing; it must be given"),
        ('[grid]\n"silo.outlet.width_m" = [0.081]',
         "no cells of about 0.005 m have lines at 0.0595, 0.1405 m, the edges of the outlet"),
        ("[grid]\nfilling.layers = [2]\n" + LATIN + "displacement_m = [0.1, 0.2]",
         "a sweep has a grid or a latin_hypercube, not both"),
        ("[latin_hypercube]\nruns = 1\nbetween.flow.displacement_m = [0.1, 0.2]",
         "latin_hypercube.runs is 1; it must be at least 2"),
        ("[latin_hypercube]\nruns = 2\nseeds = 1\nbetween = {}", "latin_hypercube.seeds is .*; did you mean .*seed"),
        ("[latin_hypercube]\nruns = 2", "latin_hypercube.between is missing; it must be given"),
        (LATIN + "speed_m_per_s = [0.2, 0.1]",
         "low is 0.2; it must be below high = 0.1"),
        (LATIN + "speed_m_per_s = [0.1, 0.2, 0.3]",
         r"flow.speed_m_per_s is \[0.1, 0.2, 0.3\]; it must be \[low, high\]"),
        (LATIN + "speed_m_per_s = {low = 0, high = 1, logarithmic = true}",
         "low is 0; it must be above 0 for a logarithmic span"),
        (LATIN + "speed_m_per_s = {low = 0, high = 1, stride = 1}",
         "flow.speed_m_per_s.stride is not a parameter of a sweep"),
        (LATIN + "speeds = [0.1, 0.2]", "flow.speeds varies; a scene has no"),
        ('[cluster]\nkind = "pbs"', "cluster.kind is pbs; it must be one of local, slurm, scheduler"),
        ('[cluster]\nkind = "slurm"\nwall_time = "1"', "cluster.wall_time is .*; did you mean cluster.walltime?"),
        ('[cluster]\nkind = "scheduler"', "cluster.address is missing; it must be given"),
        ('fidelity = "best"\n[grid]\nfilling.layers = [2]', "fidelity is best; it must be one of draft"),
    ],
)  # fmt: skip
def test_what_is_not_possible_is_refused_in_a_sentence(text, sentence):
    with pytest.raises(BadInput, match=sentence):
        scenes(text)


@pytest.mark.parametrize(
    ("texts", "sentence"),
    [
        (["flow.speed=1"], "flow.speed varies; a scene has no such value; did you mean flow.speed_m_per_s"),
        (["flow"], "vary is flow; it must be PATH=V1,V2"),
        (["filling.kind=rain,,"], "it must be PATH=V1,V2"),
        (["precision=f32"], "precision varies; a scene has no such value"),
        (["machine.threads=2"], "each run of a batch has one thread"),
        (["sand.name=hostun"], "it is only a label"),
        (["flow.speed_m_per_s=0.01,-1"], "flow.speed_m_per_s=-1: speed_m_per_s is -1; it must be at least 1e-09"),
        (["walls.kind=smooth,smooth"], "the value smooth is there twice"),
        (["walls.kind=smooth"], "friction_angle_deg is not given; smooth walls need"),
        (["sand=sahara"], "sand=sahara: sand is sahara; it must be"),
        (["sand=hostun", "sand.void_ratio=dense"], "void ratio is dense; it must be a number"),
        (
            ["grid.cell_size_m=0.01,0.03"],
            "grid.cell_size_m=0.03: cell size is 0.03 m; it must divide the width",
        ),
        ([f"sand.{name}=" + ",".join(map(str, range(30))) for name in ("n", "alpha", "beta")], "make 27000 runs"),
        (["sand=" + "a" * 300 + ".toml"], "at most 200 are allowed"),
    ],
)
def test_what_is_not_possible_is_refused_by_path_and_value(texts, sentence):
    with pytest.raises(BadInput, match=sentence):
        made(*texts)


def test_flags_and_files_that_are_not_possible_are_refused(tmp_path):
    (tmp_path / "s.toml").write_text("[grid]\nfilling.layers = [2, 3]\n")
    (tmp_path / "bad.toml").write_text("[flow]\nspeed_m_per_s = -1\n")
    sand = ["sand=hostun"]
    for given, sentence in (
        ({"file": tmp_path / "s.toml", "vary": sand}, "s.toml must say what varies"),
        ({"vary": [*sand, "sand=hamburg"]}, "vary is given twice for sand"),
        ({"vary": sand, "scheduler": "tcp://a:1", "slurm": True}, "must be one of them"),
        ({"vary": sand, "scheduler": "tcp://a:1", "jobs": 2}, "a scheduler, which has its own workers"),
        ({"file": tmp_path / "no.toml"}, "no.toml cannot be read as a sweep"),
        ({"files": [tmp_path / "bad.toml"], "vary": sand}, "bad.toml: speed_m_per_s is -1"),
        ({"files": [tmp_path / "no.toml"], "vary": sand}, "no.toml"),
    ):
        with pytest.raises(BadInput, match=sentence):
            line(**given).scenes()


# --- the latin hypercube ----------------------------------------------------------------------------------------------

BETWEEN = {
    "flow.displacement_m": [0.002, 0.02],
    "flow.speed_m_per_s": {"low": 1e-3, "high": 1.0, "logarithmic": True},
    "silo.outlet.width_m": {"low": 0.04, "high": 0.12, "step": 0.02},
    "filling.layers": [1, 4],
    "filling.kind": ["rain", "layers"],
}


def test_each_part_of_each_range_is_drawn_once_and_the_same_by_its_seed():
    runs = 20
    first, again, other = (LatinHypercube(runs=runs, seed=seed, between=BETWEEN).settings(whole) for seed in (3, 3, 4))
    assert first == again and first != other
    drawn = pd.DataFrame(first)
    linear = (drawn["flow.displacement_m"] - 0.002) / 0.018
    decades = np.log10(drawn["flow.speed_m_per_s"] / 1e-3) / 3.0
    for part in (linear, decades):
        assert sorted(np.floor(part * runs * (1.0 - 1e-6)).astype(int)) == list(range(runs))
    assert drawn["silo.outlet.width_m"].value_counts().to_dict() == dict.fromkeys((0.04, 0.06, 0.08, 0.1, 0.12), 4)
    assert drawn["filling.layers"].value_counts().to_dict() == dict.fromkeys((1, 2, 3, 4), 5)
    assert drawn["filling.kind"].value_counts().to_dict() == {"rain": 10, "layers": 10}
    assert all(float(f"{one:.6g}") == one for one in drawn["flow.speed_m_per_s"]), "the table shows what was used"


def test_steps_end_where_they_were_told_and_carry_no_noise():
    tenths = Span(low=0.1, high=0.3, step=0.1)
    assert [tenths.value(part, False) for part in (0.0, 0.34, 0.67, 1.0)] == [0.1, 0.2, 0.3, 0.3]
    assert Span(low=1.0, high=3.0).value(1.0, True) == 3 and isinstance(Span(low=1, high=3).value(0.5, True), int)
    assert Span(low=0.01, high=1.0, step=0.01, logarithmic=True).value(0.5, False) == 0.1
    assert Choices(choices=("a", "b")).value(1.0, False) == "b"


def test_runs_of_a_hypercube_are_numbered_and_none_is_there_twice():
    found = scenes("""
        [latin_hypercube]
        runs = 12
        [latin_hypercube.between]
        filling.kind = ["rain", "layers"]
        flow.displacement_m = { low = 0.01, high = 0.02, step = 0.01 }
    """)
    assert len(found) == len({scene.model_dump_json() for scene in found.values()}) <= 4
    assert list(found)[0] == "run-1"


# --- runs that are kept -----------------------------------------------------------------------------------------------


def left(folder: Path, scene: Scene, factor: float = 1.0, **summary) -> Run:
    """A run that was there: its scene, its summary and its forces."""
    folder.mkdir(parents=True)
    write_parameters(folder, scene, {"finished": True})
    forces = {"bottom_N_per_m": 500.0 * factor, "shear_N_per_m": 600.0, "normal_N_per_m": 700.0 * factor}
    found = {
        "finished": True,
        "filling": forces | {"wall_friction_angle_deg": 30.0},
        "largest_wall_normal_stress_Pa": {
            "filling": {"node": 1.0, "pressure_cell": 2.0}, "residual": {"node": 3.0, "pressure_cell": 1.0},
        },
        "cost": {"points": 40, "steps": 100, "seconds": 1.0},
    }  # fmt: skip
    (folder / "summary.json").write_text(json.dumps(found | summary))
    u = np.linspace(0.0, scene.flow.displacement_m, 50)
    rows = {"stage": "flow", "time_s": u, "displacement_m": u, "bottom_force_N_per_m": 500.0 * factor}
    rows |= {f"{side}_{kind}_N_per_m": 700.0 * factor for side in ("left", "right") for kind in ("normal", "shear")}
    pd.DataFrame(rows).to_csv(folder / "forces.csv", index=False)
    return Run(scene, folder)


def test_a_run_is_there_if_its_scene_is_the_wanted_one_on_any_machine_and_it_finished(tmp_path):
    scene = Scene(walls={"kind": "smooth", "friction_angle_deg": 19.0}, machine={"threads": 1})
    run = left(tmp_path / "run", scene)
    assert run.finished
    assert Run(changed(scene, {"machine.lanes": False}), run.folder).finished
    assert not Run(scene, run.folder, film=True).finished, "its film is not"
    assert not left(tmp_path / "failed", scene, finished=False, failure="no sand").finished
    other = Run(changed(scene, {"flow.speed_m_per_s": 0.003}), run.folder)
    assert not other.finished and other.summary == {}
    with pytest.raises(BadInput, match="holds another scene's run; give another folder, or overwrite=True"):
        other.check()
    run.check()
    Run(scene, tmp_path / "nothing").check()


def test_whoever_wants_a_finished_run_again_gets_it_from_the_start(tmp_path):
    """A run that is finished when it is attempted would be left alone."""
    seen = []

    class Nobody(ProcessPool):
        def run(self, tasks, console, ended):
            seen.extend(Run.from_json(line)[0] for task in tasks for line in json.loads(task.line))
            return {}

    run = left(tmp_path / "run", Scene(machine={"threads": 1}))
    simulate({"run": run}, Nobody(1))
    assert seen == [run] and not run.finished and not (run.folder / "forces.csv").exists()


def study(folder: Path, *texts: str, overwrite: bool = False, **more) -> Study:
    return Study(from_flags([], list(texts)).model_copy(update=more), folder, Console(quiet=True), overwrite)


def test_what_is_there_is_kept_drawn_and_in_the_table_without_a_cluster(tmp_path):
    one = study(tmp_path, "silo.outlet.width_m=0.04,0.08", "filling.kind=rain,layers")
    for number, run in enumerate(one.runs.values()):
        left(run.folder, run.scene, 1 + number)
    again = study(tmp_path, "silo.outlet.width_m=0.04,0.08", "filling.kind=rain,layers")
    assert again.missing == {} and again.varied == ["silo.outlet.width_m", "filling.kind"]
    again.run()
    table = pd.read_csv(tmp_path / TABLE)
    assert table.N_filled_N_per_m.tolist() == [700.0, 1400.0, 2100.0, 2800.0] and table.finished.all()
    assert [file.name for file in again.left] == [TABLE, "response.png", "forces.png"]
    assert not (tmp_path / ".sweep").exists()
    assert json.loads(json.dumps(again.result, default=str))["runs"] == dict.fromkeys(one.runs, True)
    assert set(study(tmp_path, "filling.kind=rain,layers", overwrite=True).missing) == {
        "filling-rain", "filling-layers"
    }  # fmt: skip


def test_a_run_is_attempted_by_one_process_at_a_time_and_left_alone_once_finished(tmp_path, monkeypatch):
    run = left(tmp_path / "run", Scene(machine={"threads": 1}))
    before = {file: file.stat().st_mtime_ns for file in run.folder.iterdir()}
    monkeypatch.setattr("taichi_silo.studies.sweep.runs.WAIT_S", 0.3)
    with alone(run.folder / LOCK, 0.0, ""), pytest.raises(BadInput, match="is being written by another process"):
        run.attempt()
    (run.folder / LOCK).write_text("")  # as a killed process leaves it
    run.attempt()
    assert {file: file.stat().st_mtime_ns for file in run.folder.iterdir()} == before
    with pytest.raises(BadInput, match="cannot be written"), alone(tmp_path / "no" / LOCK, 0.0, ""):
        pass


def test_an_estimate_says_what_it_would_cost_and_leaves_nothing(tmp_path, capsys):
    coarse = ("grid.cell_size_m=0.05", "flow.displacement_m=0.002,0.004", "flow.speed_m_per_s=0.05")
    command(None, list(coarse), estimate=True, output=tmp_path / "out", json=True)
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert told["runs"] == 2 and set(told["missing"]) == set(told["core_seconds"])
    assert all(seconds > 0.0 for seconds in told["core_seconds"].values())
    assert "0 runs are there, 2 to do: about" in err and not (tmp_path / "out").exists()


def test_a_response_that_the_table_does_not_hold_is_refused(tmp_path):
    for response, sentence in (
        (Response(y="P_fill_N_per_m"), "response.y is P_fill_N_per_m; did you mean P_filled_N_per_m?"),
        (Response(y="flow_pattern"), "response.y is flow_pattern; "),
        (Response(x="filling.colour"), "response.x is filling.colour; did you mean filling.kind?"),
        (Response(colour="pattern"), "response.colour is pattern; did you mean flow_pattern?"),
    ):
        with pytest.raises(BadInput, match=sentence):
            study(tmp_path, "filling.kind=rain,layers", response=response)
    study(tmp_path, "filling.kind=rain,layers", response=Response(x="filling.kind", colour="flow_pattern"))


def test_a_sweep_on_a_cluster_needs_dask_and_one_on_this_machine_does_not(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(BadInput, match="needs taichi-silo.cluster"):
        Scheduler(address="tcp://a:1").check()
    Local().check()
    with pytest.raises(BadInput, match="jobs is 9999; this machine has "):
        Local(jobs=9999).check()


def test_a_job_of_slurm_asks_for_what_the_file_says(tmp_path):
    asked = {
        "kind": "slurm", "queue": "short", "cores": 8, "memory": "24GB", "walltime": "02:30:00", "account": "sand",
        "job_extra": ["--exclusive"], "prologue": ["module load python"],
    }  # fmt: skip
    cluster = from_tables({"cluster": asked}, Path()).cluster
    with cluster.cluster(tmp_path) as slurm:
        script = slurm.job_script()
    for line in ("-p short", "-A sand", "--cpus-per-task=8", "--mem=23G", "-t 02:30:00", "--exclusive"):
        assert f"#SBATCH {line}" in script, script
    assert "module load python\n" in script
    assert f"{sys.executable} -m distributed.cli.dask_worker" in script
    for word in ("--nthreads 8 ", "--nanny", "--no-dashboard"):
        assert word in script, script
    assert cluster.with_jobs(20).jobs == 3 and cluster.with_jobs(20).at_once == 24
    with Slurm().cluster(tmp_path) as slurm:
        assert "#SBATCH --mem=30G" in slurm.job_script(), "2 GB a core"


def test_the_table_has_a_row_for_every_run_and_says_why_one_failed(tmp_path):
    found = made("sand.void_ratio=0.6,0.7,0.8")
    runs = {name: Run(scene, tmp_path / name) for name, scene in found.items()}
    first, second, third = runs
    left(tmp_path / first, found[first], warnings=["a", "b"])
    why = {second: "killed"}
    rows = [row(name, run, ["sand.void_ratio"], why.get(name, "")) for name, run in runs.items()]
    table = leave_table(tmp_path / "batch.csv", rows)
    read = pd.read_csv(tmp_path / "batch.csv").set_index("run")
    assert list(read.index) == list(table.run) == list(runs)
    assert read["sand.void_ratio"].tolist() == [0.6, 0.7, 0.8]
    assert read.finished.tolist() == [True, False, False]
    assert read.failure[second] == "killed" and pd.isna(read.failure[third])
    assert (read.P_filled_N_per_m[first], read.N_filled_N_per_m[first], read.warnings[first]) == (500.0, 700.0, 2)
    assert read.largest_wall_normal_stress_node_Pa[first] == 3.0
    assert read.largest_wall_normal_stress_pressure_cell_Pa[first] == 2.0
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.parametrize("count", [1, 7, 17])
def test_of_many_runs_a_few_from_least_to_largest_are_coloured(tmp_path, count):
    runs = [left(tmp_path / f"run{k}", Scene(), 1.0 + 0.01 * k) for k in range(count)]
    figure = batch_figure([Result(run.folder) for run in runs])
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert len(names) == min(count, len(COLORS))
    assert {"run0", f"run{count - 1}"} <= set(names)
    assert len(figure.axes[0].get_lines()) == count
    assert batch_figure([]) is None


# --- the figure -------------------------------------------------------------------------------------------------------


def table_of(**columns) -> pd.DataFrame:
    return pd.DataFrame(columns).rename(columns=lambda name: name.replace("__", "."))


def test_runs_that_are_alike_in_all_else_are_joined_and_one_without_an_answer_is_marked(tmp_path):
    table = table_of(silo__outlet__width_m=[0.04, 0.08, 0.12] * 2, walls__kind=["smooth"] * 3 + ["very-rough"] * 3)
    table[PRESSURE] = [3e3, 2e3, 1e3, np.nan, 5e3, 4e3]
    varied = ["silo.outlet.width_m", "walls.kind"]
    figure = response_figure(table, varied, Response())
    panel, other = figure.axes
    lines = [line.get_xydata().tolist() for line in panel.get_lines() if line.get_linestyle() == "-"]
    assert lines == [[[0.04, 3.0], [0.08, 2.0], [0.12, 1.0]], [[0.08, 5.0], [0.12, 4.0]]]
    assert panel.get_xlabel() == "outlet width (m)"
    assert panel.get_ylabel() == "largest wall pressure on a 20 mm cell (kPa)"
    assert [text.get_text() for text in panel.get_legend().get_texts()] == ["smooth", "very-rough", "no answer"]
    assert [text.get_text() for text in other.get_xticklabels()] == ["smooth", "very-rough"]
    assert "6 runs, 1 without an answer" in figure.get_suptitle()
    assert response_figure(table, varied, Response(x="walls.kind")).axes[0].get_xlabel() == "walls"
    assert [file.name for file in plot_response(table, varied, Response(), tmp_path)] == ["response.png"]
    assert response_figure(table.assign(**{PRESSURE: np.nan}), varied, Response()) is None
    few = table.iloc[[0, 1, 5]].assign(**{"silo.outlet.width_m": [0.04, 0.08, 0.1]})  # as drawn by chance
    assert not response_figure(few, varied, Response()).axes[0].get_lines()


def test_wide_ranges_have_logarithmic_axes_and_many_colours_a_bar():
    table = table_of(flow__speed_m_per_s=np.geomspace(1e-3, 1.0, 12), sand__void_ratio=np.linspace(0.6, 0.8, 12))
    table["N_largest_N_per_m"] = 500.0
    figure = response_figure(table, ["flow.speed_m_per_s", "sand.void_ratio"], Response(y="N_largest_N_per_m"))
    assert [figure.axes[k].get_xscale() for k in (0, 1)] == ["log", "linear"]
    assert len(figure.axes) == 4 and figure.axes[2].get_ylabel() == "sand void ratio (-)"


def test_every_column_has_a_label_with_its_unit():
    assert label("silo.inserts.0.width_m") == "inserts 0 width (m)"
    assert label("sand.granular_hardness_Pa") == "sand granular hardness (kPa)"
    assert label("P_least_N_per_m") == "bottom force P least in flow (kN/m)"
    assert label("stagnant_area_share") == "share of sand that stands still (-)"
    assert label("largest_wall_friction_angle_deg") == "largest wall friction angle (°)"
    assert set(found({})) < set(row("a", Run(Scene(), Path("nothing")), []))
