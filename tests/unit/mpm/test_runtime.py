"""One Taichi after the other in one process."""

import gc

from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti


@ti.kernel
def total(values: ti.types.ndarray(dtype=ti.f64, ndim=1)) -> ti.f64:
    found = 0.0
    for i in values:
        values[i] = 1.0
        found += values[i]
    return found


def test_arrays_of_an_ended_taichi_take_nothing_from_the_next():
    """With arrays of Taichi's own, some of two hundred lie where old ones lay, and go with them."""
    runtime.init()
    old = [runtime.array(ti.f64, 1000 + number) for number in range(200)]
    runtime.init()
    new = [runtime.array(ti.f64, 50) for _ in range(200)]
    del old
    gc.collect()
    assert [total(one) for one in new] == [50.0] * 200
