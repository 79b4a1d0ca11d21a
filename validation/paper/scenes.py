"""The scenes of the paper's cases."""

from taichi_silo.scene import sands
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Scene, Walls
from taichi_silo.scene.silo import Outlet, Silo
from validation.paper.cases import CASES, Case

LENGTH_M = 0.0015  # characteristic length of the paper's silos
LONGEST_S = 4.0  # of free outflow; it ends before if the flow stops


def scene_of(case: Case, cell_size_m: float = 0.005, speed_m_per_s: float = 0.002) -> Scene:
    """One case, on one thread; free outflow with intergranular strain, as in the paper, everything else without."""
    opening = case.opening
    outlet = None
    if not opening.whole:
        place = "centre" if opening.symmetric else "right"
        outlet = Outlet(width_m=round(opening.width_m, 9), position=place)
    silo = Silo(width_m=case.silo_width_m, height_m=case.silo_height_m, half="no", outlet=outlet)
    flow = Flow(speed_m_per_s=speed_m_per_s, displacement_m=case.displacement_m)
    if case.gravity:
        flow = Flow(outflow="gravity", displacement_m=silo.area_m2 / silo.outlet_share_m, longest_s=LONGEST_S)
    law = "intergranular" if case.gravity else "gudehus-bauer"
    return Scene(
        silo=silo,
        sand=sands.sand("karlsruhe", case.void_ratio, law=law),
        walls=Walls(kind=case.walls, friction_angle_deg=case.wall_friction_angle_deg),
        grid=Mesh(cell_size_m=cell_size_m, points_per_cell=1),  # the paper's
        averaging=Averaging(characteristic_length_m=LENGTH_M),
        flow=flow,
        machine=Machine(threads=1),
    )


def scenes(cell_size_m: float = 0.005, speed_m_per_s: float = 0.002) -> dict[str, Scene]:
    """The scenes of all 17 cases, by name."""
    return {name: scene_of(case, cell_size_m, speed_m_per_s) for name, case in CASES.items()}
