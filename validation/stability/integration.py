"""Failure mode 6: integration of the law over a step that is too long for it."""

import numpy as np

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import GudehusBauer
from taichi_silo.mpm.laws.stress_point import StressPoint
from taichi_silo.mpm.tensors import added, norm
from validation.stability.measurement import Measurement, measurements

FAILURE_MODE = "6 stress integration"
STATES = 200
INCREMENTS = 10.0 ** np.arange(-5.0, -0.9, 0.25)  # of strain
PRESSURES = (0.5e3, 5e3)  # [Pa]


@ti.kernel
def _euler(law: ti.template(), states: ti.types.ndarray(), strains: ti.types.ndarray(), out: ti.types.ndarray()):
    """One step of Euler's rule, without anything that pulls the stress back."""
    for p in range(states.shape[0]):
        stress = (states[p, 0], states[p, 1], states[p, 2], states[p, 3])
        D = (strains[p, 0], strains[p, 1], strains[p, 2], strains[p, 3])
        zero = 0.0 * states[p, 4]
        rate = law.rate(stress, (zero, zero, zero, zero), law.factors(stress, states[p, 4]), D, norm(D))
        new = added(stress, rate, 1.0)
        for k in ti.static(range(4)):
            out[p, k] = new[k]


def random_states(seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Admissible stresses with void ratios (states, 5), and directions of strain of norm 1 (states, 4)."""
    rng = np.random.default_rng(seed)
    p = rng.uniform(*PRESSURES, STATES)
    stress = -p[:, None] * np.array([1.0, 1.0, 1.0, 0.0]) + 0.4 * p[:, None] * rng.uniform(-1, 1, (STATES, 4))
    void_ratio = rng.uniform(0.55, 0.95, STATES)
    D = rng.normal(size=(STATES, 4))
    D /= np.sqrt((D**2 * [1, 1, 1, 2]).sum(axis=1))[:, None]
    return np.column_stack([stress, void_ratio]), D


def inadmissible(stress: np.ndarray) -> np.ndarray:
    """Which of the stresses (states, 4) pull somewhere, or are not finite."""
    centre, half = 0.5 * (stress[:, 0] + stress[:, 1]), 0.5 * (stress[:, 0] - stress[:, 1])
    largest = np.maximum(centre + np.hypot(half, stress[:, 3]), stress[:, 2])
    return ~(largest <= 1e-9) | ~np.isfinite(stress).all(axis=1)


def after(integrator: str, law, states, strains) -> np.ndarray:
    """Stresses after one increment: "euler", "law" (as in a step) or "exact" (a thousand parts)."""
    if integrator == "euler":
        out = np.zeros((len(states), 4))
        _euler(law, states, strains, out)
        return out
    parts = 1 if integrator == "law" else 1000
    found = []
    for state, strain in zip(states, strains, strict=True):
        point = StressPoint(law, state[:4], state[4])
        found.append(point.trial(strain / parts, count=parts)[:4])
    return np.array(found)


def largest_safe_increment(integrator: str, law, fails) -> float:
    """Largest increment of strain below which no state fails, by `fails(states, strains, stresses)`; at most 0.1."""
    states, D = random_states()
    safe = 0.0
    for size in INCREMENTS:
        strains = size * D
        if fails(states, strains, after(integrator, law, states, strains)).any():
            break
        safe = size
    return safe


def measure(full: bool = True) -> list[Measurement]:
    """Euler's rule and the sub-stepped law: where they leave the admissible set, and where they are 1 % wrong."""
    law = GudehusBauer()

    def leaves(states, strains, stress):
        return inadmissible(stress)

    def errs(states, strains, stress):
        exact = after("exact", law, states, strains)
        return np.linalg.norm(stress - exact, axis=1) > 0.01 * np.linalg.norm(states[:, :4], axis=1)

    names = {"euler": "Euler's rule", "law": "sub-stepped law"}
    safe = {word: largest_safe_increment(name, law, leaves) for name, word in names.items()}
    found = measurements("strain increment with admissible stress", "-", ">=", 0.1, safe)
    if full:
        near = {word: largest_safe_increment(name, law, errs) for name, word in names.items()}
        found += measurements("strain increment with error below 1 %", "-", ">=", 1e-2, near)
    return found
