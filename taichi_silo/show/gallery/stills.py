"""Pictures small enough to stand in a page."""

import base64
import io
from pathlib import Path

import imageio_ffmpeg
from PIL import Image

WIDE, QUALITY = 960, 82  # pixels; of JPEG
LAST_S = 0.1  # of a film: later than that there may be no frame


def of_film(file: Path, share: float) -> str | None:
    """The frame at a share of a film's length, 0 to 1, as a data URI; None if the film cannot be read."""
    try:
        reader = imageio_ffmpeg.read_frames(str(file))
        seconds = next(reader)["duration"]
        reader.close()
        when = max(0.0, min(share * seconds, seconds - LAST_S))
        reader = imageio_ffmpeg.read_frames(str(file), input_params=["-ss", f"{when:.3f}"])
        size = next(reader)["size"]
        frame = Image.frombytes("RGB", size, next(reader))
        reader.close()
    except (OSError, RuntimeError, StopIteration, ValueError):  # whatever a damaged film makes of the decoder
        return None
    return _small(frame)


def of_figure(file: Path) -> str | None:
    """A figure as a data URI; None if it is not there or damaged."""
    try:
        return _small(Image.open(file).convert("RGB"))
    except OSError:  # Pillow's own error is one
        return None


def _small(picture: Image.Image) -> str:
    picture.thumbnail((WIDE, WIDE * 4))
    content = io.BytesIO()
    picture.save(content, "JPEG", quality=QUALITY, optimize=True)
    return f"data:image/jpeg;base64,{base64.b64encode(content.getvalue()).decode('ascii')}"
