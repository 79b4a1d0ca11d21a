"""`taichi-silo drawing`."""

from pathlib import Path
from typing import Annotated

import typer


def drawing(
    file: Annotated[Path, typer.Argument(metavar="FILE.dxf", help="side view of the silo, its inside a closed line")],
    unit: Annotated[str | None, typer.Option(help="mm | cm | m | in; that of the drawing if not given")] = None,
    output: Annotated[Path | None, typer.Option(help="scene file to write; the screen if not given")] = None,
) -> None:
    """Turn a DXF drawing into a scene file: the largest closed line is the silo's inside, lines within are inserts.

    The lowest side is the floor, and the outlet, unless one is added ([silo.outlet]). Curves become corners.

    Example: taichi-silo drawing bunker.dxf --output bunker.toml
    """
    import tomli_w

    from taichi_silo.cli.command_line import print_or_write
    from taichi_silo.scene.dxf import read_silo

    silo = read_silo(file, unit)
    text = tomli_w.dumps({"silo": silo.model_dump(mode="json", exclude_none=True, exclude_defaults=True)})
    print_or_write(text, output)
