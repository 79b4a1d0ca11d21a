"""A whole comparison: read, computed, and left in a folder."""

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from taichi_silo.errors import BadInput
from taichi_silo.runs.run_folder import no_link, writable
from taichi_silo.show.figures.run_files import RunFiles
from taichi_silo.studies.compare import differences as tables
from taichi_silo.studies.compare.deviation import deviations
from taichi_silo.studies.compare.figures import draw
from taichi_silo.studies.compare.measured import read
from taichi_silo.studies.compare.runs import read_runs
from taichi_silo.utils import atomic_write
from taichi_silo.utils.bounded_reading import as_left, place
from validation.paper.against_runs import PaperFindings, against_paper

PRODUCTS = (
    "compare.csv", "janssen.csv", "deviation.csv", "paper.csv", "compare_forces.png", "compare_walls.png",
)  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """Its runs, tables (None if they were not asked for) and files."""

    runs: list[RunFiles]
    differences: pd.DataFrame
    janssen: pd.DataFrame | None
    deviations: pd.DataFrame | None
    paper: list[PaperFindings]
    files: list[Path]

    def as_json(self) -> dict:
        """All numbers, in SI units."""
        found = {
            "runs": {run.label: str(run.folder) for run in self.runs},
            "differences": _records(self.differences),
            "files": [str(file) for file in self.files],
        }
        for name in ("janssen", "deviations"):
            if getattr(self, name) is not None:
                found[name] = _records(getattr(self, name))
        if self.paper:
            found["paper"] = [_paper(one) for one in self.paper]
        return found


def compared(folders: list[Path], output: Path, *, janssen: bool, paper: bool, csv: list[Path]) -> Comparison:
    """Compare runs and leave tables and figures.

    Parameters
    ----------
    folders : of the runs.
    output : folder of what is left.
    janssen, paper : whether theory and the paper's statements are wanted.
    csv : files of measurements.

    Raises
    ------
    BadInput
        before anything is written: if a folder or a file is not what it must be, or there is nothing to compare with.

    """
    output, runs = place(output, "output"), read_runs(folders)
    measured = [read(file) for file in csv]
    if len({one.place for one in measured if one.kind == "curves"}) > 1:
        raise BadInput("csv: curves are given over displacement and over time; they must all be over one of them")
    if len(runs) == 1 and not (janssen or paper or measured):
        raise BadInput("runs: there is 1; it must be 2 or more, or one with --janssen, --paper or --csv FILE")
    with as_left(runs[0].folder if len(runs) == 1 else f"one of {len(runs)}"):
        found = Comparison(
            runs=runs,
            differences=tables.differences(runs),
            janssen=tables.janssen(runs) if janssen else None,
            deviations=deviations(runs, measured) if measured else None,
            paper=against_paper(runs) if paper else [],
            files=[],
        )
    no_link(*(output / f"{name}{end}" for name in PRODUCTS for end in ("", ".part")))
    output = writable(output)
    left = {"compare.csv": found.differences, "janssen.csv": found.janssen, "deviation.csv": found.deviations}
    if paper:
        left["paper.csv"] = pd.concat([one.rows for one in found.paper])
    for name in PRODUCTS:
        (output / name).unlink(missing_ok=True)
    for name, table in left.items():
        if table is not None:
            found.files.append(_write(table, output / name))
    found.files.extend(draw(runs, measured, janssen, output))
    return found


def _write(table: pd.DataFrame, file: Path) -> Path:
    """A table in one piece or not at all."""
    with atomic_write.written(file) as passing:
        table.to_csv(passing, index=False, encoding="utf-8")
    return file


def _records(table: pd.DataFrame) -> list[dict]:
    return table.astype(object).where(table.notna(), None).to_dict("records")


def _paper(found: PaperFindings) -> dict:
    case = found.known.case
    return {
        "run": found.label,
        "case": None if case is None else case.name,
        "differences": [{"path": path, "run": mine, "case": other} for path, mine, other in found.known.differences],
        "statements": _records(found.rows),
        "not_compared": found.others,
        "verdicts": found.verdicts,
    }
