"""EN 1991-4 for a silo, as tables and words: for the page of the command, and for the report of a run."""

from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from taichi_silo.analysis.theory.eurocode.bottoms import Bottom
from taichi_silo.analysis.theory.eurocode.flow_channel import FlowChannel, channels
from taichi_silo.analysis.theory.eurocode.flow_pattern import flow_pattern
from taichi_silo.analysis.theory.eurocode.load_cases import LoadCase, clause_of, depth_table
from taichi_silo.analysis.theory.eurocode.patch_loads import STATES, PatchLoad, patch_loads, uniform_increase
from taichi_silo.analysis.theory.eurocode.solids import TABLE_3_1
from taichi_silo.analysis.theory.eurocode.vertical_walls import EurocodeSilo
from taichi_silo.runs.eurocode import bottom_of, eurocode_of, whose_numbers
from taichi_silo.scene.design import Design
from taichi_silo.scene.scene import Scene
from taichi_silo.show.report.tables import ReportTable
from taichi_silo.show.report.words import NONE, kN, kPa, number, plain

ROWS = 20
DEPTH = {  # column: title
    "p_hf_Pa": "filling p_hf", "p_wf_Pa": "p_wf", "p_vf_Pa": "p_vf", "p_he_Pa": "discharge p_he", "p_we_Pa": "p_we",
    "n_f_N_per_m": "n_zSk filling (kN/m)", "n_e_N_per_m": "n_zSk discharge (kN/m)",
    "envelope_normal_Pa": "envelope p_h", "envelope_least_normal_Pa": "least p_h", "envelope_shear_Pa": "envelope p_w",
}  # fmt: skip


@dataclass(frozen=True)
class EurocodeReport:
    """What EN 1991-4 says of a silo with vertical walls."""

    scene: Scene | Design
    silo: EurocodeSilo
    rows: int = ROWS

    @classmethod
    def of(cls, scene: Scene | Design, rows: int = ROWS) -> "EurocodeReport | None":
        """Of a scene; None without vertical walls."""
        silo = eurocode_of(scene)
        return None if silo is None else cls(scene, silo, rows)

    @property
    def bottom(self) -> Bottom | None:
        """Floor or hopper; None below inclined walls that are neither cone nor wedge."""
        return bottom_of(self.scene, self.silo)

    @cached_property
    def _table(self) -> tuple[pd.DataFrame, list[LoadCase]]:
        columns, cases = depth_table(self.silo, self.rows, self.scene.eurocode.wall_thickness_m)
        return pd.DataFrame(columns), cases

    @property
    def frame(self) -> pd.DataFrame:
        """Depths and pressures, units in the names."""
        return self._table[0]

    @property
    def cases(self) -> list[LoadCase]:
        """The loads that the envelope is over."""
        return self._table[1]

    @property
    def patches(self) -> list[PatchLoad]:
        """Patch loads after filling and on discharge."""
        return patch_loads(self.silo, self.scene.eurocode.wall_thickness_m)

    @property
    def channels(self) -> list[FlowChannel]:
        """Flow channels at the wall."""
        return channels(self.silo)

    @cached_property
    def hopper_rows(self) -> list[dict[str, float]]:
        """Pressures on the hopper; empty where there is none, or Walker's theory does not hold."""
        try:
            return self.bottom.hopper_rows() if self.bottom else []
        except ValueError:
            return []

    @property
    def facts(self) -> dict[str, str]:
        """Name and value of what the tables do not show."""
        silo, bottom = self.silo, self.bottom
        h, w = silo.discharge_factors
        found = {
            "solid": silo.solid.title, "wall": silo.wall, "action assessment class": str(silo.action_class),
            "h_c / d_c": f"{plain(silo.height_m)} m / {plain(silo.width_m)} m = {silo.height_m / silo.width_m:.3g}: "
            f"{silo.slenderness} (5.1)",
            "C_h, C_w": f"{h:.3g}, {w:.3g} ({clause_of(silo, 'discharge')})",
        }  # fmt: skip
        for state in STATES:
            more = uniform_increase(silo, state, self.scene.eurocode.wall_thickness_m)
            if more is not None:
                found[f"instead of patches, {state}"] = f"p_h times {more[0]:.3g}, p_w times {more[1]:.3g} (5.2.3)"
        if bottom is not None:
            found["bottom"] = f"{bottom.kind} (6.1.1)"
            found["C_b, p_vft"] = f"{bottom.load_factor:g}, {kPa(bottom.transition_Pa)} kPa (6.1.2)"
            if bottom.kind == "flat":
                clause = "6.2.1" if silo.slenderness == "slender" else "6.2.2"
                found["largest pressure on the floor"] = f"{kPa(bottom.floor_Pa)} kPa ({clause})"
            found["flow"] = f"{flow_pattern(bottom)} (3.3; after Jenike's theory, an approximation of figure 3.1)"
        return found

    @property
    def notes(self) -> list[str]:
        """What has to be known to use the numbers."""
        found = [whose_numbers(self.scene), "All values are characteristic ones, without partial factors."]
        found += self.silo.limits()
        if self.scene.silo.inserts:
            found.append("The standard is not for silos with structures inside (1.1.2).")
        if any(one.clause == "5.2.3" for one in self.cases):
            found.append("The uniform increase (5.2.3) may stand for the patch loads; the envelope has both.")
        if self.bottom is None:
            found.append("The inclined walls of the outline are no cone or wedge of section 6: they are not computed.")
        elif self.bottom.kind != "flat" and not self.hopper_rows:
            found.append("Of so wide a hopper Walker's theory has no passive state: it is not computed.")
        elif self.bottom.kind != "flat" and self.silo.section == "plane":
            found += self._wedge_notes(self.bottom.kind)
        if self.channels and self.bottom is not None and flow_pattern(self.bottom) == "mass flow":
            found.append(
                "Mass flow (3.3) is said of a hopper about the axis, by its angle and friction; 5.2.4 asks for flow "
                "channels by the place of the outlet alone, and both are given."
            )
        if self.silo.section == "round" and self.scene.eurocode.wall_thickness_m is None and self.patches:
            found.append(
                "Without eurocode.wall_thickness_m both kinds of patch are given, and not the increase of 5.2.3."
            )
        if self.silo.action_class > 1 and self.silo.slenderness in ("squat", "intermediate"):
            found.append("Large eccentricities of the heap (5.3.3) are not computed.")
        return found

    def _wedge_notes(self, kind: str) -> list[str]:
        """How a wedge's numbers depart from the print, and what of a rectangular silo they leave out."""
        found = []
        if kind == "steep":
            found.append(
                "On discharge this wedge is in vertical equilibrium, n = F (mu_h cot(beta) + 1) - 1 (6.1.2); as far as "
                "could be confirmed the code prints -2, which is right for a cone and gives a wedge larger pressures."
            )
        if self.silo.length_m is not None:
            found.append("The hopper is a wedge along the longer side; a pyramid's is not computed.")
        return found

    def depth_table(self) -> ReportTable:
        """Pressures by depth in kPa."""
        rows = [(f"{row.depth_m:.4g}", *(kPa(getattr(row, name)) for name in DEPTH)) for row in self.frame.itertuples()]
        clauses = [f"{one.name.replace('_', ' ')} ({one.clause})" for one in self.cases]
        note = (
            "kPa, n_zSk in kN per metre of girth; depth below the levelled surface. p_h presses outward, p_w downward. "
            f"Envelope over {', '.join(clauses)}; n_zSk, p_vf: {clause_of(self.silo, 'filling')}."
        )
        if any(one.shares[1] < 0.0 for one in self.patches):
            note += " A patch takes away p_h at most: near the surface 0 is left, as no solid pulls at a wall."
        if self.channels and self.silo.surface_depth_m:
            note += " So does what stands beside a flow channel."
        return ReportTable(("depth (m)", *DEPTH.values()), tuple(rows), note)

    def value_table(self) -> ReportTable:
        """Characteristic values of the vertical walls, by load."""
        rows = []
        for load in ("wall pressure", "wall friction", "bottom load"):
            values = self.silo.values(load)
            words = (values.wall_friction, values.pressure_ratio, values.internal_friction_angle_deg)
            rows.append((load, *map(number, words), number(self.silo.depth_scale_m(load))))
        low, high = self.silo.solid.lower_weight_density_N_per_m3, self.silo.solid.upper_weight_density_N_per_m3
        note = (
            f"Table 3.1 of annex E's means; γ = {plain(high / 1e3)} kN/m³ (lower {plain(low / 1e3)}), "
            f"φ_r = {plain(self.silo.solid.angle_of_repose_deg)}°, C_op = {plain(self.silo.solid.patch_factor)}."
        )
        assert set(TABLE_3_1) >= {row[0] for row in rows}
        return ReportTable(("largest", "μ", "K", "φ_i (°)", "z_o (m)"), tuple(rows), note)

    def patch_table(self) -> ReportTable | None:
        """Patch loads; None if there are none."""
        head = ("patch", "clause", "C_p", "middle at depth (m)", "height s (m)", "p_p (kPa)", "inward (kPa)", "force")
        rows = []
        for one in self.patches:
            unit = "kN/m" if one.kind == "band" else "kN each" if one.kind == "thick-walled" else "kN"
            place = f"{one.depth_m:.4g}{' or above' if one.anywhere else ''}"
            inward = kPa(one.inward_Pa) if one.inward_Pa else NONE
            force = f"{kN(one.force_N)} {unit}"
            rows.append(
                (f"{one.state}, {one.kind}", one.clause, number(one.factor), place, number(one.height_m),
                 kPa(one.pressure_Pa), inward, force)
            )  # fmt: skip
        note = (
            "Thin-walled: p_p cos θ round the girth, F the horizontal force. Thick-walled: on two opposite squares of "
            "side s, inward on the rest. Band: 0.36 p_p on all sides, force per metre of girth."
        )
        return ReportTable(head, tuple(rows), note) if rows else None

    def channel_table(self) -> ReportTable | None:
        """Flow channels of a far outlet; None if there are none."""
        foot, rows = self.silo.height_m, []
        for one in self.channels:
            theta, has_radius = one.contact_deg, one.radius_share is not None
            sizes = (
                number((one.radius_share or 0.0) * 0.5 * self.silo.width_m) if has_radius else NONE,
                number(one.eccentricity_m) if has_radius else NONE, f"{theta:.1f}",
            )  # fmt: skip
            pressures = (kPa(float(one.normal_Pa(foot, angle))) for angle in (0.0, 1.5 * theta, 180.0))
            rows.append((one.clause, *sizes, *pressures))
        head = ("clause", "r_c (m)", "e_c (m)", "θ_c (°)", "inside (kPa)", "beside (kPa)", "far (kPa)")
        note = (
            "Pressures at the foot of the vertical walls; beside the channel from θ_c to 2 θ_c. Cases are "
            "named by r_c in per cent of the radius."
        )
        return ReportTable(head, tuple(rows), note) if rows else None

    def hopper_table(self) -> ReportTable | None:
        """Pressures on the hopper; None if there is none."""
        rows = [
            (f"{row['above_outlet_m']:.4g}",
             *(kPa(row[f"{state}_{part}_Pa"]) for state in STATES for part in ("normal", "friction", "vertical")))
            for row in self.hopper_rows
        ]  # fmt: skip
        parts = ("p_n", "p_t", "p_v")
        head = ("above the outlet (m)", *(f"{state} {part}" for state in STATES for part in parts))
        note = (
            "kPa: normal to the hopper's wall, friction along it, mean vertical pressure in the solid; lower μ_h and K "
            "(6.1.1, 6.3, 6.4; table 3.1)."
        )
        return ReportTable(head, tuple(rows), note) if rows else None

    def as_json(self) -> dict:
        """Everything as numbers, units in the names."""
        silo, bottom = self.silo, self.bottom
        values = {load: vars(silo.values(load)) | {"depth_scale_m": silo.depth_scale_m(load)} for load in TABLE_3_1}
        found: dict = {
            "solid": vars(silo.solid), "wall": silo.wall, "action_class": silo.action_class,
            "slenderness": silo.slenderness, "surface_depth_m": silo.surface_depth_m, "values": values,
            "discharge_factors": list(silo.discharge_factors), "table": self.frame.to_dict("records"),
            "cases": {one.name: one.clause for one in self.cases}, "patches": [vars(one) for one in self.patches],
            "channels": [
                {"radius_share": one.radius_share, "contact_deg": one.contact_deg} for one in self.channels
            ],
            "bottom": None, "hopper": self.hopper_rows, "notes": self.notes,
        }  # fmt: skip
        if bottom is not None:
            found["bottom"] = {
                "kind": bottom.kind, "load_factor": bottom.load_factor, "transition_Pa": bottom.transition_Pa,
                "floor_Pa": bottom.floor_Pa if bottom.kind == "flat" else None, "flow": flow_pattern(bottom),
            }  # fmt: skip
        return found
