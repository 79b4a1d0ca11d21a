"""The paper's four mass flows side by side: dense and loose sand, smooth and very rough walls.

Source: Krzyzanowski et al. (2020), section 6; the figures are the counterparts of figures 10 to 13. Each case is a run
of `mass_flow.py` in a process of its own, as many at a time as there are cores; cases already there are kept.

Cost: about twelve minutes on two cores.
"""

import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated

from typer import Option

from taichi_silo import cli, sands
from taichi_silo.faults import BadInput, RunFailed
from taichi_silo.folder import read_scene
from taichi_silo.plots import plot_cases

LAW = "gudehus-bauer"  # the paper's
CASES = {
    "dense, smooth": ("dense", "smooth"),
    "dense, very rough": ("dense", "very-rough"),
    "loose, smooth": ("loose", "smooth"),
    "loose, very rough": ("loose", "very-rough"),
}


def four_cases(
    sand: cli.SandFlag = "karlsruhe",
    dense: Annotated[float, Option(help="void ratio of the dense fill [-]")] = 0.60,
    loose: Annotated[float, Option(help="void ratio of the loose fill [-]")] = 0.90,
    cell_size: Annotated[float, Option(help="of the grid [m]")] = 0.005,
    speed: Annotated[float, Option(help="of the bottom [m/s]")] = 0.002,
    displacement: Annotated[float, Option(help="of the bottom at the end [m]")] = 0.02,
    shape: cli.ShapeFlag = "ugimp",
    method: cli.MethodFlags = None,
    output: Annotated[Path, Option(help="folder; one subfolder a case")] = Path("outputs/four_cases"),
    film: Annotated[bool, Option(help="draw the films")] = True,
):
    """Run the paper's four cases and draw them side by side."""
    constants = sands.sand(sand, dense, law=LAW).model_dump(exclude={"void_ratio"})
    flags = {"--sand": sand, "--law": LAW, "--shape": shape, "--cell-size": cell_size, "--speed": speed}
    flags |= {"--displacement": displacement, "--threads": 1} | cli.flags_of(method)
    chosen = {"shape": shape} | {name: value for name, value in method.items() if value is not None}
    folders = {name: output / name.replace(", ", "_").replace(" ", "-") for name in CASES}

    def simulate(name: str) -> tuple[str, int, str]:
        packing, walls = CASES[name]
        void_ratio = {"dense": dense, "loose": loose}[packing]
        folder = folders[name]
        wanted = {"void_ratio": void_ratio, "kind": walls, "cell_size_m": cell_size}
        wanted |= constants | chosen | {"speed_m_per_s": speed, "displacement_m": displacement}
        if is_there(folder, wanted) and (not film or (folder / "void_ratio.mp4").exists()):
            return name, 0, "kept"
        case = flags | {"--void-ratio": void_ratio, "--walls": walls, "--output": folder}
        command = [sys.executable, str(Path(__file__).with_name("mass_flow.py")), "--overwrite"]
        command += [str(part) for pair in case.items() for part in pair] + ([] if film else ["--no-film"])
        done = subprocess.run(command, capture_output=True, text=True)
        lines = done.stderr.strip().splitlines()
        return name, done.returncode, lines[-1] if done.returncode and lines else "done"

    with ThreadPoolExecutor(max(1, min(len(CASES), os.cpu_count() or 1))) as workers:
        for name, code, word in workers.map(simulate, CASES):
            print(f"{name:20s} {word}", flush=True)
            if code == cli.BAD_INPUT:
                raise BadInput(word.removeprefix("Error: ").rstrip("."))
            if code:
                raise RunFailed(f"in the case '{name}': {word}")
    for file in plot_cases(folders, output / "figures"):
        print(file)


def is_there(folder: Path, wanted: dict) -> bool:
    """Whether the folder holds a finished run with these values."""
    try:
        tables = read_scene(folder / "run.toml").model_dump()
        finished = json.loads((folder / "summary.json").read_text())["finished"]
    except (BadInput, OSError, ValueError, KeyError):
        return False
    values = {key: value for table in tables.values() for key, value in table.items()}
    return finished and all(values.get(key) == value for key, value in wanted.items())


if __name__ == "__main__":
    cli.command(four_cases)
