"""How a run ends is said, and who follows the advice is rid of what it is about."""

import json

import pytest

from taichi_silo import run
from taichi_silo.runs.flow_findings import flow_findings
from taichi_silo.scene import known_limits
from taichi_silo.scene.scene import Flow
from taichi_silo.scene.silo import Outlet, Silo
from taichi_silo.scene.walls import Walls
from taichi_silo.show.report.trust import verdict
from taichi_silo.simulation import filling
from tests.smallest import SMALLEST, smallest

pytestmark = pytest.mark.usefixtures("bare")
FREE = Flow(outflow="gravity", displacement_m=2.0, longest_s=5.0)


def ended(folder, scene):
    """Summary, log and verdict of a run."""
    result = run(scene, folder, film=False, progress=False)
    return json.loads((folder / "summary.json").read_text()), (folder / "run.log").read_text(), verdict(result)


def test_a_free_outflow_that_jams_is_named_everywhere(tmp_path):
    """An outlet of two cells passes next to nothing, as its edges hold 1.7 cells of sand."""
    narrow = smallest(silo=Silo(width_m=0.2, height_m=0.1, outlet=Outlet(width_m=0.1)), flow=FREE)
    summary, log, said = ended(tmp_path / "narrow", narrow)
    assert summary["ledger"]["outflow_ended"] == "jam"
    (sentence,) = [words for words in summary["warnings"] if words.startswith("The flow has jammed")]
    assert "% of the sand stays in the silo and bridges the outlet" in sentence and "a wider outlet help" in sentence
    assert f"warning: {sentence}" in log and "ends: the flow has jammed; " in log
    assert said.title == "The flow has jammed" and said.level == "care"
    assert said.words.lower().startswith(sentence.lower().removeprefix("the flow has jammed: "))


def test_a_gate_that_the_sand_does_not_follow_is_named_everywhere_and_makes_no_flow_pattern(tmp_path):
    """Through a cone's outlet of two cells next to nothing passes."""
    silo = Silo.polygon([(0.15, 0), (0.25, 0), (0.4, 0.2), (0.4, 0.3), (0, 0.3), (0, 0.2)], section="round")
    walls, flow = Walls(kind="smooth", friction_angle_deg=22.5), Flow(speed_m_per_s=0.04, displacement_m=0.02)
    summary, log, said = ended(tmp_path / "narrow", smallest(silo=silo, walls=walls, flow=flow))
    (sentence,) = [words for words in summary["warnings"] if words.startswith("The flow has jammed")]
    assert "the gate has sunk by 20 mm" in sentence and "bridges the outlet; the outlet is 2 cells wide" in sentence
    assert summary["ledger"]["outflow_ended"] == "jam" and "flow_pattern" not in summary
    assert f"warning: {sentence}" in log and "ends: the flow has jammed; " in log
    assert said.title == "The flow has jammed" and said.level == "care"
    assert said.words.lower().startswith(sentence.lower().removeprefix("the flow has jammed: "))


def test_sand_that_jams_flows_through_the_wider_outlet_that_is_advised(tmp_path):
    """One of six cells."""
    wide = smallest(silo=Silo(width_m=0.4, height_m=0.1, outlet=Outlet(width_m=0.3)), flow=FREE)
    summary, log, said = ended(tmp_path / "wide", wide)
    assert summary["ledger"]["outflow_ended"] in ("empty", "rest")
    assert "jammed" not in log + said.title + json.dumps(summary)


def test_sand_that_was_not_at_rest_before_the_flow_comes_to_rest_with_the_time_that_is_advised(tmp_path, monkeypatch):
    monkeypatch.setattr(filling, "LONGEST_SETTLING_PERIODS", 0)
    summary, _, said = ended(tmp_path / "hasty", SMALLEST)
    assert not summary["certificate"]["settled_before_flow"]
    assert "at rest before flow (a greater method.longest_settling_s lets it come to rest)" in said.words
    summary, _, said = ended(tmp_path / "patient", smallest(method={"longest_settling_s": 30.0}))
    assert summary["certificate"]["settled_before_flow"] and "at rest" not in said.words


def test_a_gate_that_has_hardly_sunk_makes_no_flow_pattern(monkeypatch):
    """All sand sinks a little while it loosens: that is no mass flow."""
    outlet = Silo(outlet=Outlet(width_m=0.1))
    short, long = (smallest(silo=outlet, flow=Flow(speed_m_per_s=0.04, displacement_m=way)) for way in (0.0045, 0.0055))
    few, words = known_limits.of_method(short)
    assert "2 cells wide" in few and "4.5 mm" in words and "(5 mm)" in words and "no flow pattern" in words
    assert known_limits.of_method(long) == [few]
    assert known_limits.has_pattern(smallest(flow=Flow(displacement_m=1e-4))), "a floor that sinks takes all sand along"
    for name in ("since_filling", "zones_inside"):
        monkeypatch.setattr(f"taichi_silo.runs.flow_findings.{name}", lambda *states: {})
    for scene, has in ((short, False), (long, True)):
        found = flow_findings({}, *sinking(scene), scene)
        assert ("flow_pattern" in found, "residence" in found) == (has, has)


def sinking(scene):
    """Two states of sand that sinks as a block, the second at the end of the flow."""
    import numpy as np

    x, y = np.meshgrid(np.linspace(0.01, 0.19, 10), np.linspace(0.01, 0.39, 20))
    way = scene.flow.displacement_m
    for part in (0.9, 1.0):
        gone = part * way
        yield {
            "position": np.column_stack([x.ravel(), y.ravel() - 0.5 * gone]), "identity": np.arange(x.size),
            "volume": np.full(x.size, 4e-4), "mass": np.full(x.size, 0.6), "time_s": part * 0.1, "sunk_m": 0.0,
            "displacement_m": gone, "left_m2": 0.1 * gone,
        }  # fmt: skip
