"""How far to trust a run: the numbers of its quasi-static certificate beside their limits, and a verdict in words."""

from collections.abc import Iterator
from dataclasses import dataclass

from taichi_silo.runs.alarms.of_records import LONGEST_FALLING, LONGEST_STEP
from taichi_silo.runs.result import Result
from taichi_silo.show.report.words import number, plain, sentence
from taichi_silo.simulation.outflow import JAMMED, LAGS

RIGID = {"smooth": (0.9, 1.1), "very-rough": (0.0, 5.0)}
DRIFT = "mean_void_ratio_drift"  # the one number whose sign says nothing
MUST_HOLD = ("balance of forces", "books of the sand", "time step")  # whatever breaks these is wrong, not inexact
SETTLED, ENERGY, STEP = "settled_before_flow", "kinetic_energy_over_rigid_motion", "largest_time_step_over_stable"
CHECKS = (  # name, key of the certificate, upper limit of the size, of which runs, what it means
    (
        "balance of forces", "force_balance_residual_over_weight", 1e-9, "all",  # round-off leaves 1e-15
        "bottom force and wall friction carry weight and inertia in every record; the rest over the weight",
    ),
    (
        "time step", STEP, LONGEST_STEP, "all",
        "largest time step over the stable one of that moment; beyond the limit the run would have been stopped",
    ),
    (
        "books of the sand", "error_over_first_mass", 1e-9, "all",
        "sand that has left and sand in the silo add up to what was filled in; the error over it",
    ),
    ("at rest before flow", SETTLED, None, "all", "the sand had come to rest before the outflow began"),
    (
        "inertial number", "inertial_number_99th_percentile", 1e-3, "controlled",
        "how much inertia counts in the shear zones (99th percentile); below the limit flow is quasi-static",
    ),
    (
        "noise of N", "noise_of_normal_force", 0.01, "controlled",
        "scatter of the wall force about its moving mean, over the wall force",
    ),
    (
        "force of the noise control", "largest_noise_control_force_over_weight", 0.003, "all",
        "largest force with which the numerical noise control holds the sand, over the weight",
    ),
    (
        "kinetic energy", ENERGY, None, "all",
        "kinetic energy over that of the whole column at the speed of the bottom, least and largest",
    ),
    (
        "unexplained densification", "unexplained_densification", 0.003, "controlled",
        "void ratio lost by sand that has not been sheared: the mark of ratcheting",
    ),
    (
        "drift of the void ratio", DRIFT, 0.003, "block",
        "change of the mean void ratio in flow; a block that slides down has none",
    ),
    (
        "strain in the core", "core_strain_path", 5e-4, "block",
        "length of the strain's path in the middle of the silo; a block that slides down has none",
    ),
    (
        "left against right", "left_right_difference_over_weight", 1e-6, "block",
        "largest difference of the two walls' forces, over the weight",
    ),
)  # fmt: skip

REMEDIES = {  # of what is outside of its limit
    "at rest before flow": "a greater method.longest_settling_s lets it come to rest",
    "inertial number": "a smaller flow.speed_m_per_s helps",
    "noise of N": "a smaller flow.speed_m_per_s helps, and a greater method.filling_time_s",
    "unexplained densification": 'method.noise_control = "column" and a greater method.filling_time_s help',
}
FOUR = {"at rest before flow": "four points a cell, the default where walls cut cells, come to rest"}


@dataclass(frozen=True)
class CertificateCheck:
    """One number of the certificate, in words, with its meaning for readers who do not know the method.

    `passed` says whether it is within its limit; None where there is none for this kind of silo.
    """

    name: str
    means: str
    value: str
    limit: str
    passed: bool | None


@dataclass(frozen=True)
class Verdict:
    """How far to trust a run: level "good", "care" or "bad", title, words, and the numbers behind it."""

    level: str
    title: str
    words: str
    checks: tuple[CertificateCheck, ...]


def verdict(run: Result) -> Verdict:
    """Verdict on a run from its certificate; a run that did not come to its end is never good."""
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
    told = run.summary.get("warnings", [])
    for title in (JAMMED, LAGS):
        if said := [words for words in told if words.startswith(title)]:
            why = said[0].removeprefix(title).strip(": .")
            return Verdict("care", title, " ".join(sentence(words) for words in (why, count) if words), checks)
    alarms = [alarm["name"] for alarm in run.summary.get("alarms", [])]
    if wrong or alarms:
        title = "To be read with care"
        remedies = REMEDIES | (FOUR if run.scene.silo.cuts_cells and run.scene.grid.points_per_cell == 1 else {})
        outside = [f"{name} ({remedies[name]})" if name in remedies else name for name in wrong]
        found = [count, *([f"outside: {', '.join(outside)}"] if wrong else [])]
        found += [f"alarms in run.log: {', '.join(alarms)}"] if alarms else []
        return Verdict("care", title, sentence("; ".join(found)), checks)
    if not judged:
        return Verdict("bad", "No certificate", "The summary holds none of its numbers.", checks)
    if run.free:
        words = sentence(f"{count}; free outflow is not quasi-static, and has fewer of them")
        return Verdict("good", "Books and balances close", words, checks)
    return Verdict("good", "The flow is quasi-static and clean", sentence(count), checks)


def _checks(run: Result) -> Iterator[CertificateCheck]:
    """Each number of the certificate that the run has."""
    found, walls = (run.summary.get("certificate") or {}) | (run.summary.get("ledger") or {}), run.scene.walls.kind
    block = walls == "smooth" and run.scene.silo.floor_is_outlet  # sand sinks as one block, and should not deform
    kinds = {"all", *(() if run.free else ("controlled",)), *(("block",) if block else ())}
    for name, key, limit, kind, means in CHECKS:
        value = found.get(key)
        if value is None or value == []:
            continue
        if key == SETTLED:
            yield CertificateCheck(name, means, "yes" if value else "no", "should be yes", bool(value))
        elif key == ENERGY:
            low, high = RIGID.get(walls, RIGID["very-rough"])  # of a contact of a plugin nothing more is known
            words = f"limit {plain(low)} to {plain(high)}" if low else f"limit ≤ {plain(high)}"
            passed = low <= min(value) and max(value) <= high
            yield CertificateCheck(name, means, f"{number(value[0], 2)} to {number(value[-1], 2)}", words, passed)
        elif kind not in kinds:
            yield CertificateCheck(name, means, number(value, 2), "no limit here", None)
        else:
            limit = LONGEST_FALLING if key == STEP and run.free else limit
            words = f"limit {'±' if key == DRIFT else '≤ '}{plain(limit)}"
            passed = bool((abs(value) if key == DRIFT else value) <= limit)
            yield CertificateCheck(name, means, number(value, 2), words, passed)
