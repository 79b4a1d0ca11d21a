"""A film that is made in pieces: each is a whole file, so that what is drawn outlives whatever ends the run.

`cut` ends a piece; a run that goes on begins the next one. Pieces are joined without being encoded again.
"""

import contextlib
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.show.film.encoder import FilmError, program
from taichi_silo.utils import atomic_write
from taichi_silo.utils.messages import shown

MARK = ".segment_"
LISTED = "-protocol_whitelist file,pipe -f concat -safe 0 -i pipe:0"  # names of the pieces come through a pipe
JOINED = "-c copy -movflags +faststart -f mp4"


class Segments:
    """Takes frames; the film gets its name when closed.

    Parameters
    ----------
    path : of the film; pieces stand beside it.
    encoder : makes, of a path, what writes frames to it (see `film.Encoder`).

    """

    def __init__(self, path: Path, encoder):
        self.path, self.encoder = path, encoder
        self.present, self.closed = None, False
        self.pieces: list[Path] = []
        self.number = 0  # of the next one

    def write(self, frame: np.ndarray) -> None:
        """Append one frame; RuntimeError if the film is closed or the encoder has stopped."""
        if self.closed:
            raise RuntimeError(f"{self.path} is closed")
        if self.present is None:
            self.present = self.encoder(self._piece(self.number))
            self.number += 1
        self.present.write(frame)

    def _piece(self, number: int) -> Path:
        return self.path.with_name(f"{self.path.stem}{MARK}{number:04d}{self.path.suffix}")

    def cut(self) -> list[str]:
        """Names of all pieces; up to now everything is in them, and on the disk."""
        if self.present is not None:
            self.present.close()
            atomic_write.sync(self.present.path)
            self.pieces.append(self.present.path)
            self.present = None
        return [piece.name for piece in self.pieces]

    def go_on(self, names: list[str]) -> None:
        """Go on after these pieces, and take away what was drawn later.

        Raises
        ------
        BadInput
            if one of them is missing.

        """
        own = re.compile(re.escape(f"{self.path.stem}{MARK}") + r"\d{4,}" + re.escape(self.path.suffix))
        for name in names:
            if not own.fullmatch(name):
                raise BadInput(f"{self.path.parent} cannot be resumed: {shown(name)} is no name of a piece of its film")
        self.pieces = [self.path.with_name(name) for name in names]
        for piece in self.pieces:
            if not piece.exists():
                raise BadInput(f"{piece} is missing; the film cannot go on without a gap, the run can with --no-film")
        for file in self.path.parent.glob(f"{self.path.stem}{MARK}*"):
            number = int(file.name.removeprefix(f"{self.path.stem}{MARK}").split(".")[0])
            self.number = max(self.number, number + 1)  # an encoder that outlived its run may still write to the last
            if file not in self.pieces:
                with contextlib.suppress(OSError):
                    file.unlink()

    def abandon(self) -> None:
        """Take away the present piece, whose encoder has failed; the others stay."""
        present, self.present = self.present, None
        if present is not None:
            with contextlib.suppress(FilmError, OSError):
                present.close()
            for left in (present.partial, present.path):
                with contextlib.suppress(OSError):
                    left.unlink(missing_ok=True)

    def close(self, keep: bool = False) -> None:
        """Join all pieces; without frames there is no film. They are left beside it if they are to be kept."""
        if self.closed:
            return
        self.cut()
        self.closed = True
        if self.pieces:
            with atomic_write.written(self.path) as passing:
                if len(self.pieces) == 1:
                    shutil.copyfile(self.pieces[0], passing)
                else:
                    self._join(passing)
        for piece in () if keep else self.pieces:
            piece.unlink()

    def _join(self, file: Path) -> None:
        lines = []
        for piece in self.pieces:
            name = piece.resolve().as_posix().replace("'", "'\\''")
            lines.append(f"file 'file:{name}'\n")
        command = [program(), "-y", "-loglevel", "error", *LISTED.split(), *JOINED.split(), str(file)]
        # own session: Ctrl-C stops the run, which then still completes its film
        try:
            done = subprocess.run(command, input="".join(lines).encode(), capture_output=True, start_new_session=True)
        except OSError as error:
            raise FilmError(f"ffmpeg cannot be started ({error.strerror})") from error
        if done.returncode:
            raise FilmError(f"ffmpeg failed to join {self.path}: {done.stderr.decode(errors='replace').strip()}")


def clear(folder: Path) -> None:
    """Take away the pieces of all films of a folder."""
    for piece in folder.glob(f"*{MARK}*"):
        piece.unlink(missing_ok=True)
