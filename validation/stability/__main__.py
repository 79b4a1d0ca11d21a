"""The stability map: where each variant of the material point method fails, measured.

Thirteen failure modes (cell crossing, stretching, shear and rotation, null space, time step, stress integration,
limits of the law, ratcheting, walls, precision, conservation, order of accuracy, null modes of sheared sand) against
shapes, transfers, stress updates, filters and noise controls. Source: Krzyzanowski et al. (2020), section 3, which
names the variants and their errors without measuring them, and what was found on the way.

Leaves `table.csv` (mode, method, measure, value, unit, bound, holds), `figures/` and `page.html`. Modes that are there
are kept; `--overwrite` measures them anew.

Cost: about fifteen minutes on two cores.
"""

import json
from pathlib import Path
from typing import Annotated

import pandas as pd
from matplotlib import rc_context
from typer import Option

from taichi_silo.cli import command_line
from taichi_silo.errors import BadInput, RunFailed
from taichi_silo.show.figures.style import STYLE
from validation.in_parallel import in_parallel
from validation.stability import MODES, leave
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
    lost = in_parallel(leave, {name: (name, not quick, parts) for name in wanted}, MODES)
    draw(output, parts)
    for name, why in lost.items():
        raise RunFailed(f"in {len(lost)} of {len(wanted)} modes, the first being {name}: {why}")


def draw(output: Path, parts: Path) -> None:
    """The table, a figure for each mode, and the page."""
    tables = {name: pd.read_csv(file) for name in MODES if (file := parts / f"{name}.csv").exists()}
    if not tables:
        return
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
