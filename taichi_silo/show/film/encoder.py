"""Frames to a film, through imageio and its ffmpeg plugin: H.264 (MP4), VP9 (WebM) or GIF."""

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
# codec and what ffmpeg is told, by the ending of the file; each frame of a GIF has 256 colours of its own
KINDS = {
    ".mp4": ("libx264", f"{COLOURS} -preset veryfast -crf 18 -bf 0 -threads 2 -movflags +faststart -f mp4"),
    ".webm": ("libvpx-vp9", f"{COLOURS} -crf 24 -b:v 0 -deadline realtime -cpu-used 6 -row-mt 1 -threads 2 -f webm"),
    ".gif": (
        "gif",
        "-filter_complex [0:v]split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=none -f gif",
    ),
}


def encode(file: Path, frames: Iterable[np.ndarray], frames_per_second: int = FRAMES_PER_SECOND) -> int:
    """Encode frames (rows, columns, 3) of bytes, even numbers of rows and columns; returns how many there were.

    The ending of the file, one of `KINDS`, says what film it is. The film is there when it is complete, or not at all;
    without frames there is none.

    Raises
    ------
    FilmError
        if ffmpeg is not there, or has stopped.

    """
    passing, count = passing_name(file), 0
    codec, told = KINDS[file.suffix.lower()]
    try:
        with imageio.get_writer(
            passing, format="FFMPEG", mode="I", fps=frames_per_second, codec=codec, macro_block_size=2,
            pixelformat="pal8" if codec == "gif" else "yuv420p", quality=None, output_params=told.split(),
            ffmpeg_log_level="quiet",  # its lines would stand on the terminal before the sentence that says it
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
    """The name of a film that is not complete; its ending lets imageio write it with ffmpeg, which it does no GIF.

    It is absolute: in a relative one, ffmpeg reads "run:1/..." as a protocol and "-run/..." as an option.
    """
    ending = ".mp4" if file.suffix.lower() == ".gif" else file.suffix
    return file.absolute().with_name(f"{file.stem}.part{ending}")


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
