"""A graphics card that is asked for and not there is told before any work, however the run is begun."""

import pytest

from taichi_silo.mpm import graphics_cards, runtime
from tests.faults.harness import failed

SILO = '[grid]\ncell_size_m = 0.05\n[machine]\narch = "cuda"\n'


@pytest.mark.parametrize("how", ["a scenario", "a scenario's name", "a scene file", "a sweep"])
def test_a_graphics_card_that_is_not_there_is_told_and_nothing_is_written(how, tmp_path, monkeypatch, capsys, tried):
    monkeypatch.setattr(runtime, "has_cuda", lambda: False)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "silo.toml").write_text(SILO)
    words = {
        "a scenario": ["run", "outlet", "--arch", "cuda"],
        "a scenario's name": ["run", "mass_flow", "--arch", "cuda", "--output", "new"],
        "a scene file": ["run", "silo.toml", "--output", "new"],
        "a sweep": ["sweep", "--scene", "silo.toml", "--vary", "sand.void_ratio=0.6,0.7", "--output", "new"],
    }[how]
    if how == "a sweep":
        pytest.importorskip("distributed")
    code, err = failed(monkeypatch, capsys, *words, "--quiet")
    assert (code, err) == (2, "Error: arch is 'cuda' but this machine has no CUDA device; use --arch cpu.")
    assert [file.name for file in tmp_path.iterdir()] == ["silo.toml"]
    tried("faults survived", "graphics card absent though asked for")


def test_vulkan_that_is_not_there_is_told_with_what_to_install(tmp_path, monkeypatch, capsys, tried):
    monkeypatch.setattr(graphics_cards, "vulkan_cards", list)
    monkeypatch.chdir(tmp_path)
    code, err = failed(monkeypatch, capsys, "run", "mass_flow", "--arch", "vulkan", "--quiet")
    assert code == 2
    assert err == f"Error: arch is 'vulkan' but no Vulkan device answers; install {runtime.DRIVERS}, or use --arch cpu."
    assert not any(tmp_path.iterdir())
    tried("faults survived", "graphics card absent though asked for")
