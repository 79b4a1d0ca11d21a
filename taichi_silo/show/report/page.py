"""`report.html`: everything that a run's folder tells, in one file that needs no other."""

import datetime
import re
from dataclasses import replace
from pathlib import Path

import jinja2
from markupsafe import Markup

from taichi_silo.errors import BadInput
from taichi_silo.runs.run_folder import MADE, no_link, writable
from taichi_silo.scene import sands
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.show.figures import plot_run
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.show.report import media, tables
from taichi_silo.show.report.drawing import drawing
from taichi_silo.show.report.hopper import hopper_table
from taichi_silo.show.report.key import in_one_sentence, key_numbers
from taichi_silo.show.report.limits import known_limits
from taichi_silo.show.report.parameters import parameter_tables
from taichi_silo.show.report.story import story
from taichi_silo.show.report.trust import verdict
from taichi_silo.show.report.words import count, kN, mm, number, plain
from taichi_silo.utils import atomic_write, bounded_reading

FILM = "void_ratio.mp4"
FIGURES = {  # name: (what it shows, for those who cannot see it; a caption)
    "forces": (
        "Curves of P, T and N against the bottom displacement",
        "Forces per metre run: P on the bottom, T friction and N normal force of a wall. The marker is the state after "
        "filling; for smooth walls Janssen's theory is dashed.",
    ),
    "wall_friction_angle": (
        "Curve of the mobilised wall friction angle against the bottom displacement",
        "Mobilised wall friction, arctan(T/N).",
    ),
    "wall_stress": (
        "Profiles of wall normal and shear stress against height",
        "Stresses along the walls in three states, with Janssen's theory after filling and EN 1991-4 on discharge.",
    ),
    "void_ratio": (
        "Void ratio in the silo at several displacements",
        "Void ratio: dense sand that is sheared loosens, loose sand thickens, so zones of shear show by their colour.",
    ),
}


def write_report(folder: Path, file: Path | None = None) -> Path:
    """Write the report of a run and return where it is; in one piece or not at all.

    Parameters
    ----------
    folder : of the run, finished or not.
    file : where to; `report.html` in the folder if absent.

    Raises
    ------
    BadInput
        if the folder holds no run of a silo, or the file cannot be written.

    """
    run = read_run(folder)
    file = run.folder / "report.html" if file is None else bounded_reading.place(file, "output")
    if file.is_dir():
        raise BadInput(f"output is {file}, a folder; it must be a file, such as {file / 'report.html'}")
    no_link(file, file.with_name(file.name + ".part"))
    writable(file.parent)
    with bounded_reading.as_left(run.folder):
        if not run.summary or not list((run.folder / "figures").glob("*.png")):
            run = replace(run, trouble=(*run.trouble, *_draw(run.folder)))
        text = page(run)
    with atomic_write.written(file) as passing:
        passing.write_text(text, encoding="utf-8")
    return file


def read_run(folder: Path) -> RunFiles:
    """A run's folder.

    Raises
    ------
    BadInput
        if there is none, or it holds no run of a silo.

    """
    folder = bounded_reading.place(folder, "folder")
    if not folder.is_dir():
        raise BadInput(f"folder is {folder}; it must be the folder of a run, and there is no such folder")
    if not (folder / MADE).is_file():
        raise BadInput(f"folder is {folder}; it must be the folder of a run, and it holds no {MADE}")
    run = RunFiles.read(folder)
    if not isinstance(run.parameters.get("silo"), dict):
        damaged = any(words.startswith(MADE) for words in run.trouble)
        why = f"its {MADE} is damaged" if damaged else f"its {MADE} names no silo"
        raise BadInput(f"folder is {folder}; it must be that of a run of a silo, and {why}")
    try:
        run.silo  # noqa: B018 - checks it
    except ValueError as error:
        raise BadInput(f"folder is {folder}; the silo in its {MADE} is not possible") from error
    read_scene(folder / MADE, threads=1)  # so that no value is of another kind
    return run


def _draw(folder: Path) -> list[str]:
    """The figures of a run that goes on, or ended before it could draw them, where the folder can be written.

    Returns
    -------
    A sentence if its files are too damaged for that.

    """
    no_link(folder / "figures", *(folder / "figures").glob("*"))
    try:
        plot_run(folder)
    except OSError:
        return []
    except BadInput as error:
        return [f"Figures are missing: {error}."]
    return []


def page(run: RunFiles) -> str:
    """The page of a run."""
    loader = jinja2.FileSystemLoader(Path(__file__).parent, encoding="utf-8")
    settings = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    program = run.parameters.get("program", {})
    return settings.get_template("report.html.j2").render(
        title=title(run),
        about=in_one_sentence(run),
        today=datetime.date.today().isoformat(),
        program=program,
        state=state(run),
        trouble=run.trouble,
        drawing=Markup(drawing(run)),
        facts=facts(run),
        cards=key_numbers(run),
        verdict=verdict(run),
        warnings=run.summary.get("warnings") or [],
        limits=known_limits(run),
        story=story(run, _sand(run)),
        parts=run.summary.get("parts") or [],
        film=media.film(run.folder / FILM),
        figures={name: _figure(run, name) for name in FIGURES},
        forces=tables.force_table(run),
        stresses=tables.stress_table(run),
        hopper=hopper_table(run),
        wall_zones=tables.wall_zone_table(run),
        inner_zones=tables.inner_zone_table(run),
        inner=run.summary.get("zones_inside") or {},
        residence=tables.residence_table(run),
        parameters=parameter_tables(run.parameters),
        cost=cost(run),
        folder=run.folder.as_posix(),
        again=f'"{file}"' if " " in (file := (run.folder / MADE).as_posix()) else file,
    )


def title(run: RunFiles) -> str:
    """One line."""
    words = re.sub(r"(\d) (mm)", "\\1\u00a0\\2", run.title.replace("$e_0$ = ", "e₀\u00a0=\u00a0"))
    return words[:1].upper() + words[1:]


def facts(run: RunFiles) -> list[tuple[str, str]]:
    """What a drawing cannot show: name and value."""
    angle, weight = run.parameter("walls", "friction_angle_deg"), run.summary.get("weight_N_per_m")
    walls = f"smooth, {plain(angle)}°" if run.wall_kind == "smooth" else run.wall_kind.replace("-", " ")
    return [
        ("sand", str(run.parameter("sand", "name", "–"))),
        ("void ratio", plain(run.void_ratio)),
        ("side walls", walls),
        ("weight", f"{kN(weight)} kN/m"),
    ]


def state(run: RunFiles) -> dict | None:
    """What has to be said first of a run that did not come to its end; None of one that did."""
    if run.summary.get("finished"):
        return None
    reached = "It was still being filled"
    if len(run.flow):
        reached = f"It had reached u = {mm(float(run.flow['displacement_m'].iloc[-1]))}"
        if wanted := run.parameter("flow", "displacement_m"):
            reached += f" of {mm(wanted)}"
    if len(run.forces):
        reached += f" at t = {number(float(run.forces['time_s'].iloc[-1]), 4)} s"
    if not run.summary:
        title = "This run has not ended, or was cut off"
        return {"title": title, "words": f"There is no summary of it. {reached}; below is what it has left so far."}
    cause = run.summary.get("failure") or "no reason was told"
    if cause == "KeyboardInterrupt":
        return {"title": "This run was stopped before its end", "words": f"{reached}; below is what it has left."}
    cause = cause.removeprefix("stopped ")
    return {"title": "This run failed", "words": f"It stopped {cause}. {reached}; below is what it has left."}


def cost(run: RunFiles) -> list[tuple[str, str]]:
    """What the run took: name and value."""
    found = run.summary.get("cost") or {}
    step = found.get("time_step_s")
    rows = [
        ("points computed", count(found.get("points"))),
        ("steps", count(found.get("steps"))),
        ("mean time step", f"{number(step * 1e6)} µs" if step else number(None)),
        ("stepping", f"{number(found.get('seconds'))} s"),
        ("point-steps a second", f"{number((found.get('particle_steps_per_second') or 0.0) / 1e6)} million"),
        ("whole run", f"{number(found.get('wall_seconds'))} s"),
        ("threads", str(run.parameter("machine", "threads", "–"))),
    ]
    return rows if found else []


def _figure(run: RunFiles, name: str) -> dict | None:
    data = media.figure(run.folder / "figures" / f"{name}.png")
    words, caption = FIGURES[name]
    return {"data": data, "words": words, "caption": caption} if data else None


def _sand(run: RunFiles) -> str:
    """Title of the sand, with its source if it is a published one."""
    name = str(run.parameter("sand", "name", "sand"))
    known = sands.published().get(name)
    return f"{known['title']} ({known['source']})" if known else f"sand “{name}”"
