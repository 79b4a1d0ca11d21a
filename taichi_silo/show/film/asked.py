"""What may be asked of a film or a picture; everything else is refused before any work."""

import math
from pathlib import Path

from taichi_silo.errors import BadInput, Way, way
from taichi_silo.runs.run_folder import no_link, writable
from taichi_silo.show.film.encoder import FRAMES_PER_SECOND, KINDS, passing_name
from taichi_silo.show.film.layout import LAYOUTS, SAND, SIZES
from taichi_silo.show.film.look import COLOURS
from taichi_silo.show.film.moments import Slow
from taichi_silo.show.film.sequence import need_sequence, passing_folder
from taichi_silo.utils.bounded_reading import place

LONGEST_S = 600.0  # of a film
SMALLEST, LARGEST = (180, 180), (7680, 7680)
LEAST_PIXELS = 320 * 180
FORM = 0.02  # by which the form of a size may differ from that of its layout
PICTURES = (".png", ".svg")
GIF_RATES = (1, 2, 4, 5, 10, 20, 25, 50)  # a GIF counts in hundredths of a second
LONGEST_TITLE = 200
MOST_SLOWLY = 1000.0


def need_length(seconds: float | None, speed: float | None, fps: int | None, frame: float | None) -> None:
    """Check how long a film is, or which picture is drawn."""
    if frame is not None and not math.isfinite(frame):
        raise BadInput(f"frame is {frame:g}; it must be a number: a displacement in mm, or seconds")
    if frame is not None and (seconds, speed) != (None, None):
        raise BadInput(f"frame is {frame:g}; one picture has neither a length nor a speed")
    if seconds is not None and speed is not None:
        raise BadInput(f"speed is {speed:g}; it cannot be given together with a length ({seconds:g} s)")
    if seconds is not None and not 0.1 <= seconds <= LONGEST_S:
        raise BadInput(f"seconds is {seconds:g}; it must be from 0.1 to {LONGEST_S:g}")
    if speed is not None and not 1e-6 <= speed <= 1e6:
        raise BadInput(f"speed is {speed:g}; it must be from 1e-06 to 1e+06")
    if fps is not None and not 1 <= fps <= 120:
        raise BadInput(f"fps is {fps}; it must be from 1 to 120")


def rate(fps: int | None, file: Path) -> int:
    """Frames a second of a film."""
    if file.suffix.lower() != ".gif":
        return fps or FRAMES_PER_SECOND
    if fps is not None and fps not in GIF_RATES:
        raise BadInput(f"fps is {fps}; of a GIF it must be one of {', '.join(map(str, GIF_RATES))}")
    return fps or 25


def need_look(layout: str | None, size: tuple | None, colours: str | None, title: str | None, axes: bool) -> None:
    """Check the page and the colours."""
    if layout is not None and layout not in LAYOUTS:
        raise BadInput(f"layout is {layout}; it must be one of {', '.join(LAYOUTS)}")
    if size is not None:
        need_size(size)
        if layout in SIZES and abs(math.log(size[0] * SIZES[layout][1] / (size[1] * SIZES[layout][0]))) > FORM:
            named = "x".join(map(str, SIZES[layout]))
            raise BadInput(
                f"size is {size[0]}x{size[1]}; of the layout {layout} it must have that form, such as {named}"
            )
    if colours is not None and colours not in COLOURS:
        raise BadInput(f"colours is {colours}; it must be one of {', '.join(COLOURS)}")
    if title is not None and (len(title) > LONGEST_TITLE or not title.isprintable()):
        raise BadInput(f"title is {title[:40]!r}...; it must be one line of at most {LONGEST_TITLE} characters")
    if layout == SAND and title is not None:
        raise BadInput(f"title is {title[:40]!r}; the layout {SAND} has nothing but sand, and it must be left out")
    if layout == SAND and not axes:
        raise BadInput(f"axes are off; the layout {SAND} has none, and that must be left out")


def need_size(size: tuple) -> None:
    """Check columns and rows."""
    size = size if isinstance(size, tuple | list) else (size,)
    whole = len(size) == 2 and all(isinstance(value, int) and value % 2 == 0 for value in size)
    inside = whole and all(a <= b <= c for a, b, c in zip(SMALLEST, size, LARGEST, strict=True))
    if not (inside and size[0] * size[1] >= LEAST_PIXELS and size[0] * size[1] <= 7680 * 4320):
        raise BadInput(
            f"size is {'x'.join(map(str, size))}; it must be COLUMNSxROWS: even numbers from 320x180 (or 180x320) to "
            "7680x4320"
        )


def need_limits(limits: tuple | None) -> None:
    """Check the ends of the colours."""
    if limits is not None:
        low, high = _numbers(limits, 2)
        if not (low < high and abs(low) < 1e30 and abs(high) < 1e30):
            raise BadInput(f"range is {_said(limits)}; it must be LOW,HIGH: two numbers, the second above the first")


def need_box(zoom_mm: tuple | None) -> None:
    """Check that a box has four numbers; whether it lies in the silo is checked when that is known."""
    if zoom_mm is not None and not all(map(math.isfinite, _numbers(zoom_mm, 4))):
        raise BadInput(f"zoom is {_said(zoom_mm)}; it must be LEFT,BOTTOM,RIGHT,TOP in mm: four numbers")


def slow_of(slow: tuple | None, unit_in_si: float) -> Slow | None:
    """The part of a film that is shown more slowly."""
    if slow is None:
        return None
    begin, end, times = _numbers(slow, 3)
    if not (0.0 <= begin < end < 1e9 and 1.0 < times <= MOST_SLOWLY):
        raise BadInput(
            f"slow is {_said(slow)}; it must be FROM,TO,TIMES: a part of the flow in mm (in free outflow, "
            f"or of two runs, in s), and how many times slower, above 1 to {MOST_SLOWLY:g}"
        )
    return Slow(unit_in_si * begin, unit_in_si * end, times)


def _said(values) -> str:
    """Numbers or words as they were given."""
    if not isinstance(values, tuple | list):
        return str(values)
    return ",".join(f"{value:g}" if isinstance(value, float | int) else str(value) for value in values)


def _numbers(values, count: int) -> tuple[float, ...]:
    """So many numbers; nan where there are not so many."""
    try:
        found = tuple(float(value) for value in values)
    except (TypeError, ValueError):
        found = ()
    return found if len(found) == count else (math.nan,) * count


def need_kind(file: Path, frame: float | None, transparent: bool, beside: bool) -> None:
    """Check the ending of what is drawn."""
    suffix = file.suffix.lower()
    if frame is None and suffix and suffix not in KINDS:
        raise BadInput(f"output is {file}; it must end with {', '.join(KINDS)}, or be a folder of pictures: no ending")
    if frame is not None and suffix not in PICTURES:
        raise BadInput(f"output is {file}; it must end with {' or '.join(PICTURES)}")
    if beside and suffix == ".svg":
        raise BadInput(f"output is {file}; two runs beside each other must end with .png")
    if transparent and suffix in KINDS:
        one = Way("frame", "--frame")
        words = f"output is {file}; only pictures are transparent: it must be a folder, or a .png with {one}"
        raise BadInput(words, one)


def free(file: Path, overwrite: bool) -> Path:
    """The file, which may be written."""
    file = place(file, "output")
    if file.exists() and not overwrite:
        anew = way("overwrite")
        raise BadInput(f"output {file} is there already; give another name, or {anew} to replace it", anew)
    no_link(file, file.with_name(f"{file.name}.part"), passing_name(file))
    if file.exists() and file.is_dir() != (not file.suffix):
        raise BadInput(f"output {file} is {'a folder' if file.is_dir() else 'a file'}; give another name")
    if file.is_dir():
        need_sequence(file)
    if not file.suffix and passing_folder(file).is_dir():
        need_sequence(passing_folder(file))
    writable(file.parent)
    return file
