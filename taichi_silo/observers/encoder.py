"""Frames to a film, by ffmpeg."""

import contextlib
import subprocess
import tempfile
from pathlib import Path

import imageio_ffmpeg
import numpy as np


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
    """

    def __init__(self, path: Path, frames_per_second: int, size: tuple[int, int]):
        self.path = path
        self.partial = path.with_name(f"{path.stem}.partial{path.suffix}")
        path.parent.mkdir(parents=True, exist_ok=True)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the encoder
        # no frame refers to a later one (-bf 0): films can then be joined whatever their lengths are
        options = (
            f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {size[0]}x{size[1]} -r {frames_per_second} -i - "
            "-an -vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p "
            "-colorspace bt709 -color_primaries bt709 -color_trc bt709 "
            "-c:v libx264 -preset veryfast -crf 18 -bf 0 -threads 2 -movflags +faststart -f mp4"
        )
        command = [imageio_ffmpeg.get_ffmpeg_exe(), *options.split(), str(self.partial)]
        # own session: Ctrl-C stops the run, not the encoder, which then still completes its file
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            start_new_session=True,
        )
        self.frames = 0

    def write(self, frame: np.ndarray) -> None:
        """Append one frame, (rows, columns, 3) of bytes; RuntimeError if ffmpeg has stopped."""
        try:
            self._process.stdin.write(memoryview(np.ascontiguousarray(frame)).cast("B"))
        except (BrokenPipeError, ValueError) as error:
            raise RuntimeError(f"ffmpeg stopped while writing {self.partial}: {self._complaint()}") from error
        self.frames += 1

    def _complaint(self) -> str:
        self._process.wait()
        if self._errors.closed:
            return "already closed"
        self._errors.seek(0)
        return self._errors.read().decode(errors="replace").strip()

    def close(self) -> None:
        """Finish the file and give it its final name; remove it if it holds no frame; RuntimeError if bad."""
        if self._process.stdin.closed:
            return
        with contextlib.suppress(BrokenPipeError):  # ffmpeg has gone; its exit code tells below
            self._process.stdin.close()
        complaint = self._complaint()
        self._errors.close()
        if self.frames == 0:
            self.partial.unlink(missing_ok=True)
        elif self._process.returncode == 0:
            self.partial.replace(self.path)
        else:
            raise RuntimeError(f"ffmpeg failed on {self.partial}: {complaint}")
