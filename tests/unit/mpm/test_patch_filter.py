"""The filter that acts by strain: what varies from point to point fades as sand is sheared, and nothing else does."""

import math

import numpy as np
import pytest

from taichi_silo.mpm import felt_part, patch_filter, runtime
from taichi_silo.mpm.felt_part import FeltPart
from taichi_silo.mpm.field_memory import put
from taichi_silo.mpm.geometry import Axisymmetric, PlaneStrain
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.patch_filter import STRAIN, PatchFilter
from taichi_silo.mpm.patch_passes import PatchPasses
from taichi_silo.mpm.shapes import ContiguousGimp, ConvectedDomain, UniformGimp
from taichi_silo.scene.sand import Sand
from validation.stability.bodies import block, change, solver
from validation.stability.rotation import CELL as TURNED_CELL
from validation.stability.rotation import carried_round

CELL, CELLS = 0.01, 16
SHEARED = 0.1  # path of the strain from which nothing is remembered
LARGE = 40.0 * STRAIN  # after so much strain nothing is left of what fades


@pytest.fixture
def forgetful(monkeypatch):
    """An elastic law that forgets from the first strain."""
    monkeypatch.setattr(Elastic, "FORGETS", True)
    monkeypatch.setattr(patch_filter, "FORGETS", 1e-9)


def filtered(stress, per_axis=1, strain=LARGE, jitter=0.0, shift=0.0, turns=1, sheared=SHEARED, packed=(), law=Elastic):
    """Stresses before and after turns of the filter, each after a strain, and the places of the points [cells]."""
    runtime.init()
    size = CELLS * CELL
    particles, grid = block(
        width=size, height=size, cell=CELL, points_per_axis=per_axis, box=(size + CELL, size + CELL)
    )
    rng = np.random.default_rng(3)
    place = particles.arrays()["position"]
    place = place + CELL * (shift + jitter / per_axis * rng.uniform(-1.0, 1.0, place.shape))
    given = stress(place / CELL)
    # the elastic law admits any stress; here it forgets, too, because it has been sheared
    volume = (CELL / per_axis) ** 2 * (1.0 + 0.2 * jitter * rng.uniform(-1.0, 1.0, len(place)))
    volume[list(packed)] *= 0.85
    change(particles, position=place, stress=given, volume=volume, path=np.full(len(place), sheared))
    patch = PatchFilter(particles, grid, law(1e6, 0.0))
    for _ in range(turns):
        patch.begin()
        particles.path.from_numpy(particles.path.to_numpy() + strain)
        patch.turn()
    return given, particles.arrays()["stress"], place / CELL


def inner(place, width=3.5):
    """Which points lie so many cells within the block."""
    return ((place > width) & (place < CELLS - width)).all(axis=1)


def alternating(per_axis, along):
    """A pattern that changes its sign from point to point along some axes."""

    def stress(place):
        number = np.floor(place * per_axis + 1e-9)[:, along].sum(axis=1)
        return 1e3 * np.outer((-1.0) ** number, [1.0, 1.0, 1.0, 0.5])

    return stress


def linear(place):
    x, y = place.T
    return np.stack([1e3 * x, 2e3 * y - 1e3, 0.0 * x, 500.0 * (x + y)], axis=1)


class Packing(Elastic):
    """It has room above a void ratio of 0.6."""

    @ti.func
    def room(self, stress, void_ratio):
        return ti.min(1.0, ti.max(0.0, 10.0 * (void_ratio - 0.6)))


def test_sand_as_dense_as_it_can_be_keeps_its_stress():
    """Nothing else would keep it from being packed further."""
    packed = 2 * CELLS * (2 * CELLS // 2) + CELLS  # e = 0.50; all others have 0.77
    before, after, _place = filtered(alternating(2, [0, 1]), 2, packed=[packed], law=Packing)
    assert (after[packed] == before[packed]).all()
    assert np.abs(after[packed + 1]).max() < 0.1 * np.abs(before[packed + 1]).max()


@pytest.mark.parametrize("per_axis, jitter", [(1, 0.0), (2, 0.4)])
def test_linear_fields_stay_at_the_edges_too(per_axis, jitter):
    before, after, _place = filtered(linear, per_axis, jitter=jitter)
    assert np.abs(after - before).max() < 1e-9 * np.abs(before).max()


@pytest.mark.parametrize("along", [[0], [1], [0, 1]])
@pytest.mark.parametrize("per_axis, shift, most", [(1, 0.0, 0.02), (1, 0.5, 0.69), (2, 0.0, 0.02), (3, 0.0, 0.3)])
def test_what_alternates_from_point_to_point_fades(per_axis, shift, most, along):
    """On the nodes a quadratic weight of one point a cell feels three quarters of it: a turn takes (3/4)^4."""
    before, after, place = filtered(alternating(per_axis, along), per_axis, shift=shift)
    here = inner(place)
    assert np.abs(after[here]).max() < most * np.abs(before[here]).max()


def test_it_fades_with_strain_whatever_the_turns():
    board = alternating(2, [0, 1])
    before, once, place = filtered(board, 2, strain=STRAIN)
    _, twice, _ = filtered(board, 2, strain=0.5 * STRAIN, turns=2)
    here = inner(place)
    assert once[here] == pytest.approx(math.exp(-1.0) * before[here], rel=0.05)
    assert twice[here] == pytest.approx(once[here], rel=0.02)


def test_a_thousandth_of_strain_takes_nearly_all_of_it():
    before, after, place = filtered(alternating(1, [0]), strain=1e-3)
    here = inner(place)
    assert 0.01 < np.abs(after[here]).max() / np.abs(before[here]).max() < 0.1


def test_without_strain_nothing_changes():
    before, after, _place = filtered(alternating(2, [0, 1]), 2, strain=0.0)
    assert (after == before).all()


def test_little_happens_to_sand_that_has_hardly_been_sheared():
    """A path of 0.001 is that of filling."""
    before, after, place = filtered(alternating(2, [0, 1]), 2, strain=1e-3, sheared=0.0)
    here = inner(place)
    assert after[here] == pytest.approx(before[here], rel=0.01)


def test_its_error_is_of_eighth_order():
    """A wave of 8 cells loses 2^8 times as much as one of 16 cells."""

    def lost(wave):
        k = 2.0 * math.pi / wave
        before, after, place = filtered(lambda place: np.outer(np.cos(k * (place[:, 0] - 8.0)), [1e3] * 3 + [0.0]))
        here = inner(place, 5.0)
        return np.abs((after - before)[here]).max()

    assert lost(8.0) / lost(16.0) == pytest.approx(256.0, rel=0.5)
    assert lost(8.0) < 0.001 * 1e3


def uneven(place):
    """A stress, isotropic in the plane, that varies by a fifth over 10 cells: it stays itself as it turns."""
    wave = 1.0 + 0.2 * np.sin(0.6 * place[:, 0] / TURNED_CELL) * np.cos(0.6 * place[:, 1] / TURNED_CELL)
    return np.outer(wave, [-1e3, -1e3, 0.0, 0.0])


@pytest.mark.parametrize("per_axis", [1, 2])
def test_a_body_that_turns_keeps_an_uneven_stress(per_axis, forgetful):
    """A quarter of a turn of a disc of 40 cells: it strains no more than round its edge, so nothing fades within.

    (What the grid sees of a rotation is a strain rate of some hundredths of it.)
    """
    shape = UniformGimp(0.5 / per_axis)
    ends = [
        carried_round(shape, lambda radius: 0.0 * radius + 1.0, 0.5 * math.pi, 200, uneven, per_axis, filtering)
        for filtering in (None, PatchFilter)
    ]
    within = ends[0][1] < 0.7
    plain, kept = (particles.arrays()["stress"][within] for particles, _radius in ends)
    assert np.abs(kept - plain).max() < 0.01 * 1e3


def test_a_body_that_is_carried_keeps_any_stress(forgetful):
    """Over 20 cells, from point to point too."""
    runtime.init()
    particles, grid = block(width=0.08, height=0.08, cell=CELL, points_per_axis=2, box=(0.4, 0.12), origin=(0.05, 0.02))
    law = Elastic(0.0, 0.0)
    body = solver(particles, grid, UniformGimp(0.25), law, filtering=PatchFilter)
    place = particles.arrays()["position"]
    given = 1e-6 * np.outer(alternating(2, [0, 1])(place / CELL)[:, 0], [1.0, 1.0, 1.0, 0.0])
    change(particles, stress=given, velocity=np.tile([4.0, 0.0], (len(place), 1)))
    body.advance(500, 1e-4)
    now = particles.arrays()
    assert now["position"] == pytest.approx(place + [20 * CELL, 0.0], abs=1e-6)
    assert now["stress"] == pytest.approx(given, rel=0.01)


@pytest.mark.parametrize("geometry", [PlaneStrain(), Axisymmetric()])
@pytest.mark.parametrize("shape", [UniformGimp(0.25), ContiguousGimp(0.25), ConvectedDomain(0.25)])
def test_what_nodes_feel_of_a_pattern_is_taken_out_and_what_they_do_not_feel_stays(shape, geometry, monkeypatch):
    """A second time there is nothing to take out, and the forces are those of a hundredth of the pattern.

    (Of a random one, which has long waves, too; the passes leave none of those, and fewer steps do.)
    """
    monkeypatch.setattr(felt_part, "STEPS", 60)
    monkeypatch.setattr(felt_part, "LEFT", 1e-3)
    runtime.init()
    particles, grid = block(width=0.08, height=0.08, cell=CELL, points_per_axis=2, box=(0.2, 0.2), origin=(0.05, 0.05),
                            extra=("domain",) * shape.DOMAIN)  # fmt: skip
    rng = np.random.default_rng(5)
    place = particles.arrays()["position"]
    change(particles, position=place + 0.2 * CELL * rng.uniform(-0.5, 0.5, place.shape))
    if shape.DOMAIN:
        change(particles, domain=np.tile([0.5 * CELL, 0.0, 0.0, 0.5 * CELL], (len(place), 1)))
    felt, passes = FeltPart(particles, grid, shape, geometry), PatchPasses(particles, grid, False)
    passes.hold()
    given = np.zeros(passes.points.to_numpy().shape)
    given[: len(place), :4] = 1e3 * rng.uniform(-1.0, 1.0, (len(place), 4))
    given[:, 6] = 1.0  # all may give way
    passes.points.from_numpy(given)
    forces = [np.linalg.norm(felt._forces(passes.points, False))]
    left = []
    for _ in range(2):
        put(felt.grid.mass, 0.0)
        felt.take_out(passes.points)
        left.append(passes.points.to_numpy()[: len(place), :4])
        forces.append(np.linalg.norm(felt._forces(passes.points, False)))
    volume = particles.arrays()["volume"][:, None] * np.array([1.0, 1.0, geometry.HOOP, 2.0])
    assert forces[1] < 0.02 * forces[0]
    assert (volume * (given[: len(place), :4] - left[0]) * left[0]).sum() < 0.01 * (volume * left[0] ** 2).sum()
    assert (volume * (left[1] - left[0]) ** 2).sum() < 1e-3 * (volume * left[0] ** 2).sum()
    assert (volume * left[0] ** 2).sum() > 0.5 * (volume * given[: len(place), :4] ** 2).sum()
    if not geometry.HOOP:
        assert (left[0][:, 2] == given[: len(place), 2]).all()


@pytest.mark.parametrize("leaves", [True, False])
def test_a_filter_that_leaves_what_nodes_feel_changes_no_force(leaves):
    """A kink of the stress, as beside a body, is felt and stays; what alternates from point to point fades."""
    runtime.init()
    size = CELLS * CELL
    particles, grid = block(width=size, height=size, cell=CELL, points_per_axis=2, box=(size + CELL, size + CELL))
    place = particles.arrays()["position"] / CELL
    kink = np.outer(1e3 * np.abs(place[:, 0] - 8.2) * (place[:, 1] > 6.3), [1.0, 0.0, 0.0, 0.5])
    board = 0.1 * alternating(2, [0, 1])(place)
    change(particles, stress=kink + board, path=np.full(len(place), SHEARED))
    felt = FeltPart(particles, grid, UniformGimp(0.25), PlaneStrain())
    patch = PatchFilter(particles, grid, Elastic(1e6, 0.0), felt=felt if leaves else None)
    patch.passes.hold()
    seen = []

    def forces():
        rows = np.zeros(patch.passes.points.to_numpy().shape)
        rows[: len(place), :4] = particles.arrays()["stress"]
        patch.passes.points.from_numpy(rows)
        seen.append(felt._forces(patch.passes.points, False))
        put(felt.grid.mass, 0.0)

    forces()
    patch.begin()
    particles.path.from_numpy(particles.path.to_numpy() + LARGE)
    patch.turn()
    forces()
    changed = np.abs(seen[1] - seen[0]).max() / np.abs(seen[0]).max()
    assert changed < 0.01 if leaves else changed > 0.05
    here = inner(place) & (np.abs(place[:, 0] - 8.2) > 3.0) & (np.abs(place[:, 1] - 6.3) > 3.0)
    assert np.abs(particles.arrays()["stress"] - kink)[here].max() < 0.2 * np.abs(board).max()


def test_sand_that_would_be_pulled_stays_in_compression_and_costs_a_fifth_of_what_nodes_feel_at_most():
    """Many points bear next to nothing, as at a free surface, and half of them have been sheared."""
    runtime.init()
    size = CELLS * CELL
    particles, grid = block(width=size, height=size, cell=CELL, points_per_axis=2, box=(size + CELL, size + CELL))
    rng = np.random.default_rng(8)
    pressure = 1.5 + 1e3 * rng.uniform(0.0, 1.0, particles.number) ** 4
    before = np.outer(-pressure, [1.0, 1.0, 1.0, 0.0])
    path = np.full(particles.number, SHEARED)
    lost = []
    for leaves in (True, False):
        felt = FeltPart(particles, grid, UniformGimp(0.25), PlaneStrain())
        patch = PatchFilter(
            particles, grid, Sand(law="gudehus-bauer").constitutive_law(), felt=felt if leaves else None
        )
        patch.passes.hold()
        change(particles, stress=before, path=path)
        particles.revision += 1
        patch.begin()
        change(particles, path=path + 2.0 * STRAIN * (rng.uniform(size=len(path)) < 0.5))
        patch.turn()
        after = particles.arrays()["stress"]
        rows = np.zeros(patch.passes.points.to_numpy().shape)
        rows[: len(after), :4] = after - before
        patch.passes.points.from_numpy(rows)
        lost.append(np.linalg.norm(felt._forces(patch.passes.points, False)))
        xx, yy, _, xy = after.T
        assert (xx < 0.0).all() and (xx * yy > xy**2 * (1.0 - 1e-9)).all()
        assert np.abs(after - before).mean() > 0.1 * pressure.mean()
    assert lost[0] < 0.2 * lost[1]


def test_sand_as_dense_as_it_can_be_gives_no_way_to_its_neighbours_either():
    """Every third point has no room left; what nodes feel is taken from the others alone."""
    runtime.init()
    size = CELLS * CELL
    particles, grid = block(width=size, height=size, cell=CELL, points_per_axis=2, box=(size + CELL, size + CELL))
    law = Sand(law="gudehus-bauer").constitutive_law()
    felt = FeltPart(particles, grid, UniformGimp(0.25), PlaneStrain())
    patch = PatchFilter(particles, grid, law, felt=felt)
    pressure = 1e3 * (1.0 + np.random.default_rng(9).uniform(0.0, 1.0, particles.number))
    before, path = np.outer(-pressure, [1.0, 1.0, 1.0, 0.0]), np.full(particles.number, SHEARED)
    dense = np.arange(particles.number) % 3 == 0
    void_ratio = np.where(dense, 0.9 * Sand().e_d0, 0.5 * (Sand().e_d0 + Sand().e_c0))
    volume = particles.arrays()["volume"]
    change(particles, stress=before, path=path, mass=volume * law.grain_density / (1.0 + void_ratio))
    particles.revision += 1
    patch.begin()
    change(particles, path=path + STRAIN)
    patch.turn()
    after = particles.arrays()["stress"]
    assert (after[dense] == before[dense]).all()
    assert np.abs(after - before)[~dense].mean() > 0.05 * pressure.mean()
