"""What pages for a browser share: templates, and pictures and films as data that stand in the page itself."""

import base64
import io
from pathlib import Path

import imageio_ffmpeg
import jinja2
from PIL import Image

LAST_S = 0.1  # of a film: later than that there may be no frame


def render(template: Path, **values) -> str:
    """The text of a template; whatever a run's files hold stands in it as text, never as markup."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template.parent, encoding="utf-8"), autoescape=True,
        undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template(template.name).render(**values)


def data_uri(content: bytes, kind: str) -> str:
    """Content as it stands in a page."""
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def jpeg(picture: Image.Image | None, width: int) -> str | None:
    """A picture as JPEG data, at most so many pixels wide; None if there is no picture."""
    if picture is None:
        return None
    picture.thumbnail((width, 4 * width))
    content = io.BytesIO()
    picture.save(content, "JPEG", quality=85, optimize=True)
    return data_uri(content.getvalue(), "image/jpeg")


def picture_of(file: Path) -> Image.Image | None:
    """The picture of a file; None if it is not there or damaged."""
    try:
        return Image.open(file).convert("RGB")
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError):  # whatever a damaged one makes of Pillow
        return None


def frame_of(film: Path, share: float) -> Image.Image | None:
    """The frame at a share of a film's length, 0 to 1; None if the film is not there or cannot be read."""
    file = str(film.absolute())  # ffmpeg reads a relative "run:1/..." as a protocol
    try:
        reader = imageio_ffmpeg.read_frames(file)
        seconds = next(reader)["duration"]
        reader.close()
        when = max(0.0, min(share * seconds, seconds - LAST_S))
        reader = imageio_ffmpeg.read_frames(file, input_params=["-ss", f"{when:.3f}"])
        size = next(reader)["size"]
        frame = Image.frombytes("RGB", size, next(reader))
        reader.close()
    except (OSError, RuntimeError, StopIteration, ValueError):  # whatever a damaged film makes of the decoder
        return None
    return frame
