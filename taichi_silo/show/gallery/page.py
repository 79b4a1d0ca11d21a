"""The page: one file, pictures included; films and figures in full size are linked."""

from importlib.metadata import version
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from taichi_silo.errors import BadInput
from taichi_silo.runs.run_folder import no_link
from taichi_silo.show.gallery.runs import Entry, entry, folders
from taichi_silo.utils import atomic_write

PAGE = "index.html"


def gather(root: Path, page: Path, seen=lambda number, count: None) -> list[Entry]:
    """What the page in the folder `page` shows of the runs below `root`.

    Parameters
    ----------
    root : folder that is searched.
    page : folder of the page.
    seen : hears how many of how many runs are done.

    Raises
    ------
    BadInput
        if there is no run with a film or a figure.

    """
    found, entries = folders(root), []
    for number, folder in enumerate(found):
        entries.append(entry(folder, root, page))
        seen(number + 1, len(found))
    entries = [one for one in entries if one is not None]
    if not entries:
        raise BadInput(f"folder is {root}; it must hold runs with films or figures, and holds {len(found)} runs")
    return entries


def write(entries: list[Entry], page: Path, title: str) -> Path:
    """Write the page into a folder; it is there when it is complete, or not at all."""
    environment = Environment(
        loader=PackageLoader("taichi_silo.show.gallery", "."), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    text = environment.get_template("page.html.j2").render(entries=entries, title=title, version=version("taichi-silo"))
    no_link(page / PAGE, page / f"{PAGE}.part")
    with atomic_write.written(page / PAGE) as passing:
        passing.write_text(text, encoding="utf-8")
    return page / PAGE
