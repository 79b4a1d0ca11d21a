"""Counterparts of the paper's figures 10 to 22: void ratio and wall stresses, sand by sand and wall by wall."""

from pathlib import Path

from taichi_silo.show.figures import plot_cases
from validation.paper.cases import CASES

FIGURES = {  # the paper's numbers, and the cases of each
    "figures_10-13_mass_flow": [name for name, case in CASES.items() if case.outlet == "bottom"],
    "figures_14-15_dense_very-rough": ["dense", "very-rough"],
    "figures_16-17_dense_smooth": ["dense", "smooth"],
    "figures_18-19_loose_very-rough": ["loose", "very-rough"],
    "figures_20-21_loose_smooth": ["loose", "smooth"],
    "figure_22_gravity": [name for name, case in CASES.items() if case.gravity],
}


def plot_paper(folder: Path, target: Path) -> list[Path]:
    """Draw those for which runs are in the folder; returns the files."""
    written = []
    for figure, cases in FIGURES.items():
        if cases[0] in ("dense", "loose"):
            sand, walls = cases
            cases = [
                name
                for name, case in CASES.items()
                if (case.sand, case.walls) == (sand, walls) and case.outlet != "bottom" and not case.gravity
            ]
        there = {_label(name): folder / name for name in cases if (folder / name / "forces.csv").exists()}
        if there:
            written += plot_cases(there, target / figure)
    return written


def _label(name: str) -> str:
    """Short words for a legend."""
    case = CASES[name]
    words = {"bottom": "", "centre-80": "80 mm in the middle", "right-150": "150 mm, right", "right-50": "50 mm, right"}
    free = "free outflow, " if case.gravity else ""
    ends = [words[case.outlet]] if words[case.outlet] else []
    return ", ".join([f"{free}{case.sand}", case.walls.replace("-", " "), *ends])
