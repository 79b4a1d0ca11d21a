"""The non-local average: a weighted mean over neighbours, in sparse rows or by way of a grid."""

import math

import numpy as np
import pytest

from taichi_silo.errors import RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.grid_means import GridMeans
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.neighbour_rows import NeighbourRows
from taichi_silo.mpm.nonlocal_average import Exponential, Gaussian, NonLocal, self_weight, summed_by
from taichi_silo.mpm.particles import Particles
from taichi_silo.scene.scene import Averaging, Mesh, Scene, Silo, Walls
from taichi_silo.simulation.simulation import Simulation

LENGTH = 1.5e-3
KERNELS = [Gaussian(LENGTH), Exponential(LENGTH)]


@ti.data_oriented
class Reading:
    """Reads the means of all points."""

    def __init__(self, means):
        self.means, self.add = means, means.add
        self.value, self.found = (ti.field(runtime.real, shape=means.particles.count) for _ in range(2))

    @ti.kernel
    def read(self):
        ti.loop_config(serialize=True)
        for p in range(self.means.particles.count):
            self.means.give(self, p, self.value[p], p % self.means.copies)
        for run in ti.static(self.means.passes()):
            ti.loop_config(serialize=True)
            for j in range(self.means.rows):
                run(j)
        ti.loop_config(serialize=True)
        for p in range(self.means.particles.count):
            self.found[p] = self.means.mean(p)

    def __call__(self, values):
        self.value.from_numpy(np.asarray(values, dtype=float))
        self.read()
        return self.found.to_numpy()


def rows_of(kernel, place, spacing, volume=None, rigid_planes=()):
    return NeighbourRows(kernel, points_at(place, volume), spacing, rigid_planes)


def grid_of(kernel, place, spacing, volume=None, rigid_planes=(), mirrored=False):
    low, high = place.min(axis=0), place.max(axis=0)
    assert (low > -2.0 * spacing).all()
    grid = Grid(spacing * math.ceil(high[0] / spacing - 1e-9), high[1], spacing)
    return GridMeans(kernel, points_at(place, volume), grid, mirrored, rigid_planes)


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
    means = rows_of(kernel, place, 0.03 / math.sqrt(600), volume)
    means.build()
    assert np.abs(Reading(means)(norm) - by_definition(kernel, place, volume, norm)).max() < 1e-13


def test_cost_grows_with_points_times_neighbours():
    spacing, pairs = 0.5e-3, []
    for across in (30, 60, 120):
        x, y = np.meshgrid(np.arange(across) * spacing, np.arange(across) * spacing)
        means = rows_of(Gaussian(LENGTH), np.stack([x.ravel(), y.ravel()], axis=1), spacing)
        means.build()
        pairs.append(means.pairs / across**2)
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


def average_of(place, spacing, **options):
    return NonLocal(Gaussian(LENGTH), points_at(place), spacing, **options)


@pytest.mark.parametrize("made_of", [rows_of, grid_of])
def test_kept_means_are_those_of_new_ones_as_long_as_they_are_kept_and_later_would_be_wrong(made_of):
    for moves, low, high in ((0.98 * 0.02 * LENGTH, 0.0, 2e-3), (2.0 * LENGTH, 0.02, np.inf)):
        place, moved, norm, spacing = in_a_shear_zone(moves)
        means = made_of(Gaussian(LENGTH), place, spacing)
        means.build()
        means.particles.position.from_numpy(moved)
        kept = Reading(means)(norm)
        means.build()
        assert low < np.abs(kept - Reading(means)(norm)).max() / norm.max() < high
        assert np.abs(kept - norm).max() > 0.05 * norm.max()  # the average itself changes much more


def test_rows_are_built_anew_once_half_of_the_allowed_displacement_is_used_up():
    allowed = 0.02 * LENGTH
    for amount, builds in ((0.4, 1), (0.6, 2)):
        place, moved, _, spacing = in_a_shear_zone(amount * allowed)
        average = average_of(place, spacing)
        average.refresh()
        average.means.particles.position.from_numpy(moved)
        average.refresh()
        assert average.means.builds == builds


def test_points_that_clump_beyond_the_room_of_the_rows_stop_the_run():
    place = np.full((400, 2), 0.01) + np.random.default_rng(3).uniform(0.0, 1e-4, (400, 2))
    with pytest.raises(RunFailed, match="clumped"):
        rows_of(Gaussian(LENGTH), place, 1.5e-3).build()


def test_a_length_that_is_not_positive_is_refused():
    for length in (0.0, -1e-3):
        with pytest.raises(ValueError, match="above 0"):
            rows_of(Gaussian(length), np.zeros((4, 2)), 1e-3)


@pytest.mark.parametrize(
    ("spacing_mm", "weight"), [(0.83, 0.098), (1.25, 0.221), (1.66, 0.389), (2.5, 0.791), (5.0, 1.0)]
)
def test_share_of_the_own_weight_on_a_lattice(spacing_mm, weight):
    """On the paper's silo grid, 5 mm, the average is local."""
    assert self_weight(Gaussian(LENGTH), 1e-3 * spacing_mm) == pytest.approx(weight, abs=2e-3)


def test_a_scene_says_when_non_locality_is_inactive_and_then_leaves_it_out():
    smooth = Walls(kind="smooth", friction_angle_deg=19.0)
    coarse, fine = Scene(walls=smooth), Scene(walls=smooth, grid=Mesh(cell_size_m=0.0025))
    assert kernel_of(Scene())[0].length_m == pytest.approx(0.0025), "half a cell, between very rough walls"
    kernel, sentence = kernel_of(coarse)
    assert kernel is None
    assert sentence.startswith("Non-locality is inactive")
    kernel, sentence = kernel_of(fine)
    assert kernel == Gaussian(LENGTH)
    assert sentence.startswith("Non-locality is active")
    kernel, sentence = kernel_of(fine.model_copy(update={"averaging": Averaging(characteristic_length_m=0.0)}))
    assert kernel is None
    assert "local" in sentence
    printed = Scene(
        averaging=Averaging(weight="exponential"), walls=smooth
    )  # its tail reaches the next point even at 5 mm
    assert kernel_of(printed)[0] == Exponential(LENGTH)


def kernel_of(scene):
    return scene.averaging.kernel(scene.characteristic_length_m, scene.spacing_m)


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
        assert not length or simulation.solver.averaging.means.pairs > 10 * count
    assert np.abs(ends[0] - ends[1]).max() > 1e-4 * np.abs(ends[0]).max()


def test_means_are_built_anew_when_other_volumes_are_loaded_at_the_same_places():
    place, volume, norm = scattered(seed=5)
    average = average_of(place, 0.03 / math.sqrt(600))
    average.refresh()
    particles = average.means.particles
    particles.load(particles.arrays() | {"volume": volume})
    average.refresh()
    assert np.abs(Reading(average.means)(norm) - by_definition(Gaussian(LENGTH), place, volume, norm)).max() < 1e-13


def test_sand_at_rest_is_looked_at_again_after_some_hundred_steps():
    average = average_of(scattered()[0], 0.03 / math.sqrt(600))
    assert average.steps_within(0.0, 1e-6) <= 500
    assert average.steps_within(10.0, 1e-5) == 1


@pytest.mark.parametrize(("made_of", "error"), [(rows_of, 1e-9), (grid_of, 1e-9)])
def test_walls_that_count_hold_the_shares_of_the_kernel_beyond_them(made_of, error):
    """Of a field alike everywhere; parallel planes share what is left of it, planes across multiply."""
    runtime.init()
    kernel, half = Gaussian(LENGTH), 0.6 * LENGTH
    spacing = LENGTH / 3.0
    at = 40 * spacing
    x, y = np.meshgrid(np.arange(81) * spacing, np.arange(81) * spacing)
    place = np.stack([x.ravel(), y.ravel()], axis=1)
    middle = np.argmin(np.hypot(*(place - at).T))
    beyond = kernel.beyond(half)
    for planes, left in (
        ([(0, 1, at + half), (0, -1, at - half)], 1.0 - 2.0 * beyond),
        ([(0, 1, at + half), (1, -1, at - half)], (1.0 - beyond) ** 2),
    ):
        means = made_of(kernel, place, spacing, rigid_planes=planes)
        means.build()
        assert Reading(means)(np.ones(len(place)))[middle] == pytest.approx(left, rel=error)


FIELDS = {  # over the distance from the wall and along it, over l_c
    "a wall's zone": lambda x, y: np.exp(-0.5 * x) + 0.1 * np.cos(0.7 * y),
    "a narrow zone across": lambda x, y: np.exp(-((0.8 * (x - y) / 1.0) ** 2)),
    "noise": lambda x, y: 1.0 + 0.3 * np.random.default_rng(1).standard_normal(len(x)),
    "a jump": lambda x, y: 1.0 * (x + 0.5 * y > 7.0),
}


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("per_length", [1.5, 2.0, 4.0])
def test_means_by_the_grid_are_those_over_rows_within_one_per_cent(field, per_length):
    """At walls, in corners and at a free surface too, on lattices and between scattered points; 1.5 % at a jump."""
    spacing, bound = LENGTH / per_length, 0.015 if field == "a jump" else 0.01
    x, y = np.meshgrid(*[np.arange(0.5, 14 * per_length) * spacing] * 2)
    lattice = np.stack([x.ravel(), y.ravel()], axis=1)
    shaken = lattice + 0.3 * spacing * np.random.default_rng(2).uniform(-1.0, 1.0, lattice.shape)
    volume = spacing**2 * np.random.default_rng(3).uniform(0.8, 1.2, len(lattice))
    for place in (lattice, shaken):
        values = FIELDS[field](*(place.T / LENGTH))
        found = []
        for made_of in (rows_of, grid_of):
            means = made_of(Gaussian(LENGTH), place, spacing, volume)
            means.build()
            found.append(Reading(means)(values))
        assert np.abs(found[1] - found[0]).max() < bound * np.abs(values).max()


def test_beyond_an_axis_of_symmetry_the_grid_finds_the_mirror_image():
    spacing = LENGTH / 2.0
    x, y = np.meshgrid(np.arange(0.5, 20) * spacing, np.arange(0.5, 20) * spacing)
    half = np.stack([x.ravel(), y.ravel()], axis=1)
    whole = np.concatenate([half, [40 * spacing, 0.0] + half * [-1.0, 1.0]])
    values = np.random.default_rng(4).uniform(0.0, 1.0, len(half))
    found = []
    for place, given, mirrored in ((half, values, True), (whole, np.tile(values, 2), False)):
        means = grid_of(Gaussian(LENGTH), place, spacing, mirrored=mirrored)
        means.build()
        found.append(Reading(means)(given)[: len(half)])
    # nodes lie elsewhere in the whole, so the two differ as the grid's means differ from those over rows
    assert np.abs(found[0] - found[1]).max() < 0.01
    rows = rows_of(Gaussian(LENGTH), whole, spacing)
    rows.build()
    assert np.abs(found[0] - Reading(rows)(np.tile(values, 2))[: len(half)]).max() < 0.01


def test_the_grids_kernel_has_the_moments_of_the_gaussian():
    """Far from every edge a variance of l_c^2 / 2, and where nodes lie averaged out no fourth cumulant."""
    spacing = LENGTH / 6.0  # four points to a node
    x, y = np.meshgrid(np.arange(0.5, 84) * spacing, np.arange(0.5, 84) * spacing)
    place = np.stack([x.ravel(), y.ravel()], axis=1)
    means = grid_of(Gaussian(LENGTH), place, spacing)
    means.build()
    read, some = Reading(means), [k * 84 + k for k in range(42, 46)]
    for axis in (0, 1):
        moments = []
        for at in some:
            away = (place[:, axis] - place[at, axis]) / LENGTH
            moments.append([read(away**power)[at] for power in (2, 4)])
        assert [variance for variance, _ in moments] == pytest.approx([0.5] * 4, rel=1e-9)
        assert np.mean(moments, axis=0)[1] == pytest.approx(0.75, rel=1e-3)


@pytest.mark.parametrize(("across", "by"), [(1.2, "rows"), (1.49, "rows"), (1.51, "grid"), (4.0, "grid")])
def test_means_of_a_gaussian_are_summed_by_the_grid_from_one_and_a_half_spacings_on(across, by):
    assert summed_by(Gaussian(LENGTH), LENGTH / across) == by
    assert summed_by(Exponential(LENGTH), LENGTH / across) == "rows"
