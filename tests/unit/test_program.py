"""The program `taichi-silo`: its commands, what they print, and their exit codes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from taichi_silo.cli import app, catalogue, command_line
from taichi_silo.scene.fidelity import FIDELITIES
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.show.figures import RUN_FIGURES
from tests import made_up

TINY = (
    "[silo]\nwidth_m = 0.1\nheight_m = 0.2\n[grid]\ncell_size_m = 0.05\n[flow]\nspeed_m_per_s = 0.02\n"
    "displacement_m = 0.0005\n[method]\nfilling_time_s = 0.05\nlongest_settling_s = 0.02\n"
    "[machine]\nthreads = 1\nlanes = false\n"
)


def program(*words, cwd=None):
    command = [sys.executable, "-m", "taichi_silo.cli.app", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=200, cwd=cwd)


@pytest.mark.parametrize("name", app.COMMANDS)
def test_the_help_names_every_command_and_each_has_one(said, name):
    assert f" {name} " in said("--help")[1]
    code, out, _ = said(name, "--help")
    assert code == 0 and "Usage: taichi-silo" in out


def test_an_unknown_command_or_flag_is_refused(said):
    assert said("rnu")[0] == 2
    code, _, err = said("list", "--jsn")
    assert (code, err.count("\n")) == (2, 1) and "--jsn" in err


def test_the_list_has_every_scenario_and_sand(said):
    code, out, _ = said("list", "--json")
    found = json.loads(out)
    assert code == 0
    assert set(found["scenarios"]) == {file.stem for file in catalogue.folder().glob("*.py")}
    assert "hostun" in found["sands"]
    assert all(found["scenarios"].values())


def test_the_scene_that_is_printed_is_a_scene(said, tmp_path):
    file = tmp_path / "silo.toml"
    assert said("scene", "--output", file)[0] == 0
    assert read_scene(file) == Scene()
    code, _, err = said("scene", "--output", file)
    assert code == 2 and "is there already" in err
    assert json.loads(said("scene", "--schema")[1])["title"] == "Scene"
    assert said("scene", "--markdown")[1].startswith("## `[silo]`")


def test_a_scene_from_a_file_takes_the_number_of_threads_as_a_scenario_does(said, tmp_path):
    file = tmp_path / "silo.toml"
    file.write_text(TINY.replace("threads = 1\n", ""))
    code, out, _ = said("run", file, "--threads", 1, "--check", "--json")
    assert code == 0
    assert json.loads(out)["scene"]["machine"]["threads"] == 1
    code, _, err = said("run", file, "--threads", 1000, "--check")
    assert code == 2 and "threads is 1000" in err


def test_a_scene_is_checked_without_being_run(said, tmp_path):
    file = tmp_path / "silo.toml"
    file.write_text(TINY)
    code, out, _ = said("run", file, "--check")
    assert code == 0
    assert "8 points" in out
    code, out, _ = said("run", file, "--check", "--json", "--set", "grid.points_per_cell=4")
    assert json.loads(out)["points"] == 32
    assert [each.name for each in tmp_path.iterdir()] == ["silo.toml"]


def test_flags_may_stand_before_a_scene_file_and_nothing_else(said, tmp_path):
    file = tmp_path / "silo.toml"
    file.write_text(TINY)
    for words in (("--check", file), ("--set", "silo.height_m=0.4", file, "--set", "silo.height_m=0.2", "--check")):
        code, out, _ = said("run", *words)
        assert code == 0 and "8 points" in out
    for words in (("--quiet", "outlet"), ("--check",)):
        code, out, err = said("run", *words)
        assert (code, out) == (2, "") and f"begins with {words[0]}; a scenario or a folder stands first" in err
    assert "Usage: taichi-silo run" in said("run", "--quiet", "--help")[1]


def test_a_scenario_is_checked_as_a_file_is(said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, _ = said("run", "mass_flow", "--cell-size", 0.02, "--check", "--json")
    assert code == 0
    assert json.loads(out)["points"] == 250  # 10 x 25 cells
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "right"),
    [
        (("--cell-size", "0.01"), "--set grid.cell_size_m=0.01"),
        (("--speed=0.004",), "--set flow.speed_m_per_s=0.004"),
        (("--quiet", "--half", "no"), "--set silo.half=no"),
        (("--sand", "hostun"), "--set sand.name=hostun"),
        (("--fidelity", "draft"), "--set grid.cell_size_m=... and --set flow.speed_m_per_s=..."),
        (("--walls",), "--set walls.kind=..."),
    ],
)
def test_a_flag_of_scenarios_is_refused_for_a_file_with_what_does_the_same(said, tmp_path, words, right):
    file = tmp_path / "silo.toml"
    file.write_text(TINY)
    code, out, err = said("run", file, *words)
    assert (code, out) == (2, "")
    flag = words[-2 if len(words) > 1 else 0].split("=")[0]
    assert err == f"Error: {flag} is a flag of scenarios, and this is a scene file; give {right}.\n"


def test_every_flag_of_a_silo_scenario_is_one_of_a_scene_file_or_names_its_path(said, tmp_path):
    from typer.main import get_command

    from taichi_silo.cli import catalogue, command_line, flags
    from taichi_silo.cli.commands.run import _own_flags
    from taichi_silo.scene.dotted_paths import known

    own = _own_flags()
    for name in ("mass_flow", "outlet", "hopper", "insert", "gravity_discharge"):
        for one in get_command(command_line.app_of(catalogue.load(name))).params:
            for flag in one.opts:
                path = flags.paths_of_flags().get(flag)
                assert flag in own or flag == "--fidelity" or (path and known(path)) or flag == "--share", (name, flag)


def test_explaining_a_scene_file_names_what_a_scene_file_takes(said, tmp_path):
    file = tmp_path / "silo.toml"
    file.write_text(TINY)
    code, out, _ = said("run", file, "--explain")
    assert code == 0
    assert "--set" in out and "grid.cell_size_m=" in out.replace("\n", "")
    assert "--cell-size" not in out and "--speed" not in out
    assert "--no-film" in out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["run", "outlt"], "did you mean outlet?\n"),
        (["run", "-"], "standard input must be given as /dev/stdin"),
        (["run", "nowhere.toml"], "cannot be read as a scene"),
        (["run", "{file}", "--set", "grid.cell_size_m=0.03"], "must divide the width"),
        (["run", "{file}", "--set", "grid.cel_size_m=0.03"], "did you mean grid.cell_size_m"),
        (["run", "{file}", "--colour"], "--colour"),
        (["run", "mass_flow", "--void-ratio", "9"], "void ratio is 9"),
    ],
)
def test_what_cannot_be_run_is_refused_in_one_sentence(said, tmp_path, words, sentence):
    file = tmp_path / "silo.toml"
    file.write_text(TINY)
    code, out, err = said(*(word.format(file=file) for word in words))
    assert (code, out) == (2, "")
    assert err.startswith("Error: ")
    assert err.count("\n") == 1
    assert sentence in err


def test_a_scene_runs_from_its_file_and_says_where_it_is(tmp_path):
    (tmp_path / "mine.toml").write_text(TINY)
    done = program("run", "mine.toml", "--no-film", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert Path(found["folder"]) == Path("outputs/mine")
    assert found["summary"]["finished"]
    assert (tmp_path / "outputs/mine/forces.csv").exists()
    assert (tmp_path / "outputs/mine/figures/forces.png").exists()
    words = ("--no-film", "--no-figures", "--quiet", "--output", "again")
    again = program("run", "outputs/mine/run.toml", *words, cwd=tmp_path)
    assert (again.returncode, again.stdout) == (0, ""), again.stderr
    assert not (tmp_path / "again/figures").exists()
    assert (tmp_path / "again/forces.csv").read_bytes() == (tmp_path / "outputs/mine/forces.csv").read_bytes()
    there = program("run", "mine.toml", "--output", "again", cwd=tmp_path)
    assert there.returncode == 2
    assert "holds a run already" in there.stderr


def test_a_scenario_has_a_name_and_flags_of_its_own_in_the_program_and_as_a_script(said):
    code, out, _ = said("run", "outlet", "--help")
    assert code == 0
    assert "Usage: taichi-silo run outlet" in out
    script = subprocess.run([sys.executable, catalogue.script("outlet"), "--help"], capture_output=True, text=True)
    assert script.returncode == 0
    assert script.stdout.replace("Usage: outlet.py", "Usage: taichi-silo run outlet") == out


def test_flags_come_from_the_scene(said):
    out = " ".join(said("run", "outlet", "--help")[1].split())
    assert "--height <float> height of the fill above the floor, a hopper included [m] (≥ 0.001, ≤ 1000)" in out
    assert "0.002 in standard fidelity" in out
    assert "19 for dense and 12.3 for loose sand if not given" in out


def test_the_doctor_finds_this_machine_fit(tmp_path):
    done = program("doctor", "--json", "--output", tmp_path / "outputs")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["self-test"]["good"]
    assert found["ffmpeg"]["good"]
    assert not (tmp_path / "outputs").exists(), "it leaves nothing"


def test_the_doctor_ends_with_1_where_nothing_can_be_written(tmp_path):
    (tmp_path / "file").touch()
    done = program("doctor", "--quiet", "--output", tmp_path / "file" / "outputs")
    assert (done.returncode, done.stdout) == (1, "")


def test_a_command_that_returns_a_folder_ends_well(monkeypatch):
    monkeypatch.setattr("sys.argv", ["command"])
    with pytest.raises(SystemExit) as end:
        command_line.command(lambda: Path("outputs") / "run")
    assert end.value.code == 0


def test_the_help_of_sweep_names_every_fidelity(said):
    assert f"{' | '.join(FIDELITIES)}: cell size" in " ".join(said("sweep", "--help")[1].replace("│", " ").split())


def test_a_run_names_each_of_its_figures_at_its_end(tmp_path, capsys):
    made_up.leave(tmp_path / "run")
    for name in RUN_FIGURES:
        (tmp_path / "run" / "figures").mkdir(exist_ok=True)
        (tmp_path / "run" / "figures" / f"{name}.png").touch()
    command_line.tell(tmp_path / "run")
    told = capsys.readouterr().out
    assert not [name for name in RUN_FIGURES if f"figures/{name}.png " not in told]


def test_what_a_run_has_compiled_is_kept_for_the_next(tmp_path):
    (tmp_path / "silo.toml").write_text(
        "[grid]\ncell_size_m = 0.05\n[flow]\nspeed_m_per_s = 0.05\ndisplacement_m = 0.0005\n"
    )
    words = ("run", "silo.toml", "--overwrite", "--quiet", "--no-film", "--no-figures")
    kept = []
    for _ in range(2):
        subprocess.run(
            [sys.executable, "-m", "taichi_silo.cli.app", *words], cwd=tmp_path, check=True,
            env=os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")},
        )  # fmt: skip
        kept.append({file for file in (tmp_path / "cache").rglob("*") if file.is_file()})
    assert kept[0] == kept[1]
    assert len(kept[0]) > 10  # the trial of the vector unit, in a process of its own, leaves fewer
