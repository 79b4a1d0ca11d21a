"""What a sweep is: scenes, what varies, and where it is done; from a file, or from the flags that stand for one.

scene = "silo.toml"                            # or a table [scene]; the default silo if absent
fidelity = "draft"

[grid]                                         # every combination
"silo.outlet.width_m" = [0.04, 0.08, 0.12]
sand = ["karlsruhe", "hostun"]                 # all constants of a published sand, or of a TOML file

[latin_hypercube]                              # or everything at once
runs = 20
seed = 1
[latin_hypercube.between]
"flow.speed_m_per_s" = [0.002, 0.02]
"sand.granular_hardness_Pa" = { low = 50e6, high = 1e9, logarithmic = true }
"silo.outlet.width_m" = { low = 0.04, high = 0.12, step = 0.02 }
"walls.kind" = ["smooth", "very-rough"]        # of which the angle of the scene holds for smooth ones
"""

from pathlib import Path
from typing import Any

from pydantic import Field, InstanceOf, field_validator

from taichi_silo.errors import BadInput
from taichi_silo.scene import fidelity as fidelities
from taichi_silo.scene.dotted_paths import changed, known, whole
from taichi_silo.scene.scene import Scene
from taichi_silo.studies.sweep.clusters import Cluster, Local, Scheduler, Slurm, cluster_of
from taichi_silo.studies.sweep.hypercube import LatinHypercube, checked
from taichi_silo.studies.sweep.table import Response
from taichi_silo.studies.sweep.variations import SAND, Variation, bases, made, product, refuse, scenes, variation
from taichi_silo.utils import bounded_reading
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import Options

KINDS: dict[str, type[Options]] = {"local": Local, "slurm": Slurm, "scheduler": Scheduler}
WORDS = {"low", "high", "choices"}  # of a quantity's range, by which its table is told from one of the scene


class Sweep(Options):
    """A parameter study: scenes, what varies in them, what is plotted, and where they are run."""

    scene: InstanceOf[Scene] | dict[str, Any] | tuple[Path, ...] = ()  # itself, values at dotted paths, or files
    fidelity: str | None = None  # of all runs, unless it varies
    film: bool = False
    retries: int = Field(3, ge=0, le=1000)  # of a run whose process crashed or whose worker died
    grid: dict[str, tuple[Any, ...]] = {}  # by dotted paths; every combination is run
    latin_hypercube: LatinHypercube | None = None  # draws instead of combinations
    response: Response = Response()
    cluster: Cluster = Local()

    @field_validator("grid", mode="before")
    @classmethod
    def _lists(cls, given):
        for path, values in given.items() if isinstance(given, dict) else ():
            if not isinstance(values, list | tuple):
                raise ValueError(f"grid.{shown(path)} is {shown(values)}; it must be a list of values")
        return given

    @property
    def paths(self) -> list[str]:
        """Dotted paths that vary, in their order."""
        return list(self.grid if self.latin_hypercube is None else self.latin_hypercube.between)

    def scenes(self) -> dict[str, Scene]:
        """All, by the names of their runs; raises BadInput if nothing varies, or a scene is not possible."""
        if self.grid and self.latin_hypercube is not None:
            raise BadInput("a sweep has a grid or a latin_hypercube, not both; choices of the latter may be words, too")
        if isinstance(self.scene, Scene):
            found = {"": changed(self.scene, {"machine.threads": 1})}
        elif isinstance(self.scene, dict):
            found = {"": made(bases([])[""], self.scene | {"machine.threads": 1})}
        else:
            found = bases(list(self.scene))
            found = dict(zip([""], found.values(), strict=True)) if len(found) == 1 else found
        if not self.paths and len(found) == 1:
            raise BadInput("nothing varies; a sweep needs a table grid or latin_hypercube, or several scenes")
        made_of = scenes(found, self._varied())
        if self.fidelity is None:
            return made_of
        chosen = fidelities.fidelity(self.fidelity)
        return {
            name: changed(scene, {path: one for path, one in chosen.values(scene).items() if path not in self.paths})
            for name, scene in made_of.items()
        }

    def _varied(self) -> dict[str, dict]:
        if self.latin_hypercube is None:
            return product([Variation(path, values) for path, values in self.grid.items()])
        for path in self.paths:
            refuse(path)
        drawn = self.latin_hypercube.settings(whole)
        once = list({str(one): one for one in drawn}.values())  # steps may bring the same run twice
        digits = len(str(len(once)))
        return {f"run-{number:0{digits}d}": one for number, one in enumerate(once, 1)}


def read(file: Path) -> Sweep:
    """The sweep of a file; raises BadInput if it cannot be read, or its values are not possible."""
    file = bounded_reading.place(file)
    tables = bounded_reading.toml(file, "a sweep")
    try:
        return from_tables(tables, file.parent)
    except BadInput as error:
        raise BadInput(f"{file}: {error}") from error


def from_tables(tables: dict, beside: Path) -> Sweep:
    """The sweep of a file's tables; files are named from the folder `beside`.

    Raises BadInput if its values are not possible.
    """
    tables = dict(tables)
    for name in ("grid", "latin_hypercube", "response", "cluster"):
        if name in tables and not isinstance(tables[name], dict):
            raise BadInput(f"{name} is {shown(tables[name])}; it must be a table")
    scene = tables.get("scene", {})
    if isinstance(scene, dict):
        tables["scene"] = _settings({name: one for name, one in scene.items() if name != "program"})  # of a run.toml
    elif not isinstance(scene, Scene):
        files = scene if isinstance(scene, list | tuple) else [scene]
        if not all(isinstance(one, str | Path) for one in files):
            raise BadInput(f"scene is {shown(scene)}; it must be a file, a list of files, or a table")
        tables["scene"] = [beside / bounded_reading.place(one, "scene") for one in files]
    if "grid" in tables:
        tables["grid"] = {path: _files(path, values, beside) for path, values in _settings(tables["grid"]).items()}
    if "latin_hypercube" in tables:
        draw = dict(tables["latin_hypercube"])
        if isinstance(draw.get("between"), dict):
            between = _settings(draw["between"])
            draw["between"] = {path: _files(path, one, beside) for path, one in between.items()}
        tables["latin_hypercube"] = checked(LatinHypercube, draw, "latin_hypercube.")
    if "response" in tables:
        tables["response"] = checked(Response, tables["response"], "response.")
    if "cluster" in tables:
        kind = tables["cluster"].get("kind", "local")
        if not isinstance(kind, str) or kind not in KINDS:
            raise BadInput(f"cluster.kind is {shown(kind)}; it must be one of {', '.join(KINDS)}")
        tables["cluster"] = checked(KINDS[kind], tables["cluster"], "cluster.")
    return checked(Sweep, tables)


def from_flags(files: list[Path], texts: list[str]) -> Sweep:
    """The sweep of scene files with every combination of `PATH=V1,V2,...` each.

    Raises BadInput if a text does not read so, or a path is there twice.
    """
    grid = {}
    for text in texts:
        one = variation(text)
        if one.path in grid:
            raise BadInput(f"vary is given twice for {one.path}; it must name all its values at once")
        grid[one.path] = one.values
    return Sweep(scene=tuple(files), grid=grid)


def from_command_line(file: Path | None, files: list[Path], texts: list[str], flags: dict) -> Sweep:
    """The sweep of a file, or of scene files and the texts that say what varies; raises BadInput if it cannot be.

    The flags fidelity, film, jobs, scheduler and slurm, if they are given, come before what the file says.
    """
    if file is not None and (files or texts):
        raise BadInput(f"vary and scene are flags of a sweep without a file; {file} must say what varies")
    sweep = read(file) if file is not None else from_flags(files, texts)
    given = {name: flags[name] for name in ("fidelity", "film") if flags[name] is not None}
    cluster = cluster_of(flags["scheduler"], flags["slurm"], flags["jobs"], sweep.cluster)
    return sweep.model_copy(update={**given, "cluster": cluster})


def _settings(tables: dict, before: str = "") -> dict:
    """Values by dotted paths, of which parts may be tables; the name of a sand stands for all of it."""
    found: dict[str, Any] = {}
    for name, inner in tables.items():
        path = SAND if before + name == "sand.name" else before + name
        deeper = isinstance(inner, dict) and not known(path) and not WORDS & set(inner)
        found |= _settings(inner, f"{path}.") if deeper else {path: inner}
    return found


def _files(path: str, values, beside: Path):
    """The values, those of `sand` that are files with the folder that they are beside."""
    if path != SAND or not isinstance(values, list):
        return values
    return [str(beside / one) if isinstance(one, str) and one.lower().endswith(".toml") else one for one in values]
