"""What carries sand beside bottom and vertical walls, and Janssen's theory does not know: hopper and inserts."""

from taichi_silo.runs.result import Result
from taichi_silo.show.report.words import per_cent
from taichi_silo.show.theory import straight_m

NAMES = {"hopper": ("hopper_", "the hopper carries"), "inserts": ("insert_", "the inserts carry")}  # columns' begin


def shares(run: Result) -> dict[str, float]:
    """Share of the weight that "hopper" and "inserts" carry after filling, of those that the silo has."""
    if run.filled is None or not run.filled.get("weight_N_per_m"):
        return {}
    upwards = run.filled.filter(regex="_vertical_N_per_m$")
    found = {name: upwards[upwards.index.str.startswith(begin)] for name, (begin, _) in NAMES.items()}
    return {name: float(one.sum() / run.filled["weight_N_per_m"]) for name, one in found.items() if len(one)}


def lead(run: Result) -> str:
    """The sentence on which forces carry the weight."""
    if others := " and ".join(shares(run)):
        bodies = others.replace(" and ", ", ")
        return (
            f"What the sand does to bottom, walls, {bodies}: P, T of both walls and the upward forces of {others} "
            "carry its weight."
        )
    return "What the sand does to bottom and walls: P + T of both walls carry its weight."


def beyond_janssen(run: Result) -> str:
    """The sentence on what Janssen's theory does not know of a silo, and what that carries; empty if it knows all."""
    found = shares(run)
    if not found or not straight_m(run):
        return ""
    carry = " and ".join(f"{NAMES[name][1]} {per_cent(share)}" for name, share in found.items())
    return f"Janssen's theory knows no {' or '.join(found)}; of the weight after filling {carry}."
