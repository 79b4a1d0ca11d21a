"""What a page says of each run of a folder."""

import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from taichi_silo.errors import BadInput
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.runs.run_folder import MADE
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.gallery import stills
from taichi_silo.utils.bounded_reading import as_left

FIGURES = {"forces": "P, T and N", "void_ratio": "Void ratio", "wall_stress": "Wall stresses"}
HALF_WAY, NEAR_END = 0.5, 0.98  # of a film: an emptied silo shows nothing
NUMBERS = (("P", "bottom_N_per_m"), ("T", "shear_N_per_m"), ("N", "normal_N_per_m"))


@dataclass(frozen=True)
class Still:
    """A picture with its words, and the file that it stands for, relative to the page."""

    words: str
    picture: str
    link: str


@dataclass(frozen=True)
class Entry:
    """A run: its name, what it is, what became of it, numbers (name, value), films and figures."""

    name: str
    title: str
    state: str
    numbers: tuple[tuple[str, str], ...]
    films: tuple[Still, ...]
    figures: tuple[Still, ...]


def folders(root: Path) -> list[Path]:
    """The runs below a folder, or the folder itself, by name."""
    return sorted({file.parent for file in root.rglob(MADE)})


def entry(folder: Path, root: Path, page: Path) -> Entry | None:
    """A run as the page in the folder `page` shows it; None if it has neither a film nor a figure."""
    run = RunFiles.read(folder)
    try:
        with as_left(folder):
            words = _plain(run.title), _state(run.summary), _numbers(run)
    except BadInput:
        words = "", "Its files are not as a run leaves them.", ()
    share = HALF_WAY if run.free else NEAR_END
    films = [
        Still(f"Film: {field.scale.label}", picture, _link(folder / f"{name}.mp4", page))
        for name, field in FIELDS.items()
        if (folder / f"{name}.mp4").is_file() and (picture := stills.of_film(folder / f"{name}.mp4", share))
    ]
    figures = [
        Still(words, picture, _link(folder / "figures" / f"{name}.png", page))
        for name, words in FIGURES.items()
        if (picture := stills.of_figure(folder / "figures" / f"{name}.png"))
    ]
    if not films and not figures:
        return None
    name = folder.relative_to(root).as_posix() if folder != root else folder.resolve().name
    return Entry(name, *words, tuple(films), tuple(figures))


def _plain(title: str) -> str:
    """A title without the signs of a formula."""
    return title.replace("$e_0$", "e₀")


def _state(summary: dict) -> str:
    if not summary:
        return "It has not ended."
    return "" if summary.get("finished") else f"It went wrong: {summary.get('failure') or 'no reason is told'}."


def _numbers(run: RunFiles) -> tuple[tuple[str, str], ...]:
    """Cells, residual forces, wall friction angle and flow pattern, as far as they are known."""
    found, residual = [], run.summary.get("residual") or {}
    cell, moved = run.parameter("grid", "cell_size_m"), run.parameter("flow", "displacement_m")
    if cell is not None:
        found.append(("cells", f"{1e3 * cell:g} mm"))
    if moved is not None and not run.free:
        found.append(("u", f"{1e3 * moved:g} mm"))
    found += [(name, f"{1e-3 * residual[key]:.3f} kN/m") for name, key in NUMBERS if residual.get(key) is not None]
    if residual.get("wall_friction_angle_deg") is not None:
        found.append(("arctan(T/N)", f"{residual['wall_friction_angle_deg']:.1f}°"))
    pattern = (run.summary.get("flow_pattern") or {}).get("kind")
    return tuple(found + ([("flow", pattern)] if pattern else []))


def _link(file: Path, page: Path) -> str:
    """Of a file from the page; absolute where no relative one leads there."""
    try:
        return quote(Path(os.path.relpath(file.resolve(), page.resolve())).as_posix())
    except ValueError:  # another drive of Windows
        return file.resolve().as_uri()
