"""Eight points at once: formulas hold for a vector as they stand, and what cannot be trusted is not used.

The formulas run in a process of its own: Taichi aborts on an operation that vectors do not know.
"""

import json
import shutil
import subprocess
import sys

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import UniformGimp
from taichi_silo.mpm.simd import selftest, trial
from taichi_silo.mpm.solver import Solver

LANES = True  # see conftest.py
SCRIPT = """
import numpy as np
from taichi_silo.mpm.language import ti
from taichi_silo.mpm import runtime
from taichi_silo.mpm.laws import GudehusBauer, Intergranular
from taichi_silo.mpm.laws.integrate import update
from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.mpm.simd.lane_maths import exp_minus, power
from taichi_silo.mpm.simd.vectors import arrays_of_eight, compiling_simd, eight
from taichi_silo.mpm.tensors import norm, spun

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
with compiling_simd():
    together(x, y)
alone = np.zeros((COUNT, 8))
singly(given, alone)
worst = np.abs(y.to_numpy() - alone).max(axis=1) / np.abs(alone).max(axis=1)
assert worst.max() < 3e-13, worst
print("equal")
"""


def test_formulas_hold_for_eight_points_at_once(tmp_path):
    script = tmp_path / "formulas.py"  # Taichi reads the source of its kernels from a file
    script.write_text(SCRIPT)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=400)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "equal" in done.stdout


def block():
    """A solver of 27 elastic points, three more than fill whole groups."""
    runtime.init()
    law = Elastic(1e6)
    # not along grid lines: there, nodes that hardly any sand touches make much of round-off
    particles = Particles.lattice(law, 0.45, 0.15, 0.05, origin_m=(0.115, 0.12))
    return Solver(particles, Grid(1.0, 0.6, 0.05), UniformGimp(), law, simd=True)


def test_the_order_of_the_points_changes_nothing_but_round_off(monkeypatch):
    ends = []
    for order in (np.lexsort, lambda keys: np.random.default_rng(1).permutation(len(keys[0]))):
        monkeypatch.setattr(np, "lexsort", order)
        body = block()
        place = body.particles.arrays()["position"]
        body.particles.load(body.particles.arrays() | {"velocity": 0.1 * np.sin(50.0 * place)})
        body.advance(20, 1e-4, gravity=(0.0, 9.81))
        ends.append(body.particles.arrays())
    assert np.abs(ends[0]["stress"]).max() > 1e3
    for name, field in ends[0].items():
        assert np.abs(field - ends[1][name]).max() <= 1e-12 * np.abs(field).max(), name


@pytest.mark.parametrize("place", [np.nan, np.inf, -np.inf, 1e300, -1e9])
def test_points_that_are_nowhere_are_counted_and_touch_no_memory_of_others(place):
    body = block()
    arrays = body.particles.arrays()
    arrays["position"][[0, 5]] = place
    body.particles.load(arrays)
    body.advance(3, 1e-6, gravity=(9.81, 9.81))
    assert body.point_sums().strays >= 2


class TestSelftest:
    @pytest.fixture(autouse=True)
    def forgetful(self, monkeypatch, tmp_path):
        """No verdict in memory or on disk."""
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        selftest.failure.cache_clear()
        yield
        selftest.failure.cache_clear()

    @pytest.fixture
    def python(self, monkeypatch, tmp_path):
        """A function that puts a script in the place of Python."""

        def replace(script):
            file = tmp_path / "python"
            file.write_text(f"#!/bin/sh\n{script}\n")
            file.chmod(0o755)
            monkeypatch.setattr(sys, "executable", str(file))

        return replace

    @pytest.mark.parametrize(
        ("script", "why"),
        [("kill -6 $$", "ended with code -6"), ("echo lanes differ; exit 1", "lanes differ"), ("exit 7", "code 7")],
    )
    def test_a_trial_that_aborts_or_differs_is_a_reason_not_an_end(self, python, script, why):
        python(script)
        assert why in selftest.failure()
        assert why in json.loads(selftest.place().read_text())["failure"]

    def test_a_verdict_is_kept_until_circumstances_change(self, python, monkeypatch):
        python("echo once; exit 1")
        assert selftest.failure() == "once"
        python("exit 0")
        selftest.failure.cache_clear()
        assert selftest.failure() == "once"
        monkeypatch.setattr(selftest, "circumstances", lambda: "another processor")
        selftest.failure.cache_clear()
        assert selftest.failure() == ""

    @pytest.mark.parametrize(
        ("changed", "anew"),
        [
            ("laws/gudehus_bauer.py", False),
            ("simd/store.py", False),
            ("simd/vectors.py", True),
            ("simd/trial.py", True),
        ],
    )
    def test_circumstances_change_with_what_is_tried_not_with_the_rest_of_the_code(
        self, monkeypatch, tmp_path, changed, anew
    ):
        copy = shutil.copytree(selftest.ROOM.parent, tmp_path / "mpm")
        monkeypatch.setattr(selftest, "ROOM", copy / "simd")
        before = selftest.circumstances()
        with (copy / changed).open("a") as file:
            file.write("# changed")
        assert (selftest.circumstances() != before) == anew

    def test_a_broken_file_of_verdicts_is_no_verdict(self, python):
        selftest.place().parent.mkdir(parents=True)
        selftest.place().write_text("{")
        python("exit 0")
        assert selftest.failure() == ""


def test_the_trial_passes_here_and_finds_a_difference(monkeypatch):
    assert trial.compare() == ""
    monkeypatch.setattr(trial, "TOLERANCE", -1.0)
    assert "differ by" in trial.compare()
