"""Film and figures as data that a page can hold."""

import base64
import io
import subprocess
from dataclasses import dataclass
from pathlib import Path

import imageio_ffmpeg
from PIL import Image

POSTER_WIDTH, QUALITY = 1280, 85
FROM_END_S = 0.5  # where the poster is taken: nearly all has happened
SLOWEST_S = 60.0


@dataclass(frozen=True)
class Film:
    """A film and one of its frames, each as a data URI."""

    film: str
    poster: str


def data_uri(content: bytes, kind: str) -> str:
    """Content as it stands in a page."""
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def figure(file: Path) -> str | None:
    """A PNG; None if it is not there or is none."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    whole = content.startswith(b"\x89PNG\r\n\x1a\n") and b"IEND" in content[-16:]
    return data_uri(content, "image/png") if whole else None


def film(file: Path) -> Film | None:
    """An H.264 film with its poster; None if it is not there or cannot be read."""
    frame = _frame(file)
    return Film(data_uri(file.read_bytes(), "video/mp4"), data_uri(frame, "image/jpeg")) if frame else None


def _frame(file: Path) -> bytes:
    """A frame near the film's end as JPEG; empty if there is none."""
    if not file.is_file():
        return b""
    command = [
        imageio_ffmpeg.get_ffmpeg_exe(), "-nostdin", "-loglevel", "error", "-sseof", f"-{FROM_END_S}", "-i", str(file),
        "-frames:v", "1", "-vf", f"scale={POSTER_WIDTH}:-2", "-f", "image2pipe", "-c:v", "png", "-",
    ]  # fmt: skip
    try:
        picture = subprocess.run(command, capture_output=True, timeout=SLOWEST_S, check=True).stdout
        content = io.BytesIO()
        Image.open(io.BytesIO(picture)).convert("RGB").save(content, "JPEG", quality=QUALITY)
        return content.getvalue()
    except (OSError, subprocess.SubprocessError):  # no film, or one that was cut off; Pillow's errors are OSErrors
        return b""
