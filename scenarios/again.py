"""Run a scene from a file: the run.toml of an earlier run, or one written by hand.

The same scene on the same number of threads gives the same forces, bit by bit.
"""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo import cli, flags
from taichi_silo.folder import free_name, read_scene
from taichi_silo.observers.progress import ProgressLine
from taichi_silo.run import run


def again(
    file: Annotated[Path, Argument(help="run.toml of a run; what it leaves out takes the defaults")],
    output: Annotated[Path | None, Option(help="folder of the run; outputs/again if not given")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="replace a run in the output folder")] = False,
    film: Annotated[bool, Option(help="draw void_ratio.mp4")] = True,
    explain: flags.ExplainFlag = False,
):
    """Run the scene in FILE."""
    scene = read_scene(file)
    if explain:
        cli.explain(scene)
        return
    folder = output.expanduser() if output else free_name(Path("outputs") / "again")
    cli.tell(run(scene, folder, overwrite=overwrite, film=film, extra=(ProgressLine(),)))


if __name__ == "__main__":
    cli.command(again)
