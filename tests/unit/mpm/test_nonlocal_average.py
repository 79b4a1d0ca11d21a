"""The non-local average: a weighted mean over neighbours, kept in sparse rows."""

import math

import numpy as np
import pytest

from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.nonlocal_average import Exponential, Gaussian, NonLocal, self_weight
from taichi_silo.mpm.particles import Particles
from taichi_silo.scene.scene import Averaging, Mesh, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation

LENGTH = 1.5e-3
KERNELS = [Gaussian(LENGTH), Exponential(LENGTH)]


@ti.data_oriented
class Means:
    """Reads all means."""

    def __init__(self, average):
        self.average = average
        self.found = ti.field(runtime.real, shape=average.particles.count)

    @ti.kernel
    def read(self):
        for p in range(self.average.particles.count):
            self.found[p] = self.average.mean(p)

    def __call__(self, norm):
        self.average.norm.from_numpy(np.append(norm, 0.0))
        self.read()
        return self.found.to_numpy()


def points_at(place, volume=None):
    count = len(place)
    particles = Particles(count)
    particles.load(
        {
            "position": place,
            "velocity": np.zeros((count, 2)),
            "stress": np.zeros((count, 4)),
            "mass": np.ones(count),
            "volume": np.ones(count) if volume is None else volume,
            "path": np.zeros(count),
        }  # fmt: skip
    )
    return particles


def scattered(count=600, size=0.03, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, size, (count, 2)), rng.uniform(0.5, 2.0, count), rng.uniform(0.0, 5.0, count)


def by_definition(kernel, place, volume, norm):
    distance = np.linalg.norm(place[:, None] - place[None], axis=2)
    ratio = distance / kernel.length_m
    weight = np.exp(-(ratio**2 if isinstance(kernel, Gaussian) else ratio)) * (distance <= kernel.CUT * LENGTH)
    weight = weight * volume
    return weight @ norm / weight.sum(axis=1)


@pytest.mark.parametrize("kernel", KERNELS, ids=["gaussian", "exponential"])
def test_it_is_the_mean_by_definition(kernel):
    place, volume, norm = scattered()
    average = NonLocal(kernel, points_at(place, volume), 0.03 / math.sqrt(600))
    average.refresh()
    assert np.abs(Means(average)(norm) - by_definition(kernel, place, volume, norm)).max() < 1e-13


def test_cost_grows_with_points_times_neighbours():
    spacing, pairs = 0.5e-3, []
    for across in (30, 60, 120):
        x, y = np.meshgrid(np.arange(across) * spacing, np.arange(across) * spacing)
        average = NonLocal(Gaussian(LENGTH), points_at(np.stack([x.ravel(), y.ravel()], axis=1)), spacing)
        average.refresh()
        pairs.append(average.rows.pairs / across**2)
    inside = sum(i * i + j * j <= 81 for i in range(-9, 10) for j in range(-9, 10))
    assert pairs[0] < pairs[1] < pairs[2] < inside  # fewer neighbours at the edges only
    assert pairs[2] > 0.9 * inside


def in_a_shear_zone(amount):
    """A lattice and the same lattice after a shear zone has moved its points by up to `amount`."""
    spacing = 0.75e-3
    x, y = np.meshgrid(np.arange(40) * spacing, np.arange(40) * spacing)
    place = np.stack([x.ravel(), y.ravel()], axis=1)
    profile = np.exp(-(((place[:, 0] - 0.015) / 0.003) ** 2))
    moved = place + np.stack([0.2 * amount * profile, amount * np.tanh((place[:, 0] - 0.015) / 0.003)], axis=1)
    return place, moved, profile, spacing


def moved_after_building(place, moved, spacing):
    average = NonLocal(Gaussian(LENGTH), points_at(place), spacing)
    average.refresh()
    average.particles.position.from_numpy(moved)
    return average


def test_kept_rows_give_the_answer_of_new_ones_as_long_as_they_are_kept_and_later_would_be_wrong():
    for moves, low, high in ((0.98 * 0.02 * LENGTH, 0.0, 2e-3), (2.0 * LENGTH, 0.02, np.inf)):
        place, moved, norm, spacing = in_a_shear_zone(moves)
        average = moved_after_building(place, moved, spacing)
        kept = Means(average)(norm)
        average.rows.build()
        assert low < np.abs(kept - Means(average)(norm)).max() / norm.max() < high
        assert np.abs(kept - norm).max() > 0.05 * norm.max()  # the average itself changes much more


def test_rows_are_built_anew_once_half_of_the_allowed_displacement_is_used_up():
    allowed = 0.02 * LENGTH
    for amount, builds in ((0.4, 1), (0.6, 2)):
        place, moved, _, spacing = in_a_shear_zone(amount * allowed)
        average = moved_after_building(place, moved, spacing)
        average.refresh()
        assert average.rows.builds == builds


def test_points_that_clump_beyond_the_room_of_the_rows_stop_the_run():
    place = np.full((400, 2), 0.01) + np.random.default_rng(3).uniform(0.0, 1e-4, (400, 2))
    with pytest.raises(RunFailed, match="clumped"):
        NonLocal(Gaussian(LENGTH), points_at(place), 1.5e-3).refresh()


def test_a_length_that_is_not_positive_is_refused():
    for length in (0.0, -1e-3):
        with pytest.raises(ValueError, match="above 0"):
            NonLocal(Gaussian(length), points_at(np.zeros((4, 2))), 1e-3)


@pytest.mark.parametrize(
    ("spacing_mm", "weight"), [(0.83, 0.098), (1.25, 0.221), (1.66, 0.389), (2.5, 0.791), (5.0, 1.0)]
)
def test_share_of_the_own_weight_on_a_lattice(spacing_mm, weight):
    """On the paper's silo grid, 5 mm, the average is local."""
    assert self_weight(Gaussian(LENGTH), 1e-3 * spacing_mm) == pytest.approx(weight, abs=2e-3)


def test_a_scene_says_when_non_locality_is_inactive_and_then_leaves_it_out():
    coarse, fine = Scene(), Scene(grid=Mesh(cell_size_m=0.0025))
    kernel, sentence = kernel_of(coarse)
    assert kernel is None
    assert sentence.startswith("Non-locality is inactive")
    kernel, sentence = kernel_of(fine)
    assert kernel == Gaussian(LENGTH)
    assert sentence.startswith("Non-locality is active")
    kernel, sentence = kernel_of(fine.model_copy(update={"averaging": Averaging(characteristic_length_m=0.0)}))
    assert kernel is None
    assert "local" in sentence
    printed = Scene(averaging=Averaging(weight="exponential"))  # its tail reaches the next point even at 5 mm
    assert kernel_of(printed)[0] == Exponential(LENGTH)


def kernel_of(scene):
    return scene.averaging.kernel(scene.sand, scene.spacing_m)


def test_a_non_local_step_differs_from_a_local_one():
    ends = []
    for length in (3e-3, 0.0):
        runtime.init()
        scene = Scene(
            silo=Silo(width_m=0.04, height_m=0.08), grid=Mesh(cell_size_m=0.0025), walls=Walls(kind="very-rough"),
            averaging=Averaging(characteristic_length_m=length),
        )  # fmt: skip
        simulation = Simulation(scene)
        state = simulation.model.particles.arrays()
        count = simulation.model.particles.count
        state["stress"] = np.tile([-3e3, -5e3, -3e3, 0.0], (count, 1))
        state["velocity"] = np.random.default_rng(4).normal(0.0, 0.01, (count, 2))
        simulation.model.particles.load(state)
        simulation.solver.advance(150, 1e-5, gravity=(0.0, 9.81), plate_velocity=(0.0, -0.02))
        ends.append(simulation.model.particles.arrays()["stress"])
        assert not length or simulation.solver.averaging.rows.pairs > 10 * count
    assert np.abs(ends[0] - ends[1]).max() > 1e-4 * np.abs(ends[0]).max()


def test_rows_are_built_anew_when_other_volumes_are_loaded_at_the_same_places():
    place, volume, norm = scattered(seed=5)
    particles = points_at(place)
    average = NonLocal(Gaussian(LENGTH), particles, 0.03 / math.sqrt(600))
    average.refresh()
    particles.load(particles.arrays() | {"volume": volume})
    average.refresh()
    assert np.abs(Means(average)(norm) - by_definition(Gaussian(LENGTH), place, volume, norm)).max() < 1e-13


def test_sand_at_rest_is_looked_at_again_after_some_hundred_steps():
    average = NonLocal(Gaussian(LENGTH), points_at(scattered()[0]), 0.03 / math.sqrt(600))
    assert average.steps_within(0.0, 1e-6) <= 500
    assert average.steps_within(10.0, 1e-5) == 1


def test_walls_that_count_hold_the_shares_of_the_kernel_beyond_them():
    """Of a field alike everywhere; parallel planes share what is left of it, planes across multiply."""
    runtime.init()
    kernel, half = Gaussian(LENGTH), 0.6 * LENGTH
    spacing = LENGTH / 3.0
    line = (np.arange(-40, 41)) * spacing
    x, y = np.meshgrid(line, line)
    place = np.stack([x.ravel(), y.ravel()], axis=1)
    middle = np.argmin(np.hypot(*place.T))
    beyond = kernel.beyond(half)
    for planes, left in (
        ([(0, 1, half), (0, -1, -half)], 1.0 - 2.0 * beyond),
        ([(0, 1, half), (1, -1, -half)], (1.0 - beyond) ** 2),
    ):
        mean = Means(NonLocal(kernel, points_at(place), spacing, rigid_planes=planes))
        mean.average.refresh()
        assert mean(np.ones(len(place)))[middle] == pytest.approx(left, rel=1e-9)
