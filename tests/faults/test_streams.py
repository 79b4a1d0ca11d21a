"""No listener, a full disk behind standard output, a small code page, no home: a run goes on, and says what it can."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from taichi_silo.runs.result import Result
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from tests.unit.test_program import TINY

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the shell and the devices of POSIX")


def shell(line, folder, **env):
    """Exit code, standard output and error of a line of the shell in which `silo` is the program."""
    program = f"{sys.executable} -m taichi_silo.cli.app"
    given = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), **env}
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", line.replace("silo ", f"{program} ", 1)], cwd=folder, env=given,
        capture_output=True, timeout=200,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr.decode()


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "tiny.toml").write_text(TINY)
    return tmp_path


@pytest.mark.parametrize("ear", ["| head -1", ">&-", "> /dev/full"])
def test_a_run_goes_on_when_nobody_listens(scene, ear):
    code, _, err = shell(f"silo run tiny.toml --no-film --output out {ear}", scene)
    assert (code, err) == (0, "")
    assert len(Result(scene / "out").forces) > 1


def test_a_listener_that_has_seen_enough_is_no_error(scene):
    code, out, err = shell("silo scene | head -1", scene)
    assert (code, err) == (0, "")
    assert out.startswith(b"#")


def test_a_result_that_is_lost_is_an_error(scene):
    code, _, err = shell("silo scene > /dev/full", scene)
    assert code == 1
    assert "No space left on device" in err and err.count("\n") == 1


@pytest.mark.parametrize("page", ["ascii", "cp437", "cp1252", "latin-1"])
def test_a_scene_that_is_printed_to_a_file_is_utf_8_on_any_code_page(scene, page):
    code, _, err = shell("silo scene > whole.toml", scene, PYTHONIOENCODING=page)
    assert (code, err) == (0, "")
    assert read_scene(scene / "whole.toml") == Scene()


def test_words_that_a_code_page_lacks_are_spelt_out(scene):
    code, out, err = shell("silo list", scene, PYTHONIOENCODING="ascii")
    assert (code, err) == (0, "")
    assert out.isascii()


def test_a_process_without_a_home_finds_one(scene):
    code, out, err = shell("unset HOME; silo list", scene)
    assert (code, err) == (0, "")
    assert b"mass_flow" in out


@pytest.mark.parametrize("name", ["run:1", "file:x", "./-dash", "http:[%03d]"])
def test_a_folder_may_have_a_name_that_libraries_read_as_something_else(scene, name):
    code, _, err = shell(f"silo run tiny.toml --quiet --output {name}", scene)
    assert (code, err) == (0, "")
    assert (scene / name / "void_ratio.mp4").stat().st_size > 1000
    assert len(Result(scene / name).forces) > 1
