"""`taichi-silo render`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console

LONGEST_S = 600.0  # of a film
SMALLEST, LARGEST = (320, 180), (7680, 4320)


def command(
    folder: Annotated[Path, Argument(help="of a run, also of one that goes on")],
    field: Annotated[
        str, Option(help="void_ratio | strain_path | speed | mean_stress | mobilised_friction | layers")
    ] = "void_ratio",
    limits: Annotated[
        str | None, Option("--range", help="LOW,HIGH: ends of the colours; from the scene and the data if not given")
    ] = None,
    size: Annotated[str, Option(help="columns x rows of a frame, such as 1280x720; even numbers")] = "1920x1080",
    seconds: Annotated[float | None, Option(help="length of the film in seconds; 15 if no speed is given")] = None,
    speed: Annotated[
        float | None, Option(help="of the sand over its own, 0.5 for slow motion, in place of a length")
    ] = None,
    fps: Annotated[int, Option(help="frames a second, 1 to 120")] = 30,
    frame: Annotated[
        float | None,
        Option(help="draw one picture, at this displacement in mm, in free outflow so many seconds after the opening"),
    ] = None,
    output: Annotated[Path | None, Option(help="the film or picture; FOLDER/FIELD.mp4 if not given")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a film or picture that is there")] = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Draw a film of any field of a run, afterwards: from the states that it has kept and its forces, on no screen.

    Between two states points move on straight lines. Examples:

    taichi-silo render outputs/silo --field layers --size 1280x720 --seconds 10

    taichi-silo render outputs/silo --field speed --range 0,5 --speed 0.5

    taichi-silo render outputs/silo --field mean_stress --frame 10
    """
    from taichi_silo.errors import MachineFailed
    from taichi_silo.mpm import runtime
    from taichi_silo.runs.point_fields import field as known
    from taichi_silo.runs.result import Result
    from taichi_silo.scene.scene import cores
    from taichi_silo.show.film import FilmError, renderer
    from taichi_silo.utils.bounded_reading import as_left
    from taichi_silo.utils.machine_faults import of_file

    known(field)
    _check(seconds, speed, fps, frame)
    look, console = renderer.Look(field, _limits(limits), _size(size)), Console(quiet, json)
    history = Result(folder).need_states()
    runtime.init("cpu", min(2, cores()))
    try:
        with as_left(history.folder):
            if frame is None:
                shown = _moments(history, field, seconds, speed, fps)
                file = _free(output or history.folder / f"{field}.mp4", ".mp4", overwrite)
                drawn = renderer.film(history, file, _tracked(shown, field, console), look, fps)
                found = {"film": str(file), "frames": len(shown), "seconds": len(shown) / fps}
            else:
                number, unit = _number(history, frame)
                file = _free(output or history.folder / f"{field}_{frame:g}{unit}.png", ".png", overwrite)
                drawn = renderer.still(history, file, number, look)
                found = {"picture": str(file), "snapshot": str(history.snapshots["file"].iloc[number])}
    except OSError as error:
        raise of_file(error, file) from error
    except FilmError as error:
        raise MachineFailed(f"{file} could not be drawn: {error}; see to that, and give the command again") from error
    scale = drawn.scale
    ends = "" if isinstance(scale.colours, tuple) else f", {scale.low:g} to {scale.high:g}"
    console.say(f"{file}  {scale.label}{ends}")
    console.result(found | {"field": field, "range": [scale.low, scale.high], "size": list(look.size)})


def _moments(history, field: str, seconds: float | None, speed: float | None, fps: int) -> list:
    """What the frames show."""
    from taichi_silo.errors import BadInput
    from taichi_silo.show.film import moments, renderer

    if speed is None:
        return renderer.moments_of(history, field, max(2, round((seconds or 15.0) * fps)))
    if history.end_s > speed * LONGEST_S:
        lasts = history.end_s / speed
        raise BadInput(f"speed is {speed:g}; the film would last {lasts:.4g} s, it must be at most {LONGEST_S:g} s")
    return moments.at_speed(history, speed, fps)


def _number(history, frame: float) -> tuple[int, str]:
    """The snapshot nearest to a displacement [mm] or, in free outflow, a time [s], and that unit."""
    from taichi_silo.show.film.moments import nearest

    return (nearest(history, frame), "s") if history.free else (nearest(history, 1e-3 * frame), "mm")


def _free(file: Path, suffix: str, overwrite: bool) -> Path:
    """The file, which may be written."""
    from taichi_silo.errors import BadInput
    from taichi_silo.runs.run_folder import no_link, writable
    from taichi_silo.utils.bounded_reading import place

    file = place(file, "output")
    if file.suffix.lower() != suffix:
        raise BadInput(f"output is {file}; it must end with {suffix}")
    if file.exists() and not overwrite:
        raise BadInput(f"output {file} is there already; give another name, or --overwrite to replace it")
    no_link(file, file.with_name(f"{file.name}.part"), file.with_name(f"{file.stem}.part{file.suffix}"))
    writable(file.parent)
    return file


def _tracked(shown: list, field: str, console: Console):
    """The moments, with a progress bar where there is a terminal."""
    from rich.progress import track

    terminal = console.terminal
    silent = terminal.quiet or not terminal.is_terminal
    return track(shown, f"drawing {field}", console=terminal, transient=True, disable=silent)


def _limits(text: str | None) -> tuple[float, float] | None:
    from taichi_silo.errors import BadInput

    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        low = high = 0.0
    if not (low < high and abs(low) < 1e30 and abs(high) < 1e30):
        raise BadInput(f"range is {text}; it must be LOW,HIGH: two numbers, the second above the first")
    return low, high


def _size(text: str) -> tuple[int, int]:
    from taichi_silo.errors import BadInput

    try:
        columns, rows = (int(part) for part in text.lower().split("x"))
    except ValueError:
        columns = rows = 0
    wide, high = (SMALLEST[k] <= value <= LARGEST[k] and value % 2 == 0 for k, value in enumerate((columns, rows)))
    if not (wide and high):
        raise BadInput(
            f"size is {text}; it must be COLUMNSxROWS: even numbers from {SMALLEST[0]}x{SMALLEST[1]} to "
            f"{LARGEST[0]}x{LARGEST[1]}"
        )
    return columns, rows


def _check(seconds: float | None, speed: float | None, fps: int, frame: float | None) -> None:
    from taichi_silo.errors import BadInput

    if frame is not None and (seconds, speed) != (None, None):
        raise BadInput(f"frame is {frame:g}; one picture has neither a length nor a speed")
    if seconds is not None and speed is not None:
        raise BadInput(f"speed is {speed:g}; it cannot be given together with a length ({seconds:g} s)")
    if seconds is not None and not 0.1 <= seconds <= LONGEST_S:
        raise BadInput(f"seconds is {seconds:g}; it must be from 0.1 to {LONGEST_S:g}")
    if speed is not None and not 1e-6 <= speed <= 1e6:
        raise BadInput(f"speed is {speed:g}; it must be from 1e-06 to 1e+06")
    if not 1 <= fps <= 120:
        raise BadInput(f"fps is {fps}; it must be from 1 to 120")
