"""Each alarm is raised by the wrongness that it is for, with time, place, point, cause and remedy; by nothing else."""

import contextlib
import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
import shapely

from taichi_silo import Flow, Machine, Mesh, Method, RunFailed, Scene, Silo, run
from taichi_silo.mpm import runtime
from taichi_silo.runs.alarms import of_points as of_points
from taichi_silo.runs.alarms import of_records as of_records
from taichi_silo.runs.observers import Observer, guard
from taichi_silo.runs.observers.guard import Guard
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.scene import Filling, Walls
from taichi_silo.scene.silo import Hopper, Insert, Outlet
from taichi_silo.simulation.alarm import Alarm, Alarms
from taichi_silo.simulation.clock import OPENED, Clock, Interval
from taichi_silo.simulation.simulation import Simulation
from tests.faults.harness import assert_finite

SCENE = Scene(
    silo=Silo(height_m=0.4), grid=Mesh(cell_size_m=0.05), walls=Walls(kind="smooth", friction_angle_deg=19.0),
    flow=Flow(speed_m_per_s=0.01, displacement_m=0.004),
    method=Method(filling_time_s=0.1, longest_settling_s=0.1), machine=Machine(threads=1),
)  # fmt: skip

pytestmark = pytest.mark.usefixtures("quick")


class Spoiler(Observer):
    """Changes the points, or what the next record says, once in the middle of the flow."""

    def __init__(self, change):
        self.change, self.done = change, False

    def begin(self, simulation):
        self.simulation = simulation

    def observe(self, record):
        if record.stage == "flow" and record.displacement_m > 0.001 and not self.done:
            self.done = True
            arrays = self.simulation.model.particles.arrays()
            self.change(arrays, self.simulation)
            self.simulation.model.particles.load(arrays)


def set_(name, index, value):
    def change(arrays, simulation):
        arrays[name][index] = value

    return change


def compact(arrays, simulation):
    arrays["volume"] *= 1.0 - 0.02 / 1.6


def sink_into_wall(arrays, simulation):
    arrays["position"][5, 0] = -0.6 * simulation.scene.grid.cell_size_m


SPOILT = {  # name of the alarm: what is done, words in its sentence, whether it stops the run
    "not finite": (set_("stress", 7, np.nan), "are not finite", True),
    "outside the grid": (set_("position", 7, [5.0, -3.0]), "left the silo", True),
    "void ratio": (set_("volume", 7, 0.0025 * 1.40 / 1.60), "denser than any packing", True),
    "outside the walls": (sink_into_wall, "beyond the walls, the farthest", True),
    "ratcheting": (compact, "has lost 0.0", False),
}


@pytest.fixture
def often(monkeypatch):
    """Looks at all points in every record: these runs are short, and a wall pushes back what is in it."""
    monkeypatch.setattr(guard, "EVERY_PERIODS", 0.1)


def alarmed(folder, scene, *extra, stops):
    if stops:
        with pytest.raises(RunFailed):
            run(scene, folder, film=False, extra=extra)
    else:
        run(scene, folder, film=False, extra=extra)
    assert_finite(folder)
    assert len(pd.read_csv(folder / "forces.csv")) > 3
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["finished"] != stops
    log = (folder / "run.log").read_text()
    for alarm in summary["alarms"]:
        assert f"alarm: {alarm['name']}" in log and alarm["sentence"] in log
        assert summary["failure"] == alarm["sentence"] if alarm["stops"] else True
    return {alarm["name"]: alarm for alarm in summary["alarms"]}


@pytest.mark.parametrize("name", SPOILT)
def test_wrongness_raises_its_alarm_with_time_place_point_cause_and_remedy(tmp_path, request, tried, name):
    if name in ("outside the walls", "ratcheting"):
        request.getfixturevalue("often")
    change, words, stops = SPOILT[name]
    spoiler = Spoiler(change)
    alarm = alarmed(tmp_path / "run", SCENE, spoiler, stops=stops)[name]
    assert spoiler.done and alarm["stops"] == stops
    assert words in alarm["sentence"]
    assert alarm["stage"] == "flow" and 0.001 < alarm["displacement_m"] < 0.004
    assert f"at t = {alarm['time_s']:.4f} s (flow, u = " in alarm["sentence"]
    assert alarm["cause"] in alarm["sentence"] and alarm["remedy"] in alarm["sentence"] and alarm["remedy"]
    assert alarm["point"] is not None and np.isfinite([alarm["x_m"], alarm["y_m"]]).all()
    assert f"(point {alarm['point']})" in alarm["sentence"]
    tried("alarms fired", name)


def test_a_step_above_the_stable_one_raises_an_alarm_as_the_stress_rises(tmp_path, tried):
    """A step that was given does not follow: right at first, too long once the sand bears its weight."""
    method = SCENE.method.model_copy(update={"time_step_s": 4.5e-4})
    alarm = alarmed(tmp_path / "run", SCENE.model_copy(update={"method": method}), stops=True)["time step"]
    assert alarm["value"] > alarm["limit"] == 1.5 and alarm["time_s"] > 0.02
    assert "the time step was given" in alarm["cause"] and "let it be chosen" in alarm["remedy"]
    tried("alarms fired", "time step")


def test_a_nan_in_one_point_names_that_point_and_where_it_was_filled_in(tmp_path):
    alarm = alarmed(tmp_path / "run", SCENE, Spoiler(set_("position", 7, np.nan)), stops=True)["not finite"]
    assert alarm["point"] in range(32) and 0.0 < alarm["x_m"] < 0.2 and 0.0 < alarm["y_m"] < 0.4


# --- what a run cannot be brought to without a defect of the program ------------------------------------------------


@pytest.fixture
def simulation(quick):
    return quick(SCENE)


def guarded(simulation, **changes):
    """The alarms that records with these values raise, over two periods."""
    one = Guard()
    one.begin(simulation)
    record = next(simulation.fill())
    try:
        for _ in range(2 * simulation.scene.output.records_per_period):
            one.observe(dataclasses.replace(record, **changes))
    except RunFailed:
        pass
    return simulation.alarms.found


def test_forces_that_do_not_balance_raise_an_alarm(simulation, tried):
    weight = SCENE.weight_N_per_m
    assert not guarded(simulation, momentum_rate_N_per_m=0.0, bottom_force_N_per_m=0.0, weight_N_per_m=0.0,
                       left_shear_N_per_m=0.5e-6 * weight, right_shear_N_per_m=0.0,
                       noise_control_force_N_per_m=0.0)  # fmt: skip
    found = guarded(simulation, bottom_force_N_per_m=2e-6 * weight, momentum_rate_N_per_m=0.0, weight_N_per_m=0.0,
                    left_shear_N_per_m=0.0, right_shear_N_per_m=0.0, noise_control_force_N_per_m=0.0)  # fmt: skip
    assert set(found) == {"force balance"} and "out of balance by 0.00" in found["force balance"].sentence
    tried("alarms fired", "force balance")


def test_a_balance_that_is_no_number_raises_it_too(simulation):
    assert set(guarded(simulation, bottom_force_N_per_m=np.nan)) == {"force balance"}


def test_a_point_as_fast_as_no_sand_raises_an_alarm(simulation, tried):
    arrays = simulation.model.particles.arrays()
    arrays["velocity"][7] = [0.0, 60.0]
    simulation.model.particles.load(arrays)
    found = guarded(simulation, speed_m_per_s=60.0, stable_step_s=1.0)  # its step is not what this is about
    assert "moves at 60.0 m/s" in found["speed"].sentence and found["speed"].x_m is not None
    tried("alarms fired", "speed")


def test_sand_looser_than_any_packing_raises_an_alarm(simulation, tried):
    found = guarded(simulation, void_ratio_high=1.01 * SCENE.sand.e_i0)
    assert "looser than any packing" in found["void ratio"].sentence
    tried("alarms fired", "void ratio too high")


def test_a_fill_that_falls_apart_raises_an_alarm(simulation, tried):
    found = guarded(simulation, stage="flow", separated=20)
    assert "20 of 32 points carry no stress" in found["separation"].sentence
    tried("alarms fired", "separation")


def test_outflow_that_is_not_quasi_static_though_asked_to_be_raises_an_alarm(tmp_path, often, tried):
    """At 0.2 m/s the inertia of sheared sand counts."""
    scene = SCENE.model_copy(update={"flow": Flow(speed_m_per_s=0.2, displacement_m=0.04), "walls": Walls()})
    alarms = alarmed(tmp_path / "run", scene, stops=False)
    assert alarms["inertia"]["value"] > 1e-2 and alarms["inertia"]["remedy"] == "a smaller flow.speed_m_per_s helps"
    assert "inertia" in json.dumps(json.loads((tmp_path / "run" / "summary.json").read_text())["warnings"])
    tried("alarms fired", "inertia")


def test_who_lets_the_sand_out_more_slowly_is_rid_of_the_inertia(tmp_path, often):
    scene = SCENE.model_copy(update={"flow": Flow(speed_m_per_s=0.02, displacement_m=0.004), "walls": Walls()})
    run(scene, tmp_path / "run", film=False)
    assert "alarms" not in json.loads((tmp_path / "run" / "summary.json").read_text())


def test_an_advice_names_what_the_scene_can_change():
    """A step that was given follows no cfl, and a noise control that is on cannot be switched on."""
    given = SCENE.model_copy(update={"method": Method(time_step_s=1e-4)})
    assert of_records.smaller_step(given) == "a smaller method.time_step_s than 0.0001 s, or none, helps"
    assert of_records.smaller_step(SCENE) == "method.cfl = 0.2 helps"
    small = SCENE.model_copy(update={"method": Method(cfl=0.1, noise_control="none")})
    assert of_records.smaller_step(small) == "a smaller method.cfl than 0.1 helps"
    assert of_records.quieter(small).endswith('method.noise_control = "column"') and not of_records.quieter(SCENE)


def test_sand_that_moves_otherwise_than_its_outlet_raises_an_alarm(quick, simulation, tried):
    rigid = 0.5 * simulation.model.mass * SCENE.flow.speed_m_per_s**2
    still = {"stage": "flow", "separated": 0, "kinetic_gain_J_per_m": 0.0}
    assert not guarded(simulation, **still, kinetic_energy_J_per_m=4.9 * rigid)
    found = guarded(quick(SCENE), **still, kinetic_energy_J_per_m=5.1 * rigid)
    assert found["not quasi-static"].value > found["not quasi-static"].limit and not found["not quasi-static"].stops
    tried("alarms fired", "not quasi-static")


# --- the books of energy ---------------------------------------------------------------------------------------------


def test_a_step_beyond_the_stable_one_makes_energy_of_nothing(tmp_path, monkeypatch, tried):
    """If nobody looked at the step itself: energy tells long before a speed that no sand has."""
    monkeypatch.setattr(of_records, "LONGEST_STEP", np.inf)
    method = SCENE.method.model_copy(update={"time_step_s": 9e-4})
    alarm = alarmed(tmp_path / "run", SCENE.model_copy(update={"method": method}), stops=True)["energy"]
    assert alarm["value"] > alarm["limit"] > 0.0 and "makes energy of nothing" in alarm["sentence"]
    assert alarm["point"] is not None
    assert alarm["remedy"] == "a smaller method.time_step_s than 0.0009 s, or none, helps"
    run(SCENE, tmp_path / "chosen", film=False)
    assert "alarms" not in json.loads((tmp_path / "chosen" / "summary.json").read_text())
    tried("alarms fired", "energy")


def test_work_is_weight_times_way_and_sand_gains_no_more_motion_than_that():
    runtime.init()
    free = Scene(silo=Silo(outlet=Outlet(width_m=0.1)), grid=SCENE.grid, walls=SCENE.walls, machine=SCENE.machine)
    simulation = Simulation(free)
    simulation.clock.begin_flow()
    before = simulation.points()
    records = [simulation.advance(Interval(1e-3, plate_velocity=(OPENED, OPENED))) for _ in range(20)]
    after = simulation.points()
    gain, work = (sum(getattr(r, name) for r in records) for name in ("kinetic_gain_J_per_m", "work_J_per_m"))
    sunk = before["position"][:, 1] - after["position"][:, 1]
    assert work == pytest.approx(9.81 * (after["mass"] * sunk).sum(), rel=1e-9)
    assert gain == pytest.approx(0.5 * (after["mass"] * (after["velocity"] ** 2).sum(axis=1)).sum(), rel=1e-9)
    assert 0.0 < gain < work


@pytest.mark.parametrize(
    "silo",
    [pytest.param(Silo(half="no"), marks=pytest.mark.long), Silo(half="yes"), Silo(section="round", width_m=0.2)],
)
def test_work_of_a_sinking_bottom_is_weight_less_bottom_force_times_its_way(silo):
    runtime.init()
    scene = SCENE.model_copy(update={"silo": silo, "walls": Walls()})
    simulation = Simulation(scene)
    filled = list(simulation.fill())
    assert sum(r.work_J_per_m for r in filled) > 0.0, "sand settles under its weight"
    flow = list(simulation.flow())
    work = sum(r.work_J_per_m for r in flow)
    way = [r.displacement_m for r in flow]
    steps = np.diff([0.0, *way])
    lost = sum((r.weight_N_per_m - r.bottom_N_per_m) * step for r, step in zip(flow, steps, strict=True))
    points = simulation.points()
    assert work < lost, "sand that hangs on rough walls sinks less than the bottom"
    assert work > 0.1 * lost and len(points["mass"])


# --- when they come, and what is kept of them -------------------------------------------------------------------------


def test_an_alarm_that_comes_again_is_counted_and_said_once():
    now = Clock(time=0.1, stage="flow", displacement=0.001)
    alarms, one = Alarms(), Alarm("inertia", False, "it is fast{place}", "why", "what", 2.0, 1.0).at((0.1, 0.2), 4)
    assert alarms.enter(one, now) is True
    now.time = 0.3
    assert alarms.enter(one, now) is False
    (kept,) = alarms.state()
    assert (kept["times"], kept["time_s"], kept["last_time_s"]) == (2, 0.1, 0.3)
    assert kept["sentence"].startswith("at t = 0.1000 s (flow, u = 1.000 mm) it is fast near x = 100.0 mm, y = 200")
    again = Alarms(json.loads(json.dumps(alarms.state())))
    assert again.found == alarms.found


def test_the_step_adapts_as_the_stress_rises(simulation):
    """While the weight grows, sand stiffens a thousandfold; each interval takes the step that its own stress allows."""
    records = list(simulation.fill())
    steps = [r.time_step_s for r in records]
    assert steps[0] > 5.0 * steps[-1] or records[0].stable_step_s > 5.0 * records[-1].stable_step_s
    assert max(r.time_step_s / r.stable_step_s for r in records) < of_records.LONGEST_STEP


def test_after_a_sudden_stress_the_next_interval_has_a_smaller_step(simulation):
    *_, before = simulation.fill()
    arrays = simulation.model.particles.arrays()
    simulation.model.particles.load(arrays | {"stress": 16.0 * arrays["stress"]})
    after = simulation.advance(Interval(simulation.model.interval))
    assert after.time_step_s < 0.6 * before.time_step_s
    assert after.time_step_s < of_records.LONGEST_STEP * after.stable_step_s


SILENT = {
    "smooth": {},
    "very rough": {"walls": Walls()},
    "loose": {"walls": Walls(), "sand": Sand(void_ratio=0.9)},
    "outlet": {"silo": Silo(outlet=Outlet(width_m=0.1)), "walls": Walls()},
    "beside the wall": {"silo": Silo(outlet=Outlet(width_m=0.1, position="left"))},
    "hopper": {"silo": Silo(hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.1))},
    "insert": {"silo": Silo(outlet=Outlet(width_m=0.1), inserts=(Insert(kind="roof", width_m=0.06, bottom_m=0.2),))},
    "round": {"silo": Silo(section="round", width_m=0.2)},
    "rain": {"silo": Silo(height_m=0.2), "filling": Filling(kind="rain", drop_m=0.1), "grid": Mesh(cell_size_m=0.025),
        "method": Method(longest_settling_s=2.0),
    },
    "layers": {"filling": Filling(kind="layers", layers=4)},
    "free outflow": {
        "silo": Silo(outlet=Outlet(width_m=0.12), height_m=0.3), "grid": Mesh(cell_size_m=0.02),
        "flow": Flow(outflow="gravity", displacement_m=2.0, longest_s=0.4),
    },
}  # fmt: skip
OFTEN = ("smooth", "very rough", "round")  # each has kernels of its own; the others with `make test-long`


@pytest.mark.parametrize(
    "name", [name if name in OFTEN else pytest.param(name, marks=pytest.mark.long) for name in SILENT]
)
def test_a_run_with_which_nothing_is_wrong_raises_none(name, often, tried):
    """Every kind of silo, looked at in every record: nothing is near a limit that it must not reach."""
    runtime.init()
    flow = Flow(speed_m_per_s=0.005, displacement_m=0.002)
    simulation = Simulation(SCENE.model_copy(update={"flow": flow} | SILENT[name]))
    one = Guard()
    one.begin(simulation)
    for record in simulation.fill():
        one.observe(record)
    one.filled()
    for record in simulation.flow():
        one.observe(record)
    assert simulation.alarms.found == {}
    tried("loads held", "kinds of silo without an alarm")


def test_the_space_for_sand_is_the_silo_the_opening_and_what_is_above():
    scene = SCENE.model_copy(update={"silo": SILENT["insert"]["silo"]})
    space = of_points.space(scene)

    def holds(x, y):
        return bool(shapely.contains_xy(space, x, y))

    assert holds(0.1, 0.1) and holds(0.01, 0.499) and holds(0.1, 0.505) and holds(0.1, -0.05)
    assert not holds(0.02, -0.01) and not holds(0.1, 0.21) and not holds(-0.01, 0.1) and not holds(0.1, -0.2)


M = Method(filling_time_s=0.2, longest_settling_s=0.1)
ADVISED = {  # name of the alarm: what raises it, and the scene as its advice has it
    "time step, given": (
        "time step", {"method": M.model_copy(update={"time_step_s": 4e-4})}, "let the time step be chosen",
        {"method": M},
    ),
    "time step, cfl": (
        "time step", {"method": M.model_copy(update={"cfl": 1.0})}, "let the step be chosen", {"method": M}
    ),
    "separation": (
        "separation", {"flow": Flow(speed_m_per_s=1.0, displacement_m=0.05)}, "a slower bottom lets it follow",
        {"flow": Flow(speed_m_per_s=0.05, displacement_m=0.05)},
    ),
    "void ratio": (
        "void ratio", {"method": M.model_copy(update={"stress_filter": "smoothing"})}, "the default, patch, does not",
        {"method": M.model_copy(update={"stress_filter": "patch"})},
    ),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", ADVISED)
def test_who_follows_the_advice_of_an_alarm_is_rid_of_it(name, tmp_path):
    alarm, wrong, advice, right = ADVISED[name]
    raised = []
    for number, change in enumerate((wrong, right)):
        scene = SCENE.model_copy(update={"grid": Mesh(cell_size_m=0.02), "method": M, **change})
        with contextlib.suppress(RunFailed):
            run(scene, tmp_path / str(number))
        summary = json.loads((tmp_path / str(number) / "summary.json").read_text(encoding="utf-8"))
        raised.append({one["name"]: one["sentence"] for one in summary.get("alarms", [])})
    assert advice in raised[0][alarm]
    assert not raised[1]
