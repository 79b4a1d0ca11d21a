"""Every command line in the pages is one that the program takes."""

import re
import shlex
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer
from typer.main import get_command
from written import beside, blocks

from taichi_silo import api
from taichi_silo.cli import app, catalogue, command_line
from taichi_silo.cli.commands.run import scene_file
from taichi_silo.runs.plugins import load_plugin
from taichi_silo.scene import known_limits, likely_units
from taichi_silo.scene.scene import Scene

LINES = [
    pytest.param(block, shlex.split(line, comments=True)[1:], id=f"{block} {line}")
    for block in blocks("console", "bash")
    for line in block.text.splitlines()
    if line.startswith("taichi-silo ")
]


def command_of(function):
    return get_command(command_line.app_of(function))


def parse(command, words):
    with command.make_context("taichi-silo", list(words)):
        pass


def parted(words):
    """The files of plugins, the command and the rest of a command line."""
    ordered, files = app.plugins_first(words), []
    while ordered[0] == app.PLUGIN:
        files.append(ordered[1])
        ordered = ordered[2:]
    return files, ordered[0], ordered[1:]


@pytest.fixture
def wanted(monkeypatch):
    """Scenes that scenarios would have run."""
    scenes = []
    monkeypatch.setattr(api, "run", lambda scene, folder, **_: scenes.append(scene) or SimpleNamespace(folder=folder))
    monkeypatch.setattr(command_line, "tell", lambda *_: None)
    return scenes


@pytest.mark.parametrize(("block", "words"), LINES)
def test_a_command_line_is_one_that_the_program_takes(block, words, wanted, tmp_path, monkeypatch):
    beside(block, tmp_path)
    monkeypatch.chdir(tmp_path)
    plugins, name, rest = parted(words)
    for file in plugins:
        load_plugin(file)
    assert name in app.COMMANDS
    if name != "run":
        parse(get_command(app.make()).commands[name], rest)
        return
    what, *rest = rest
    if what.endswith(".toml"):
        parse(command_of(scene_file), [what, *rest])
        return
    command = command_of(catalogue.load(what))
    if any(one.name == "explain" for one in command.params):  # of a silo
        command.main(rest, standalone_mode=False)  # values are checked as well
        assert "--explain" in rest or isinstance(wanted[0], Scene)
    else:
        parse(command, rest)


def test_a_flag_that_does_not_exist_is_noticed(wanted):
    with pytest.raises(typer.BadParameter.__base__):
        parse(command_of(scene_file), ["silo.toml", "--no-such-flag"])
    with pytest.raises(ValueError, match="kind|walls"):
        command_of(catalogue.load("mass_flow")).main(["--walls", "slippery"], standalone_mode=False)


def test_what_the_pages_show_of_a_run_s_parts_is_what_it_says(capsys):
    command_of(catalogue.load("mass_flow")).main(["--walls", "smooth", "--explain"], standalone_mode=False)
    said = capsys.readouterr().out
    shown = next(one for one in blocks("text") if one.page == "how-to/explain.md").text
    assert shown.split() == said[said.index(" part ") :].split()


def test_the_silo_of_the_tutorial_is_possible(tmp_path, monkeypatch, capsys):
    block = next(one for one in blocks("toml") if one.page == "tutorial.md")
    beside(block, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["taichi-silo", "run", "silo.toml", "--check"])
    with pytest.raises(SystemExit) as ended:
        app.main()
    assert not ended.value.code
    possible, few, cost = capsys.readouterr().out.splitlines()
    assert "8 cells wide" in few and possible == "silo.toml is a possible scene: 3,466 points, 1327 N/m of sand"
    assert re.fullmatch(r"3,466 points, about [\d,]+ steps: some \d+:\d\d minutes of stepping", cost)


def test_nothing_speaks_against_the_silo_of_the_readme():
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    scene = Scene.model_validate(tomllib.loads(re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1]))
    assert not [*known_limits.of_method(scene), *likely_units.of_scene(scene)]


def test_the_tutorial_has_its_commands_in_an_order_that_works():
    said = [line.values[1][0] for line in LINES if line.values[0].page == "tutorial.md"]
    assert said == ["doctor", "run", "run", "compare", "run", "run", "compare", "report"]
