"""Frames to a film, by ffmpeg."""

import contextlib
import subprocess
import tempfile
from pathlib import Path

import imageio_ffmpeg
import numpy as np


class FilmError(RuntimeError):
    """ffmpeg is not there, or has stopped."""


def program() -> str:
    """The file of ffmpeg.

    Raises
    ------
    FilmError
        if there is none.

    """
    try:
        return imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError as error:
        raise FilmError("there is no ffmpeg") from error


class Encoder:
    """Feeds raw frames to ffmpeg under a temporary name; the film gets its final name when closed.

    Parameters
    ----------
    path : Path
        Where the film goes.
    frames_per_second : int
        Frame rate.
    size : tuple of int
        Columns and rows of a frame, even numbers.

    Raises
    ------
    FilmError
        if ffmpeg cannot be started.
    """

    def __init__(self, path: Path, frames_per_second: int, size: tuple[int, int]):
        self.path = path
        self.partial = path.with_name(f"{path.stem}.partial{path.suffix}")
        # no frame refers to a later one (-bf 0): films can then be joined whatever their lengths are
        options = (
            f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {size[0]}x{size[1]} -r {frames_per_second} -i - "
            "-an -vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p "
            "-colorspace bt709 -color_primaries bt709 -color_trc bt709 "
            "-c:v libx264 -preset veryfast -crf 18 -bf 0 -threads 2 -movflags +faststart -f mp4"
        )
        command = [program(), *options.split(), str(self.partial)]
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the encoder
        # own session: Ctrl-C stops the run, not the encoder, which then still completes its file
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=self._errors,
                start_new_session=True,
            )
        except OSError as error:
            self._errors.close()
            raise FilmError(f"ffmpeg cannot be started ({error.strerror})") from error
        self.frames = 0

    def write(self, frame: np.ndarray) -> None:
        """Append one frame, (rows, columns, 3) of bytes; FilmError if ffmpeg has stopped."""
        try:
            self._process.stdin.write(memoryview(np.ascontiguousarray(frame)).cast("B"))
        except (BrokenPipeError, ValueError) as error:
            raise FilmError(f"ffmpeg stopped while writing {self.partial}: {self._complaint()}") from error
        self.frames += 1

    def _complaint(self) -> str:
        self._process.wait()
        if self._errors.closed:
            return "already closed"
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        code = self._process.returncode
        return lines[-1].strip() if lines else f"it was ended by signal {-code}" if code < 0 else f"code {code}"

    def close(self) -> None:
        """Finish the file and give it its final name; remove it if it holds no frame; FilmError if bad."""
        if self._errors.closed:
            return
        with contextlib.suppress(BrokenPipeError):  # ffmpeg has gone; its exit code tells below
            self._process.stdin.close()
        complaint = self._complaint()
        self._errors.close()
        if self.frames == 0 or self._process.returncode != 0:
            self.partial.unlink(missing_ok=True)
        if self._process.returncode != 0:
            raise FilmError(f"ffmpeg failed on {self.partial}: {complaint}")
        if self.frames > 0:
            self.partial.replace(self.path)
