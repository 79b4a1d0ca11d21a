"""The stability map: where each variant of the material point method fails, measured.

Twelve failure modes (cell crossing, stretching, shear and rotation, null space, time step, stress integration, limits
of the law, ratcheting, walls, precision, conservation, order of accuracy) against shapes, transfers, stress updates,
filters and noise controls. Source: Krzyzanowski et al. (2020), section 3, which names the variants and their errors
without measuring them, and what was found on the way.

Leaves `table.csv` (mode, method, measure, value, unit, bound, holds), `figures/` and `page.html`. Modes that are there
are kept; `--overwrite` measures them anew.

Cost: about fifteen minutes on two cores.
"""

import json
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Annotated

import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.mpm import runtime
from taichi_silo.scene.scene import cores
from taichi_silo.show.figures.style import STYLE
from validation.stability import MODES, measure
from validation.stability.figures import matrix, order_figure, page, ratcheting_figure

FIGURES = {"order": order_figure, "ratcheting": ratcheting_figure}


def stability(
    mode: Annotated[str, Option(help="all, or some of " + ", ".join(MODES) + ", separated by commas")] = "all",
    quick: Annotated[bool, Option("--quick", help="only what the tests measure")] = False,
    output: Annotated[Path, Option(help="folder")] = Path("outputs/stability"),
    overwrite: Annotated[bool, Option("--overwrite", help="measure anew what is there")] = False,
):
    """Measure the failure modes and draw the map."""
    names = list(MODES) if mode == "all" else mode.split(",")
    for name in names:
        if name not in MODES:
            raise BadInput(f"mode is {name}; it must be all, or some of {', '.join(MODES)}")
    parts = output / ("quick" if quick else "modes")
    parts.mkdir(parents=True, exist_ok=True)
    wanted = [name for name in names if overwrite or not (parts / f"{name}.csv").exists()]
    wanted.sort(key=lambda name: -MODES[name])  # the longest first, so that no core waits for it at the end
    lost = []
    begun, done, whole = time.monotonic(), 0.0, sum(MODES[name] for name in wanted)
    with ProcessPoolExecutor(max(1, min(len(wanted), cores())), max_tasks_per_child=1) as workers:
        jobs = {workers.submit(leave, name, not quick, parts): name for name in wanted}
        for job in as_completed(jobs):
            name = jobs[job]
            done += MODES[name]
            left = (time.monotonic() - begun) * (whole - done) / done
            if job.exception() is not None:
                lost.append(f"{name}: {job.exception()}")
            words = lost[-1] if job.exception() else job.result()
            print(f"{100 * done / whole:5.1f} %  {name:14s} {words:32s} {left / 60:5.1f} min left", flush=True)
    draw(output, parts)
    if lost:
        raise RunFailed(f"in {len(lost)} of {len(wanted)} modes, the first being {lost[0]}")


def leave(name: str, full: bool, parts: Path) -> str:
    """Measure a mode and leave its rows and data; says how many cells hold."""
    runtime.init()
    cells, data = measure(name, full)
    if data is not None:
        (parts / f"{name}.json").write_text(json.dumps(data))
    temporary = parts / f"{name}.csv.part"
    pd.DataFrame([cell.row() for cell in cells]).to_csv(temporary, index=False, float_format="%.6g")
    temporary.replace(parts / f"{name}.csv")
    return f"{sum(cell.holds for cell in cells)} of {len(cells)} cells hold"


def draw(output: Path, parts: Path) -> None:
    """The table, a figure for each mode, and the page."""
    there = [name for name in MODES if (parts / f"{name}.csv").exists()]
    tables = {name: pd.read_csv(parts / f"{name}.csv") for name in there}
    whole = pd.concat(tables.values())
    whole.to_csv(output / "table.csv", index=False, float_format="%.6g")
    (output / "figures").mkdir(exist_ok=True)
    files = []
    with rc_context(STYLE):
        for name, rows in tables.items():
            file = output / "figures" / f"{name}.png"
            matrix(rows, f"Failure mode {rows['mode'].iloc[0]}").savefig(file)
            files.append(file)
            if name in FIGURES and (parts / f"{name}.json").exists():
                file = output / "figures" / f"{name}_curves.png"
                FIGURES[name](json.loads((parts / f"{name}.json").read_text())).savefig(file)
                files.append(file)
    (output / "page.html").write_text(page(whole, files, output))
    print(f"{int(whole.holds.sum())} of {len(whole)} cells hold")
    for file in (output / "table.csv", output / "page.html"):
        print(file)


if __name__ == "__main__":
    command_line.command(stability)
