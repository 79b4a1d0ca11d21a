"""What the stability map says of a user's choices: said before the run starts, and kept in its summary.

Each sentence is a red cell of the map that the choice can reach in a silo (`scenarios/stability.py` measures them).
"""

from taichi_silo.mpm.shapes import SHAPES
from taichi_silo.scene.scene import Scene

NOISY = ("apic", "gradient", "xpic", "blend", "pic")


def known_limits(scene: Scene) -> list[str]:
    """One sentence for each choice that is known to fail somewhere."""
    method, found = scene.method, []
    if scene.grid.shape == "linear":
        found.append(
            "Linear shapes: stresses err by a fifth where points cross cells, nearly empty cells at a free surface "
            "make any step unstable, and sand that flows freely is lost; ugimp or cpdi cure it."
        )
    if scene.grid.shape == "bspline" and scene.grid.points_per_cell > 1:
        found.append(
            "Splines ignore that several points share a cell: stresses of a compressed column err by 5 % (ugimp 2 %, "
            "cpdi 0.3 %)."
        )
    if method.stress_filter == "smoothing":
        found.append(
            "The smoothing filter is no projection: a stress at rest is gone after 1,000 steps, and a silo falls apart "
            "under it; null-space removes the same checkerboards and leaves stresses alone."
        )
    if method.noise_control == "none":
        found.append(
            "Without noise control dense sand between smooth walls ratchets: N is a third too high after filling, and "
            f"{'PIC-like transfers leave 5 to 13 %' if method.transfer in NOISY[2:] else 'void ratio keeps falling'}."
        )
    if method.stress_update != "last":
        found.append(
            f"Updating the stress in the order {method.stress_update} damps nothing: dense sand between smooth walls "
            "ratchets in spite of the noise control, and N is a quarter too high after filling."
        )
    fraction = SHAPES[scene.grid.shape](0.5 / scene.grid.points_per_cell**0.5).stable_fraction
    if method.cfl is not None and method.cfl > fraction:
        found.append(
            f"cfl is {method.cfl:g}; the shape's own limit is {fraction:.3f}, and beyond it results are wrong before "
            "anything explodes."
        )
    if method.mass_scaling > 1.0:
        found.append(
            f"Mass scaling by {method.mass_scaling:g} makes the sand feel a bottom {method.mass_scaling**0.5:.3g} "
            "times as fast: N and P between very rough walls change as with that speed."
        )
    return found
