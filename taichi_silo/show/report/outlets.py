"""What each of several outlets has let out, as a table of the report."""

from taichi_silo.runs.result import Result
from taichi_silo.show.report.tables import ReportTable
from taichi_silo.show.report.words import number


def outlet_table(run: Result) -> ReportTable | None:
    """Table of mass, mean rate and time of each outlet; None where there is but one."""
    found = (run.summary.get("ledger") or {}).get("outlets")
    if not found:
        return None
    rows = [
        (
            f"{place + 1}: {one['outlet']}", number(one["discharged_kg_per_m"], 4), number(one["mean_rate_kg_per_s_m"]),
            number(one["open_s"]),
        )
        for place, one in enumerate(found)
    ]  # fmt: skip
    head = ("outlet", "mass (kg/m)", "mean rate (kg/s per m)", "open for (s)")
    return ReportTable(head, tuple(rows), "The rate is the mean until the gate was closed.")
