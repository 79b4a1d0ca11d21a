"""What this machine could do at most: arithmetic of one core on vectors of eight, and bytes from each memory.

And how much of both a step needs, counted in the formulas; a step's place under this roof says what limits it.
"""

import time

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.vectors import LANES, arrays_of_eight, compiling_simd, eight

CHAINS = 8  # of operations that do not wait for each other
# operations + - * / sqrt min max select of a point and step (uGIMP, FLIP, Gudehus-Bauer), and bytes of the fields
FLOPS = {"particles to grid": 60 + 9 * 16 + 6 * 8, "grid to particles": 40 + 9 * 16 + 3 * 16, "law": 420}
BYTES = {"particles to grid": 10 * 8, "grid to particles": 2 * 8, "law": 11 * 8 * 2}
NODE_BYTES = {"particles to grid": 2 * 64, "grid": 3 * 64 + 6 * 8, "grid to particles": 64}  # of each node


@ti.kernel
def _multiply_add(x: arrays_of_eight, count: ti.i32):
    ti.loop_config(serialize=True)
    for _ in range(1):
        a, b, c, d, e, f, g, h = x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]
        factor, more = x[8], x[9]
        for _k in range(count):
            a, b, c, d = a * factor + more, b * factor + more, c * factor + more, d * factor + more
            e, f, g, h = e * factor + more, f * factor + more, g * factor + more, h * factor + more
        x[10] = a + b + c + d + e + f + g + h


@ti.kernel
def _triad(x: arrays_of_eight, y: arrays_of_eight, length: ti.i32, times: ti.i32):
    ti.loop_config(serialize=True)
    for _ in range(times):
        for k in range(length):
            y[k] = y[k] + x[k] * 0.999


def arithmetic() -> float:
    """Operations per second of one core; Taichi has been started."""
    x = ti.ndarray(eight, 11)
    x.fill(0.5)
    return max(2.0 * CHAINS * LANES * 2_000_000 / _seconds(lambda: _multiply_add(x, 2_000_000)) for _ in range(3))


def bandwidth(megabytes: float) -> float:
    """Bytes per second of one core, two read and one written, over two arrays of together so many megabytes."""
    length = int(megabytes * 1e6 / (2 * 8 * LANES))
    x, y = ti.ndarray(eight, length), ti.ndarray(eight, length)
    x.fill(1.0)
    y.fill(1.0)
    times = max(1, int(4e8 / (3 * 8 * LANES * length)))
    moved = 3.0 * 8 * LANES * length * times
    return max(moved / _seconds(lambda: _triad(x, y, length, times)) for _ in range(3))


def ceilings() -> dict[str, float]:
    """Operations per second, and bytes per second from the second-level cache and from memory."""
    runtime.init()
    return {"arithmetic": arithmetic(), "cache": bandwidth(0.3), "memory": bandwidth(400.0)}


def _seconds(run) -> float:
    with compiling_simd():
        run()
    begun = time.perf_counter()
    run()
    return time.perf_counter() - begun
