"""`taichi-silo scene`."""

from pathlib import Path
from typing import Annotated

import typer


def scene(
    schema: Annotated[bool, typer.Option("--schema", help="the JSON schema instead, for editors")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="a reference page instead")] = False,
    output: Annotated[Path | None, typer.Option(help="file to write; the screen if not given")] = None,
) -> None:
    """Print a scene file with every value, its unit, range, default and meaning: a start for one's own silo.

    Example: taichi-silo scene --output silo.toml
    """
    import json

    from taichi_silo.cli.command_line import print_or_write
    from taichi_silo.errors import BadInput
    from taichi_silo.scene import reference
    from taichi_silo.scene.scene import Scene

    if schema and markdown:
        raise BadInput("schema and markdown are both given; give one of them")
    text = reference.markdown() if markdown else reference.template()
    if schema:
        text = json.dumps(Scene.model_json_schema(), indent=2, ensure_ascii=False) + "\n"
    print_or_write(text, output)
