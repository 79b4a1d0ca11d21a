"""How far to trust a run: the numbers of its quasi-static certificate beside their limits, and a verdict in words."""

from collections.abc import Callable
from dataclasses import dataclass

from taichi_silo.runs.result import Result
from taichi_silo.show.report.words import number, plain, sentence

BALANCE = 1e-9  # of the weight; round-off leaves 1e-15
STEP, FALLING_STEP = 1.5, 4.0  # of the stable time step, beyond which runs are stopped; in free outflow
NOISE, CONTROL = 0.01, 0.003
INERTIAL = 1e-3
DRIFT, UNEXPLAINED = 0.003, 0.003  # of void ratio
CORE_PATH = 5e-4
MIRROR = 1e-6  # of the weight: left and right wall of a symmetric silo with smooth walls
RIGID = {"smooth": (0.9, 1.1), "very-rough": (0.0, 5.0)}
MUST_HOLD = ("balance of forces", "books of the sand", "time step")  # whatever breaks these is wrong, not inexact


@dataclass(frozen=True)
class Check:
    """One number of the certificate.

    Attributes
    ----------
    name : what it is.
    means : in a sentence, for readers who do not know the method.
    value, limit : in words.
    passed : whether it is within its limit; None where there is none for this kind of silo.

    """

    name: str
    means: str
    value: str
    limit: str
    passed: bool | None


@dataclass(frozen=True)
class Verdict:
    """The whole: level is "good", "care" or "bad"."""

    level: str
    title: str
    words: str
    checks: tuple[Check, ...]


def verdict(run: Result) -> Verdict:
    """What a run's certificate says; a run that did not end well is never good."""
    checks = tuple(_checks(run))
    judged = [check for check in checks if check.passed is not None]
    wrong = [check.name for check in judged if not check.passed]
    if not run.summary:
        return Verdict("bad", "No certificate", "The run has written no summary, so nothing vouches for it.", checks)
    if not run.summary.get("finished"):
        title = "The run did not come to its end"
        return Verdict("bad", title, "What is shown holds only for what was reached.", checks)
    if broken := [name for name in wrong if name in MUST_HOLD]:
        words = f"Outside of its limit: {', '.join(broken)}. A run in which this does not hold is wrong."
        return Verdict("bad", "Not to be trusted", words, checks)
    count = f"{len(judged) - len(wrong)} of {len(judged)} numbers are within their limits"
    if wrong:
        title = "To be read with care"
        return Verdict("care", title, sentence(f"{count}; outside: {', '.join(wrong)}"), checks)
    if not judged:
        return Verdict("bad", "No certificate", "The summary holds none of its numbers.", checks)
    if run.free:
        words = sentence(f"{count}; free outflow is not quasi-static, and has fewer of them")
        return Verdict("good", "Books and balances close", words, checks)
    return Verdict("good", "The flow is quasi-static and clean", sentence(count), checks)


def _checks(run: Result):
    found, walls = run.summary.get("certificate") or {}, run.scene.walls.kind
    # sand that sinks as one block should not deform at all
    block = walls == "smooth" and run.scene.silo.floor_is_outlet
    controlled = not run.free
    for name, key, limit, means in (
        (
            "balance of forces", "force_balance_residual_over_weight", BALANCE,
            "bottom force and wall friction carry weight and inertia in every record; the rest over the weight",
        ),
        (
            "time step", "largest_time_step_over_stable", STEP if controlled else FALLING_STEP,
            "largest time step over the stable one of that moment; beyond the limit the run would have been stopped",
        ),
    ):  # fmt: skip
        yield from _below(found, name, key, limit, means)
    yield from _below(
        run.summary.get("ledger") or {}, "books of the sand", "error_over_first_mass", BALANCE,
        "sand that has left and sand in the silo add up to what was filled in; the error over it",
    )  # fmt: skip
    settled = found.get("settled_before_flow")
    if settled is not None:
        means = "the sand had come to rest before the outflow began"
        yield Check("at rest before flow", means, "yes" if settled else "no", "should be yes", bool(settled))
    yield from _below(
        found, "inertial number", "inertial_number_99th_percentile", INERTIAL if controlled else None,
        "how much inertia counts in the shear zones (99th percentile); below the limit flow is quasi-static",
    )  # fmt: skip
    yield from _below(
        found, "noise of N", "noise_of_normal_force", NOISE if controlled else None,
        "scatter of the wall force about its moving mean, over the wall force",
    )  # fmt: skip
    yield from _below(
        found, "force of the noise control", "largest_noise_control_force_over_weight", CONTROL,
        "largest force with which the numerical noise control holds the sand, over the weight",
    )  # fmt: skip
    yield from _rigid(found, walls)
    yield from _below(
        found, "unexplained densification", "unexplained_densification", UNEXPLAINED if controlled else None,
        "void ratio lost by sand that has not been sheared: the mark of ratcheting",
    )  # fmt: skip
    yield from _below(
        found, "drift of the void ratio", "mean_void_ratio_drift", DRIFT if block else None,
        "change of the mean void ratio in flow; a block that slides down has none", size=abs,
    )  # fmt: skip
    yield from _below(
        found, "strain in the core", "core_strain_path", CORE_PATH if block else None,
        "length of the strain's path in the middle of the silo; a block that slides down has none",
    )  # fmt: skip
    yield from _below(
        found, "left against right", "left_right_difference_over_weight", MIRROR if block else None,
        "largest difference of the two walls' forces, over the weight",
    )  # fmt: skip


def _below(found: dict, name: str, key: str, limit: float | None, means: str, size: Callable = float):
    """One check of a number against an upper limit, if the run has the number."""
    value = found.get(key)
    if value is None:
        return
    words = "no limit here" if limit is None else f"limit {'±' if size is abs else '≤ '}{plain(limit)}"
    yield Check(name, means, number(value, 2), words, None if limit is None else bool(size(value) <= limit))


def _rigid(found: dict, walls: str):
    energy = found.get("kinetic_energy_over_rigid_motion")
    if not energy:
        return
    low, high = RIGID.get(walls, RIGID["very-rough"])
    limit = f"limit {plain(low)} to {plain(high)}" if low else f"limit ≤ {plain(high)}"
    passed = low <= min(energy) and max(energy) <= high
    means = "kinetic energy over that of the whole column at the speed of the bottom, least and largest"
    yield Check("kinetic energy", means, f"{number(energy[0], 2)} to {number(energy[-1], 2)}", limit, passed)
