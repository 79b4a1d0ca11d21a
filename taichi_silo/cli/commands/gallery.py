"""`taichi-silo gallery`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import JsonFlag, QuietFlag
from taichi_silo.utils.console import Console
from taichi_silo.utils.messages import counted


def command(
    folder: Annotated[Path, Argument(help="that holds runs, at any depth")] = Path("outputs"),
    output: Annotated[Path | None, Option(help="folder of the page; FOLDER/gallery_page if not given")] = None,
    title: Annotated[str, Option(help="above the page")] = "Silo flows",
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Make a page of all runs below a folder: a frame of each film, figures and numbers, with links to the films.

    The page is one file, and is made anew each time. Example:

    taichi-silo gallery outputs --output outputs/gallery_page
    """
    from taichi_silo.errors import BadInput
    from taichi_silo.runs.run_folder import writable
    from taichi_silo.show.gallery import page
    from taichi_silo.utils.bounded_reading import place

    console, root = Console(quiet, json), place(folder, "folder")
    if not root.is_dir():
        raise BadInput(f"folder is {folder}; it must be a folder that holds runs")
    target = place(output, "output") if output else root / "gallery_page"
    with console.progress() as progress:
        task = progress.add_task("looking", total=None)
        entries = page.gather(root, target, lambda done, count: progress.update(task, completed=done, total=count))
    file = page.write(entries, writable(target), title)
    console.say(f"{file}  {counted(len(entries), 'run')}, {file.stat().st_size / 1e6:.2g} MB")
    console.result({"page": str(file), "runs": [one.name for one in entries]})
