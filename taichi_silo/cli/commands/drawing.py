"""`taichi-silo drawing`."""

import sys
from pathlib import Path
from typing import Annotated

import typer


def drawing(
    file: Annotated[Path, typer.Argument(metavar="FILE.dxf", help="side view of the silo, its inside a closed line")],
    unit: Annotated[
        str | None, typer.Option(help="mm | cm | m | in | ft | ...; that of the drawing if not given")
    ] = None,
    layer: Annotated[
        list[str] | None,
        typer.Option(help="layer whose lines count, repeatable; all that are on and not frozen if not given"),
    ] = None,
    line: Annotated[
        int | None,
        typer.Option(help="number of the closed line that is the inside, the largest is 1; asked if unclear"),
    ] = None,
    gap: Annotated[
        float | None,
        typer.Option(
            help="ends at most so far apart are joined [m]; 1/500 of the drawing's larger side if not given, or three "
            "times as much where that alone makes a silo"
        ),
    ] = None,
    show: Annotated[
        Path | None, typer.Option(help="picture of the closed lines (PNG); beside the scene file if not given")
    ] = None,
    output: Annotated[Path | None, typer.Option(help="scene file to write; the screen if not given")] = None,
) -> None:
    """Turn a DXF drawing into a scene file: a closed line is the silo's inside, closed lines within are inserts.

    The lowest side is the floor, and the outlet, unless one is added ([silo.outlet]). Lines that meet are joined,
    blocks taken apart, curves become corners. What was taken is said, and stands at the head of the scene file.

    Example: taichi-silo drawing bunker.dxf --output bunker.toml
    """
    import tomli_w

    from taichi_silo.cli.command_line import print_or_write
    from taichi_silo.errors import BadInput
    from taichi_silo.scene.drawing.choice import Unclear
    from taichi_silo.scene.dxf import read_drawing
    from taichi_silo.utils.console import Console
    from taichi_silo.utils.messages import sentence

    picture = _picture(show, output)
    try:
        drawn = read_drawing(file, unit, layer or (), line, gap)
    except Unclear as unclear:
        if show is None:
            raise
        from taichi_silo.show.figures.drawing import draw_lines

        draw_lines(show, [one.corners for one in unclear.lines])
        raise BadInput(f"{unclear} ({show} shows them)") from unclear
    words = [sentence(one) for one in drawn.words]
    head = "".join(f"# {one}\n" for one in (f"From the drawing {sentence(file.name)}.", *words))
    print_or_write(f"{head}\n{tomli_w.dumps(drawn.tables())}", output)
    if picture is not None:
        from taichi_silo.show.figures.drawing import draw_lines

        draw_lines(picture, [one.corners for one in drawn.lines], drawn.number, drawn.bodies)
        words.append(f"The picture is {picture}.")
    if output is not None:
        Console().say(f"The scene is in {output}.", *words)
    else:  # the screen has shown the head of the scene already
        Console(as_json=True).say(*(words[len(drawn.words) :] if sys.stdout.isatty() else words))


def _picture(show: Path | None, output: Path | None) -> Path | None:
    """Where the picture goes: as asked for, else beside the scene file unless a file of that name is there.

    Raises BadInput if it cannot go where it was asked for.
    """
    from taichi_silo.errors import BadInput
    from taichi_silo.utils.bounded_reading import place

    if show is None:
        beside = output.with_suffix(".png") if output is not None else None
        return beside if beside is not None and beside != output and not beside.exists() else None
    show = place(show, "show")
    if show.suffix.lower() != ".png":
        raise BadInput(f"show is {show}; it must be the name of a picture, FILE.png")
    if show.exists():
        raise BadInput(f"show {show} is there already; give another name")
    if not show.absolute().parent.is_dir():
        raise BadInput(f"show {show} cannot be written: there is no folder {show.parent}")
    return show
