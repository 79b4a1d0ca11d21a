"""Pressures on the vertical walls after EN 1991-4 against depth."""

from matplotlib.figure import Figure

from taichi_silo.show.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    REFERENCE,
    VERMILLION,
    new_figure,
    put_title,
    start_at_zero,
)
from taichi_silo.show.report.eurocode import EurocodeReport

LINES = {  # panel: column, label, colour, line
    "pressure p_h (kPa)": (
        ("p_hf_Pa", "filling", BLACK, "-"), ("p_he_Pa", "discharge", VERMILLION, "-"),
        ("envelope_normal_Pa", "envelope", BLUE, "--"), ("envelope_least_normal_Pa", "least", REFERENCE, ":"),
    ),
    "friction p_w (kPa)": (
        ("p_wf_Pa", "filling", BLACK, "-"), ("p_we_Pa", "discharge", VERMILLION, "-"),
        ("envelope_shear_Pa", "envelope", BLUE, "--"),
    ),
    "vertical pressure p_v (kPa)": (("p_vf_Pa", "filling", GREEN, "-"),),
    "force in the wall n_zSk (kN/m)": (
        ("n_f_N_per_m", "filling", BLACK, "-"), ("n_e_N_per_m", "discharge", VERMILLION, "-"),
    ),
}  # fmt: skip


def eurocode_figure(report: EurocodeReport) -> Figure:
    """Figure of a report: pressure, friction, vertical pressure and force in the wall by depth."""
    figure, fine = new_figure(12.6, 5.4), EurocodeReport(report.scene, report.silo, 201).frame
    panels = figure.subplots(1, len(LINES), sharey=True)
    for panel, (title, lines) in zip(panels, LINES.items(), strict=True):
        for column, label, color, line in lines:
            panel.plot(fine[column] / 1e3, fine["depth_m"], color=color, linestyle=line, label=label)
        for patch in report.patches if title.startswith("pressure") else ():
            low, high = (patch.depth_m + side * 0.5 * patch.height_m for side in (-1, 1))
            panel.axhspan(low, high, color=BLUE, alpha=0.05, linewidth=0)
        panel.set_xlabel(title)
        start_at_zero([panel], "x")
        panel.legend(loc="upper right")
    panels[0].set_ylabel("depth below the levelled surface (m)")
    panels[0].set_ylim(report.silo.height_m, 0.0)
    silo = report.silo
    put_title(
        figure, f"EN 1991-4: {silo.solid.title}, wall {silo.wall}, {silo.slenderness} silo, class {silo.action_class}",
        "characteristic values, without partial factors"
        + ("; bands: where patch loads stand" if report.patches else ""),
    )  # fmt: skip
    return figure
