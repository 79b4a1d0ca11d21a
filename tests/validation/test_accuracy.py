"""The chart: its scenes and dials, errors against the truth, the front, and what it leaves for the named settings."""

import math
from types import SimpleNamespace

import matplotlib.pyplot as plt
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taichi_silo.errors import BadInput
from taichi_silo.scene.fidelity import FIDELITIES, kind
from taichi_silo.studies.converge.quantities import Quantity
from validation.accuracy import dials, scenes, study, table
from validation.accuracy.__main__ import chosen
from validation.accuracy.figures import error_figure
from validation.accuracy.table import FORCES, MEASURES, WORST, Truth, errors, front, with_front

WEIGHT = 1600.0
TRUTH = {name: Truth(700.0, 16.0, "N/m", WEIGHT) for name in FORCES} | {
    "zone_thickness": Truth(0.01, 0.001, "m", math.nan)
}


def found(**values) -> dict[str, Quantity]:
    return {name: Quantity(value, "", math.nan) for name, value in values.items()}


@pytest.mark.parametrize("name", scenes.SCENES)
def test_every_dial_makes_a_scene_and_a_scene_of_the_chart_is_of_its_own_kind(name, tmp_path):
    rows = study.planned([name], list(dials.dials()), tmp_path)
    assert {row.dial for row in rows} >= {dials.BASE_DIAL, dials.FINE, dials.SLOW, dials.NAMED}
    settings = [(row.dial, row.setting) for row in rows]
    assert len(set(settings)) == len(settings), "a dial has a setting twice"
    assert len({row.run.folder for row in rows}) < len(rows), "the base is shared by dials"
    assert kind(rows[0].run.scene) == name


def test_forces_err_over_the_weight_and_a_thickness_over_itself():
    run = found(P_residual=716.0, T_residual=700.0, N_residual=660.0, zone_thickness=0.012)
    told = errors(run, TRUTH)
    assert told["P"] == pytest.approx(16.0 / WEIGHT) and told["T"] == 0.0
    assert told[WORST] == told["N"] == pytest.approx(40.0 / WEIGHT)
    assert told["zone"] == pytest.approx(0.2)
    assert math.isnan(told["wall stress"]), "nothing to compare with"
    assert table.bars(TRUTH)[WORST] == pytest.approx(0.01)


def test_half_way_is_about_the_middle_of_the_displacement_and_not_of_the_filling():
    """Of a force that grows with the displacement it is the half."""
    u = [0.0] * 50 + [1e-4 * step for step in range(201)]
    forces = pd.DataFrame({"displacement_m": u, "stage": ["filling"] * 50 + ["flow"] * 201})
    forces["bottom_force_N_per_m"] = 1e5 * forces["displacement_m"]
    run = SimpleNamespace(forces=forces, scene=scenes.scene("very-rough dense", {}))
    assert study.half_way(run, "P") == pytest.approx(1e3)


NUMBERS = st.floats(0.1, 100.0).map(lambda x: round(x, 1)) | st.just(math.nan)


@given(st.lists(st.tuples(NUMBERS, NUMBERS), max_size=30))
def test_a_run_is_on_the_front_if_and_only_if_no_other_beats_it(pairs):
    best = front([p[0] for p in pairs], [p[1] for p in pairs])

    def beaten(one, other) -> bool:
        return other[0] <= one[0] and other[1] <= one[1] and other != one and not any(map(math.isnan, other))

    for one, on in zip(pairs, best, strict=True):
        sound = not any(map(math.isnan, one))
        assert on == (sound and not any(beaten(one, other) for other in pairs))


def made_up() -> pd.DataFrame:
    """A chart of two scenes: the base, a dial, and the named settings, which err less and less."""
    lines = []
    for scene in ("smooth dense", "very-rough dense"):
        for dial, count in ((dials.BASE_DIAL, 1), ("shape", 3), (dials.NAMED, 4)):
            for number in range(count):
                name = list(FIDELITIES)[number] if dial == dials.NAMED else str(number)
                line = {
                    "scene": scene,
                    "dial": dial,
                    "setting": name,
                    "run": f"{dial}-{number}",
                    WORST: 0.1 / 2**number,
                }
                lines.append(line | dict.fromkeys(MEASURES.values(), 0.01) | {"core_seconds": 4.0**number})
    return with_front(pd.DataFrame(lines))


def test_the_figure_shows_every_scene_and_names_the_settings():
    figure = error_figure(made_up(), {"smooth dense": 1e-3, "very-rough dense": 0.02})
    shown = [panel for panel in figure.axes if panel.get_visible()]
    assert [panel.get_title(loc="left") for panel in shown] == ["smooth dense", "very-rough dense"]
    assert {text.get_text() for text in shown[0].texts} == set(FIDELITIES)
    plt.close(figure)


def test_what_the_named_settings_err_by_is_told_with_how_well_it_is_known():
    told = study.of_fidelities(made_up(), {name: TRUTH for name in ("smooth dense", "very-rough dense")})
    assert list(told) == ["smooth dense", "very-rough dense"]
    assert set(told["smooth dense"]) == set(FIDELITIES)
    assert told["smooth dense"]["draft"] == {"P": 0.01, "T": 0.01, "N": 0.01, "known_to": 0.01}


def test_unknown_scenes_and_dials_are_refused():
    assert chosen("walls", "both", list(scenes.SCENES)) == list(scenes.SCENES)
    assert chosen("walls", "rough", list(scenes.SCENES)) == ["rough dense", "rough loose"]
    with pytest.raises(BadInput, match="walls is round; it must be all, or some of smooth dense"):
        chosen("walls", "round", list(scenes.SCENES))
    with pytest.raises(BadInput, match="dial is weather; it must be all, or some of base"):
        chosen("dial", "weather", list(dials.dials()))
