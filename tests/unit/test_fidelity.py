"""Named settings (draft, standard, converged), and scenes with some settings changed."""

import pytest

from taichi_silo.errors import BadInput
from taichi_silo.scene.dotted_paths import changed, known, value
from taichi_silo.scene.fidelity import fidelities, fidelity
from taichi_silo.scene.scene import Scene


def test_a_setting_changes_its_own_value_and_no_other():
    scene = changed(Scene(), {"flow.speed_m_per_s": 0.005, "precision": "f32"})
    assert value(scene, "flow.speed_m_per_s") == 0.005
    assert scene == Scene(flow={"speed_m_per_s": 0.005})
    assert not known("flow.colour") and not known("flow") and known("nudge")
    with pytest.raises(BadInput, match=r"setting is flow\.colour"):
        changed(Scene(), {"flow.colour": 1.0})


def test_every_fidelity_that_comes_along_makes_a_scene_and_others_are_refused():
    assert list(fidelities()) == ["draft", "standard", "converged"]
    points = [changed(Scene(), one.settings).points for one in fidelities().values()]
    assert points == sorted(points)
    assert changed(Scene(), fidelity("standard").settings) == Scene(), "the default"
    with pytest.raises(BadInput, match="fidelity is perfect; it must be one of draft, standard, converged"):
        fidelity("perfect")
