"""Counterparts of the paper's figures 10 to 22: void ratio and wall stresses, sand by sand and wall by wall."""

from pathlib import Path

from validation.case_figures import plot_cases
from validation.paper.cases import CASES

FIGURES = {  # named by the paper's numbers; the cases of each
    "figures_10-13_mass_flow": [name for name, case in CASES.items() if case.opening.whole],
    **{
        f"figures_{numbers}_{sand}_{walls}": [
            name
            for name, case in CASES.items()
            if (case.sand, case.walls) == (sand, walls) and not case.opening.whole and not case.gravity
        ]
        for numbers, sand, walls in (
            ("14-15", "dense", "very-rough"), ("16-17", "dense", "smooth"),
            ("18-19", "loose", "very-rough"), ("20-21", "loose", "smooth"),
        )
    },
    "figure_22_gravity": [name for name, case in CASES.items() if case.gravity],
}  # fmt: skip


def plot_paper(folder: Path, target: Path) -> list[Path]:
    """Draw the figures for which there are runs in the folder; returns the files."""
    written = []
    for figure, cases in FIGURES.items():
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
