"""Scenes at the ends of what is allowed, and calls from Python: they run, and rightly, or are refused in a sentence."""

import numpy as np
import pytest

from taichi_silo import api
from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene, scene_of
from taichi_silo.simulation.simulation import Simulation
from tests.faults import bad
from tests.faults.bad import CIRCLE, SQUARE, refusal, turned
from tests.smallest import TABLES

STEPS_MOST = 3000


def runs(scene, intervals=4):
    """A few intervals: forces finite and in balance, or a sentence of what went wrong. False if it takes too long."""
    runtime.init()
    simulation = Simulation(scene)
    step = scene.method.time_step(simulation.solver.point_sums(), 0.95)
    if simulation.model.interval * intervals / step > STEPS_MOST or scene.points > 20_000:
        return False
    try:
        for _, record in zip(range(intervals), simulation.run(), strict=False):
            forces = [record.bottom_N_per_m, record.left_shear_N_per_m, record.right_shear_N_per_m]
            forces += [upwards for _, upwards in record.bodies_N_per_m.values()]
            assert np.isfinite(forces).all()
            rest = record.weight_N_per_m + record.momentum_rate_N_per_m - record.noise_control_force_N_per_m
            scale = max(map(abs, [*forces, record.weight_N_per_m, record.momentum_rate_N_per_m, 1e-12]))
            assert abs(sum(forces) - rest) < 1e-9 * scale
    except RunFailed as error:
        assert 10 < len(str(error)) < 1000 and "\n" not in str(error)
    return True


EXTREMES = [  # ends of what is allowed
    {"sand.granular_hardness_Pa": 1e5}, {"sand.granular_hardness_Pa": 1e12}, {"sand.n": 0.01}, {"sand.n": 0.99},
    {"sand.alpha": 0.001}, {"sand.beta": 20}, {"sand.grain_density_kg_per_m3": 10}, {"sand.e_i0": 10},
    {"sand.grain_density_kg_per_m3": 1e5}, {"sand.critical_friction_angle_deg": 5}, {"sand.void_ratio": 0.5100001},
    {"sand.critical_friction_angle_deg": 80}, {"sand.void_ratio": 1.2999}, {"method.gravity_m_per_s2": 0.01},
    {"method.gravity_m_per_s2": 1e4}, {"method.cfl": 2}, {"method.time_step_s": 1}, {"method.mass_scaling": 1e6},
    {"method.filling_time_s": 1e-6}, {"flow.speed_m_per_s": 1}, {"flow.speed_m_per_s": 1e-9},
    {"flow.displacement_m": 1e-9}, {"flow.displacement_m": 0.4}, {"walls.bottom_friction_angle_deg": 89.999999},
    {"walls.kind": "smooth", "walls.friction_angle_deg": 89.9999}, {"filling.kind": "layers", "filling.layers": 1000},
    {"filling.kind": "rain", "filling.drop_m": 0}, {"filling.kind": "rain", "filling.drop_m": 0.4},
    {"grid.points_per_cell": 100}, {"averaging.characteristic_length_m": 0.2}, {"sand.d50_m": 1e-7},
    {"output.records_per_period": 100}, {"sand.law": "intergranular", "sand.intergranular.radius": 1e-7},
    {"sand.law": "intergranular", "sand.intergranular.chi": 100}, {"sand.name": "🙂 <b>$\\frac"},
    {"silo.outlet.width_m": 0.1, "flow.outflow": "gravity", "flow.longest_s": 1e6},
    {"silo.hopper": {"half_angle_deg": 79.9, "outlet_width_m": 0.1}},
    {"silo.outlet.width_m": 0.1, "silo.inserts": [{"kind": "roof", "width_m": 1e-4, "bottom_m": 1e-9}]},
    {"silo.inserts": [{"kind": "polygon", "corners_m": turned(SQUARE[::-1] + SQUARE[:1])}]},
    {"silo.inserts": [{"kind": "polygon", "corners_m": turned(CIRCLE)}]},
    {"silo.width_m": 0.001, "silo.height_m": 0.002, "grid.cell_size_m": 0.00025, "flow.displacement_m": 1e-4},
    {"silo.width_m": 1000.0, "silo.height_m": 1000.0, "grid.cell_size_m": 100.0},
]  # fmt: skip


def extreme(changes):
    tables = bad.changed(TABLES, changes)
    if "sand.name" in changes:
        return Scene.model_validate(tables)
    return scene_of(tables)


def runs_or_is_refused(changes):
    words = refusal(lambda: extreme(changes))
    return "refused" if words else "run" if runs(extreme(changes)) else "not run"


@pytest.mark.parametrize("number", [38])
def test_scenes_at_the_ends_of_what_is_allowed_run(number, tried):
    assert runs_or_is_refused(EXTREMES[number]) == "run"
    tried("inputs run", "a scene at the ends of what is allowed")


@pytest.mark.long
@pytest.mark.parametrize("number", range(len(EXTREMES)))
def test_all_scenes_at_the_ends_of_what_is_allowed_run_or_are_refused(number, tried):
    if runs_or_is_refused(EXTREMES[number]) == "run":
        tried("inputs run", "a scene at the ends of what is allowed")


# --- from Python ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "scene",
    [None, 3, "scene.toml", [], object(), {"silo": 3}, {1: 2}, {"a" * 10**6: {}}, {"silo": {"width_m": object()}}],
    ids=range(9),
)
def test_what_is_no_scene_is_refused_by_run(scene, tmp_path, tried):
    words = refusal(lambda: api.run(scene, tmp_path / "run", progress=False))
    assert words and not list(tmp_path.iterdir())
    tried("inputs refused", "a call of run with what is no scene")


def test_a_scene_that_was_changed_without_being_checked_is_refused(tmp_path, tried):
    good = Scene.model_validate(TABLES)
    changed = [
        good.model_copy(update={"flow": good.flow.model_copy(update={"speed_m_per_s": -1.0})}),
        good.model_copy(update={"silo": good.silo.model_copy(update={"width_m": 0.21})}),
        good.model_copy(update={"silo": None}),
        good.model_copy(update={"machine": "cpu"}),
    ]
    for scene in changed:
        assert refusal(lambda scene=scene: api.run(scene, tmp_path / "run", progress=False))
    assert not list(tmp_path.iterdir())
    tried("inputs refused", "a call of run with what is no scene", len(changed))


@pytest.mark.parametrize(
    "folder", [3, "a\x00b", "x" * 5000, "~nobody-of-this-name/run", "\ud800\ud800", [], b"\xff"], ids=range(7)
)
def test_what_is_no_path_is_refused(folder, tmp_path, monkeypatch, tried):
    monkeypatch.chdir(tmp_path)
    assert refusal(lambda: api.run(Scene.model_validate(TABLES), folder, progress=False))
    assert refusal(lambda: api.resume(folder, progress=False))
    assert refusal(lambda: read_scene(folder))
    assert not list(tmp_path.iterdir())
    tried("inputs refused", "a path that can be none", 3)


def test_what_is_no_observer_is_refused(tmp_path, tried):
    assert refusal(lambda: api.run(TABLES, tmp_path / "run", progress=False, extra=(3,)))
    assert not list(tmp_path.iterdir())
    tried("inputs refused", "a call of run with what is no observer")
