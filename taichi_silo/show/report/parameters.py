"""Every parameter of a run with its unit and meaning, from `run.toml` and the scene's own descriptions."""

from dataclasses import dataclass

from pydantic import BaseModel

from taichi_silo.scene.scene import Scene

UNITS = (  # by the end of the name, the longest first
    ("_kg_per_m3", "kg/m³"), ("_m_per_s2", "m/s²"), ("_m_per_s", "m/s"), ("_N_per_m", "N/m"), ("_deg", "°"),
    ("_Pa", "Pa"), ("_m", "m"), ("_s", "s"),
)  # fmt: skip
LETTERS = {"m_R", "m_T"}  # symbols that end like a unit
TITLES = {
    "silo": "Silo", "sand": "Sand", "walls": "Walls", "grid": "Grid and points", "averaging": "Non-local average",
    "filling": "Filling", "flow": "Flow", "method": "Method", "output": "Output", "machine": "Machine",
    "program": "Program",
}  # fmt: skip
MEANINGS = {  # where a scene does not say it, or not in full
    "silo.width_m": "distance of the walls, or diameter",
    "silo.half": "whether one half was computed and mirrored",
    "silo.hopper.half_angle_deg": "of the hopper's walls, from the vertical",
    "walls.friction_angle_deg": "of smooth walls",
    "averaging.characteristic_length_m": "lc of the non-local average; 0 for a local law",
    "sand.intergranular.radius": "R, largest intergranular strain",
    "filling.drop_m": "height of fall, with rain",
    "silo.section": "plane: between parallel walls; round: a cylinder by its section",
    "silo.outlet.width_m": "of the opening in the floor",
    "silo.outlet.position": "of the opening",
    "silo.hopper.outlet_width_m": "distance of the lower ends of the hopper's walls",
    "silo.inserts": "bodies inside the sand",
    "silo.inserts.kind": "roof or cylinder",
    "sand.name": "of the published set",
    "sand.law": "gudehus-bauer; intergranular: with a memory of the last strain",
    "sand.void_ratio": "volume of voids over volume of grains, at the start",
    "sand.critical_friction_angle_deg": "φc, of sand sheared without end",
    "sand.granular_hardness_Pa": "hs, stiffness of the grains' skeleton",
    "sand.n": "exponent of compression",
    "sand.alpha": "exponent of the influence of density on the peak",
    "sand.beta": "exponent of the influence of density on stiffness",
    "sand.e_i0": "loosest void ratio at zero pressure",
    "sand.e_c0": "critical void ratio at zero pressure",
    "sand.e_d0": "densest void ratio at zero pressure",
    "sand.grain_density_kg_per_m3": "of the grains",
    "sand.d50_m": "mean diameter of the grains",
    "sand.intergranular.m_R": "stiffness when strain turns back, over that when it goes on",
    "sand.intergranular.m_T": "stiffness when strain turns by 90°, over that when it goes on",
    "sand.intergranular.beta_r": "exponent of the evolution of the intergranular strain",
    "sand.intergranular.chi": "exponent of the interpolation between stiffnesses",
    "walls.kind": "smooth: Coulomb friction; very-rough: sand does not slip",
    "walls.bottom_friction_angle_deg": "of the bottom or floor",
    "grid.cell_size_m": "of the square cells",
    "grid.points_per_cell": "material points in a full cell",
    "grid.shape": "shape functions",
    "averaging.weight": "of neighbours in the average",
    "filling.kind": "gravity-ramp: all sand in place, its weight grows; layers; rain",
    "filling.layers": "number, with layers",
    "flow.outflow": "controlled: at a given speed; gravity: sand falls out",
    "method.transfer": "how velocities go from grid to points",
    "method.stress_update": "when in the step stresses are updated",
    "method.stress_filter": "of the stresses",
    "method.noise_control": "column: drag towards the recent mean motion; none",
    "method.gravity_m_per_s2": "acceleration",
    "method.longest_settling_s": "rest after filling, at most; or 20 column periods, if longer",
    "machine.arch": "cpu or cuda",
    "machine.threads": "of the processor",
    "program.taichi_silo": "version",
    "program.revision": "of the source",
    "program.taichi": "version",
    "program.python": "version",
    "program.precision": "of all numbers",
    "program.wall_seconds": "of the whole run, films and files included",
    "program.finished": "whether the run came to its end",
    "program.resumed": "how often it was gone on with after a break",
    "program.film": "whole, ended early, or none",
}


@dataclass(frozen=True)
class Parameter:
    """One: dotted path in its table, value as in `run.toml`, unit, meaning."""

    name: str
    value: str
    unit: str
    means: str


def parameter_tables(parameters: dict) -> list[tuple[str, list[Parameter]]]:
    """Title and parameters of each table of a `run.toml`, in the order of the file's own kind."""
    known = [name for name in TITLES if name in parameters]
    others = [name for name in parameters if name not in TITLES]
    return [(TITLES.get(name, name), list(_flat(name, parameters[name], name))) for name in known + others]


def _flat(path: str, value, table: str):
    """Parameters below a path."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _flat(f"{path}.{name}", inner, table)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for count, inner in enumerate(value, 1):
            yield from _flat(f"{path}.{count}", inner, table)
    else:
        name = path.removeprefix(f"{table}.")
        yield Parameter(name, _words(value), unit(path.rpartition(".")[2]), meaning(path))


def _words(value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(map(_words, value)) or "none"
    if isinstance(value, float):
        return repr(value).removesuffix(".0")
    return str(value)


def unit(name: str) -> str:
    """Unit of a parameter, from the end of its name; empty if it has none."""
    if name in LETTERS:
        return ""
    return next((words for end, words in UNITS if name.endswith(end)), "")


def meaning(path: str) -> str:
    """What a parameter is."""
    names = [name for name in path.split(".") if not name.isdigit()]
    return MEANINGS.get(".".join(names)) or _described(names)


def _described(names: list[str]) -> str:
    """As the scene describes it."""
    table, words = Scene, None
    for name in names:
        field = getattr(table, "model_fields", {}).get(name)
        if field is None:
            return ""
        words, table = field.description, _model(field.annotation)
    return words or ""


def _model(annotation):
    """The table that a field holds, alone, or none of it, or several."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    inner = (_model(part) for part in getattr(annotation, "__args__", ()))
    return next((part for part in inner if part is not None), None)
