"""The page of all runs: one file, pictures included; films and figures in full size are linked."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from urllib.parse import quote

from taichi_silo.errors import BadInput
from taichi_silo.runs.inclined_walls import none_vertical
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.runs.result import Result
from taichi_silo.runs.run_folder import MADE, no_link
from taichi_silo.show import html
from taichi_silo.show.titles import title
from taichi_silo.utils import atomic_write
from taichi_silo.utils.bounded_reading import as_left
from taichi_silo.utils.messages import counted

PAGE = "index.html"
FIGURES = {"forces": "P, T and N", "void_ratio": "Void ratio", "wall_stress": "Wall stresses"}
HALF_WAY, NEAR_END = 0.5, 0.98  # of a film: an emptied silo shows nothing
NUMBERS = {"P": "bottom_N_per_m", "T": "shear_N_per_m", "N": "normal_N_per_m"}
WIDTH = 960  # of a picture [pixels]


@dataclass(frozen=True)
class Still:
    """A picture with its words, and the film or figure that it stands for, relative to the page."""

    words: str
    picture: str
    link: str


@dataclass(frozen=True)
class GalleryEntry:
    """A run: its name, what it is, what became of it, numbers (name, value), films and figures."""

    name: str
    title: str
    state: str
    numbers: tuple[tuple[str, str], ...]
    films: tuple[Still, ...]
    figures: tuple[Still, ...]


def gather(root: Path, page: Path, seen: Callable[[int, int], None] = lambda number, count: None) -> list[GalleryEntry]:
    """What the page in the folder `page` shows of the runs below `root`; `seen` hears how many of how many are done.

    Raises BadInput if there is no run with a film or a figure.
    """
    found, entries = sorted({file.parent for file in root.rglob(MADE)}), []
    for number, folder in enumerate(found, 1):
        entries.append(_entry(folder, root, page))
        seen(number, len(found))
    entries = [one for one in entries if one.films or one.figures]
    if not entries:
        raise BadInput(
            f"folder is {root}; it must hold runs with films or figures, and holds {counted(len(found), 'run')}"
        )
    return entries


def write(entries: list[GalleryEntry], page: Path, title: str) -> Path:
    """Write the page into a folder; it is there when it is complete, or not at all."""
    template = Path(__file__).with_name("page.html.j2")
    text = html.render(template, entries=entries, title=title, version=version("taichi-silo"))
    no_link(page / PAGE, page / f"{PAGE}.part")
    with atomic_write.written(page / PAGE) as passing:
        passing.write_text(text, encoding="utf-8")
    return page / PAGE


def _entry(folder: Path, root: Path, page: Path) -> GalleryEntry:
    """A run as the page in the folder `page` shows it."""
    run, share = Result(folder, tolerant=True), NEAR_END
    try:
        with as_left(folder):
            words = title(run, "e₀"), _state(run.summary), _numbers(run)
            share = HALF_WAY if run.free else NEAR_END
    except BadInput:
        words = "", "Its files are not as a run leaves them.", ()
    films = {
        folder / f"{name}.mp4": (f"Film: {field.scale.label}", html.frame_of(folder / f"{name}.mp4", share))
        for name, field in FIELDS.items()
        if (folder / f"{name}.mp4").is_file()
    }
    pictures = {folder / "figures" / f"{name}.png": words for name, words in FIGURES.items()}
    figures = {file: (words, html.picture_of(file)) for file, words in pictures.items()}
    name = folder.relative_to(root).as_posix() if folder != root else folder.resolve().name
    return GalleryEntry(name, *words, _stills(films, page), _stills(figures, page))


def _stills(found: dict, page: Path) -> tuple[Still, ...]:
    """Those of files, each with its words and picture, that have a picture."""
    pictures = {file: (words, html.jpeg(picture, WIDTH)) for file, (words, picture) in found.items()}
    return tuple(Still(words, data, _link(file, page)) for file, (words, data) in pictures.items() if data)


def _state(summary: dict) -> str:
    if not summary:
        return "It has not ended."
    return "" if summary.get("finished") else f"It went wrong: {summary.get('failure') or 'no reason is told'}."


def _numbers(run: Result) -> tuple[tuple[str, str], ...]:
    """Cells, residual forces, wall friction angle and flow pattern, as far as they are known."""
    found, residual = [("cells", f"{1e3 * run.scene.grid.cell_size_m:g} mm")], run.summary.get("residual") or {}
    if not run.free:
        found.append(("u", f"{1e3 * run.scene.flow.displacement_m:g} mm"))
    silo = run.scene.silo
    forces = {name: residual.get(key) for name, key in NUMBERS.items()}
    if none_vertical(silo) and run.residual is not None:
        forces = {name: run.residual[name] for name in NUMBERS}
    found += [(name, f"{1e-3 * value:.3f} kN/m") for name, value in forces.items() if value is not None]
    if residual.get("wall_friction_angle_deg") is not None and not none_vertical(silo):
        found.append(("arctan(T/N)", f"{residual['wall_friction_angle_deg']:.1f}°"))
    pattern = (run.summary.get("flow_pattern") or {}).get("kind")
    return tuple(found + ([("flow", pattern)] if pattern else []))


def _link(file: Path, page: Path) -> str:
    """Of a file from the page; absolute where no relative one leads there."""
    try:
        return quote(Path(os.path.relpath(file.resolve(), page.resolve())).as_posix())
    except ValueError:  # another drive of Windows
        return file.resolve().as_uri()
