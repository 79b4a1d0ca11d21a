"""Speed and displacement that are not given follow the silo, as the cells do."""

import math

import pytest

from taichi_silo.runs.method_choices import outflow
from taichi_silo.scene.dotted_paths import changed
from taichi_silo.scene.known_limits import of_results
from taichi_silo.scene.scene import Flow, Scene
from taichi_silo.scene.silo import Silo


@pytest.mark.parametrize("silo", [{}, {"height_m": 0.1}, {"height_m": 2.0}, {"outlet": {"width_m": 0.05}},
                                  {"section": "round"}, {"width_m": 0.2 * (1.0 + 1e-15)}])  # fmt: skip
@pytest.mark.parametrize("gravity", [9.81, 98.1])
def test_in_a_silo_of_0_2_m_they_stay_2_mm_per_s_and_20_mm(silo, gravity):
    flow = Scene(silo=Silo(**silo), method={"gravity_m_per_s2": gravity}).flow
    assert (flow.speed_m_per_s, flow.displacement_m) == (0.002, 0.02)


@pytest.mark.parametrize(
    ("silo", "speed", "depth"),
    [
        ({"width_m": 6.0, "height_m": 20.0}, 0.011, 0.6),
        ({"width_m": 0.1, "height_m": 0.5}, 0.0014, 0.01),
        ({"width_m": 0.4, "height_m": 1.0, "section": "round"}, 0.0028, 0.04),
        ({"width_m": 40.0, "height_m": 5.0}, 0.028, 0.5),  # wider than high: a tenth of the sand
        ({"width_m": 40.0, "height_m": 5.0, "outlet": {"width_m": 4.0}}, 0.028, 4.0),  # sand of 50 m stands over it
    ],
)
def test_elsewhere_the_speed_goes_with_the_root_of_the_width_and_the_displacement_with_the_width(silo, speed, depth):
    """Equal Froude numbers v / sqrt(g b): inertia is the same share of the weight in silos of every size."""
    scene = Scene(silo=Silo(**silo))
    assert scene.flow.speed_m_per_s == speed
    assert scene.flow.displacement_m == pytest.approx(depth, rel=1e-6)
    model = 0.002 / math.sqrt(9.81 * 0.2)
    assert speed / math.sqrt(9.81 * scene.silo.width_m) == pytest.approx(model, rel=0.04)  # two digits


def test_one_that_is_given_stays_and_the_other_is_chosen():
    silo = Silo(width_m=6.0, height_m=20.0)
    assert Scene(silo=silo, flow=Flow(speed_m_per_s=0.002)).flow == Flow(speed_m_per_s=0.002, displacement_m=0.6)
    assert Scene(silo=silo, flow=Flow(displacement_m=0.02)).flow == Flow(speed_m_per_s=0.011, displacement_m=0.02)


def test_they_are_chosen_anew_for_another_silo_and_stay_in_the_file_of_a_run():
    scene = changed(Scene(), {"silo.width_m": 6.0, "silo.height_m": 20.0})
    assert scene.flow.displacement_m == 0.6
    assert changed(scene, {"silo.width_m": 0.2, "silo.height_m": 0.5}).flow == Flow()
    assert Scene.model_validate(scene.model_dump()) == scene


def test_the_program_says_whose_they_are():
    part = outflow(Scene(silo=Silo(width_m=6.0, height_m=20.0), flow=Flow(displacement_m=0.06)))
    assert part.choice == "11 mm/s, 60 mm"
    assert part.because == (
        "Speed chosen: 0.00143 of the root of gravity and width; displacement as given: 0.01 of the width."
    )


def test_the_default_speed_is_slow_in_every_silo_and_ten_times_it_is_not():
    """In 6 m × 20 m 11 mm/s is as slow as 2 mm/s in the model silo."""
    for silo, fast in (({}, 0.02), ({"width_m": 6.0, "height_m": 20.0}, 0.11)):
        assert not [words for words in of_results(Scene(silo=Silo(**silo))) if "is driven at" in words]
        found = of_results(Scene(silo=Silo(**silo), flow=Flow(speed_m_per_s=fast)))
        assert [words for words in found if f"is driven at {1e3 * fast:g} mm/s" in words]
