"""Several silos in one launch: each goes its way as it does alone."""

import numpy as np
import pytest

from taichi_silo.mpm import graphics_cards, one_taichi, runtime
from taichi_silo.mpm.crew import Crew, joined
from taichi_silo.mpm.joint_steps import JointSteps
from taichi_silo.scene.sands import sand as named_sand
from taichi_silo.scene.scene import Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.scene.silo import Outlet
from taichi_silo.simulation.simulation import Simulation

ARCHITECTURES = [
    "cpu",
    pytest.param("vulkan", marks=pytest.mark.skipif(not graphics_cards.vulkan_cards(), reason="no Vulkan device")),
]
SILO = Silo(width_m=0.1, height_m=0.2, half="no")
SHORT = Method(filling_time_s=0.02, longest_settling_s=0.0)
SCENES = {  # the first three of one shape, with other values
    "dense": {},
    "loose, fast": {"sand": Sand(void_ratio=0.8), "flow": Flow(speed_m_per_s=0.1, displacement_m=0.001)},
    "another sand, slow": {
        "sand": named_sand("hostun", void_ratio=0.7),
        "flow": Flow(speed_m_per_s=0.02, displacement_m=0.0004),
    },
    "smooth": {"walls": Walls(kind="smooth", friction_angle_deg=15.0)},  # whose step has other tasks
}


@pytest.fixture(autouse=True)
def by_tasks(monkeypatch):
    """On a processor, too, phases are parallel tasks."""
    from taichi_silo.mpm.solver import Solver

    built = Solver.__init__
    monkeypatch.setattr(Solver, "__init__", lambda self, *a, **k: built(self, *a, **(k | {"shared": True})))


def scene(arch, **parts):
    given = {"silo": SILO, "grid": Mesh(cell_size_m=0.02), "method": SHORT} | parts
    given.setdefault("flow", Flow(speed_m_per_s=0.05, displacement_m=0.001))
    return Scene(machine=Machine(arch=arch, threads=1), **given)


def run(scene):
    """Records and points of a silo that runs to its end."""
    silo = Simulation(scene)
    records = [(r.time_s, r.bottom_force_N_per_m, r.normal_N_per_m, r.shear_N_per_m) for r in silo.run()]
    return {"records": np.array(records)} | silo.points("position", "velocity", "stress", "volume")


def run_alone(scenes):
    found = {}
    for name, one in scenes.items():
        one.machine.start()
        found[name] = run(one)
    return found


def run_together(scenes):
    found = {}
    with one_taichi.held():
        next(iter(scenes.values())).machine.start()
        Crew([lambda name=name, one=one: found.update({name: run(one)}) for name, one in scenes.items()]).work()
    return found


def assert_same(one, other):
    for name, values in one.items():
        assert values.shape == other[name].shape, name
        assert np.abs(values - other[name]).max() <= 1e-12 * np.abs(values).max(), name


@pytest.mark.parametrize("arch", ARCHITECTURES)
def test_silos_that_run_together_go_each_as_it_does_alone(arch, monkeypatch):
    scenes = {name: scene(arch, **parts) for name, parts in SCENES.items()}
    alone = run_alone(scenes)
    launched = []
    steps = JointSteps.run
    monkeypatch.setattr(JointSteps, "run", lambda self, asked, n: (launched.append(len(asked)), steps(self, asked, n)))
    joined = run_together(scenes)
    most = 3 if arch == "cpu" else 2  # the software driver of Vulkan has room for no more
    assert max(launched) == most and launched.count(most) > 0.3 * len(launched)
    for name, one in alone.items():
        assert_same(one, joined[name])


def test_what_goes_wrong_in_one_run_stops_no_other():
    found = {}

    def fails():
        next(Simulation(scene("cpu")).run())
        raise ArithmeticError("this run alone")

    def caught(work, name):
        try:
            found[name] = work()
        except ArithmeticError as error:
            found[name] = str(error)

    with one_taichi.held():
        scene("cpu").machine.start()
        Crew([lambda: caught(fails, "fails"), lambda: caught(lambda: run(scene("cpu")), "goes on")]).work()
    assert found["fails"] == "this run alone"
    scene("cpu").machine.start()
    assert_same(run(scene("cpu")), found["goes on"])


def test_a_launch_takes_no_more_silos_than_a_kernel_may_use_trees_of_fields(monkeypatch):
    scene("cpu").machine.start()
    solvers = [Simulation(scene("cpu")).solver.executor for _ in range(3)]
    apart, all_of_them = len(solvers[0].trees), len(set.union(*(one.trees for one in solvers)))
    assert all_of_them == 3 * apart
    for most, sizes in ((all_of_them + 1, [3]), (all_of_them, [2, 1]), (2 * apart, [1, 1, 1]), (1, [1, 1, 1])):
        monkeypatch.setattr(runtime, "most_trees", lambda most=most: most)
        assert [len(one.members) for one in joined(solvers)] == sizes


def test_silos_that_get_new_solvers_as_they_begin_to_flow_wait_for_each_other(monkeypatch):
    """In free outflow the drag ends with the filling; what is compiled for new solvers is compiled once for all."""
    free = {"silo": Silo(width_m=0.1, height_m=0.2, outlet=Outlet(width_m=0.06))}
    free["flow"] = Flow(outflow="gravity", displacement_m=0.02, longest_s=0.02)
    scenes = {
        "soon": scene("cpu", **free),
        "later": scene("cpu", **free, method=Method(filling_time_s=0.03, longest_settling_s=0.0)),
    }
    alone = run_alone(scenes)
    made = []
    begin = JointSteps.__init__
    monkeypatch.setattr(JointSteps, "__init__", lambda self, all_: (made.append(len(all_)), begin(self, all_))[1])
    joined_runs = run_together(scenes)
    assert made == [2, 2]
    for name, one in alone.items():
        assert_same(one, joined_runs[name])
