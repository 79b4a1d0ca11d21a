"""Mass flow in the model silo: sand between parallel walls, whose whole bottom is slowly lowered.

Source: Krzyzanowski, Tejchman, Solowski and Wojcik (2020), section 6, figures 10 to 13. The paper's four cases
are void ratio 0.60 and 0.90, smooth and very rough walls.

What to expect (dense sand, very rough walls): the bottom force P falls steeply within the first millimetre and
recovers slowly, the wall friction force T peaks and falls, the wall normal force N climbs; dilatant shear zones grow
along the walls and, as parabolas, through the interior.

Cost: 4,000 points and about 570,000 steps at the default speed, some five minutes on two cores.
"""

from pathlib import Path
from typing import Annotated

from typer import Option

from taichi_silo import cli, sands
from taichi_silo import fidelity as fidelities
from taichi_silo.folder import free_name
from taichi_silo.observers.progress import ProgressLine
from taichi_silo.run import run
from taichi_silo.scene import Averaging, Flow, Machine, Mesh, Method, Output, Scene, Silo, Walls


def mass_flow(
    void_ratio: Annotated[float, Option(help="initial void ratio of the sand [-], between e_d0 and e_i0")] = 0.60,
    sand: cli.SandFlag = "karlsruhe",
    law: cli.LawFlag = "auto",
    walls: Annotated[str, Option(help="smooth | very-rough")] = "very-rough",
    wall_friction_angle: Annotated[
        float | None,
        Option(help="of smooth walls [deg]; 19 for dense and 12.3 for loose sand (from e = 0.75) if not given"),
    ] = None,
    bottom_friction_angle: Annotated[float, Option(help="of the bottom plate [deg]")] = 0.0,
    width: Annotated[float, Option(help="of the silo [m]")] = 0.2,
    height: Annotated[float, Option(help="of the fill [m]")] = 0.5,
    half: cli.HalfFlag = "auto",
    fidelity: Annotated[
        str, Option(help="draft | standard | converged: cell size and speed where they are not given")
    ] = "standard",
    cell_size: Annotated[
        float | None, Option(help="of the grid [m]; divides width and height; 0.005 in standard fidelity")
    ] = None,
    points_per_cell: Annotated[int | None, Option(help="1, 4, 9, ...; 1 if not given")] = None,
    shape: cli.ShapeFlag = "ugimp",
    characteristic_length: cli.LengthFlag = None,
    weight: cli.WeightFlag = "gaussian",
    speed: Annotated[float | None, Option(help="of the bottom [m/s]; 0.002 in standard fidelity")] = None,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.02,
    noise_control: Annotated[str, Option(help="column | none; none is the paper's 'no damping'")] = "column",
    method: cli.MethodFlags = None,
    threads: Annotated[int | None, Option(help="CPU threads; all up to 2 if not given")] = None,
    arch: Annotated[str, Option(help="cpu | cuda")] = "cpu",
    output: Annotated[Path | None, Option(help="folder of the run; outputs/... if not given")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a run in the output folder")] = False,
    film: Annotated[bool, Option(help="draw void_ratio.mp4")] = True,
    records_per_period: cli.RecordsFlag = 10,
    explain: cli.ExplainFlag = False,
):
    """Lower the bottom of a silo with parallel walls and record forces, wall stresses and shear zones."""
    machine = {"arch": arch} if threads is None else {"arch": arch, "threads": threads}
    chosen = fidelities.fidelity(fidelity)
    scene = Scene(
        silo=Silo(width_m=width, height_m=height, half=half),
        sand=sands.sand(sand, void_ratio, law=law),
        walls=Walls(
            kind=walls, friction_angle_deg=wall_friction_angle, bottom_friction_angle_deg=bottom_friction_angle
        ),
        grid=Mesh(shape=shape, **chosen.values("grid", cell_size_m=cell_size, points_per_cell=points_per_cell)),
        averaging=Averaging(characteristic_length_m=characteristic_length, weight=weight),
        flow=Flow(displacement_m=displacement, **chosen.values("flow", speed_m_per_s=speed)),
        method=Method(noise_control=noise_control, **method),
        output=Output(records_per_period=records_per_period),
        machine=Machine(**machine),
    )
    if cell_size is None and points_per_cell is None and speed is None:
        print(f"Fidelity {fidelity}: {chosen.words()}.")
    if explain:
        cli.explain(scene)
        return
    folder = output.expanduser() if output else free_name(Path("outputs") / f"mass_flow_e{void_ratio:.2f}_{walls}")
    cli.tell(run(scene, folder, overwrite=overwrite, film=film, extra=(ProgressLine(),)))


if __name__ == "__main__":
    cli.command(mass_flow)
