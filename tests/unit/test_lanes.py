"""The formulas of the law and of the shapes hold for eight lanes at once, as they stand; and so does the whole step.

The formulas run in a process of its own: Taichi aborts on an operation that lanes do not know.
"""

import subprocess
import sys

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.mpm.solver import Solver
from taichi_silo.scene.scene import Averaging, Flow, Mesh, Method, Sand, Scene, Silo, Walls
from taichi_silo.scene.silo import Hopper, Outlet
from taichi_silo.simulation.simulation import Simulation

LANES = True  # see conftest.py
SCRIPT = """
import numpy as np
import taichi_silo
from taichi_silo import runtime
from taichi_silo.laws import GudehusBauer, Intergranular
from taichi_silo.laws.integrate import update
from taichi_silo.lanes import arrays_of_eight
from taichi_silo.maths import exp_minus, power
from taichi_silo.runtime import eight, ti
from taichi_silo.shapes import SHAPES
from taichi_silo.tensors import norm, spun

runtime.init()
law = GudehusBauer(beta=1.05)
shapes = tuple(kind(0.25) for kind in SHAPES.values())
memory = Intergranular(skeleton=law)

@ti.func
def formulas(a, b, c, d, e, f, g, h):
    stress, D = (a, b, c, d), (f, g, 0.0 * f, h)
    factors = law.factors(stress, e)
    rate = law.rate(stress, stress, factors, D, norm(D))
    held = law.admissible(stress, e)
    drawn = law.admissible((a, 0.0 - b, c, d), e)
    turned = spun(held, h)
    weighed = 0.0 * e
    for shape in ti.static(shapes):
        domain = (0.5 + 0.1 * f, 0.1 * g, 0.1 * h, 0.5 - 0.1 * g)
        for patch in ti.static(range(shape.PATCHES)):
            i, sx, gx, j, sy, gy = shape.patch(patch, 7.0 * e, 5.0 * e, domain)
            for k in ti.static(range(shape.NODES)):
                weighed += (i + k) * sx[k] + gx[k] * k + (j + k) * sy[k] * 2.0 + gy[k] * k
        if ti.static(shape.DOMAIN):
            r = shape.convected(domain, (0.3 * f, 0.2 * g, 0.4 * h, 0.1 * f))
            weighed += r[0] + 2.0 * r[1] + 3.0 * r[2] + 4.0 * r[3]
    past = (2e-5 * g, 3e-5 * f, 1e-5 * h, 2e-5 * f)
    kept = memory.bounded_memory(past)
    reversed_rate = memory.rate(stress, kept, factors, D, norm(D))
    growth_of_memory = memory.memory_rate(kept, D)
    at_once = update(law, stress, kept, e, D, h, norm(D), 1e-3)  # divided, in each lane as it needs
    return (
        rate[0], rate[3], held[0], drawn[1], turned[1], law.stiffness(stress, e), weighed,
        reversed_rate[1], growth_of_memory[3], memory.stiffness(stress, e),
        at_once[0], at_once[3], at_once[8],
        power(1e-7 * e, 0.3), power(3.0 * e, 2.5), power(2e4 * e, 0.13), exp_minus(3.0 * e),
    )

COUNT = 17

@ti.kernel
def together(x: arrays_of_eight, y: arrays_of_eight):
    ti.loop_config(serialize=True)
    for _ in range(1):
        r = formulas(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7])
        for k in ti.static(range(COUNT)):
            y[k] = r[k]

@ti.kernel
def singly(x: ti.types.ndarray(), y: ti.types.ndarray()):
    for p in range(8):
        r = formulas(x[0, p], x[1, p], x[2, p], x[3, p], x[4, p], x[5, p], x[6, p], x[7, p])
        for k in ti.static(range(COUNT)):
            y[k, p] = r[k]

rng = np.random.default_rng(0)
given = np.concatenate([
    -rng.uniform(2e3, 5e3, (3, 8)), rng.uniform(-500, 500, (1, 8)),
    rng.uniform(0.55, 1.4, (1, 8)), rng.normal(size=(3, 8)),
])
x, y = ti.ndarray(eight, 8), ti.ndarray(eight, COUNT)
x.from_numpy(given)
with runtime.compiling_wide():
    together(x, y)
alone = np.zeros((COUNT, 8))
singly(given, alone)
worst = np.abs(y.to_numpy() - alone).max(axis=1) / np.abs(alone).max(axis=1)
assert worst.max() < 3e-13, worst
print("equal")
"""


def after(lanes, steps, threads=1, monkeypatch=None, **scene):
    """State and books after some steps of a silo that is filled while its bottom sinks."""
    runtime.init(threads=threads)
    built = Solver.__init__
    monkeypatch.setattr(Solver, "__init__", lambda self, *a, **k: built(self, *a, **(k | {"lanes": lanes})))
    given = {"silo": Silo(width_m=0.1, height_m=0.2), "grid": Mesh(cell_size_m=0.01)} | scene
    simulation = Simulation(Scene(flow=Flow(speed_m_per_s=0.02, displacement_m=0.002), **given))
    assert bool(simulation.solver.lanes) == lanes
    simulation.solver.advance(steps, 2e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
    monkeypatch.undo()
    return simulation.particles.arrays(), *simulation.solver.impulses.read_and_reset()


HOPPER = Silo(width_m=0.1, height_m=0.2, hopper=Hopper(half_angle_deg=20.0, outlet_width_m=0.05))
ROUND = Silo(width_m=0.1, height_m=0.2, section="round", outlet=Outlet(width_m=0.04))
SCENES = {
    "very rough": {},
    "smooth, four points a cell": {
        "walls": Walls(kind="smooth", friction_angle_deg=19.0),
        "grid": Mesh(cell_size_m=0.01, points_per_cell=4),
    },
    "nine points of hats": {"grid": Mesh(cell_size_m=0.02, points_per_cell=9, shape="linear")},
    "convected domains": {"grid": Mesh(cell_size_m=0.02, points_per_cell=4, shape="cpdi")},
    "splines, blend": {"grid": Mesh(cell_size_m=0.01, shape="bspline"), "method": Method(transfer="blend")},
    "cpgimp, pic": {"grid": Mesh(cell_size_m=0.01, shape="cpgimp"), "method": Method(transfer="pic")},
    "memory": {"sand": Sand(law="intergranular")},
    "non-local": {"averaging": Averaging(characteristic_length_m=0.01)},
    "hopper": {"silo": HOPPER, "walls": Walls(kind="smooth", friction_angle_deg=19.0)},
    "round, outlet": {"silo": ROUND},
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_lanes_do_the_step_of_the_plain_loop(scene, monkeypatch):
    plain, wide = (after(lanes, 100, monkeypatch=monkeypatch, **scene) for lanes in (False, True))
    for name, field in plain[0].items():
        assert np.abs(field - wide[0][name]).max() <= 1e-12 * np.abs(field).max(), name
    for one, other in zip(plain[1:], wide[1:], strict=True):
        assert np.abs(one - other).max() <= 1e-12 * np.abs(plain[1]).max()


@pytest.mark.parametrize(
    "scene", [SCENES["very rough"], SCENES["non-local"], SCENES["hopper"]], ids=["local", "non-local", "hopper"]
)
def test_two_threads_do_what_one_does_bit_by_bit(scene, monkeypatch, all_cores):
    one, two = (after(True, 100, threads, monkeypatch, **scene) for threads in (1, 2))
    assert all((field == two[0][name]).all() for name, field in one[0].items())
    assert (one[1] == two[1]).all()
    assert (one[2] == two[2]).all()


def test_the_order_of_the_points_changes_nothing_but_round_off(monkeypatch):
    sorted_ones = after(True, 100, monkeypatch=monkeypatch)
    monkeypatch.setattr(np, "lexsort", lambda keys: np.random.default_rng(1).permutation(len(keys[0])))
    shuffled = after(True, 100, monkeypatch=monkeypatch)
    for name, field in sorted_ones[0].items():
        assert np.abs(field - shuffled[0][name]).max() <= 1e-12 * np.abs(field).max(), name


@pytest.mark.parametrize("place", [np.nan, np.inf, -np.inf, 1e300, -1e9])
def test_points_that_are_nowhere_are_counted_and_touch_no_memory_of_others(place):
    runtime.init()
    silo = Simulation(Scene(silo=Silo(half="no"), grid=Mesh(cell_size_m=0.1)), lanes=True)
    arrays = silo.particles.arrays()
    arrays["position"][[0, 5]] = place
    silo.particles.load(arrays)
    silo.solver.advance(3, 1e-6, gravity=(9.81, 9.81))
    assert silo.solver.point_sums().strays >= 2


def test_what_lanes_cannot_do_is_done_by_the_plain_loop_and_refused_if_asked_for(monkeypatch):
    method = Method(transfer="apic")
    after(False, 1, monkeypatch=monkeypatch, method=method)
    with pytest.raises(ValueError, match="cannot run on lanes because its transfer is Apic"):
        after(True, 1, monkeypatch=monkeypatch, method=method)


def test_formulas_hold_for_eight_lanes(tmp_path):
    script = tmp_path / "lanes.py"  # Taichi reads the source of its kernels from a file
    script.write_text(SCRIPT)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=400)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "equal" in done.stdout
