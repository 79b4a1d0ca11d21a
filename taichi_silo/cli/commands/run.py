"""`taichi-silo run`: a scenario with its own flags, or a scene from a file."""

from pathlib import Path
from typing import Annotated

import typer

from taichi_silo.cli.output_flags import (
    CheckFlag,
    ExplainFlag,
    FiguresFlag,
    FilmFlag,
    JsonFlag,
    OverwriteFlag,
    QuietFlag,
    YesFlag,
)

OPTIONS = {"context_settings": {"ignore_unknown_options": True, "allow_extra_args": True}, "add_help_option": False}


def _names(incomplete: str) -> list[str]:
    from taichi_silo.cli import catalogue

    return [name for name in catalogue.scenarios() if name.startswith(incomplete)]


def run(
    context: typer.Context,
    what: Annotated[
        str | None,
        typer.Argument(
            metavar="SCENE.toml|SCENARIO",
            autocompletion=_names,
            help="a scene file (the run.toml of a run is one), or a scenario of `taichi-silo list`",
        ),
    ] = None,
) -> None:
    """Run a silo: SCENE.toml, or a SCENARIO with its flags (`taichi-silo run outlet --help` shows them).

    Examples: taichi-silo run mass_flow --void-ratio 0.9 --walls smooth, taichi-silo run silo.toml --output outputs/mine
    """
    from taichi_silo.cli import catalogue
    from taichi_silo.cli.command_line import command
    from taichi_silo.errors import BadInput

    words = [] if what is None else [what, *context.args]
    if what is None or (what.startswith("-") and "--help" in words):
        command(scene_file, ["--help"], "taichi-silo run")
    if what == "-":
        raise BadInput(
            "scene is -; standard input must be given as /dev/stdin, as in taichi-silo run /dev/stdin < silo.toml"
        )
    if what.startswith("-"):  # flags first
        what = next((word for word in words if word.lower().endswith(".toml")), "")
        if not what:
            raise BadInput(
                f"the line begins with {words[0]}; a scenario or a folder stands first, as in taichi-silo run outlet "
                "--quiet, and behind flags only a scene file, SCENE.toml"
            )
    if _is_scene(what):
        from taichi_silo.cli.flags import refuse_flags_of_scenarios

        refuse_flags_of_scenarios([word for word in words if word != what], _own_flags())
        command(scene_file, words, "taichi-silo run")
    command(catalogue.load(what), context.args, f"taichi-silo run {catalogue.script(what).stem}")


def _is_scene(what: str) -> bool:
    """Whether a word means a file rather than a scenario."""
    return what.lower().endswith(".toml") or "/" in what or "\\" in what or Path(what).is_dir()


def _own_flags() -> set[str]:
    """Flags of `run SCENE.toml`."""
    from taichi_silo.cli.command_line import app_of

    found = typer.main.get_command(app_of(scene_file)).params
    return {flag for one in found for flag in (*one.opts, *one.secondary_opts)}


def scene_file(
    scene: Annotated[Path, typer.Argument(metavar="SCENE.toml", help="what it leaves out takes the defaults")],
    output: Annotated[
        Path | None, typer.Option(help="folder of the run; outputs/ and the file's name if not given")
    ] = None,
    overwrite: OverwriteFlag = False,
    film: FilmFlag = True,
    figures: FiguresFlag = True,
    change: Annotated[
        list[str] | None,
        typer.Option("--set", help="PATH=VALUE: another value, such as --set flow.speed_m_per_s=0.005; repeatable"),
    ] = None,
    threads: Annotated[
        int | None, typer.Option(help="CPU threads that share a step; those of the scene if not given")
    ] = None,
    explain: ExplainFlag = False,
    check: CheckFlag = False,
    yes: YesFlag = False,
    quiet: QuietFlag = False,
    json: JsonFlag = False,
) -> None:
    """Run a scene from a file: SCENE.toml (also the run.toml of an earlier run).

    The same scene on the same number of threads gives the same forces, bit by bit. Instead of a file the name of a
    scenario may stand, followed by its own flags: taichi-silo list, taichi-silo run outlet --help.

    Example: taichi-silo run silo.toml --output outputs/mine --set sand.void_ratio=0.7
    """
    from taichi_silo.cli import command_line, flags
    from taichi_silo.runs.run_folder import free_name, named
    from taichi_silo.scene.scene_files import read_scene
    from taichi_silo.utils.console import Console

    console = Console(quiet, json)
    changes = list(change or ())
    if threads is not None:
        changes.append(f"machine.threads={threads}")
    wanted = read_scene(scene, changes)
    if explain:
        own = _own_flags()
        command_line.explain(wanted, lambda words: flags.for_scene_file(words, own))
        return
    if check:
        command_line.check(wanted, str(scene), console)
        return
    from taichi_silo import api
    from taichi_silo.cli.long_runs import permission
    from taichi_silo.runs.observers.progress import ProgressLine

    folder = output.expanduser() if output else free_name(Path("outputs") / named(scene))
    console.say(f"The run goes to {folder}.")
    lines = (ProgressLine(console.terminal, permission(console, yes)),)
    left = api.run(wanted, folder, overwrite=overwrite, film=film, figures=figures, progress=False, extra=lines)
    command_line.tell(left.folder, console)
