"""Pages of reference that are made from the program itself: scene files, command line, scenarios, sands, Python names."""

import json
import sys
from pathlib import Path

import command_line
import python_names
from mkdocs.structure.files import File

ROOT = str(Path(__file__).parents[2])


def on_config(config, **_):
    """The program beside these pages is the one they describe, whatever else is installed."""
    if ROOT not in sys.path:
        sys.path.insert(0, ROOT)
    return config


def on_files(files, config, **_):
    """The pages, and the schema that editors read."""
    from taichi_silo import reference, sands
    from taichi_silo.scene import Scene

    pages = {
        "reference/scene.md": SCENE + reference.markdown(),
        "reference/scene.schema.json": json.dumps(Scene.model_json_schema(), indent=2, ensure_ascii=False) + "\n",
        "reference/commands.md": command_line.commands(),
        "reference/scenarios.md": command_line.scenarios(),
        "reference/sands.md": SANDS + published(sands.published()),
        "reference/python.md": python_names.page(),
    }
    for name, content in pages.items():
        files.append(File.generated(config, name, content=content))
    return files


SCENE = """# Scene file

A scene is a TOML file. What it leaves out takes the defaults below, so a file may be as short as one line. `taichi-silo scene` prints a
file with every value; `taichi-silo run FILE --check` says whether a file is possible. Impossible values and unknown names are refused in one
sentence before any work.

```toml title="silo.toml"
[sand]
name = "hostun"      # all constants of a published sand
void_ratio = 0.70

[walls]
kind = "smooth"
```

Editors that know JSON schemas complete and check the file with [scene.schema.json](scene.schema.json). All units are SI and stand in the names.
The `run.toml` that a run leaves is a scene file too; its table `program`, which says what computed the run, is passed over.

"""

SANDS = """# Published sands

`--sand NAME`, or in a scene file `name` in the table `sand`, stands for one of these. "Read in" says where the numbers were read: where that is not
the original print, check them against it before you rely on them. All but `karlsruhe` were determined for von Wolffersdorff's version of the law. In
triaxial compression both versions have the same limit states, and their rates differ by the factor 3 tr(T̂T̂) only (1 in isotropic states, 1.32 at
φ_c = 30°); away from it they differ more.

How to give a sand of your own: [Your own sand](../how-to/sand.md).

"""


def published(sands: dict[str, dict]) -> str:
    """Their constants, and where they come from."""
    heads = ("name", "φ_c", "h_s, MPa", "n", "α", "β", "e_d0", "e_c0", "e_i0", "grains, kg/m³", "d50, mm")
    rows = [heads, ("---",) * len(heads)]
    for name, sand in sands.items():
        rows.append((
            f"`{name}`", f"{sand['critical_friction_angle_deg']:g}°", f"{1e-6 * sand['granular_hardness_Pa']:g}",
            *(f"{sand[key]:g}" for key in ("n", "alpha", "beta")),
            *(f"{sand[key]:.3g}" for key in ("e_d0", "e_c0", "e_i0")),
            f"{sand['grain_density_kg_per_m3']:g}", f"{1e3 * sand['d50_m']:g}",
        ))  # fmt: skip
    notes = [("name", "title", "source", "read in"), ("---",) * 4]
    notes += [(f"`{name}`", sand["title"], sand["source"], sand["read_in"]) for name, sand in sands.items()]
    return "\n\n".join("\n".join(f"| {' | '.join(row)} |" for row in part) for part in (rows, notes)) + "\n"
