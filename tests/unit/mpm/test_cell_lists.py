"""Points give to nodes without atomics: every node finds all its points, in an order that is always the same."""

import numpy as np
import pytest

from taichi_silo.mpm import runtime
from taichi_silo.mpm.cell_lists import CellLists
from taichi_silo.mpm.grid import Grid
from taichi_silo.mpm.language import ti
from taichi_silo.mpm.laws import Elastic
from taichi_silo.mpm.particles import Particles
from taichi_silo.mpm.shapes import ConvectedDomain, UniformGimp


@ti.data_oriented
class Asked:
    """Counts how often point p is visited, and what numbers came one after the other."""

    def __init__(self, lists, found):
        self.lists, self.found = lists, found

    @ti.func
    def visit(self, p):
        self.found[0] += 1
        self.found[self.found[0]] = p

    @ti.kernel
    def ask(self, patch: ti.template(), i: ti.i32, j: ti.i32):
        for _ in range(1):
            self.found[0] = 0
            self.lists.ask(self, patch, i, j, 0)


def points(place, cell=0.1, domain=True):
    runtime.init()
    particles = Particles.lattice(Elastic(1e6), 0.1, 0.1, 0.1, extra=("domain",) if domain else ())
    several = Particles(len(place), ("domain",) if domain else ())
    edges = {"domain": np.tile([0.5 * cell, 0.0, 0.0, 0.5 * cell], (len(place), 1))} if domain else {}
    one = particles.arrays()
    several.load({n: np.repeat(v, len(place), axis=0) for n, v in one.items()} | {"position": place} | edges)
    return several


def asked(lists, patch, i, j):
    found = runtime.whole_numbers((1 + 16 * lists.particles.count,))[0]
    Asked(lists, found).ask(patch, i, j)
    numbers = found.to_numpy()
    return numbers[1 : 1 + numbers[0]]


@pytest.mark.parametrize("crowd", [1, 60])
def test_a_node_finds_its_points_in_the_order_of_their_numbers_however_many_stand_in_a_cell(crowd):
    rng = np.random.default_rng(1)
    place = np.concatenate([rng.uniform(0.0, 0.5, (40, 2)), rng.uniform(0.2, 0.21, (crowd, 2))])
    place = rng.permutation(place)
    particles, grid, shape = points(place, domain=False), Grid(0.5, 0.5, 0.1), UniformGimp()
    lists = CellLists(particles, grid, shape)
    if crowd > 1:
        lists.room = 8
    lists.fill(0)
    first = np.floor(place / 0.1 - 0.5).astype(int) + 2
    for i, j in ((4, 4), (2, 3), (7, 7)):
        there = ((first <= (i, j)) & (first > (i - 3, j - 3))).all(axis=1)
        found = asked(lists, 0, i, j)
        assert set(np.nonzero(there)[0]) <= set(found)
        assert len(found) == len(set(found))  # nobody twice
        assert (found == asked(lists, 0, i, j)).all()


def test_points_whose_place_is_no_number_enter_lists_of_the_grid():
    place = np.array([[np.nan, 0.2], [np.inf, -np.inf], [1e12, -1e12], [0.25, 0.25]])
    particles, grid = points(place), Grid(0.5, 0.5, 0.1)
    lists = CellLists(particles, grid, ConvectedDomain())
    lists.fill(0)
    assert lists.length.to_numpy()[0].sum() == 4 * len(place)
