"""What a sweep is: scenes, what varies, and how it is done."""

from pathlib import Path
from typing import Any

from pydantic import Field, field_validator

from taichi_silo.errors import BadInput
from taichi_silo.scene import fidelity as fidelities
from taichi_silo.scene.dotted_paths import changed, whole
from taichi_silo.scene.scene import Scene
from taichi_silo.studies.sweep.clusters import Cluster, Local
from taichi_silo.studies.sweep.hypercube import LatinHypercube
from taichi_silo.studies.sweep.response import Response
from taichi_silo.studies.sweep.variations import Variation, bases, made, product, refuse, scenes
from taichi_silo.utils.messages import shown
from taichi_silo.utils.schema import Options


class Sweep(Options):
    """All of it.

    Attributes
    ----------
    scene : files, or values at dotted paths; the default silo if absent.
    fidelity : named cell size and speed of all runs, unless they vary.
    film : whether to draw the films.
    retries : how often a run is begun again whose worker died.
    grid : values at dotted paths, of which every combination is run.
    latin_hypercube : draws instead of combinations.
    response : what to plot.
    cluster : where to run.

    """

    scene: dict[str, Any] | tuple[Path, ...] = ()
    fidelity: str | None = None
    film: bool = False
    retries: int = Field(3, ge=0, le=1000)
    grid: dict[str, tuple[Any, ...]] = {}
    latin_hypercube: LatinHypercube | None = None
    response: Response = Response()
    cluster: Cluster = Local()

    @field_validator("grid", mode="before")
    @classmethod
    def _lists(cls, given):
        for path, values in given.items() if isinstance(given, dict) else ():
            if not isinstance(values, list | tuple):
                raise ValueError(f"grid.{shown(path)} is {shown(values)}; it must be a list of values")
        return given

    @property
    def paths(self) -> list[str]:
        """Dotted paths that vary, in their order."""
        return list(self.grid if self.latin_hypercube is None else self.latin_hypercube.between)

    def scenes(self) -> dict[str, Scene]:
        """All, by the names of their runs.

        Raises
        ------
        BadInput
            if nothing varies, or a scene is not possible.

        """
        if self.grid and self.latin_hypercube is not None:
            raise BadInput("a sweep has a grid or a latin_hypercube, not both; choices of the latter may be words, too")
        if isinstance(self.scene, dict):
            found = {"": made(bases([])[""], self.scene | {"machine.threads": 1})}
        else:
            found = bases(list(self.scene))
            found = dict(zip([""], found.values(), strict=True)) if len(found) == 1 else found
        if not self.paths and len(found) == 1:
            raise BadInput("nothing varies; a sweep needs a table grid or latin_hypercube, --vary, or several scenes")
        if self.fidelity is not None:
            chosen = fidelities.fidelity(self.fidelity).settings
            found = {name: changed(scene, chosen) for name, scene in found.items()}
        return scenes(found, self._varied())

    def _varied(self) -> dict[str, dict]:
        if self.latin_hypercube is None:
            return product([Variation(path, values) for path, values in self.grid.items()])
        for path in self.paths:
            refuse(path)
        drawn = self.latin_hypercube.settings(whole)
        once = list({str(one): one for one in drawn}.values())  # steps may bring the same run twice
        digits = len(str(len(once)))
        return {f"run-{number:0{digits}d}": one for number, one in enumerate(once, 1)}
