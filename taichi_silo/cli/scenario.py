"""Scenarios of a silo as commands: a scene, and which of its values are flags."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from taichi_silo import api
from taichi_silo.cli import command_line, flags, model_silo
from taichi_silo.cli.output_flags import (
    CheckFlag,
    ExplainFlag,
    FiguresFlag,
    FilmFlag,
    JsonFlag,
    OutputFlag,
    OverwriteFlag,
    QuietFlag,
    YesFlag,
)
from taichi_silo.scene import fidelity as fidelities
from taichi_silo.scene.dotted_paths import changed, tables_with
from taichi_silo.scene.sands import sand as named_sand
from taichi_silo.scene.scene import Scene
from taichi_silo.utils.console import Console

SILO = ("silo.width_m", "silo.height_m", "silo.section")
OUTLET = ("silo.outlet.width_m", "silo.outlet.position")
CONTROLLED = ("flow.speed_m_per_s", "flow.displacement_m")
ANGLE = "walls.friction_angle_deg"
SHARED = (  # by all scenarios of a silo
    "sand.void_ratio", "sand.law", "walls.kind", ANGLE, "walls.bottom_friction_angle_deg",
    "filling.kind", "filling.layers", "filling.drop_m", "silo.half",
    "grid.cell_size_m", "grid.points_per_cell", "grid.shape", "averaging.characteristic_length_m", "averaging.weight",
    "averaging.wall", "averaging.means",
    "method.noise_control", "machine.threads", "machine.arch", "output.records_per_period", "output.snapshots",
    *flags.METHOD,
)  # fmt: skip
RUN = [  # parameters of all, no values
    "sand", "fidelity", "output", "overwrite", "film", "figures", "explain", "check", "yes", "quiet", "json",
]  # fmt: skip
NOTES = {ANGLE: "; {dense:g} for dense and {loose:g} for loose sand if not given".format(**model_silo.SMOOTH_ANGLE_DEG)}


def shared_names(paths: tuple[str, ...] = ()) -> list[str]:
    """Names of the flags that all scenarios share, and of those of some paths."""
    return [flags.name_of(path) for path in (*paths, *SHARED)] + RUN


def silo_scenario(
    about: str,
    scene: Scene,
    paths: tuple[str, ...],
    name: Callable[[Scene], str],
    adapt: Callable[..., None] | None = None,
) -> Callable[..., Path | None]:
    """The function of a scenario: its parameters are the scenario's flags, and it runs the scene that they make.

    Parameters
    ----------
    about : what it does, in a sentence.
    scene : what is run where no flag is given.
    paths : dotted paths of the values that it has flags for, beside the shared ones.
    name : of the run's folder, to which void ratio and walls are added.
    adapt : called with the scene's tables, which it changes, and the values of further flags, its other parameters.

    """
    own = list(inspect.signature(adapt).parameters.values())[1:] if adapt else []

    def scenario(
        *, sand: flags.SandFlag = scene.sand.name, fidelity: flags.FidelityFlag = fidelities.STANDARD,
        output: OutputFlag = None, overwrite: OverwriteFlag = False, film: FilmFlag = True,
        figures: FiguresFlag = True, explain: ExplainFlag = False, check: CheckFlag = False, yes: YesFlag = False,
        quiet: QuietFlag = False, json: JsonFlag = False, **values: Any,
    ) -> Path | None:  # fmt: skip
        chosen, console = fidelities.fidelity(fidelity), Console(quiet, json)
        given = flags.given(values, (*paths, *SHARED))
        tables = _tables(scene, given, sand)
        if adapt is not None:
            adapt(tables, **{one.name: values[one.name] for one in own})
        wanted = Scene.model_validate(tables)
        if fidelity != fidelities.STANDARD:  # whose values are a scene's own
            settings = {path: one for path, one in chosen.values(wanted).items() if path not in given}
            wanted = changed(wanted, {path: one for path, one in settings.items() if path in (*paths, *SHARED)})
        console.say(fidelities.told(wanted))
        if explain:
            command_line.explain(wanted)
            return None
        if check:
            command_line.check(wanted, "This", console)
            return None
        from taichi_silo.cli.long_runs import permission
        from taichi_silo.runs import run_folder  # not needed to show the flags
        from taichi_silo.runs.observers.progress import ProgressLine

        usual = Path("outputs") / f"{name(wanted)}_e{wanted.sand.void_ratio:.2f}_{wanted.walls.kind}"
        folder = output.expanduser() if output else run_folder.free_name(usual)
        console.say(f"The run goes to {folder}.")
        lines = ProgressLine(console.terminal, permission(console, yes))
        left = api.run(wanted, folder, overwrite=overwrite, film=film, figures=figures, progress=False, extra=(lines,))
        command_line.tell(left.folder, console)
        return folder

    sand, *others = [one for one in inspect.signature(scenario).parameters.values() if one.name != "values"]
    scenario.__doc__ = about
    return flags.with_parameters(
        scenario, [*flags.parameters(scene, paths), *own, sand, *flags.parameters(scene, SHARED, NOTES), *others]
    )


def _tables(scene: Scene, given: dict[str, Any], sand: str) -> dict[str, Any]:
    """Tables of a scene with a named sand, and values of flags.

    Smooth walls without an angle have that of the paper's model silo.
    """
    settings = dict(given)
    void_ratio, law = settings.pop("sand.void_ratio"), settings.pop("sand.law")
    if settings["walls.kind"] == "smooth" and ANGLE not in settings:
        settings[ANGLE] = model_silo.smooth_angle_deg(void_ratio)
    tables = tables_with(scene, settings) | {"sand": named_sand(sand, void_ratio, law=law).model_dump()}
    for path in set(flags.OF_FIDELITY) - set(given):  # they follow the size of the silo
        table, name = path.split(".")
        tables[table].pop(name, None)
    if "machine.threads" not in settings:
        del tables["machine"]["threads"]  # those of the default scene, which has other points
    return tables
