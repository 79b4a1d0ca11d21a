"""The letters of a page: matplotlib's DejaVu Sans, and texts that fit into their width."""

from pathlib import Path

import matplotlib
from PIL import ImageFont

INK, GREY = (34, 34, 34), (105, 105, 105)
FONTS = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
LARGEST, SMALLEST = 42, 24  # size of a title in one line; a longer one has two


def font(size: float, bold: bool = False) -> ImageFont.FreeTypeFont:
    """Return matplotlib's bundled DejaVu Sans, `size` in pixels."""
    return ImageFont.truetype(str(FONTS / ("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")), size)


def title_lines(title: str, zoom: float, width: float) -> tuple[list[str], float]:
    """The lines of a title, one or two, and the size of their letters in lengths of the layout.

    Parameters
    ----------
    title : what to write.
    zoom : pixels to a length of the layout.
    width : that a line may have [lengths of the layout].

    """

    def wide(text: str, size: float) -> float:
        return font(size * zoom, bold=True).getlength(text) / zoom

    size = float(LARGEST)
    while size > SMALLEST and wide(title, size) > width:
        size -= 1
    if wide(title, size) <= width:
        return [title], size
    words, size = title.split(" "), float(SMALLEST + 8)
    cuts = range(1, len(words)) or range(1)
    pairs = [(" ".join(words[:cut]), " ".join(words[cut:])) for cut in cuts]
    best = min(pairs, key=lambda pair: max(wide(line, size) for line in pair))
    longest = max(wide(line, size) for line in best)
    return [line for line in best if line], min(size, size * width / longest)


def fitting(text: str, size: float, zoom: float, width_px: float, bold: bool = False) -> float:
    """The size of letters, at most that given [lengths of the layout], with which a text is so wide at most."""
    return min(size, size * width_px / max(font(size * zoom, bold).getlength(text), 1e-9))
