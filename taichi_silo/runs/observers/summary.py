"""What a run found, in one file: `summary.json`."""

import dataclasses
import json
import math
import time
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from taichi_silo.analysis.measure.matching import matched
from taichi_silo.analysis.measure.void_ratio_zones import interior_zone_count, wall_zone_thickness_m
from taichi_silo.analysis.measure.wall_pressure import cell_mean, clear_of_corner
from taichi_silo.runs.certificate import certificate
from taichi_silo.runs.collapse_findings import collapse_findings
from taichi_silo.runs.flow_findings import flow_findings
from taichi_silo.runs.janssen_findings import janssen_findings
from taichi_silo.runs.method_choices import parts
from taichi_silo.runs.observers import Observer
from taichi_silo.runs.observers.forces import rows_of
from taichi_silo.runs.observers.wall_profiles import WallProfiles
from taichi_silo.runs.result import at_rest, residual
from taichi_silo.runs.theories import theory_of
from taichi_silo.scene.outlets import Outlet
from taichi_silo.simulation import outflow
from taichi_silo.utils import atomic_write
from taichi_silo.utils.set_aside import SetAside

MEASURED = (0.9, 1.0)  # of the flow: between which its pattern is measured
# what is kept of the points: after filling, and of the two states between which the flow is measured
FILLED = ("position", "void_ratio", "mass", "path", "volume", "stress", "identity")
BEFORE = ("position", "volume", "identity")
LATER = ("position", "void_ratio", "mass", "path", "identity")
CERTIFIED = ("position", "void_ratio", "mass", "path", "identity")  # what the certificate needs of it,
AT_END = (*CERTIFIED, "stress")  # and of the last state
EARLY = 0.15  # of the sand: free outflow is measured until so much has left


class Summary(Observer):
    """Keeps what the certificate needs, and writes the file when the run ends, also when it failed.

    The force histories are read from their files, so that a long run needs no more memory than a short one; `profiles`
    is the observer that has written walls.csv by then.
    """

    def __init__(self, file: Path, profiles: WallProfiles):
        self.file, self.profiles = file, profiles
        self.failure: str | None = None
        self.found: dict = {}

    def begin(self, simulation) -> None:
        """Start the clock."""
        self.simulation, self.started = simulation, time.monotonic()
        self.after_filling: SetAside | None = None  # states of all points, as `_state` gives them
        self.before: SetAside | None = None
        self.mid: SetAside | None = None

    def state(self) -> dict:
        """All but the simulation."""
        kept = {name: getattr(self, name) for name in STATES}
        states = {name: state and state.kept for name, state in kept.items()}
        return states | {"seconds": time.monotonic() - self.started}

    def restore(self, simulation, kept: dict) -> None:
        """As it was."""
        self.simulation = simulation
        self.started = time.monotonic() - kept["seconds"]
        for name in STATES:
            setattr(self, name, None if kept[name] is None else SetAside(self.file.parent, kept[name]))

    def observe(self, record) -> None:
        """Keep the states between which the flow is measured."""
        if record.stage == "flow" and self.mid is None:
            part = self._part(record)
            if self.before is None and part >= MEASURED[0]:
                self.before = self._set_aside(*BEFORE)
            elif self.before is not None and part >= MEASURED[1]:
                self.mid = self._set_aside(*LATER)

    def _part(self, record) -> float:
        """How far the flow has come: of the displacement, or in free outflow of 15 % of the sand."""
        scene = self.simulation.scene
        if scene.flow.outflow == "collapse":  # which has no steady pattern
            return 0.0
        if scene.flow.free:
            return record.discharged_kg_per_m / (EARLY * self.simulation.model.mass)
        return record.displacement_m / scene.flow.displacement_m

    def filled(self) -> None:
        """Keep the state after filling."""
        self.after_filling = self._set_aside(*FILLED)

    def _set_aside(self, *fields: str) -> SetAside:
        return SetAside(self.file.parent, self._state(*fields))

    def _state(self, *fields: str) -> dict:
        """Fields of the points, all or those named, and when and where the bottom was."""
        simulation = self.simulation
        sunk = -simulation.origin_m
        out = simulation.displacement * simulation.scene.silo.outlet_share_m
        if simulation.model.gates is not None:  # which do not all sink as far
            out = simulation.discharged / simulation.model.density
        return simulation.points(*fields) | {
            "displacement_m": simulation.displacement, "time_s": simulation.time, "sunk_m": sunk, "left_m2": out,
        }  # fmt: skip

    def failed(self, why: str) -> None:
        """Say so in the file."""
        self.failure = why

    def end(self) -> None:
        """Write the file."""
        simulation, seconds = self.simulation, time.monotonic() - self.started
        found = {"finished": self.failure is None, "averaging": simulation.model.about_averaging}
        found["parts"] = [dataclasses.asdict(part) | {"key": part.key} for part in parts(simulation.scene)]
        if simulation.warnings:
            found["warnings"] = simulation.warnings
        if simulation.alarms.found:
            found["alarms"] = simulation.alarms.state()
        if self.failure is not None:
            found["failure"] = self.failure
        for what, measure in self._measures(found):
            try:
                found |= measure()
            except Exception as error:  # noqa: BLE001 - a measure that fails must not cost all others
                why = f"The {what} could not be measured: {type(error).__name__}: {error}."
                found["warnings"] = [*found.get("warnings", []), why]
        if simulation.discharge is not None:
            found["ledger"] = self._ledger()
        stepping, points = simulation.clock.stepping_seconds, simulation.model.particles.count
        found["cost"] = {
            "points": points,
            "steps": simulation.clock.steps,
            "time_step_s": simulation.time / max(simulation.clock.steps, 1),
            "seconds": stepping,
            "particle_steps_per_second": points * simulation.clock.steps / max(stepping, 1e-9),
            "wall_seconds": seconds,
        }
        self.found = found
        self._write()

    def tell_warnings(self) -> None:
        """Write the file once more, with warnings that came after it had been written."""
        if not self.found:
            return
        told = self.found.get("warnings", [])
        self.found["warnings"] = list(dict.fromkeys([*told, *self.simulation.warnings]))
        self._write()

    def _write(self) -> None:
        with atomic_write.written(self.file) as passing:
            passing.write_text(json.dumps(_without_nan(self.found), indent=2) + "\n", encoding="utf-8")

    def _measures(self, found: dict):
        """Name and function of each measure that the run has come far enough for; later ones use what is found."""
        simulation, folder = self.simulation, self.file.parent
        if simulation.clock.steps:
            records = cache(lambda: rows_of(folder))
            yield "forces", lambda: self._forces(records())
            yield "certificate", lambda: {"certificate": self._certificate(records())}
        if self.after_filling is not None and simulation.scene.flow.outflow == "collapse":
            yield "collapse", lambda: {"collapse": collapse_findings(folder)}
        elif self.after_filling is not None:
            yield "filling", lambda: {"janssen": self._janssen(found["filling"])}
            yield "theory", lambda: {"theory": self._theory(found["janssen"])}
            yield "shear zones", lambda: {"shear_zones": self._zones()}
            yield "wall stresses", lambda: {"largest_wall_normal_stress_Pa": self._wall_stresses()}
            yield "overpressure", self.profiles.overpressure
            yield "largest wall stresses", self.profiles.largest_in_flow
        if self.before is not None:
            yield "flow pattern", self._flow

    def _certificate(self, records: pd.DataFrame) -> dict:
        filled = self.after_filling.read(*CERTIFIED) if self.after_filling else None
        return certificate(records, filled, self._state(*AT_END), self.simulation)

    def _theory(self, janssen: dict) -> dict:
        angle_deg, ratio = janssen["wall_friction_angle_deg"], janssen["pressure_ratio_K0"]
        return theory_of(self.simulation.scene, angle_deg, ratio)

    def _flow(self) -> dict:
        simulation, filled = self.simulation, self.after_filling
        if filled is None or self.before is None:
            return {}
        found = flow_findings(
            filled.read("path", "void_ratio", "identity"), self.before.read(),
            self.mid.read() if self.mid else self._state(*LATER), simulation.scene,
        )  # fmt: skip
        if simulation.clock.ended == "jam" and not simulation.scene.flow.free:  # the sand did not follow the gate
            found = {name: value for name, value in found.items() if name not in OF_OUTFLOW}
        return found

    def _ledger(self) -> dict:
        """What has left, and whether the books close."""
        simulation = self.simulation
        gone, left, first = simulation.discharged, simulation.above_opening, simulation.model.mass
        found = {
            "discharged_kg_per_m": gone,
            "left_in_silo_kg_per_m": left,
            "error_over_first_mass": abs(gone + left - first) / first,
            **({"outflow_ended": simulation.clock.ended} if simulation.clock.ended else {}),
        }
        return found | ({} if simulation.model.gates is None else {"outlets": self._outlets()})

    def _outlets(self) -> list[dict]:
        """What has left by each of several outlets, and its mean rate while sand of the outflow left."""
        simulation, since = self.simulation, self.simulation.clock.flow_start
        seconds = 0.0 if since is None else simulation.time - since
        free, model = simulation.scene.flow.outflow == "gravity", simulation.model
        closing = 0.0 if free else outflow.start(simulation.scene, model.period)
        return [
            {
                "outlet": outlet.words(),
                "discharged_kg_per_m": mass,
                "mean_rate_kg_per_s_m": mass / open_s if (open_s := _open_s(outlet, seconds, closing)) else 0.0,
                "open_s": open_s,
            }
            for outlet, mass in zip(simulation.scene.silo.outlets, simulation.outlets_kg_per_m, strict=True)
        ]

    def _forces(self, records: pd.DataFrame) -> dict:
        """State after filling, peaks in flow (means over one period) and residual state."""
        period = self.simulation.scene.output.records_per_period
        filling, flow = records[records.stage == "filling"], records[records.stage == "flow"]
        weight = self.simulation.model.mass * self.simulation.model.gravity
        found = {"records": len(records), "weight_N_per_m": weight}
        if not filling.empty:
            found["filling"] = _means(at_rest(filling, period))
        if len(flow) < period:
            return found
        smooth = flow[list(NAMES.values())].rolling(period, center=True, min_periods=period).mean()
        found["peak"] = {}
        for name, extreme in (
            ("bottom_N_per_m", "min"), ("shear_N_per_m", "max"), ("normal_N_per_m", "max"),
            ("wall_friction_angle_deg", "max"),
        ):  # fmt: skip
            curve = smooth[NAMES[name]]
            where = getattr(curve, f"idx{extreme}")()
            found["peak"][f"{extreme}_{name}"] = {
                "value": float(curve[where]),
                "displacement_m": float(flow.displacement_m[where]),
            }
        found["residual"] = _means(residual(flow))
        return found

    def _janssen(self, filling: dict) -> dict:
        scene = self.simulation.scene
        above = self.profiles.after_filling_above(scene.silo.transition_m)
        points = self.after_filling.read("position", "stress", "volume") if self.after_filling else {}
        return janssen_findings(scene, filling, points, above)

    def _wall_stresses(self) -> dict:
        """Of each state, away from the corner: at one node, and as a pressure cell reads it."""
        walls, found, reading = pd.read_csv(self.profiles.file.absolute()), {}, self.profiles.reading
        for state, rows in walls[walls.wall.isin(["left", "right"])].groupby("state"):
            node, cell = 0.0, 0.0
            for _, wall in rows.groupby("wall"):
                height, stress = wall.height_m.to_numpy(), wall.normal_stress_Pa.to_numpy()
                inside = height > height[0] + reading.corner_m
                node = max(node, float(stress[inside].max(initial=0.0)))
                clear = clear_of_corner(height, reading)
                cell = max(cell, float(cell_mean(height, stress, reading.cell_m)[clear].max(initial=0.0)))
            found[state] = {"node": node, "pressure_cell": cell}
        return found

    def _zones(self) -> dict:
        scene, points = self.simulation.scene, self._state("position", "void_ratio", "identity")
        assert self.after_filling is not None
        filled = matched(self.after_filling.read("void_ratio", "identity"), points)
        position = points.pop("position") + [0.0, points["sunk_m"]]
        found: dict = {}
        for side in ("left", "right"):
            zone = wall_zone_thickness_m(
                position, points["void_ratio"], filled["void_ratio"], scene.silo.width_m, side=side
            )
            found[side] = {
                "thickness_m": zone.median_m,
                "lower_quartile_m": zone.lower_quartile_m,
                "upper_quartile_m": zone.upper_quartile_m,
                "contractant": zone.contractant,
            }
        interior = interior_zone_count(position, points["void_ratio"], scene.silo.width_m)
        found["interior_zones"] = {"count": interior.count, "height_m": [float(y) for y in interior.height_m]}
        return found


def _open_s(outlet: Outlet, seconds: float, closing_s: float) -> float:
    """For how long an outlet was not closed in an outflow of so many seconds, if its gate takes a time to close [s]."""
    end = math.inf if outlet.closes_at_s is None else outlet.closes_at_s + closing_s
    return max(0.0, min(seconds, end) - outlet.opens_at_s)


STATES = ("after_filling", "before", "mid")
OF_OUTFLOW = ("flow_pattern", "residence")  # which a flow that has jammed has not
NAMES = {  # in the summary, and in the records
    "bottom_N_per_m": "bottom_force_N_per_m", "normal_N_per_m": "normal_N_per_m", "shear_N_per_m": "shear_N_per_m",
    "wall_friction_angle_deg": "wall_friction_angle_deg",
}  # fmt: skip


def _without_nan(value):
    """JSON knows no NaN: null instead."""
    if isinstance(value, dict):
        return {key: _without_nan(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_without_nan(inner) for inner in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _means(rows: pd.DataFrame) -> dict:
    return {name: float(rows[column].mean()) for name, column in NAMES.items()}
