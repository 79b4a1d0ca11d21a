"""Tables of EN 1991-4 for the terminal."""

from rich import box
from rich.table import Table

from taichi_silo.scene.published_solids import published
from taichi_silo.show.report.eurocode import EurocodeReport
from taichi_silo.show.report.tables import ReportTable

MOST_ROWS = 1000
COLUMNS = {  # of table E.1: title, divided by
    "lower_weight_density_N_per_m3": ("γ_l kN/m³", 1e3), "upper_weight_density_N_per_m3": ("γ_u", 1e3),
    "angle_of_repose_deg": ("φ_r", 1.0), "internal_friction_angle_deg": ("φ_im", 1.0),
    "internal_friction_factor": ("a_φ", 1.0), "pressure_ratio": ("K_m", 1.0), "pressure_ratio_factor": ("a_K", 1.0),
    "wall_friction_D1": ("μ D1", 1.0), "wall_friction_D2": ("D2", 1.0), "wall_friction_D3": ("D3", 1.0),
    "wall_friction_factor": ("a_μ", 1.0), "patch_factor": ("C_op", 1.0),
}  # fmt: skip


def tables(report: EurocodeReport) -> list[Table]:
    """The tables of a report, each with its note."""
    found = (
        ("Vertical walls, kPa", report.depth_table()), ("Patch loads", report.patch_table()),
        ("Flow channel at the wall", report.channel_table()), ("Hopper, kPa", report.hopper_table()),
    )  # fmt: skip
    return [_table(title, one) for title, one in found if one is not None]


def _table(title: str, one: ReportTable) -> Table:
    made = Table(title=title, caption=one.note, box=box.SIMPLE_HEAD, pad_edge=False, title_justify="left",
                 caption_justify="left")  # fmt: skip
    for name in one.head:
        made.add_column(name, justify="right")
    for row in one.rows:
        made.add_row(*row)
    return made


def solid_rows() -> dict[str, dict]:
    """Table E.1 by name, with where each row was read."""
    return published()


def solid_table() -> Table:
    """Table E.1."""
    rows = [
        (name, *(f"{row[key] / unit:g}" for key, (_, unit) in COLUMNS.items())) for name, row in published().items()
    ]
    head = ("solid", *(title for title, _ in COLUMNS.values()))
    return _table("EN 1991-4:2006, table E.1: means, but for γ", ReportTable(head, tuple(rows)))
