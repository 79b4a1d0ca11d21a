"""The loops that `make bench` times are those of the present solver."""

from benchmarks.phases import Neighbours, Phases
from taichi_silo.averaging import Gaussian, NonLocal
from taichi_silo.scene import Mesh, Scene
from taichi_silo.simulation import Simulation


def test_every_phase_runs():
    simulation = Simulation(Scene(grid=Mesh(cell_size_m=0.02)))
    phases = Phases(simulation.solver).all()
    assert list(phases) == ["particles to grid", "grid", "grid to particles", "law"]
    for run in phases.values():
        run(1, 1e-9)
    average = NonLocal(Gaussian(simulation.spacing), simulation.particles, simulation.spacing)
    average.refresh()
    average.norm.fill(2.5)
    alone = Neighbours(average)
    alone.means(1)
    assert abs(alone.found.to_numpy() - 2.5).max() < 1e-14
