"""The picture of the package's layout: its rooms by floors, and who imports from whom, read from the code."""

import ast
import math
from collections import Counter
from html import escape
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "taichi_silo"
ROOMS = ("cli", "studies", "api", "show", "runs", "simulation", "scene", "analysis", "mpm", "utils", "errors")
ROW, WIDTH, GUTTER = 58, 620, 260  # of a room, of its box, of the arcs beside it [px]


def files_of(room: str) -> list[Path]:
    """Python files of a package, or of the module of that name."""
    return sorted((PACKAGE / room).rglob("*.py")) if (PACKAGE / room).is_dir() else [PACKAGE / f"{room}.py"]


def imported(file: Path) -> set[str]:
    """The rooms from which a file imports."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{name.name}" for name in node.names}
        elif isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
    return {name.split(".")[1] for name in found if name.startswith("taichi_silo.")} & set(ROOMS)


def imports() -> Counter:
    """How many files of one room import from another, by (importing, imported)."""
    pairs = ((room, other) for room in ROOMS for file in files_of(room) for other in imported(file))
    return Counter((room, other) for room, other in pairs if room != other)


def purpose(room: str) -> str:
    """First sentence of a room's docstring."""
    words = ast.get_docstring(ast.parse(files_of(room)[0].read_text(encoding="utf-8"))) or ""
    return " ".join(words.split("\n\n")[0].split())


def _box(number: int, room: str) -> str:
    files = files_of(room)
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    size = f"{len(files)} files, {lines:,} lines" if len(files) > 1 else f"{lines} lines"
    y, words = number * ROW, purpose(room)
    words = words if len(words) < 96 else f"{words[:93]}..."
    return (
        f'<rect x="1" y="{y + 4}" width="{WIDTH}" height="{ROW - 8}" rx="6" fill="none" stroke="currentColor"/>'
        f'<text x="14" y="{y + 25}" font-weight="bold">{room}</text>'
        f'<text x="{WIDTH - 12}" y="{y + 25}" text-anchor="end" font-size="12">{size}</text>'
        f'<text x="14" y="{y + 43}" font-size="12">{escape(words)}</text>'
    )


def _arc(one: int, other: int, count: int) -> str:
    """From the middle of an importing room down to the imported one; thicker the more files import."""
    y, end = (one + 0.6) * ROW, (other + 0.4) * ROW
    bulge = WIDTH + GUTTER * (other - one) / (len(ROOMS) - 1)
    return (
        f'<path d="M {WIDTH + 2} {y:g} C {bulge:g} {y:g} {bulge:g} {end:g} {WIDTH + 6} {end:g}" fill="none" '
        f'stroke="currentColor" stroke-opacity="0.55" stroke-width="{0.6 + 0.8 * math.log(count):.2g}" '
        f'marker-end="url(#into)"/>'
    )


def picture() -> str:
    """An SVG: each room imports only from rooms below it."""
    boxes = [_box(number, room) for number, room in enumerate(ROOMS)]
    arcs = [_arc(ROOMS.index(one), ROOMS.index(other), count) for (one, other), count in imports().items()]
    tip = (
        '<defs><marker id="into" orient="auto" markerUnits="userSpaceOnUse" markerWidth="9" markerHeight="8" refX="8" '
        'refY="4"><path d="M0 0 L9 4 L0 8 Z" fill="currentColor"/></marker></defs>'
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH + GUTTER} {len(ROOMS) * ROW}" role="img" '
    label = 'aria-label="Packages of taichi_silo and their imports" style="width:100%;height:auto" font-size="15" '
    return f'{head}{label}font-family="inherit" fill="currentColor">{tip}{"".join(boxes + arcs)}</svg>'
