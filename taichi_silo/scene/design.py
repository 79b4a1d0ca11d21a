"""A silo for EN 1991-4 from a scene file: what a grid and a simulation need is passed over."""

from collections.abc import Iterable
from pathlib import Path

from pydantic import ValidationError, model_validator

from taichi_silo.errors import BadInput
from taichi_silo.scene.eurocode import Eurocode
from taichi_silo.scene.sand import Sand
from taichi_silo.scene.scene import Method, Scene, Walls
from taichi_silo.scene.scene_files import read_tables
from taichi_silo.scene.silo import Silo
from taichi_silo.utils.schema import Options, one_sentence


class Design(Options):
    """Silo, sand, walls and EN 1991-4's values of a scene."""

    silo: Silo = Silo()
    sand: Sand = Sand()
    walls: Walls = Walls()
    method: Method = Method()
    eurocode: Eurocode = Eurocode()

    @model_validator(mode="after")
    def _possible(self):
        self.eurocode.check(self.silo)
        if not self.silo.transition_m < self.silo.height_m:
            raise ValueError("outline_m has no vertical walls; EN 1991-4 needs some above the inclined ones")
        return self


def read_design(file: Path, changes: Iterable[str] = ()) -> Design:
    """The design of a scene file, with changes PATH=VALUE over it; its grid, flow and the like may be of any size.

    Raises BadInput if the file cannot be read or its values are not possible.
    """
    tables = read_tables(file, changes)
    passed = Scene.model_fields.keys() - Design.model_fields.keys()
    wanted = {name: table for name, table in tables.items() if name not in passed}
    try:
        return Design.model_validate(wanted)
    except ValidationError as error:
        raise BadInput(f"{file}: {one_sentence(error)}") from error
