"""`taichi-silo resume`."""

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from taichi_silo.cli.output_flags import FiguresFlag, JsonFlag, QuietFlag
from taichi_silo.utils.console import Console


def resume(
    folder: Annotated[Path, Argument(metavar="DIR", help="folder of the run, such as outputs/mass_flow_e0.60_smooth")],
    threads: Annotated[int | None, Option(help="CPU threads; as many as before if not given")] = None,
    film: Annotated[bool, Option("--film/--no-film", help="go on with the film, if the run has one")] = True,
    figures: FiguresFlag = True,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Go on with a run that was interrupted, by Ctrl-C, a crash or a power cut, from its last checkpoint.

    On the same machine and as many threads it becomes, bit by bit, what it would have become without the interruption;
    curves and film go on without a gap. A run that is finished stays as it is.

    taichi-silo resume outputs/mass_flow_e0.60_very-rough
    """
    from taichi_silo import api
    from taichi_silo.cli.command_line import tell
    from taichi_silo.runs.observers.progress import ProgressLine
    from taichi_silo.runs.run_folder import finished

    console = Console(quiet, json)
    if finished(folder.expanduser()):
        console.say(f"The run in {folder} is finished; there is nothing to go on with.")
    else:
        lines = (ProgressLine(console.terminal),)
        api.resume(folder, threads=threads, film=None if film else False, figures=figures, progress=False, extra=lines)
    tell(folder.expanduser(), console)
