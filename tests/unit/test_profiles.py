"""Which records the three states of the wall stresses are means of."""

from types import SimpleNamespace

import numpy as np
import pytest

from taichi_silo.runs.observers.wall_profiles import WallProfiles
from taichi_silo.scene.scene import Output, Scene


@pytest.fixture
def after(tmp_path):
    """The states after so many records of filling and of flow, each with its number as every value."""

    def of(filling, flow):
        profiles = WallProfiles(tmp_path / "walls.csv")
        profiles.begin(SimpleNamespace(scene=Scene(output=Output(records_per_period=4)), origin_m=0.0))
        profiles._write = lambda *given: None
        for number in range(filling + flow):
            stage = "filling" if number < filling else "flow"
            profiles.observe(
                SimpleNamespace(
                    stage=stage,
                    interval_s=1.0,
                    profile=np.full((3, 5, 2), float(number)),
                    time_s=float(number),
                    left_normal_N_per_m=1000.0 - number,
                    right_normal_N_per_m=1000.0 - number,
                    displacement_m=0.0,
                )  # fmt: skip
            )
        profiles.end()
        return {name: float(profile.mean()) for name, (_, _, profile) in profiles.states.items()}

    return of


@pytest.mark.parametrize("flow", [20, 27, 39, 40])
def test_the_residual_state_is_the_mean_of_the_last_five_periods_wherever_the_run_ends(after, flow):
    assert after(10, flow)["residual"] == pytest.approx(10 + flow - 10.5)


def test_the_state_after_filling_is_the_mean_of_its_last_period(after):
    assert after(10, 25)["filling"] == pytest.approx(np.mean([6, 7, 8, 9]))
    assert after(10, 0) == {"filling": pytest.approx(7.5)}


def test_the_maximum_is_that_of_a_whole_block_unless_the_flow_is_shorter(after):
    assert after(0, 45)["maximum"] == pytest.approx(np.mean(range(20)))
    assert after(10, 6)["maximum"] == after(10, 6)["residual"] == pytest.approx(12.5)
