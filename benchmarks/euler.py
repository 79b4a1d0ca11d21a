"""One evaluation of the law a step, as the yardstick has it: Euler's rule in place of Heun's, without its error."""

from contextlib import AbstractContextManager
from unittest.mock import patch

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import integrate
from taichi_silo.mpm.tensors import added, trace


@ti.func
def update_from(factors, law: ti.template(), stress, h, void_ratio, D, spin, d_bar, dt):
    """As `integrate.update_from`, by Euler's rule."""
    rate, h_rate = integrate.total_rate(law, stress, h, factors, D, spin, d_bar), integrate.memory_rate(law, h, D, spin)
    e = (1.0 + void_ratio) * integrate.growth(trace(D) * dt) - 1.0
    s0, s1, s2, s3 = law.admissible(added(stress, rate, dt), e)
    h0, h1, h2, h3 = integrate.bounded_memory(law, h, h_rate, dt)
    return s0, s1, s2, s3, h0, h1, h2, h3, e


def by_euler() -> AbstractContextManager:
    """A context in which steps are compiled with Euler's rule."""
    return patch.object(integrate, "update_from", update_from)
