"""Imports point one way, and the heavy libraries stay where they are used."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "taichi_silo"
# a module may import those of earlier lines, and of its own line
LAYERS = [
    ["runtime", "maths", "tensors", "faults", "barrier", "child", "tally", "processes", "vtu", "durable", "stopping",
     "quoting"],
    ["grid", "particles", "noise", "geometry", "table", "outline", "snapshot", "archive", "lock", "reading"],
    ["shapes", "laws", "walls", "averaging", "transfers", "loops"],
    ["theory", "measure"],
    ["phases", "nodes", "survey"],
    ["filters", "lanes", "proof"],
    ["solver", "half"],
    ["inserts"],
    ["variant", "vessel", "sand", "symmetry", "record"],
    ["placing", "drawing"],
    ["scene"],
    ["weaknesses", "alarms", "settings", "fidelity", "column"],
    ["filling", "outflow", "ledger"],
    ["simulation", "state", "specimen", "sands"],
    ["trial", "memory"],
    ["element", "scene_file", "fields", "folder", "timestep", "cost"],
    ["history"],
    ["stability"],
    ["plots"],
    ["biaxial"],
    ["observers", "parts"],
    ["one_run", "batch", "chart", "paper", "render", "export", "gallery"],
    ["reference", "result", "health", "report"],
    ["api", "compare"],
    ["voice", "flags", "catalogue"],
    ["cli", "scenario", "sweep", "__init__"],
    ["commands"],
    ["app"],
]
RANK = {name: rank for rank, names in enumerate(LAYERS) for name in names}
ONLY_IN = {
    "matplotlib": {"plots", "observers", "biaxial"},
    "imageio_ffmpeg": {"observers", "gallery", "report"},
    "jinja2": {"gallery", "report"},
    "h5py": {"export"},
    "meshio": set(),
}


def imports(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names if node.module == "taichi_silo")
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names)


def layer(file):
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


def test_every_module_has_its_layer():
    assert {layer(file) for file in PACKAGE.rglob("*.py")} == set(RANK)


def test_imports_point_one_way():
    for file in PACKAGE.rglob("*.py"):
        for name in imports(file):
            parts = name.split(".")
            if parts[0] == "taichi_silo" and len(parts) > 1:
                assert RANK[parts[1]] <= RANK[layer(file)], f"{file.name} imports {name}"


def test_laws_and_shapes_do_not_know_each_other():
    for one, other in (("laws", "shapes"), ("shapes", "laws"), ("walls", "laws"), ("laws", "walls")):
        for file in (PACKAGE / one).rglob("*.py"):
            assert not [name for name in imports(file) if name.startswith(f"taichi_silo.{other}")]


def test_heavy_libraries_stay_where_they_are_used():
    for file in PACKAGE.rglob("*.py"):
        for name in imports(file):
            allowed = ONLY_IN.get(name.split(".")[0])
            assert allowed is None or layer(file) in allowed, f"{file.name} imports {name}"
