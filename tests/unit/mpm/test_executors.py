"""Whoever runs the phases, the step is the same: threads, parallel tasks, eight points at once, a GPU."""

import functools
import os

import numpy as np
import pytest

from taichi_silo.mpm import graphics_cards, own_cores, runtime, solver
from taichi_silo.mpm.executors import NODES, POINTS, SCATTER, Threads
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.patch_filter import PatchFilter
from taichi_silo.mpm.shapes import UniformGimp
from taichi_silo.mpm.simd.executor import NOTHING, Simd
from taichi_silo.mpm.solver import Solver
from taichi_silo.mpm.tasks import Tasks, tasks_of
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.scene.silo import Hopper, Outlet
from taichi_silo.simulation.simulation import Simulation

LANES = True  # see conftest.py
pytestmark = pytest.mark.usefixtures("all_cores")
ALONE, TWO, TASKS, EIGHT, EIGHT_ON_TWO = "one thread", "two threads", "tasks", "simd", "simd on two threads"
SMOOTH = Walls(kind="smooth", friction_angle_deg=19.0)
HOPPER = Silo(width_m=0.1, height_m=0.2, hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.05))
HALF = Silo(width_m=0.12, height_m=0.2, half="yes")
SCENES = {
    "very rough": {},
    "smooth, four points a cell": {"walls": SMOOTH, "grid": Mesh(cell_size_m=0.02, points_per_cell=4)},
    "convected domains": {"grid": Mesh(cell_size_m=0.02, points_per_cell=4, shape="cpdi")},
    "non-local": {"averaging": Averaging(characteristic_length_m=0.01)},
    "non-local by a grid": {"averaging": Averaging(characteristic_length_m=0.03)},
    "half, non-local": {
        "silo": HALF, "grid": Mesh(cell_size_m=0.02), "averaging": Averaging(characteristic_length_m=0.04)
    },
    "hopper": {"silo": HOPPER, "walls": SMOOTH},
    "half": {"silo": HALF, "grid": Mesh(cell_size_m=0.02)},
    "half of a wide one, outlet": {
        "silo": Silo(width_m=0.4, height_m=0.2, half="yes", outlet=Outlet(width_m=0.12)), "grid": Mesh(cell_size_m=0.02)
    },
    "nine points of hats": {"grid": Mesh(cell_size_m=0.02, points_per_cell=9, shape="linear")},
    "splines, blend": {"grid": Mesh(cell_size_m=0.01, shape="bspline"), "method": Method(transfer="blend")},
    "cpgimp, pic": {"grid": Mesh(cell_size_m=0.01, shape="cpgimp"), "method": Method(transfer="pic")},
    "memory": {"sand": Sand(law="intergranular")},
    "round, outlet": {"silo": Silo(width_m=0.1, height_m=0.2, section="round", outlet=Outlet(width_m=0.04))},
    "cpdi xpic null-space": {
        "grid": Mesh(cell_size_m=0.02, shape="cpdi", points_per_cell=4),
        "method": Method(transfer="xpic", stress_filter="null-space"),
    },
    "cpgimp first smoothing": {
        "grid": Mesh(cell_size_m=0.01, shape="cpgimp"),
        "method": Method(stress_update="first", stress_filter="smoothing"),
    },
    "bspline apic modified half": {
        "silo": HALF, "grid": Mesh(cell_size_m=0.02, shape="bspline"),
        "method": Method(transfer="apic", stress_update="modified"),
    },
}  # fmt: skip


def stepped(name, how=ALONE, arch="cpu"):
    """Fields and impulses after 100 steps of a silo that is filled while its bottom sinks, and the solver."""
    threads = 2 if how in (TWO, EIGHT_ON_TWO) else 1
    runtime.init(arch, threads=threads)
    given = {"silo": Silo(width_m=0.1, height_m=0.2, half="no"), "grid": Mesh(cell_size_m=0.01)} | SCENES[name]
    options = {"shared": how == TASKS or None, "simd": how in (EIGHT, EIGHT_ON_TWO)}
    with pytest.MonkeyPatch.context() as patch:
        built = Solver.__init__
        patch.setattr(Solver, "__init__", lambda self, *a, **k: built(self, *a, **(k | options)))
        machine = Machine(arch=arch, threads=threads)
        silo = Simulation(Scene(flow=Flow(speed_m_per_s=0.02, displacement_m=0.002), machine=machine, **given))
    silo.solver.advance(100, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
    reaction, control = silo.solver.impulses.read_and_reset()
    return silo.model.particles.arrays() | {"reaction": reaction, "control": control}, silo.solver


@functools.cache
def fields(name, how=ALONE):
    return stepped(name, how)[0]


def assert_equal(one, other, tolerance):
    """To a tolerance of the largest value of each field, of impulses that of the walls."""
    for name, field in one.items():
        size = np.abs(one["reaction" if name == "control" else name]).max()
        assert np.abs(field - other[name]).max() <= tolerance * size, name


MAY = list(SCENES)[:14]  # those that the vector unit can do
LONG = {"nine points of hats", "splines, blend", "cpgimp, pic", "memory", "round, outlet", "smooth, four points a cell"}


def marked(names):
    return [pytest.param(name, marks=pytest.mark.long if name in LONG else ()) for name in names]


@pytest.mark.parametrize("name", marked(MAY))
def test_eight_points_at_once_do_the_step_of_the_plain_loop(name):
    assert_equal(fields(name), fields(name, EIGHT), 1e-12)


@pytest.mark.parametrize(
    "name", ["very rough", "hopper", "non-local by a grid", pytest.param("non-local", marks=pytest.mark.long)]
)
def test_eight_at_once_on_two_threads_do_what_they_do_on_one_bit_by_bit(name):
    one, two = fields(name, EIGHT), fields(name, EIGHT_ON_TWO)
    assert all((field == two[key]).all() for key, field in one.items())


def test_nodes_that_no_wall_holds_move_eight_at_once():
    """Between the walls of a silo of ten cells there are nine nodes; a floor holds all, a hopper's walls reach any."""
    first, eights = stepped("very rough", EIGHT)[1].executor.layout.free.to_numpy().T
    assert (first[5], eights[5]) == (3, 1)
    assert eights[0] == 0
    assert not stepped("hopper", EIGHT)[1].executor.layout.free.to_numpy()[:, 1].any()


def test_as_many_threads_as_cores_have_cores_of_their_own():
    """Fewer threads than cores are left where the system puts them."""
    silo = stepped("very rough", EIGHT_ON_TWO)[1]
    cores = sorted(os.sched_getaffinity(0))
    for _ in range(own_cores.TRIALS):
        silo.advance(2000, 1e-6, gravity=(9.81, 9.81))
    own = [os.sched_getaffinity(int(task.name)) for task in own_cores.TASKS.iterdir()]
    alone = sorted(min(one) for one in own if len(one) == 1 < len(cores))
    assert alone == (cores if len(cores) == 2 else [])


def column():
    """A solver of an elastic column on lanes, high enough for many strips."""
    runtime.init()
    law = Elastic(1e6)
    particles = Particles.lattice(law, 0.1, 2.0, 0.05, origin_m=(0.1, 0.1))
    return Solver(particles, Grid(0.4, 2.4, 0.05), UniformGimp(), law, simd=True)


def test_strips_that_share_sums_share_no_nodes_and_are_cut_anew_before_they_would():
    body = column()
    simd = body.executor
    body.advance(3, 1e-5, gravity=(9.81, 9.81))
    low, high = simd.layout.reach.to_numpy()[:: 16 // simd.strips.count, :2].T
    assert simd.strips.count == 8
    assert not simd.layout.touched.to_numpy().any()  # rows that are read are empty again
    assert (low[2:] > high[:-2]).all()
    assert (low[1:] < high[:-1]).all()  # neighbours do share nodes
    place = body.particles.position.to_numpy()
    place[:, 1] = np.where(place[:, 1] > 1.1, place[:, 1] - 0.45, place[:, 1])
    body.particles.position.from_numpy(place)
    body.advance(1, 1e-9)
    assert simd.strips.revision == -1
    body.advance(1, 1e-9)
    assert simd.strips.count == 2


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("very rough", TWO), ("very rough", TASKS), ("hopper", TWO), ("hopper", TASKS), ("non-local", TASKS),
        ("half", TWO), ("half", TASKS), ("cpdi xpic null-space", TWO), ("cpgimp first smoothing", TASKS),
        ("bspline apic modified half", TWO), ("bspline apic modified half", TASKS),
        *(
            pytest.param(name, how, marks=pytest.mark.long)
            for name, how in [("non-local", TWO), ("cpdi xpic null-space", TASKS), ("cpgimp first smoothing", TWO)]
        ),
    ],
)  # fmt: skip
def test_threads_and_tasks_agree_to_round_off(name, how):
    """What walls give is booked where nodes get it, whoever steps them."""
    assert np.abs(fields(name)["reaction"]).max() > 0.0
    assert_equal(fields(name), fields(name, how), 1e-9)


CARDS = [
    pytest.param("cuda", marks=pytest.mark.skipif(not runtime.has_cuda(), reason="no CUDA device here")),
    pytest.param(
        "vulkan",
        marks=pytest.mark.skipif(
            graphics_cards.chosen(graphics_cards.vulkan_cards()) is None, reason="no Vulkan device with f64 here"
        ),
    ),
]


@pytest.mark.parametrize("arch", CARDS)
@pytest.mark.parametrize(
    "name", ["very rough", *(pytest.param(name, marks=pytest.mark.long) for name in list(SCENES)[1:])]
)
def test_a_graphics_card_does_the_same_step_to_round_off(name, arch):
    """On Vulkan a software driver is card enough."""
    assert_equal(fields(name), stepped(name, None, arch)[0], 1e-10)


@pytest.mark.parametrize("how", [ALONE, TWO, TASKS])
def test_threads_and_tasks_repeat_themselves_bit_by_bit(how):
    again = stepped("very rough", how)[0]
    assert all((field == again[name]).all() for name, field in fields("very rough", how).items())


@pytest.mark.long
@pytest.mark.parametrize("arch", CARDS)
def test_a_graphics_card_does_a_whole_flow_of_the_processor(arch):
    """Cells of 20 mm; on finer ones shear zones make much of round-off, between two ways of a processor as well."""
    runs = []
    for device in ("cpu", arch):
        machine = Machine(arch=device, threads=1)
        machine.start()
        scene = Scene(grid=Mesh(cell_size_m=0.02), flow=Flow(speed_m_per_s=0.02), machine=machine)
        runs.append([record.profile for record in Simulation(scene).run()])
    one, other = map(np.array, runs)
    assert len(one) > 500
    assert np.abs(one - other).max() <= 1e-10 * scene.weight_N_per_m


@pytest.mark.parametrize("arch", CARDS)
@pytest.mark.parametrize("name", ["very rough", pytest.param("hopper", marks=pytest.mark.long)])
def test_a_graphics_card_repeats_itself_bit_by_bit(name, arch):
    """Though its threads come in any order."""
    one, other = stepped(name, None, arch)[0], stepped(name, None, arch)[0]
    assert all((field == other[key]).all() for key, field in one.items())


def test_a_node_moves_in_the_task_in_which_it_takes_what_its_points_give():
    phases = tuple(block(shared=True).phases())
    nodes, points = tasks_of(phases, stretches=False)
    assert (nodes.over, nodes.takes, nodes.runs, points.over, points.enter) == (NODES, True, True, POINTS, True)
    assert [task.over for task in tasks_of(phases, stretches=True)] == [NODES, POINTS, None, POINTS]


def block(threads=1, **options):
    """A solver of a small elastic block that stands on nothing."""
    runtime.init(threads=threads)
    law = Elastic(1e6)
    particles = Particles.lattice(law, 0.2, 0.2, 0.05, origin_m=(0.1, 0.1))
    return Solver(particles, Grid(0.4, 0.4, 0.05), UniformGimp(), law, **options)


@pytest.mark.parametrize(
    ("options", "kind"), [({"simd": False}, Threads), ({"simd": True}, Simd), ({"shared": True}, Tasks)]
)
def test_steps_may_be_cut_into_launches_at_will(options, kind):
    ends = []
    for parts in ((12,), (5, 7)):
        body = block(**options)
        assert isinstance(body.executor, kind)
        for part in parts:
            body.advance(part, 1e-4, gravity=(9.81, 9.81))
        ends.append(body.particles.arrays())
    assert all(np.abs(ends[0][name] - field).max() <= 1e-12 for name, field in ends[1].items())


def test_a_grid_with_too_few_copies_of_its_sums_is_refused():
    with pytest.raises(ValueError, match="copies"):
        block(threads=2, simd=False)


def test_the_phases_of_a_step_stand_in_the_order_of_the_paper():
    assert [(phase.over, phase.run.__name__) for phase in block(simd=False).phases()] == [
        (SCATTER, "_scatter"), (NODES, "_integrate"), (POINTS, "_gather"),
    ]  # fmt: skip


def test_the_vector_unit_is_used_where_it_can_be_trusted_and_the_solver_says_why_not(monkeypatch):
    monkeypatch.setattr(solver.selftest, "failure", lambda: "the trial ended with code -6")
    body = block()
    assert isinstance(body.executor, Threads)
    assert body.simd_refused == "the trial ended with code -6"
    monkeypatch.setattr(solver.selftest, "failure", lambda: "")
    assert isinstance(block().executor, Simd)
    assert isinstance(block(simd=False).executor, Threads)
    assert isinstance(block(stress_update="first").executor, Threads)
    with pytest.raises(ValueError, match="cannot run on lanes because its stress update is 'first'"):
        block(stress_update="first", simd=True)


@pytest.mark.parametrize("how", [EIGHT, EIGHT_ON_TWO])
@pytest.mark.parametrize("name", ["very rough", "smooth, four points a cell", "half", "round, outlet", "memory"])
def test_the_patch_filter_on_groups_takes_out_what_it_takes_out_on_points(name, how):
    """Of sand that is torn, of which some has left, and a point of which is not finite."""
    solver = stepped(name, how)[1]
    sand, rng = solver.particles, np.random.default_rng(3)
    state = {name: values[:-5] for name, values in sand.arrays().items()}
    state["stress"] *= 1.0 + 0.5 * rng.random((len(state["mass"]), 1))
    state["path"] = state["path"] + 0.01 * rng.random(len(state["mass"]))
    state["stress"][7, 1] = np.nan
    found = []
    for filtering in (solver.filter, PatchFilter(sand, solver.grid, solver.law, solver.MIRRORED)):
        sand.load(state)
        filtering.begin()
        put(filtering.path, 0.95 * state["path"], sand.number)
        filtering.turn()
        solver.executor.hand_back()
        found.append(sand.arrays() | {"last path": filtering.path.to_numpy()[: sand.number]})
    assert np.nanmax(np.abs(found[1]["stress"] - state["stress"])) > 1e-3 * np.nanmax(np.abs(state["stress"]))
    for field, values in found[0].items():
        np.testing.assert_allclose(values, found[1][field], rtol=0, atol=1e-13 * np.nanmax(np.abs(values)))


@pytest.mark.parametrize("name", ["very rough", "half", "round, outlet"])
def test_sums_over_the_points_are_those_over_groups_of_eight(name):
    """Of sand of which some has left, so that the last group is not full, some of it lost and some astray."""
    solver = stepped(name, EIGHT)[1]
    sand = solver.particles
    state = {name: values[:-5] for name, values in sand.arrays().items()}
    state["stress"][:3], state["position"][3:5, 1], state["stress"][5, 0] = 0.0, 1e3, np.nan
    sand.load(state)
    groups = solver.point_sums()
    solver.sums.take()
    points = solver.sums.named(solver.sums.found.to_numpy())
    assert (groups.strays, groups.separated) == (points.strays, points.separated) and groups.strays == 3
    for found, one in vars(points).items():
        assert getattr(groups, found) == pytest.approx(one, rel=1e-13, abs=1e-18, nan_ok=True)


def test_what_fills_up_the_last_group_stays_like_the_last_point():
    """Of 30 points two places are left; what they hold weighs nothing, but must not grow."""
    solver = stepped("half, non-local", EIGHT)[1]
    sand, layout = solver.particles, solver.executor.layout
    for _ in range(6):
        solver.advance(50, 2e-5, gravity=(9.81, 9.81), plate_velocity=(-0.05, -0.05))
        solver.filter.turn()
        lanes = solver.executor.points.to_numpy().reshape(layout.groups, layout.record, 8)[sand.number // 8]
        last = lanes[:, sand.number % 8 - 1]
        for filler in lanes[:, sand.number % 8 :].T:
            weight = np.isclose(filler, last * NOTHING, rtol=1e-9, atol=0.0)
            np.testing.assert_allclose(filler[~weight], last[~weight], rtol=1e-9, atol=1e-12 * np.abs(last).max())
    assert sand.number % 8 == 6


def test_a_state_that_is_loaded_or_written_counts_whatever_was_before(monkeypatch):
    """After an interruption within an interval, after a turn of the filter by hand, beside another solver."""
    solver = stepped("very rough", EIGHT)[1]
    sand = solver.particles
    state = {name: values.copy() for name, values in sand.arrays().items()}
    state["velocity"][:] = 1.0
    with monkeypatch.context() as patch:
        patch.setattr(solver.filter, "passed", lambda *a: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            solver.advance(20, 2e-5, gravity=(9.81, 9.81))
    moved = sand.array("position")
    assert (moved != state["position"]).any()  # the steps that were done are in the fields
    for interrupt in (solver.filter.turn, lambda: solver.advance(5, 2e-5)):
        interrupt()
        sand.load(state)
        assert solver.point_sums().speed == pytest.approx(np.sqrt(2.0), rel=1e-12)
        assert (sand.array("stress") == state["stress"]).all()
    solver.advance(1, 2e-5)
    put(sand.velocity, 3.0)
    assert solver.point_sums().speed == pytest.approx(np.sqrt(18.0), rel=1e-12)
