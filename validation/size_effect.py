"""The size effect: the same silo from the model of 0.2 m to a bin of 8 m, filled with the same sand.

Source: Krzyzanowski et al. (2020), section 7.2: nominal wall stresses (over the weight of a width of sand) fall as
silos grow, because friction and dilatancy fall with pressure, and because shear zones get thinner against the width.
The grid grows with the silo, 40 cells across, and the law is local, so that what is seen is the effect of pressure
alone; zones as thin as grains would come on top. The bottom sinks by a twentieth of the width, at a speed that grows as
that of waves.

Cost: four runs of some 50 core-seconds.
"""

from pathlib import Path
from typing import Annotated

import pandas as pd
from typer import Option

from taichi_silo.cli import command_line, model_silo
from taichi_silo.scene.scene import Averaging, Flow, Machine, Mesh, Sand, Scene, Silo
from taichi_silo.studies.run_all import run_all
from taichi_silo.studies.sweep.runs import Run

MODEL_M, CELLS = 0.2, 40
WAVES = 0.25  # their speed grows with this power of the size: stiffness with the root of the stress


def size_effect(
    walls: Annotated[str, Option(help="smooth | very-rough")] = "very-rough",
    void_ratio: Annotated[float, Option(help="initial void ratio of the sand [-]")] = 0.60,
    widths: Annotated[str, Option(help="of the silos [m], with commas between")] = "0.2,0.8,2,8",
    share: Annotated[float, Option(help="displacement of the bottom over the width [-]")] = 0.05,
    speed: Annotated[float, Option(help="of the bottom of the model of 0.2 m [m/s]")] = 0.005,
    output: Annotated[Path, Option(help="folder; one subfolder a run")] = Path("outputs/size_effect"),
):
    """Fill and empty similar silos of several widths and tabulate their nominal stresses."""
    output = output.expanduser()
    runs = {}
    for width in (float(word) for word in widths.split(",")):
        scale = width / MODEL_M
        scene = Scene(
            silo=Silo(width_m=width, height_m=2.5 * width, half="no"),
            sand=Sand(void_ratio=void_ratio),
            walls=model_silo.walls(walls, void_ratio),
            grid=Mesh(cell_size_m=width / CELLS),
            averaging=Averaging(characteristic_length_m=0.0),
            flow=Flow(speed_m_per_s=speed * scale**WAVES, displacement_m=share * width),
            machine=Machine(threads=1),
        )
        runs[f"{width:g} m"] = Run(scene, output / f"{walls}_{width:g}m")
    run_all(runs, output)
    rows = []
    for run in runs.values():
        found, weight, width = run.summary, run.scene.weight_N_per_m, run.scene.silo.width_m
        unit = run.scene.density_kg_per_m3 * run.scene.method.gravity_m_per_s2 * width  # of nominal stress
        stress = found["largest_wall_normal_stress_Pa"]
        rows.append(
            {
                "width_m": width,
                "angle_filled_deg": found["filling"]["wall_friction_angle_deg"],
                "largest_angle_deg": found["peak"]["max_wall_friction_angle_deg"]["value"],
                "N_filled_over_W": found["filling"]["normal_N_per_m"] / weight,
                "T_largest_over_W": found["peak"]["max_shear_N_per_m"]["value"] / weight,
                "N_end_over_W": found["residual"]["normal_N_per_m"] / weight,
                "P_end_over_W": found["residual"]["bottom_N_per_m"] / weight,
                "largest_stress_filled_kPa": 1e-3 * stress["filling"]["pressure_cell"],
                "largest_stress_kPa": 1e-3 * stress["maximum"]["pressure_cell"],
                "nominal_filled": stress["filling"]["pressure_cell"] / unit,
                "nominal_largest": stress["maximum"]["pressure_cell"] / unit,
                "janssen_K0_N_over_W": found["janssen"]["normal_N_per_m_K0"] / weight,
            }
        )
    table = pd.DataFrame(rows)
    table.to_csv(output / f"size_effect_{walls}.csv", index=False, float_format="%.5g")
    print(table.T.to_string(header=False, float_format=lambda value: f"{value:.4g}"))


if __name__ == "__main__":
    command_line.command(size_effect)
