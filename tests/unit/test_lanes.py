"""The formulas of the law and of the shapes hold for eight lanes at once, as they stand.

Run in a process of its own: Taichi aborts on an operation that lanes do not know. Exponential and power, which need
lanes of their own, are stood in for by a rational function and a square root, on both sides of the comparison.
"""

import subprocess
import sys

SCRIPT = """
import numpy as np
import taichi_silo
from taichi_silo.runtime import ti
import taichi_silo.laws.gudehus_bauer as sand

@ti.func
def stand_in(x):
    return 1.0 / (1.0 + x + 0.5 * x * x)

sand.exp_minus = stand_in
ti.init(ti.cpu, default_fp=ti.f64, cpu_max_num_threads=1, log_level=ti.ERROR, real_matrix_scalarize=False)
from taichi_silo.shapes import SHAPES
from taichi_silo.tensors import norm, spun

lanes8 = ti.types.vector(8, ti.f64)
from taichi_silo.laws import Intergranular

law = sand.GudehusBauer(alpha=0.5)
shapes = tuple(kind(0.25) for kind in SHAPES.values())
memory = Intergranular(skeleton=law, chi=1.0)

@ti.func
def formulas(a, b, c, d, e, f, g, h):
    stress, D = (a, b, c, d), (f, g, 0.0 * f, h)
    rate = law.rate(stress, stress, e, D, norm(D))
    held = law.admissible(stress, e)
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
    kept = memory.remembered(past)
    reversed_rate = memory.rate(stress, kept, e, D, norm(D))
    growth_of_memory = memory.memory_rate(kept, D)
    return (
        rate[0], rate[3], held[0], turned[1], law.stiffness(stress, e), weighed,
        reversed_rate[1], growth_of_memory[3], memory.stiffness(stress, e),
    )

@ti.kernel
def together(x: ti.types.ndarray(lanes8, 1), y: ti.types.ndarray(lanes8, 1)):
    ti.loop_config(serialize=True)
    for _ in range(1):
        r = formulas(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7])
        for k in ti.static(range(9)):
            y[k] = r[k]

@ti.kernel
def singly(x: ti.types.ndarray(), y: ti.types.ndarray()):
    for p in range(8):
        r = formulas(x[0, p], x[1, p], x[2, p], x[3, p], x[4, p], x[5, p], x[6, p], x[7, p])
        for k in ti.static(range(9)):
            y[k, p] = r[k]

rng = np.random.default_rng(0)
given = np.concatenate([
    -rng.uniform(2e3, 5e3, (3, 8)), rng.uniform(-500, 500, (1, 8)),
    rng.uniform(0.55, 1.4, (1, 8)), rng.normal(size=(3, 8)),
])
x, y = ti.ndarray(lanes8, 8), ti.ndarray(lanes8, 9)
x.from_numpy(given)
together(x, y)
alone = np.zeros((9, 8))
singly(given, alone)
worst = (np.abs(y.to_numpy() - alone).max(axis=1) / np.abs(alone).max(axis=1)).max()
assert worst < 1e-14, worst
print("equal")
"""


def test_formulas_hold_for_eight_lanes(tmp_path):
    script = tmp_path / "lanes.py"  # Taichi reads the source of its kernels from a file
    script.write_text(SCRIPT)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "equal" in done.stdout
