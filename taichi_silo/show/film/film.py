"""A film, encoded as its frames are drawn."""

from pathlib import Path

from taichi_silo.show.film.encoder import Encoder
from taichi_silo.show.film.picture import Picture
from taichi_silo.show.film.segments import Segments

FRAMES_PER_SECOND = 30


class Film:
    """An H.264 film of one run, drawn off screen.

    Parameters
    ----------
    path : Path
        The film, for example void_ratio.mp4; it bears this name only once closed.
    picture : Picture
        What draws the frames.
    frames_per_second : int
        Frame rate.

    Raises
    ------
    ValueError
        If the frame rate is not positive.
    """

    def __init__(self, path: Path, picture: Picture, frames_per_second: int = FRAMES_PER_SECOND):
        if not frames_per_second > 0:
            raise ValueError("frame rate must be positive")
        self.picture = picture
        size = picture.canvas.size
        self.segments = Segments(Path(path), lambda piece: Encoder(piece, frames_per_second, size))

    def add_forces(self, *row: float) -> None:
        """Extend the force curves, as `Picture.add_forces` is told."""
        self.picture.add_forces(*row)

    def add_frame(self, position, values, **when) -> None:
        """Draw and encode one frame, as `Picture.frame` is told; RuntimeError if closed or if ffmpeg has stopped."""
        self.segments.write(self.picture.frame(position, values, **when))

    def close(self) -> None:
        """Finish the film and give it its name; safe to call again, and after an aborted run."""
        self.segments.close()

    def __enter__(self) -> "Film":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
