"""From a scene to its history: fill the silo, let it settle, let it flow."""

import dataclasses
import math
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np

from taichi_silo.mpm import runtime
from taichi_silo.mpm.noise_control import NoiseControl
from taichi_silo.scene import known_limits, likely_units
from taichi_silo.scene.scene import Scene
from taichi_silo.simulation import filling, gates, outflow, restart, wall_friction
from taichi_silo.simulation.alarm import Alarms
from taichi_silo.simulation.clock import Clock, Interval
from taichi_silo.simulation.discharge import Discharge
from taichi_silo.simulation.discretise import discretise
from taichi_silo.simulation.record import Record
from taichi_silo.simulation.views import Views

STEP_SAFETY = 0.95  # of the stable step, which changes within an interval
EXIT = 1.1  # cells below the floor: at most an eighth of the weight of sand there is still on the row of the floor


class Simulation(Views):
    """The silo of a scene, ready to be filled; Taichi has been started.

    Iterate over `run()`: it yields a `Record` after each interval. Observers look at the public attributes in between;
    there it can be left (`state`), and go on in another process (`restore`).

    Parameters
    ----------
    scene : what to simulate.
    control : noise control; that of the scene if absent.

    Attributes
    ----------
    model : points, grid, walls, law and scales of time.
    clock : where the simulation stands.
    solver : what steps the points.
    filling : how far the filling has come.
    discharge : what has left; None where the whole floor sinks and nothing does.
    identity : of the points, their indices in the fill.
    alarms : what has been found wrong.
    warnings : sentences on what is known, and what observers find.

    """

    def __init__(self, scene: Scene, control: NoiseControl | None = None):
        self.model = model = discretise(scene, control)
        self.clock, self.filling = Clock(), filling.Progress()
        self.warnings, self.alarms = known_limits.of_method(scene) + likely_units.of_scene(scene), Alarms()
        self.discharge = None
        if scene.silo.has_opening:
            self.discharge = Discharge(model.particles, -EXIT * scene.grid.cell_size_m, model.openings, model.spacing)
        self.identity = np.arange(model.particles.count, dtype=np.int32)
        self._fill: dict[str, np.ndarray] = {}  # while sand is poured
        self.sums: SimpleNamespace | None = None  # over the points at the last record,
        self.sums_revision: int | None = None  # and which revision of the points that was
        self._held = -1, 0.0  # a revision of the points, and their mass
        self.solver = model.solver(model.control)
        if why := self.solver.simd_refused:
            slower = "Steps take two to four times as long."
            self.warnings.append(f"The processor's vector unit is not used: {why}. {slower}")
        self.solver.advance(0, 1.0)  # compiles

    # --- stages ---------------------------------------------------------------------------------------------------

    def run(self) -> Iterator[Record]:
        """Fill, settle and flow; yields a Record after each interval."""
        yield from self.fill()
        yield from self.flow()

    def fill(self) -> Iterator[Record]:
        """Get the sand in, then rest until the wall force no longer changes; from where the simulation stands."""
        if self.clock.stage != "filling":
            return
        model, done = self.model, self.filling
        for interval in filling.intervals(model, done.intervals):
            record = self.advance(interval)
            done.intervals += 1
            yield record
        self._fill = {}
        longest = math.ceil(filling.longest_rest(model.scene, model.period) / model.interval)
        while done.rest < longest and not self.clock.settled:
            record = self.advance(Interval(model.interval))
            two_periods = 2 * model.scene.output.records_per_period
            self.clock.settled = done.at_rest(float(record.normal_N_per_m), two_periods)
            yield record

    def flow(self) -> Iterator[Record]:
        """Lower the bottom or the gate, or open the gate; from where the simulation stands."""
        if self.clock.stage == "filling":
            self.clock.begin_flow()
        self._use(outflow.control(self.model))
        while not self.clock.finished:
            interval = outflow.next_interval(self.model, self.clock, self.sums.speed if self.sums else 0.0)
            if interval is None:
                self.clock.finished = True
                self._note_end()
            else:
                yield self.advance(interval)

    def _note_end(self) -> None:
        """Note why a free outflow has ended, and warn of one, or of a driven one, that has jammed."""
        if self.discharge is None or self.scene.flow.outflow == "collapse":
            return
        if self.scene.flow.outflow == "controlled":
            since = self.model.section.factor * (self.discharge.passed - self.discharge.noted)
            words, jammed = outflow.lags(self.model, self.clock, self.discharged, since)
        else:
            self.clock.ended = outflow.why_ended(self.model, self.clock)
            rests = self.clock.ended == "rest"
            words = outflow.jam(self.model, self.above_opening / self.model.mass) if rests else ""
            jammed = bool(words)
        if jammed:
            self.clock.ended = "jam"
        if words:
            self.warnings.append(words)

    def advance(self, interval: Interval) -> Record:
        """Compute an interval."""
        model, clock, solver, duration = self.model, self.clock, self.solver, interval.duration
        gravity = interval.gravity or (model.gravity, model.gravity)
        if interval.poured is not None:
            self._pour(interval.poured, interval.above)
        if model.gates is not None and interval.gates:
            model.gates.move(interval.gates)
            if interval.gate_is_open and self.discharge is not None:  # a gate that closes cuts the sand that falls
                self._keep(self.discharge.shut(np.array(interval.gates) == 0.0))
        before = self.sums
        if before is None or self.sums_revision != model.particles.revision:
            before = solver.point_sums()
        if model.scene.walls.bands and model.scene.silo.floor_is_outlet:  # they stand still while the grid sinks
            wall_friction.place(model.walls, model.scene.walls, model.grid, self.origin_m + 0.5 * interval.travel)
        steps, clock.step = self._steps(interval, before)
        held = self.held_mass
        stage = "start" if clock.stage == "flow" and interval.hastens else clock.stage
        begun = runtime.seconds()
        solver.advance(steps, clock.step, gravity, interval.plate_velocity, stage)
        runtime.wait()
        clock.stepping_seconds += runtime.seconds() - begun
        impulse, control, after = solver.record()
        self.sums, self.sums_revision = after, model.particles.revision
        if after.strays:
            self.alarms.enter(self._astray(after.strays), clock)
        clock.time += duration
        clock.steps += steps
        self._let_go()
        if model.scene.flow.outflow == "collapse":
            clock.displacement = outflow.run_out(model) if clock.stage == "flow" else 0.0
        elif interval.gate_is_open:
            clock.displacement = self.discharged / (model.density * model.scene.silo.outlet_share_m)
        else:
            clock.displacement -= interval.travel
        columns, profile = model.wall_forces.read(impulse, duration)
        factor, mean_gravity = model.section.factor, 0.5 * (gravity[0] + gravity[1])
        lift, travel = factor * (after.height - before.height), 0.0 if interval.gate_is_open else interval.travel
        if model.scene.silo.floor_is_outlet:  # heights are above the bottom, which moves
            lift += held * travel
        return Record(
            time_s=clock.time,
            stage=clock.stage,
            displacement_m=clock.displacement,
            interval_s=duration,
            **columns,
            weight_N_per_m=held * mean_gravity,
            momentum_rate_N_per_m=factor * (after.momentum - before.momentum) / duration,
            noise_control_force_N_per_m=factor * control[:, 1].sum() / duration,
            kinetic_energy_J_per_m=factor * after.kinetic_energy,
            kinetic_gain_J_per_m=factor * (after.kinetic_energy - before.kinetic_energy),
            work_J_per_m=model.wall_forces.push(impulse, model.gate_shares(interval.gates)) / duration * travel
            - mean_gravity * lift,
            stored_J_per_m=factor * (after.stored + solver.surfaces.stored_J(clock.step)),
            time_step_s=clock.step,
            stable_step_s=after.stable_step,
            void_ratio_low=after.void_ratio_low,
            void_ratio_high=after.void_ratio_high,
            separated=model.section.points_per_computed * after.separated,
            strays=after.strays,
            speed_m_per_s=after.speed,
            profile=profile,
            discharged_kg_per_m=self.discharged,
            **self._outlets(interval, impulse),
        )

    def _steps(self, interval: Interval, sums: SimpleNamespace) -> tuple[int, float]:
        """Number and length [s] of the steps of an interval that begins with points of these sums."""
        method = self.model.scene.method
        step = method.time_step(sums, STEP_SAFETY)
        if method.time_step_s is None:
            step = min(interval.growth * step, interval.longer * self.clock.step)
        steps = max(1, math.ceil(interval.duration / step - 1e-9))
        return steps, interval.duration / steps

    def _use(self, control: NoiseControl) -> None:
        """From now on step with this noise control; surfaces go on pressing as they did."""
        if control != self.solver.control:
            self.solver.executor.rest()
            pressing = self.solver.surfaces
            self.solver = self.model.solver(control)
            self.solver.surfaces.take_over(pressing)

    # --- sand that comes and goes -----------------------------------------------------------------------------------

    def _pour(self, chosen: np.ndarray, above: float) -> None:
        """Add points of the fill, given by their indices, so far above their place [m]."""
        particles = self.model.particles
        self.solver.executor.rest()
        self._fill = fill = self._fill or {n: values for n, values in self.model.fill().items() if n in particles.names}
        new = {name: values[chosen] for name, values in fill.items()}
        new["position"] = new["position"] + (0.0, above)
        first = self.filling.intervals == 0  # until then the whole fill is loaded
        there = {name: values[:0] for name, values in fill.items()} if first else particles.arrays()
        if "affine" in there:
            new["affine"] = np.zeros((len(chosen), 4))
        particles.load({name: np.concatenate([there[name], new[name]]) for name in there})
        self.identity = np.concatenate([self.identity[: len(there["mass"])], chosen.astype(np.int32)])

    def _outlets(self, interval: Interval, impulse: np.ndarray) -> dict:
        """What a record tells of each of several outlets."""
        model = self.model
        if model.gates is None:
            return {}
        first = len(model.walls) - 2 * len(model.openings)
        return {
            "gates": interval.gates or (0.0,) * len(model.openings),
            "gates_N_per_m": gates.forces(model.openings, impulse, first, interval.duration),
            "outlets_kg_per_m": self.outlets_kg_per_m,
        }

    @property
    def outlets_kg_per_m(self) -> tuple[float, ...]:
        """What has left by each opening since the start [kg/m]."""
        return tuple((self.model.section.factor * self.discharge.passed_each).tolist()) if self.discharge else ()

    def _keep(self, kept: np.ndarray | None) -> None:
        """Go on with the points that have stayed (n,); None: all have."""
        if kept is not None:
            self.identity = self.identity[kept]
            if self.solver.filter.BETWEEN_LAUNCHES:
                self.solver.filter.keep(kept)

    def _let_go(self) -> None:
        """Count what has passed the openings, and take out what has passed the exit; see whether a column spreads."""
        if self.clock.stage == "flow" and self.scene.flow.outflow == "collapse":
            if self.sums and outflow.spreads(self.model, self.sums.kinetic_energy):
                self.clock.left_at = self.clock.time
            return
        if self.discharge is None or self.clock.stage != "flow":
            return
        self._keep(self.discharge.take_out())
        a_point = self.model.mass / self.model.section.factor / self.model.particles.count
        if self.discharge.flows(a_point):
            self.clock.left_at = self.clock.time

    @property
    def held_mass(self) -> float:
        """Of the sand that is in the silo now [kg/m]."""
        particles = self.model.particles
        if self._held[0] != particles.revision:
            self._held = particles.revision, self.model.section.factor * float(particles.array("mass").sum())
        return self._held[1]

    @property
    def above_opening(self) -> float:
        """Mass of the sand that has not passed the opening's plane [kg/m]."""
        passing = self.model.section.factor * self.discharge.passing if self.discharge else 0.0
        return self.held_mass - passing

    @property
    def discharged(self) -> float:
        """Mass of the sand that has passed the opening's plane since the start [kg/m]."""
        return self.model.section.factor * self.discharge.passed if self.discharge else 0.0

    # --- state ----------------------------------------------------------------------------------------------------

    @property
    def scene(self) -> Scene:
        """What is simulated."""
        return self.model.scene

    @property
    def time(self) -> float:
        """Since the start of the filling [s]."""
        return self.clock.time

    @property
    def stage(self) -> str:
        """Either "filling" or "flow"."""
        return self.clock.stage

    @property
    def displacement(self) -> float:
        """Of the bottom or the gate, downwards [m]."""
        return self.clock.displacement

    def state(self) -> dict:
        """What it needs to go on from a record as if it had never been left: numbers, words, arrays, dictionaries.

        Arrays are the fields themselves where that is possible: what is kept of them must be copied.
        """
        self.solver.executor.rest()
        particles = self.model.particles
        kept = {
            "clock": dataclasses.asdict(self.clock) | {"seen": self.sums_revision, "loads": particles.revision},
            "filling": dataclasses.asdict(self.filling),
            "warnings": list(self.warnings),
            "alarms": self.alarms.state(),
            "after": vars(self.sums) if self.sums else None,
            "points": {name: particles.present(name) for name in particles.names} | {"identity": self.identity},
        }
        if self.discharge:
            kept["ledger"] = self.discharge.state()
        return kept | restart.state_of(self.solver)

    def restore(self, kept: dict) -> None:
        """Stand where a simulation of the same scene stood when its `state` was taken."""
        self.solver.executor.rest()
        clock, points = kept["clock"], dict(kept["points"])
        self.clock = Clock(
            **{field.name: clock[field.name] for field in dataclasses.fields(Clock) if field.name in clock}
        )
        self.filling = filling.Progress(**kept["filling"])
        self.warnings = list(dict.fromkeys([*kept["warnings"], *self.warnings]))
        self.alarms = Alarms(kept["alarms"])
        self.sums = SimpleNamespace(**kept["after"]) if kept["after"] else None
        self.sums_revision = clock["seen"]
        self.identity = points.pop("identity").astype(np.int32)
        self._use(self.model.control if self.clock.stage == "filling" else outflow.control(self.model))
        restart.restore(self.solver, kept, points, clock["loads"])
        self._held = -1, 0.0
        if self.discharge:
            self.discharge = dataclasses.replace(self.discharge, **kept["ledger"])
