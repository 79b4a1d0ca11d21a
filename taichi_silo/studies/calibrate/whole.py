"""A whole calibration: tests read, constants fitted, and left in a folder."""

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import tomli_w

from taichi_silo.errors import BadInput, way
from taichi_silo.runs.run_folder import named, no_link, typed, writable
from taichi_silo.show.figures import draw_all
from taichi_silo.show.figures.calibration import compression_figure, shearing_figure
from taichi_silo.studies.calibrate.closed_formulas import Guess, first_guess
from taichi_silo.studies.calibrate.constants import SHOWN, SYMBOLS, how_known
from taichi_silo.studies.calibrate.fit import Fit, Heard, fitted
from taichi_silo.studies.calibrate.lab_files import read_laboratory
from taichi_silo.studies.calibrate.lab_tests import Laboratory
from taichi_silo.studies.calibrate.model_curves import compressions, shearings, with_signs
from taichi_silo.utils import atomic_write
from taichi_silo.utils.bounded_reading import place, toml
from taichi_silo.utils.messages import counted, sentence, shown

SAND, TABLE = "sand.toml", "calibration.csv"
FIGURES = ("compression", "shearing")
PRODUCTS = (SAND, TABLE, *(f"{name}.png" for name in FIGURES))
LONGEST_SOURCE = 150  # letters that are shown
USUAL = {"grain_density_kg_per_m3": 2650.0, "d50_m": 0.5e-3}  # where no test says them
FAR_OFF = {"void ratio": 0.02, "deviator": 0.1, "volume strain": 0.01}  # q over its largest value
UNITS = {"critical_friction_angle_deg": "deg", "granular_hardness_Pa": "Pa"}


@dataclass(frozen=True)
class Calibration:
    """Constants of a sand and how far they are known.

    Attributes
    ----------
    lab : the folder of its tests, or their one file.
    laboratory : the tests as they were read.
    guess : first values of the constants, each with its source.
    fit : constants, intervals and what the tests leave open.
    files : what was written; empty without an output folder.

    """

    lab: Path
    laboratory: Laboratory
    guess: dict[str, Guess]
    fit: Fit
    files: list[Path]

    @property
    def name(self) -> str:
        """Of the sand, as the folder of its tests."""
        return named(self.lab)

    @property
    def table(self) -> pd.DataFrame:
        """A row for each constant: value, ends of its interval, whether it is known, first value and its source."""
        rows = []
        for name in SHOWN:
            low, high = self.fit.intervals[name]
            rows.append({
                "constant": name, "unit": UNITS.get(name, "-"), "value": self.fit.constants[name], "low": low,
                "high": high, "known": self.known(name), "first_value": self.guess[name].value,
                "source": self.guess[name].source,
            })  # fmt: skip
        return pd.DataFrame(rows)

    def known(self, name: str) -> str:
        """Whether the tests determine a constant: yes, poorly, no, or at the end of its range."""
        if name in self.fit.undetermined:
            return "no"
        return "at the end of its range" if name in self.fit.at_bound else how_known(self.fit.widths[name])

    @property
    def sand(self) -> dict[str, Any]:
        """The table of a sand file."""
        index = self.laboratory.index
        means = {name: getattr(index, name) for name in USUAL}
        return {
            "title": f"{self.name}, from {counted(len(self.laboratory.names), 'laboratory test')}",
            "source": _source(self.lab),
            **{name: float(f"{self.fit.constants[name]:.6g}") for name in SHOWN},
            **{name: float(np.mean(values)) if values else USUAL[name] for name, values in means.items()},
        }

    @property
    def sand_text(self) -> str:
        """The sand file; remarks stand at values that no test determines."""
        remarks = {
            name: f"first value, {self.guess[name].source}: the tests do not determine it" for name in self.fit.kept
        }
        remarks |= {
            name: "usual of sands: no test says it" for name in USUAL if not getattr(self.laboratory.index, name)
        }
        lines = tomli_w.dumps(self.sand).splitlines()
        names = [line.split(" = ")[0] for line in lines]
        return "".join(
            f"{line} # {sentence(remarks[name])}\n" if name in remarks else f"{line}\n"
            for line, name in zip(lines, names, strict=True)
        )

    @property
    def only_typical(self) -> str:
        """Symbols of the constants that the tests leave as they were, in words; empty if there are none."""
        return ", ".join(SYMBOLS[name] for name in SHOWN if name in self.fit.kept)

    @property
    def words(self) -> list[str]:
        """What the tests leave open, and how they were read; a sentence each."""
        fit, found = self.fit, list[str]()
        if fit.rank < len(SHOWN):
            found.append(f"The tests determine {fit.rank} of {len(SHOWN)} directions of the constants.")
        if not fit.settled:
            found.append(
                "The search was ended before it had settled: the law does not come near the tests; look at them."
            )
        for name in SHOWN:
            if name in fit.kept:
                found.append(f"{SYMBOLS[name]} is not determined: {SAND} keeps {self._first(name)}.")
            elif name in fit.undetermined:
                others = f"with the first values of {self.only_typical}" if fit.kept else "with the others"
                found.append(f"{SYMBOLS[name]} is not determined by itself: it is fitted {others}.")
        found += [f"{SYMBOLS[name]} lies at the end of its range." for name in fit.at_bound]
        for one, other, share in fit.entangled:
            found.append(f"{SYMBOLS[one]} and {SYMBOLS[other]} trade off (correlation {share:.2f}).")
        for kind, size in fit.noise.items():
            if size > FAR_OFF[kind]:
                found.append(
                    f"The law is far from the tests: {kind} by {size:.2g}; are units, signs and specimens right? "
                    "Look at the figures."
                )
        for name, usual in (("grain_density_kg_per_m3", "grain density"), ("d50_m", "d50")):
            if not getattr(self.laboratory.index, name):
                found.append(f"No test gives the {usual}; {SAND} has {USUAL[name]:g}.")
        return found + [f"{remark}." for remark in self.laboratory.remarks]

    def _first(self, name: str) -> str:
        """The first value of a constant, as it is kept."""
        guess, unit = self.guess[name], UNITS.get(name, "")
        of = "" if np.isclose(self.fit.constants[name], guess.value, rtol=1e-3) else "its share of e_c0 in "
        return f"{of}its first value, {guess.value:.4g}{' ' if unit else ''}{unit} ({guess.source})"

    def as_json(self) -> dict:
        """All numbers, in SI units."""
        return {
            "sand": self.sand, "constants": self.table.to_dict("records"), "rank": self.fit.rank,
            "trade_off": [{"constants": pair[:2], "correlation": pair[2]} for pair in self.fit.entangled],
            "noise": self.fit.noise, "void_ratios": self.fit.void_ratios, "remarks": self.words,
            "files": [str(file) for file in self.files],
        }  # fmt: skip


def _source(lab: Path) -> str:
    """The command that determines the sand anew, by which its file is known again."""
    return f"taichi-silo calibrate {typed(lab.resolve())}"


def calibrate(
    lab: str | os.PathLike,
    output: str | os.PathLike | None = None,
    heard: Heard | None = None,
    overwrite: bool = False,
) -> Calibration:
    """Determine the constants of a sand from laboratory tests.

    Parameters
    ----------
    lab : folder of CSV files (or one file) of oedometer and drained triaxial tests, angle of repose, limit densities.
    output : folder for sand.toml, calibration.csv and figures; an earlier calibration of the same lab there is
        replaced. Nothing is written if it is not given.
    heard : called with a few words after each evaluation of the fit.
    overwrite : replace another sand.toml that is there.

    Returns
    -------
    Constants with intervals of 95 %, and what the tests leave open.

    Raises
    ------
    BadInput
        before any work, if a file cannot be understood, a test shows what no sand does, none has a curve, or the
        output folder holds another sand.toml.

    """
    place_ = place(lab, "lab")
    laboratory = read_laboratory(place_)
    if not laboratory.names:
        raise BadInput(f"lab {place_} has no curve; it must have at least an oedometer or a drained triaxial test")
    target = None
    if output is not None:
        target = place(output, "output")
        no_link(*(target / f"{name}{end}" for name in PRODUCTS for end in ("", ".part")))
        if not overwrite:
            _refuse_another(target, place_)
        target = writable(target)
    guess = first_guess(laboratory)
    laboratory = with_signs(laboratory, {name: one.value for name, one in guess.items()})
    guess = first_guess(laboratory)
    found = Calibration(place_, laboratory, guess, fitted(laboratory, guess, heard), [])
    return found if target is None else _left(found, target)


def _refuse_another(folder: Path, lab: Path) -> None:
    """Refuse a folder whose sand is not of this lab: it may be what later runs take."""
    if not (folder / SAND).exists():
        return
    try:
        source = toml(folder / SAND, "a sand").get("source", "without a source")
    except BadInput:
        source = "that cannot be read"
    if source != _source(lab):
        anew = way("overwrite")
        words = f"output {folder} holds another sand ({shown(source, LONGEST_SOURCE)}); give another folder, or {anew}"
        raise BadInput(f"{words} to replace it", anew)


def _left(found: Calibration, folder: Path) -> Calibration:
    """The calibration with its files."""
    for name in PRODUCTS:
        (folder / name).unlink(missing_ok=True)
    with atomic_write.written(folder / SAND) as passing:
        passing.write_text(found.sand_text, encoding="utf-8")
    with atomic_write.written(folder / TABLE) as passing:
        found.table.to_csv(passing, index=False, float_format="%.6g", encoding="utf-8")
    fit, lab = found.fit, found.laboratory
    figures = draw_all(
        {
            "compression": lambda _: compression_figure(compressions(lab, fit)),
            "shearing": lambda _: shearing_figure(shearings(lab, fit)),
        },
        None, folder,
    )  # fmt: skip
    return replace(found, files=[folder / SAND, folder / TABLE, *figures])
