"""Parts of the reference that are made from the program itself: they stand where a page has the mark."""

import json
import sys
from pathlib import Path

import command_line
import house
import python_names
from mkdocs.structure.files import File

ROOT = str(Path(__file__).parents[2])
MARK = "<!-- made from the program -->"
SCHEMA = "reference/scene.schema.json"


def on_config(config, **_):
    """The program beside these pages is the one they describe, whatever else is installed."""
    if ROOT not in sys.path:
        sys.path.insert(0, ROOT)
    return config


def on_files(files, config, **_):
    """The schema that editors read."""
    from taichi_silo.scene.scene import Scene

    schema = json.dumps(Scene.model_json_schema(), indent=2, ensure_ascii=False)
    files.append(File.generated(config, SCHEMA, content=f"{schema}\n"))
    return files


def on_page_markdown(markdown: str, page, **_) -> str:
    """A page with what belongs to its mark."""
    if MARK not in markdown:
        return markdown
    return markdown.replace(MARK, PARTS[Path(page.file.src_uri).stem]())


def scene() -> str:
    """Every value of a scene file."""
    from taichi_silo.scene import reference

    return reference.markdown()


def sands() -> str:
    """Constants of the published sands, and where they come from."""
    from taichi_silo.scene.sands import published

    known = published()
    heads = ("name", "φ_c", "h_s, MPa", "n", "α", "β", "e_d0", "e_c0", "e_i0", "grains, kg/m³", "d50, mm")
    rows = [heads, ("---",) * len(heads)]
    for name, sand in known.items():
        rows.append((
            f"`{name}`", f"{sand['critical_friction_angle_deg']:g}°", f"{1e-6 * sand['granular_hardness_Pa']:g}",
            *(f"{sand[key]:g}" for key in ("n", "alpha", "beta")),
            *(f"{sand[key]:.3g}" for key in ("e_d0", "e_c0", "e_i0")),
            f"{sand['grain_density_kg_per_m3']:g}", f"{1e3 * sand['d50_m']:g}",
        ))  # fmt: skip
    notes = [("name", "title", "source", "read in"), ("---",) * 4]
    notes += [(f"`{name}`", sand["title"], sand["source"], sand["read_in"]) for name, sand in known.items()]
    return "\n\n".join("\n".join(f"| {' | '.join(row)} |" for row in part) for part in (rows, notes))


def solids() -> str:
    """Table E.1 of EN 1991-4, and where each row was read."""
    from taichi_silo.cli.eurocode_words import COLUMNS
    from taichi_silo.scene.published_solids import published

    heads = ("name", *(title for title, _ in COLUMNS.values()), "read in")
    rows = [heads, ("---",) * len(heads)]
    for name, row in published().items():
        rows.append((f"`{name}`", *(f"{row[key] / unit:g}" for key, (_, unit) in COLUMNS.items()), row["read_in"]))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


PARTS = {
    "architecture": house.picture,
    "scene": scene, "sands": sands, "solids": solids, "commands": command_line.commands,
    "scenarios": command_line.scenarios, "python": python_names.names,
}  # fmt: skip
