"""The folder that a run leaves, and the parameters in it."""

import contextlib
import os
import platform
import shlex
import stat
import subprocess
import tempfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import tomli_w

from taichi_silo.errors import BadInput, Way, way
from taichi_silo.mpm import language
from taichi_silo.runs.point_fields import FIELDS
from taichi_silo.scene.scene import Scene
from taichi_silo.scene.scene_files import read_scene
from taichi_silo.scene.symmetry import half_model
from taichi_silo.utils import atomic_write, bounded_reading, plugin_files
from taichi_silo.utils.messages import shown

CHECKPOINT = "checkpoint.npz"  # from which it goes on
INSIDE = ("figures", "snapshots", "csv", "wall-loads")  # folders in it
MADE = "run.toml"  # its presence says that the folder holds a run
PRODUCTS = (
    MADE, "run.log", "summary.json", "forces.csv", "balance.csv", "outflow.csv", "walls.csv", "film_states.bin",
    "checkpoint*.npz", "curve.csv", "points.npz", "points.vtu", "scene.json", "figures/*.png", "snapshots/*.vtu",
    "snapshots/index.csv", "snapshots/silo.pvd",
    *(f"{field}{ending}" for field in FIELDS for ending in (".mp4", ".*.mp4", "_*.png")),  # films and pictures
    "silo.vtkhdf", "silo_walls.vtkhdf", "csv/*.csv", "wall-loads/*.*", "report.html",
)  # fmt: skip


def products() -> tuple[str, ...]:
    """Patterns of all files that a run or what shows it leaves in its folder."""
    pictures = (f"{field}{ending}" for field in FIELDS for ending in (".mp4", ".*.mp4", "_*.png"))
    return (*PRODUCTS, *pictures)


def writable(folder: Path) -> Path:
    """The folder, made and proved writable.

    Raises
    ------
    BadInput
        if it cannot be written; nothing is left of it then.

    """
    folder = bounded_reading.place(folder, "output")
    made = _missing(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        _remove_empty(made)
        raise BadInput(f"output {folder} cannot be written: {error.strerror or error}") from error
    return folder


def _missing(folder: Path) -> list[Path]:
    """The folder and those around it that are not there, the innermost first."""
    try:
        return [parent for parent in (folder, *folder.parents) if not parent.exists()]
    except (OSError, ValueError):  # no name of a folder, which is said where it is made
        return []


def _remove_empty(folders: list[Path]) -> None:
    for folder in folders:
        with contextlib.suppress(OSError):
            folder.rmdir()


@contextlib.contextmanager
def none_left_empty(folder: Path) -> Iterator[None]:
    """Within, the folder of a run is made; if nothing has come into it at the end, it is taken away."""
    made = _missing(folder)
    try:
        yield
    finally:
        _remove_empty(made)


def own(folder: Path) -> Path:
    """The folder of a run, made and proved writable, of which nothing leads out: whatever is written stays in it.

    The folder itself may be a link.

    Raises
    ------
    BadInput
        if it cannot be written, or a file or folder in it is a link, a pipe or a device.

    """
    folder = writable(folder)
    try:
        for place in (folder, *(folder / name for name in INSIDE)):
            for entry in os.scandir(place) if place.is_dir() else ():
                _refuse_link(Path(entry.path), entry.stat(follow_symlinks=False).st_mode)
    except OSError as error:
        raise BadInput(f"output {folder} cannot be read: {error.strerror or error}") from error
    return folder


def no_link(*files: Path) -> None:
    """Refuse files that are to be written and are links: what they lead to may be anything.

    Raises
    ------
    BadInput
        with the first of them.

    """
    for file in files:
        try:
            _refuse_link(file, os.lstat(file).st_mode)
        except OSError:
            continue  # it is not there


def _refuse_link(file: Path, mode: int) -> None:
    if stat.S_ISLNK(mode):
        raise BadInput(f"output {file} is a link, and what it leads to would be changed; remove it, or give another "
                       "folder")  # fmt: skip
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise BadInput(f"output {file} is no file or folder; remove it, or give another folder")
    if file.name in INSIDE and not stat.S_ISDIR(mode):
        raise BadInput(f"output {file} is a file; it must be a folder, remove it or give another output")


def named(file: Path) -> str:
    """What a run of a scene file is called: as the file, or for a run.toml as its folder; never a way out of one."""
    name = file.resolve().parent.name if file.name == MADE else file.stem
    name = "".join(sign for sign in name if sign.isprintable() and sign not in "/\\:").strip(". ")
    return name or "run"


def free(folder: Path, overwrite: bool = False) -> Path:
    """The folder, made and proved writable.

    Raises
    ------
    BadInput
        if it cannot be written, or holds a run and `overwrite` is false.

    """
    folder = own(folder)
    if (folder / MADE).exists() and not overwrite:
        anew, on = way("overwrite"), Way(f"ts.resume({str(folder)!r})", go_on(folder))
        further = "" if finished(folder) or not (folder / CHECKPOINT).exists() else f", or `{on}`"
        words = f"output {folder} holds a run already; give another folder, or {anew} to replace it{further}"
        raise BadInput(words, anew, on)
    return folder


def claim(folder: Path, overwrite: bool = False) -> Path:
    """The folder, made, proved writable, and free of an earlier run.

    Raises
    ------
    BadInput
        if it cannot be written, or holds a run and `overwrite` is false.

    """
    folder = free(folder, overwrite)
    try:
        for pattern in products():
            for old in folder.glob(pattern):
                old.unlink()
    except OSError as error:
        raise BadInput(f"output {folder} cannot be written: {error.strerror or error}") from error
    return folder


def go_on(folder: Path) -> str:
    """The command that goes on with the run of a folder."""
    return f"taichi-silo resume {typed(folder)}"


def typed(path: Path) -> str:
    """A path as a command line takes it: quoted where a shell would read more in it, and never a flag."""
    name = f"./{path}" if str(path).startswith("-") else str(path)
    if os.name == "nt":
        return f'"{name}"' if " " in name else name
    return shlex.quote(name)


def finished(folder: Path) -> bool:
    """Whether a run has come to its end there, and all its files are made; its summary must be there still."""
    if program(folder).get("finished") is not True:
        return False
    try:
        return bool(bounded_reading.tables(folder / "summary.json"))
    except BadInput:
        return False


def program(folder: Path) -> dict:
    """What computed the run of a folder, and how far it has come; empty if that cannot be read."""
    try:
        found = bounded_reading.toml(folder / MADE, "a run").get("program")
    except BadInput:
        return {}
    return found if isinstance(found, dict) else {}


def free_name(folder: Path) -> Path:
    """The folder's name, or the first of name-2, name-3, ... that holds no run yet."""
    number, name = 2, folder
    while (name / MADE).exists():
        name, number = folder.with_name(f"{folder.name}-{number}"), number + 1
    return name


def _revision() -> str:
    """Of the checkout that this is; an installed package may lie in one of something else."""
    if not (Path(__file__).parents[2] / ".git").exists():
        return "installed"
    try:
        answer = subprocess.run(
            ["git", "describe", "--always", "--dirty"],
            cwd=Path(__file__).parent, capture_output=True, text=True, timeout=5, check=True,
        )  # fmt: skip
        return answer.stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return "unknown"


def parameters(scene: Scene) -> dict:
    """Every parameter of a silo as used, in the tables of run.toml."""
    tables = scene.model_dump(exclude_none=True)
    tables["sand"]["law"] = scene.sand.law_for(scene.flow.turns_back)
    tables["silo"]["half"] = "yes" if half_model(scene)[0] else "no"
    tables["averaging"]["characteristic_length_m"] = scene.characteristic_length_m
    tables["output"]["snapshots"] = scene.snapshots
    return tables


def same_scene(folder: Path, scene: Scene) -> None:
    """Refuse a folder whose run.toml is that of another scene; the number of threads may be another.

    Raises
    ------
    BadInput
        with the first value that differs.

    """
    if not (folder / MADE).exists():
        return  # the run was left before it was written
    try:
        there = parameters(read_scene(folder / MADE, threads=scene.machine.threads))
    except BadInput:
        return  # damaged: the scene is in the checkpoint, too
    here = parameters(scene)
    for table, values in here.items():
        for name, value in values.items() if table != "machine" else ():
            if there[table].get(name) != value:
                raise BadInput(
                    f"{folder} cannot be resumed: its checkpoint is of another run, with {table}.{name} = "
                    f"{shown(value)} instead of {shown(there[table].get(name))}"
                )


def write_parameters(folder: Path, scene: Scene, program: dict) -> None:
    """Write run.toml of a silo, and what computed it."""
    write_tables(folder, parameters(scene), program)


def write_tables(folder: Path, tables: dict, program: dict) -> None:
    """Write run.toml, with what computed it; in one piece or not at all, and on the disk."""
    tables["program"] = {
        "taichi_silo": version("taichi-silo"),
        "revision": _revision(),
        language.NAME: version(language.NAME),
        "python": platform.python_version(),
        "precision": "f64",
        **({"plugins": plugins} if (plugins := plugin_files.loaded()) else {}),
        **program,
    }
    with atomic_write.written(folder / MADE) as passing:
        passing.write_text(tomli_w.dumps(tables), encoding="utf-8")
