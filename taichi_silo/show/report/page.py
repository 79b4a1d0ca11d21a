"""`report.html`: everything that a run's folder tells, in one file that needs no other."""

import contextlib
import datetime
import os
import re
from collections.abc import Sequence
from pathlib import Path

from markupsafe import Markup

from taichi_silo.errors import BadInput
from taichi_silo.runs.result import FILM, Result
from taichi_silo.runs.run_folder import MADE, no_link, typed, writable
from taichi_silo.scene import bands, known_limits, sands
from taichi_silo.show import beside_walls, html
from taichi_silo.show.figures import plot_run
from taichi_silo.show.report import tables
from taichi_silo.show.report.drawing import drawing
from taichi_silo.show.report.eurocode import EurocodeReport
from taichi_silo.show.report.key import in_one_sentence, key_numbers
from taichi_silo.show.report.outlets import outlet_table
from taichi_silo.show.report.parameters import parameter_tables
from taichi_silo.show.report.story import story
from taichi_silo.show.report.trust import verdict
from taichi_silo.show.report.words import count, kN, mm, number, plain
from taichi_silo.show.titles import title
from taichi_silo.utils import atomic_write, bounded_reading

POSTER_AT, POSTER_WIDTH = 0.97, 1280  # of the film: nearly all has happened; pixels
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
    "outflow": (
        "Curves of the mass that has left by each outlet, and of its rate",
        "What has left by each outlet, and how fast. Hollow lines: its gate is closed.",
    ),
    "void_ratio": (
        "Void ratio in the silo at several displacements",
        "Void ratio: dense sand that is sheared loosens, loose sand thickens, so zones of shear show by their colour.",
    ),
}


def report(run: str | os.PathLike, file: str | os.PathLike | None = None) -> Path:
    """Write one page of a run, finished or not: drawing, key numbers, trust, film, figures, parameters.

    Parameters
    ----------
    run : a `Result`, or its folder.
    file : `report.html` in the run's folder if absent; an earlier one there is replaced.

    Returns
    -------
    The page; it needs no other file.

    Raises
    ------
    BadInput
        if the folder holds no run of a silo, or the file cannot be written.

    """
    found = Result(run, tolerant=True)
    found.scene  # noqa: B018 - which no report can do without
    target = found.folder / "report.html" if file is None else bounded_reading.place(file, "output")
    if target.is_dir():
        raise BadInput(f"output is {target}, a folder; it must be a file, such as {target / 'report.html'}")
    no_link(target, target.with_name(target.name + ".part"))
    writable(target.parent)
    with bounded_reading.as_left(found.folder):
        trouble = [] if found.summary and found.figures else _draw(found.folder)
        text = page(found, trouble)
    with atomic_write.written(target) as passing:
        passing.write_text(text, encoding="utf-8", errors="replace")  # a name may be of any bytes
    return target


def _draw(folder: Path) -> list[str]:
    """Draw the figures of a run that goes on, or ended before it could, where the folder can be written.

    Returns a sentence if the run's files are too damaged for that.
    """
    no_link(folder / "figures", *(folder / "figures").glob("*"))
    try:
        with contextlib.suppress(OSError):
            plot_run(folder)
    except BadInput as error:
        return [f"Figures are missing: {error}."]
    return []


def page(run: Result, trouble: Sequence[str] = ()) -> str:
    """The page of a run, with what else has to be said of its files."""
    return html.render(
        Path(__file__).with_name("report.html.j2"),
        title=_title(run),
        about=in_one_sentence(run),
        today=datetime.date.today().isoformat(),
        program=run.program,
        state=_state(run),
        trouble=[*run.trouble, *trouble],
        drawing=Markup(drawing(run)),
        facts=_facts(run),
        cards=key_numbers(run),
        verdict=verdict(run),
        warnings=run.summary.get("warnings") or [],
        limits=known_limits.of_results(run.scene),
        story=story(run, _sand(run)),
        parts=run.summary.get("parts") or [],
        film=_film(run.folder / FILM),
        figures={name: _figure(run, name) for name in FIGURES},
        carriers=beside_walls.lead(run),
        forces=tables.force_table(run),
        stresses=tables.stress_table(run),
        hopper=tables.hopper_table(run),
        code=EurocodeReport.of(run.scene),
        wall_zones=tables.wall_zone_table(run),
        inner_zones=tables.inner_zone_table(run),
        inner=run.summary.get("zones_inside") or {},
        residence=tables.residence_table(run),
        outlets=outlet_table(run),
        parameters=parameter_tables(run.parameters),
        cost=_cost(run),
        folder=run.folder.as_posix(),
        again=typed(run.folder / MADE),
    )


def _title(run: Result) -> str:
    """One line, in which no unit is parted from its number."""
    words = re.sub(r"(\d) (mm)", "\\1\u00a0\\2", title(run, "e₀").replace("e₀ = ", "e₀\u00a0=\u00a0"))
    return words[:1].upper() + words[1:]


def _facts(run: Result) -> list[tuple[str, str]]:
    """What a drawing cannot show: name and value."""
    scene = run.scene
    walls = scene.walls.kind.replace("-", " ")
    if scene.walls.friction_angle_deg is not None:
        walls += f", {plain(scene.walls.friction_angle_deg)}°"
    walls = ", ".join(filter(None, (walls, bands.words(scene.walls))))
    return [
        ("sand", scene.sand.words),
        ("void ratio", plain(scene.sand.void_ratio)),
        ("side walls", walls),
        ("weight", f"{kN(run.summary.get('weight_N_per_m'))} kN/m"),
    ]


def _state(run: Result) -> dict | None:
    """What has to be said first of a run that did not come to its end; None of one that did."""
    if run.summary.get("finished"):
        return None
    reached = "It was still being filled"
    if len(run.flow):
        reached = f"It had reached u = {mm(float(run.flow['displacement_m'].iloc[-1]))}"
        reached += f" of {mm(run.scene.flow.displacement_m)}"
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


def _cost(run: Result) -> list[tuple[str, str]]:
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
        ("threads", str(run.parameters.get("machine", {}).get("threads", "–"))),
    ]
    return rows if found else []


def _figure(run: Result, name: str) -> dict | None:
    """A figure's data, words for those who cannot see it, and caption; None if it is not there or damaged."""
    file, (words, caption) = run.folder / "figures" / f"{name}.png", FIGURES[name]
    if html.picture_of(file) is None:
        return None
    return {"data": html.data_uri(file.read_bytes(), "image/png"), "words": words, "caption": caption}


def _film(file: Path) -> dict | None:
    """A film and one of its last frames, as data; None if it is not there or cannot be read."""
    poster = html.jpeg(html.frame_of(file, POSTER_AT), POSTER_WIDTH) if file.is_file() else None
    return {"film": html.data_uri(file.read_bytes(), "video/mp4"), "poster": poster} if poster else None


def _sand(run: Result) -> str:
    """Title of the sand, with its source if it is a published one."""
    name = run.scene.sand.name
    known = sands.published().get(name)
    return f"{known['title']} ({known['source']})" if known else f"sand “{name}”"
