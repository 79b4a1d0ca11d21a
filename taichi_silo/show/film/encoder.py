"""Frames to an H.264 film, through imageio and its ffmpeg plugin."""

import contextlib
from collections.abc import Iterable
from pathlib import Path

import imageio.v2 as imageio
import imageio_ffmpeg
import numpy as np

from taichi_silo.show.film import FilmError
from taichi_silo.utils import atomic_write

FRAMES_PER_SECOND = 30
COLOURS = (
    "-vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p -colorspace bt709 -color_primaries bt709 "
    "-color_trc bt709"
)
QUALITY = "-preset veryfast -crf 18 -bf 0 -threads 2 -movflags +faststart -f mp4"


def encode(file: Path, frames: Iterable[np.ndarray], frames_per_second: int = FRAMES_PER_SECOND) -> int:
    """Encode frames (rows, columns, 3) of bytes, even numbers of rows and columns; returns how many there were.

    The film is there when it is complete, or not at all; without frames there is none.

    Raises
    ------
    FilmError
        if ffmpeg is not there, or has stopped.

    """
    passing, count = passing_name(file), 0
    try:
        with imageio.get_writer(
            passing, format="FFMPEG", mode="I", fps=frames_per_second, codec="libx264", macro_block_size=2,
            quality=None, output_params=f"{COLOURS} {QUALITY}".split(),
        ) as writer:  # fmt: skip
            for frame in frames:
                _append(writer, frame, file)
                count += 1
        if not count:
            return 0
        if _frames(passing) != count:  # imageio does not say how ffmpeg has ended
            raise FilmError(_stopped(file))
        atomic_write.put(passing, file)
    finally:
        with contextlib.suppress(OSError):
            passing.unlink(missing_ok=True)
    return count


def passing_name(file: Path) -> Path:
    """The name of a film that is not complete; its ending tells imageio what it is.

    It is absolute: in a relative one, ffmpeg reads "run:1/..." as a protocol and "-run/..." as an option.
    """
    return file.absolute().with_name(f"{file.stem}.part{file.suffix}")


def _append(writer, frame: np.ndarray, file: Path) -> None:
    try:
        writer.append_data(frame)
    except FileNotFoundError as error:
        raise FilmError(f"ffmpeg cannot be started ({error.strerror})") from error
    except OSError as error:
        raise FilmError(_stopped(file)) from error
    except RuntimeError as error:
        raise FilmError("there is no ffmpeg") from error


def _frames(file: Path) -> int:
    """How many frames a film has; 0 if it is none."""
    try:
        return imageio_ffmpeg.count_frames_and_secs(file)[0]
    except (OSError, RuntimeError):
        return 0


def _stopped(file: Path) -> str:
    return f"ffmpeg stopped before {file} was complete, as when a disk is full or the process is ended"
