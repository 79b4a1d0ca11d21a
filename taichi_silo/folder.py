"""The folder that a run leaves, and the parameters in it."""

import platform
import subprocess
import tomllib
from importlib.metadata import version
from pathlib import Path

import tomli_w

from taichi_silo import durable
from taichi_silo.faults import BadInput
from taichi_silo.fields import FIELDS
from taichi_silo.scene import Scene
from taichi_silo.symmetry import half_model

CHECKPOINT = "checkpoint.npz"  # from which it goes on
MADE = "run.toml"  # its presence says that the folder holds a run
PRODUCTS = (
    MADE, "run.log", "summary.json", "forces.csv", "balance.csv", "walls.csv", "checkpoint*.npz", "curve.csv",
    "points.npz", "points.vtu", "scene.json", "figures/*.png", "snapshots/*.vtu", "snapshots/index.csv",
    "snapshots/silo.pvd",
    *(f"{field}{ending}" for field in FIELDS for ending in (".mp4", ".*.mp4", "_*.png")),  # films and pictures
    "silo.vtkhdf", "csv/*.csv", "report.html",
)  # fmt: skip


def writable(folder: Path) -> Path:
    """The folder, made and proved writable.

    Raises
    ------
    BadInput
        if it cannot be written; nothing is left of it then.

    """
    folder = folder.expanduser()
    made = []
    try:
        made = [parent for parent in (folder, *folder.parents) if not parent.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".probe"
        probe.touch()
        probe.unlink(missing_ok=True)  # another process may have tried at the same time
    except OSError as error:
        for parent in made:
            if parent.is_dir() and not any(parent.iterdir()):
                parent.rmdir()
        raise BadInput(f"output {folder} cannot be written: {error.strerror or error}") from error
    return folder


def free(folder: Path, overwrite: bool = False) -> Path:
    """The folder, made and proved writable.

    Raises
    ------
    BadInput
        if it cannot be written, or holds a run and `overwrite` is false.

    """
    folder = writable(folder)
    if (folder / MADE).exists() and not overwrite:
        further = "" if finished(folder) or not (folder / CHECKPOINT).exists() else f", or `{go_on(folder)}`"
        raise BadInput(
            f"output {folder} holds a run already; give another folder, or --overwrite to replace it{further}"
        )
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
        for pattern in PRODUCTS:
            for old in folder.glob(pattern):
                old.unlink()
    except OSError as error:
        raise BadInput(f"output {folder} cannot be written: {error.strerror or error}") from error
    return folder


def go_on(folder: Path) -> str:
    """The command that goes on with the run of a folder."""
    return f'taichi-silo resume "{folder}"' if " " in str(folder) else f"taichi-silo resume {folder}"


def finished(folder: Path) -> bool:
    """Whether a run has come to its end there, and all its files are made."""
    return program(folder).get("finished", False)


def program(folder: Path) -> dict:
    """What computed the run of a folder, and how far it has come; empty if that cannot be read."""
    try:
        return tomllib.loads((folder / MADE).read_text(encoding="utf-8"))["program"]
    except (OSError, KeyError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return {}


def free_name(folder: Path) -> Path:
    """The folder's name, or the first of name-2, name-3, ... that holds no run yet."""
    number, name = 2, folder
    while (name / MADE).exists():
        name, number = folder.with_name(f"{folder.name}-{number}"), number + 1
    return name


def _revision() -> str:
    """Of the checkout that this is; an installed package may lie in one of something else."""
    if not (Path(__file__).parents[1] / ".git").exists():
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
    if scene.walls.kind == "smooth":
        tables["walls"]["friction_angle_deg"] = scene.wall_friction_angle_deg
    tables["sand"]["law"] = scene.sand.law_for(scene.flow.turns_back)
    tables["silo"]["half"] = "yes" if half_model(scene)[0] else "no"
    tables["averaging"]["characteristic_length_m"] = scene.averaging.length_m(scene.sand)
    tables["output"]["snapshots"] = scene.snapshots
    return tables


def write_parameters(folder: Path, scene: Scene, program: dict) -> None:
    """Write run.toml of a silo, and what computed it."""
    write_tables(folder, parameters(scene), program)


def write_tables(folder: Path, tables: dict, program: dict) -> None:
    """Write run.toml, with what computed it; in one piece or not at all, and on the disk."""
    tables["program"] = {
        "taichi_silo": version("taichi-silo"),
        "revision": _revision(),
        "taichi": version("taichi"),
        "python": platform.python_version(),
        "precision": "f64",
        **program,
    }
    with durable.written(folder / MADE) as passing:
        passing.write_text(tomli_w.dumps(tables), encoding="utf-8")
