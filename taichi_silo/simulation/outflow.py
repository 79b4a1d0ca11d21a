"""How the sand gets out of the silo: the bottom or a gate sinks at a given speed, or the gate is opened.

Each way is a generator of records over a simulation. What it knows at a record are attributes of the simulation, so it
can be left there and entered again.
"""

from taichi_silo.mpm.noise_control import NoiseControl

RAMP_PERIODS = 5  # the bottom reaches its speed over so many periods
OPENED = -20.0  # speed of a gate that sand cannot follow [m/s]
SHORT, LANDING = 0.5, 0.6  # of an interval and of a time step in free outflow: sand that lands is stiff at once
LONGER = 1.05  # at most, a step against that of the interval before: where sand has landed, more will
AT_REST_S = 0.25  # without outflow, after which a free flow has stopped


def flow(simulation):
    """The way that the scene asks for; yields a Record after each interval."""
    yield from fall(simulation) if simulation.scene.flow.outflow == "gravity" else sink(simulation)


def sink(simulation):
    """A smooth start over several periods, then constant speed."""
    target = simulation.scene.flow.displacement_m
    while simulation.displacement < target * (1.0 - 1e-12):
        duration, speed = simulation.interval, simulation.bottom_speed
        faster = speed_after(simulation, simulation.time + duration - simulation.flow_start)
        duration = min(duration, (target - simulation.displacement) / (0.5 * (speed + faster)))
        record = simulation.advance(duration, plate_velocity=(-speed, -faster))
        simulation.bottom_speed = faster
        yield record


def speed_after(simulation, since_start_s: float) -> float:
    """Of the bottom or the gate [m/s]."""
    part = min(since_start_s / (RAMP_PERIODS * simulation.period), 1.0)
    return simulation.scene.flow.speed_m_per_s * part * part * (3.0 - 2.0 * part)


def fall(simulation):
    """Free outflow until the flow has stopped, enough has left, or the time is over."""
    loosen(simulation)
    scene = simulation.scene
    reach = 0.5 * scene.grid.cell_size_m  # no sand may pass the exit by more within an interval
    end = simulation.flow_start + scene.flow.longest_s
    while (
        simulation.time < end
        and simulation.displacement < scene.flow.displacement_m
        and simulation.particles.active[None]
        and simulation.time - simulation.left_at < AT_REST_S
    ):
        fastest = simulation.after.speed + simulation.gravity * simulation.interval
        before, short = simulation.ledger.mass, SHORT * simulation.interval
        duration = min(short, reach / fastest)
        record = simulation.advance(duration, plate_velocity=(OPENED, OPENED), growth=LANDING, longer=LONGER)
        if simulation.ledger.mass > before:
            simulation.left_at = simulation.time
        yield record


def loosen(simulation) -> None:
    """Leave of the noise control only the relaxation: the drag towards the recent mean would brake what accelerates."""
    if simulation.solver.control.drag:
        pressing = simulation.solver.surfaces
        simulation.use(NoiseControl(relaxation=simulation.control.relaxation))
        simulation.solver.surfaces.take_over(pressing)
