"""The folder that `taichi-silo eurocode --output` leaves: a page that prints, tables, a figure, loads for shells."""

import datetime
import io
from importlib.metadata import version
from pathlib import Path

import pandas as pd
from matplotlib import rc_context

from taichi_silo.errors import BadInput, way
from taichi_silo.runs.run_folder import no_link, writable
from taichi_silo.show import html
from taichi_silo.show.export import wall_loads
from taichi_silo.show.figures.eurocode import eurocode_figure
from taichi_silo.show.figures.style import STYLE
from taichi_silo.show.report.eurocode import EurocodeReport
from taichi_silo.utils import atomic_write, bounded_reading

PAGE, TABLE, HOPPER, FIGURE, LOADS = "eurocode.html", "eurocode.csv", "hopper.csv", "eurocode.png", "wall-loads"


def write(report: EurocodeReport, folder: Path, scene: Path, overwrite: bool = False) -> list[Path]:
    """Write all files and return them, the page first.

    Raises BadInput if one is there already and may not be replaced, or the folder cannot be written.
    """
    folder = bounded_reading.place(folder, "output")
    files = [folder / name for name in (PAGE, TABLE, FIGURE)] + ([folder / HOPPER] if report.hopper_rows else [])
    there = [file for file in (*files, folder / LOADS) if file.exists()]
    if there and not overwrite:
        anew = way("overwrite")
        raise BadInput(f"output {there[0]} is there already; give another folder, or {anew} to replace it", anew)
    no_link(*files, folder / LOADS)
    writable(folder)
    picture = _picture(report)
    texts = {
        PAGE: _page(report, scene, picture), TABLE: report.frame.to_csv(index=False, float_format="%.6g"),
        HOPPER: pd.DataFrame(report.hopper_rows).to_csv(index=False, float_format="%.6g"),
    }  # fmt: skip
    for file in files:
        with atomic_write.written(file) as passing:
            passing.write_bytes(picture if file.name == FIGURE else texts[file.name].encode())
    wall_loads.write_loads(wall_loads.of_code(report), folder / LOADS, f"EN 1991-4:2006 for {scene.name}")
    return [*files, folder / LOADS]


def _picture(report: EurocodeReport) -> bytes:
    content = io.BytesIO()
    with rc_context(STYLE):
        eurocode_figure(report).savefig(content, format="png")
    return content.getvalue()


def _page(report: EurocodeReport, scene: Path, picture: bytes) -> str:
    return html.render(
        Path(__file__).with_name("eurocode.html.j2"), code=report, file=scene.name, version=version("taichi-silo"),
        title=f"{report.silo.solid.title}, {report.silo.slenderness} silo", today=datetime.date.today().isoformat(),
        figure=html.data_uri(picture, "image/png"),
    )  # fmt: skip
