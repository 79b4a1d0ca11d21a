"""Every file in the pages is one that the program takes."""

import tomllib

import pytest
from written import beside, blocks

from taichi_silo.errors import BadInput
from taichi_silo.runs.plugins import load_plugin
from taichi_silo.scene import sands
from taichi_silo.scene.scene_files import scene_of

TOML = [pytest.param(block, id=str(block)) for block in blocks("toml")]


@pytest.mark.parametrize("block", TOML)
def test_a_file_in_the_pages_is_possible(block, tmp_path):
    beside(block, tmp_path)
    file = tmp_path / block.title
    file.write_text(block.text, encoding="utf-8")
    if block.page == "how-to/own-parts.md":
        load_plugin(tmp_path / "my_parts.py")
    if block.title == "silo.toml":
        assert scene_of(tomllib.loads(block.text)).points > 0
    elif block.title == "sand.toml":
        assert sands.sand(str(file), 0.65).void_ratio == 0.65
    else:
        assert block.title == "sweep.toml"
        (tmp_path / "silo.toml").touch()
        from taichi_silo.studies.sweep.plan import read

        assert len(read(file).scenes()) > 1


CSV = [pytest.param(block, id=str(block)) for block in blocks("csv")]


@pytest.mark.parametrize("block", CSV)
def test_measurements_in_the_pages_can_be_read(block, tmp_path):
    from taichi_silo.studies.calibrate.lab_files import read_laboratory
    from taichi_silo.studies.compare.measured import read

    file = tmp_path / block.title
    file.write_text(block.text, encoding="utf-8")
    if block.page == "how-to/calibrate.md":
        found = read_laboratory(file)
        assert found.names == ([] if block.title == "index.csv" else [block.title])
    else:
        assert len(read(file).table) > 1


def test_a_value_that_is_not_possible_is_noticed():
    block = next(one for one in blocks("toml") if one.page == "tutorial.md")
    with pytest.raises((ValueError, BadInput)):
        scene_of(tomllib.loads(block.text.replace('name = "hostun"', 'name = "hostum"')))
