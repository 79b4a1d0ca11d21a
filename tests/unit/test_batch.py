"""Batches: combinations, names, refusals, runs that are kept, table and figure."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from taichi_silo import Scene
from taichi_silo.errors import BadInput
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import writable, write_parameters
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.show.figures.batch import COLORS, batch_figure
from taichi_silo.studies.sweep.runs import Run, simulate
from taichi_silo.studies.sweep.table import leave, row
from taichi_silo.studies.sweep.variations import bases, differences, product, scenes, variation
from taichi_silo.utils.process_pool import ProcessPool


def made(*texts: str, files: tuple = ()) -> dict[str, Scene]:
    return scenes(bases(list(files)), product([variation(text) for text in texts]))


# --- combinations and names -------------------------------------------------------------------------------------------


def test_variations_make_every_combination_under_a_readable_name():
    found = made("flow.speed_m_per_s=0.002,0.005", "filling.kind=rain,layers")
    assert list(found) == [
        "speed-0.002_filling-rain", "speed-0.002_filling-layers",
        "speed-0.005_filling-rain", "speed-0.005_filling-layers",
    ]  # fmt: skip
    assert [(scene.flow.speed_m_per_s, scene.filling.kind) for scene in found.values()] == [
        (0.002, "rain"), (0.002, "layers"), (0.005, "rain"), (0.005, "layers"),
    ]  # fmt: skip
    assert {scene.machine.threads for scene in found.values()} == {1}


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


def test_the_friction_angle_of_smooth_walls_is_left_out_where_walls_are_very_rough():
    found = made("walls.kind=smooth,very-rough", "walls.friction_angle_deg=19")
    assert [scene.walls.friction_angle_deg for scene in found.values()] == [19.0, None]


def test_columns_are_what_was_asked_for_and_what_differs(tmp_path):
    (tmp_path / "loose.toml").write_text(
        "[sand]\nvoid_ratio = 0.9\n[walls]\nkind = 'smooth'\nfriction_angle_deg = 12.3\n"
    )
    (tmp_path / "dense.toml").write_text("")
    found = made("method.cfl=0.2", files=(tmp_path / "loose.toml", tmp_path / "dense.toml"))
    # dense sand is between very rough walls here, of which no half is computed
    columns = {"method.cfl", "sand.void_ratio", "walls.kind", "walls.friction_angle_deg", "silo.half"}
    assert set(differences(found, ["method.cfl"])) == columns


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
        (["silo.width_m=0.2,0.333"], "silo.width_m=0.333: cell size is 0.005 m; it must divide the width of 0.333 m"),
        ([f"sand.{name}=" + ",".join(map(str, range(30))) for name in ("n", "alpha", "beta")], "make 27000 runs"),
        (["sand=" + "a" * 300 + ".toml"], "at most 200 are allowed"),
    ],
)
def test_what_is_not_possible_is_refused_by_path_and_value(texts, sentence):
    with pytest.raises(BadInput, match=sentence):
        made(*texts)


def test_a_bad_file_is_refused_by_its_name(tmp_path):
    (tmp_path / "bad.toml").write_text("[flow]\nspeed_m_per_s = -1\n")
    for file, words in ((tmp_path / "bad.toml", "bad.toml: speed_m_per_s is -1"), (tmp_path / "no.toml", "no.toml")):
        with pytest.raises(BadInput, match=words):
            made(files=(file,))


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
    with pytest.raises(BadInput, match="holds another scene's run; give another folder, or --overwrite it"):
        other.check()
    run.check()
    Run(scene, tmp_path / "nothing").check()


def test_whoever_wants_a_finished_run_again_gets_it_from_the_start(tmp_path):
    """A run that is finished when it is attempted would be left alone."""
    seen = []

    class Nobody(ProcessPool):
        def run(self, tasks, console, ended):
            seen.extend(Run.from_json(task.line)[0] for task in tasks)
            return {}

    run = left(tmp_path / "run", Scene(machine={"threads": 1}))
    simulate({"run": run}, Nobody(1))
    assert seen == [run] and not run.finished and not (run.folder / "forces.csv").exists()


def test_the_table_has_a_row_for_every_run_and_says_why_one_failed(tmp_path):
    found = made("sand.void_ratio=0.6,0.7,0.8")
    runs = {name: Run(scene, tmp_path / name) for name, scene in found.items()}
    first, second, third = runs
    left(tmp_path / first, found[first], warnings=["a", "b"])
    why = {second: "killed"}
    rows = [row(name, run, ["sand.void_ratio"], why.get(name, "")) for name, run in runs.items()]
    table = leave(tmp_path / "batch.csv", rows)
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


def test_an_output_that_cannot_be_written_is_refused_and_leaves_nothing(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="cannot be written"):
        writable(tmp_path / "file" / "batch")
    assert writable(tmp_path / "a" / "b").is_dir()
