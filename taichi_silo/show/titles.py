"""A run in one line: which sand, which walls, and what is special."""

from taichi_silo.runs.result import Result
from taichi_silo.scene.sand import Sand


def sand_title(sand: Sand, symbol: str = "$e_0$") -> str:
    """Loose or dense, with its initial void ratio; the symbol as figures write it, or "e₀" for other text."""
    return f"initially {'loose' if sand.loose else 'dense'} sand ({symbol} = {sand.void_ratio:.2f})"


def title(run: Result, symbol: str = "$e_0$") -> str:
    """Sand, walls, and what else a run is told by, such as an outlet."""
    scene = run.scene
    words = [sand_title(scene.sand, symbol)]
    words.append(scene.walls.words)
    if special := scene.silo.words():
        words.append(special)
    if run.free:
        words.append("free outflow")
    return ", ".join(words)
