"""Each package imports only from floors below its own, and heavy libraries stay where they are used."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "taichi_silo"
FLOORS = ["errors", "mpm utils", "scene analysis", "simulation", "runs", "show", "api", "studies", "cli", "__init__"]
FLOOR = {room: number for number, rooms in enumerate(FLOORS) for room in rooms.split()}
ONLY_IN = {
    "matplotlib": {"show"}, "imageio": {"show"}, "imageio_ffmpeg": {"show"}, "jinja2": {"show"}, "h5py": {"show"},
    "typer": {"cli"}, "meshio": set(), "validation": set(), "scenarios": set(),
}  # fmt: skip


def imports(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Import):
            yield from (name.name for name in node.names)


def room(file):
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


def test_at_most_twelve_entries_stand_at_the_root():
    entries = {file.name for file in PACKAGE.iterdir()} - {"__pycache__", "py.typed"}
    assert {name.removesuffix(".py") for name in entries} <= set(FLOOR)
    assert len(entries) <= 12


def test_each_package_imports_only_from_floors_below():
    for file in PACKAGE.rglob("*.py"):
        for name in imports(file):
            head, *rest = name.split(".")
            if head == "taichi_silo" and rest and rest[0] in FLOOR and rest[0] != room(file):
                assert FLOOR[rest[0]] < FLOOR[room(file)], f"{file} imports {name}"


def test_laws_shapes_and_walls_do_not_know_each_other():
    for one, other in (("laws", "shapes"), ("shapes", "laws"), ("walls", "laws"), ("laws", "walls")):
        for file in (PACKAGE / "mpm" / one).rglob("*.py"):
            assert not [name for name in imports(file) if name.startswith(f"taichi_silo.mpm.{other}")]


def test_heavy_libraries_stay_where_they_are_used():
    for file in PACKAGE.rglob("*.py"):
        for name in imports(file):
            allowed = ONLY_IN.get(name.split(".")[0])
            assert allowed is None or room(file) in allowed, f"{file} imports {name}"


def test_the_language_of_the_kernels_is_imported_in_one_place():
    folders = [PACKAGE, *(PACKAGE.parent / name for name in ("tests", "validation", "benchmarks", "scenarios"))]
    files = [file for folder in folders for file in folder.rglob("*.py")]
    found = {file.name for file in files for name in imports(file) if name.split(".")[0] in ("taichi", "quadrants")}
    assert found == {"language.py"}
