"""The state of all points in a file that ParaView opens, and back again."""

import functools
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from taichi_silo.errors import BadInput
from taichi_silo.scene.scene import Flow
from taichi_silo.utils import vtu

BETWEEN = "film_"  # how the names of snapshots begin that stand between those of the figures
# shares of the displacement at which figures show the state, after that at 0; free outflow is over sooner
SHOWN, SHOWN_OF_FREE = (0.1, 0.25, 0.5, 1.0), (0.02, 0.1, 0.3, 1.0)


UNITS = {  # of arrays that do not end with it; a number without one has 1
    "velocity": "m/s", "Pa": "Pa", "m2_per_m": "m2/m", "kg_per_m": "kg/m", "mm_per_s": "mm/s", "deg": "deg",
}  # fmt: skip
COMPONENTS = {"velocity": ("x", "y", "z"), "stress_Pa": ("xx", "yy", "zz", "xy")}


def unit_of(name: str) -> str:
    """The unit of an array: of its name's end, or known here."""
    found = (unit for end, unit in UNITS.items() if name == end or name.endswith(f"_{end}"))
    return next(found, "1")


def shown_displacements(flow: Flow) -> list[float]:
    """Displacements [m] of the bottom, after 0, at which figures show the state of a run."""
    shares = SHOWN_OF_FREE if flow.free else SHOWN
    return [share * flow.displacement_m for share in shares]


def _mean(stress: np.ndarray) -> np.ndarray:
    xx, yy, zz, _ = stress.T
    return -(xx + yy + zz) / 3.0


# what a snapshot holds beside the places: the field of the points that it is made of, how, and its type; single
# precision is 6e-8 of a value, places stay in double precision, as strains follow from their differences
ARRAYS: dict[str, tuple[str, Callable[[np.ndarray], np.ndarray], type]] = {
    "void_ratio": ("void_ratio", np.asarray, np.float32),
    "velocity": ("velocity", vtu.spatial, np.float32),
    "stress_Pa": ("stress", np.asarray, np.float32),
    "mean_stress_Pa": ("stress", _mean, np.float32),
    "volume_m2_per_m": ("volume", np.asarray, np.float32),
    "mass_kg_per_m": ("mass", np.asarray, np.float32),
    "strain_path": ("path", np.asarray, np.float32),
    "identity": ("identity", np.asarray, np.int32),
}


def stored(points: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What a snapshot holds beside the places, under names with units, of points as `Simulation.points` gives them."""
    return {name: make(points[field]).astype(kind) for name, (field, make, kind) in ARRAYS.items()}


def write(file: Path, points: dict[str, np.ndarray]) -> None:
    """Write a state; points that are not finite are left out."""
    write_pieces(file, tuple(points), lambda field: [points[field]])


def write_pieces(
    file: Path, fields: tuple[str, ...], pieces: Callable[[str], Iterable[np.ndarray]], synced: bool = True
) -> None:
    """As `write`, from the names of the fields of the points and what gives each field in pieces: no copy of all."""
    sound = np.array(True)
    for field in fields:
        finite = [np.isfinite(piece).all(axis=tuple(range(1, piece.ndim))) for piece in pieces(field)]
        sound = sound & np.concatenate(finite)

    def kept(field: str, make: Callable[[np.ndarray], np.ndarray], kind: type) -> Iterator[np.ndarray]:
        end = 0
        for piece in pieces(field):
            begin, end = end, end + len(piece)
            yield make(piece[sound[begin:end]]).astype(kind)

    arrays = {name: functools.partial(kept, *how) for name, how in ARRAYS.items()}
    places = functools.partial(kept, "position", vtu.spatial, np.float64)
    units = {name: unit_of(name) for name in ARRAYS}
    vtu.write_pieces(file, int(sound.sum()), places, arrays, units, COMPONENTS, synced)


def read(file: Path) -> dict[str, np.ndarray]:
    """A state as `Simulation.points` gives it.

    Raises
    ------
    BadInput
        if the file is not there, is damaged, or lacks an array.

    """
    file = Path(file)
    if not file.is_file():
        raise BadInput(f"snapshot {file} is {'no file' if file.exists() else 'missing'}")
    try:
        places, arrays = vtu.read(file)
    except Exception as error:  # whatever a broken file makes of a parser, XML included
        raise BadInput(f"snapshot {file} cannot be read; it is damaged") from error
    names = {
        "void_ratio": "void_ratio", "stress": "stress_Pa", "volume": "volume_m2_per_m", "mass": "mass_kg_per_m",
        "path": "strain_path", "identity": "identity",
    }  # fmt: skip
    lacking = [name for name in ("velocity", *names.values()) if name not in arrays]
    if lacking:
        raise BadInput(f"snapshot {file} holds no {lacking[0]}; it must be of taichi_silo 0.2 or later")
    shapes = {"stress_Pa": (len(places), 4), "velocity": (len(places), 3)}
    for name in ("velocity", *names.values()):
        if arrays[name].shape != shapes.get(name, (len(places),)):
            raise BadInput(f"snapshot {file} cannot be read; its {name} is not that of its points")
    points = {"position": places[:, :2], "velocity": arrays["velocity"][:, :2]}
    points |= {own: np.asarray(arrays[name]) for own, name in names.items()}
    kind = {"identity": np.int64}
    return {own: values.astype(kind.get(own, np.float64)) for own, values in points.items()}


def figured(index):
    """Rows of `snapshots/index.csv` (a table) less those that only films need."""
    return index[~index["file"].astype(str).str.startswith(BETWEEN)]
