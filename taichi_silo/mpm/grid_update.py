"""What one node does with what the points have given it: equation of motion, noise control, walls.

    v_i = (m v)_i / m_i,   v_i += dt f_i / m_i + dt g,   then walls: v_i as far as contact lets it (paper, section 3.1)

Formulas only; the executors loop over the nodes.
"""

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.walls.contact import Frictionless, NoSlip

KEEPS_IN = Frictionless()  # what a wall does where it does not bear
STICKS = NoSlip()  # and a gate with what has passed it


@ti.func
def velocity_of_wall(wall: ti.template(), step, i, j):
    """Of a wall at node (i, j), (x, y) [m/s]."""
    x, y = step.plate_velocity * wall.motion[0], step.plate_velocity * wall.motion[1]
    if ti.static(getattr(wall, "fade", 0.0) > 0.0):
        y += step.plate_velocity * wall.followed(j)
    if ti.static(getattr(wall, "own_time", False)):
        share = wall.gates.of(wall.gate)
        x, y = share * x, share * y
    return x, y


@ti.func
def held(wall: ti.template(), step, i, j, x, y):
    """The velocity (x, y) [m/s] of node (i, j) that its contact with a wall admits."""
    base_x, base_y = velocity_of_wall(wall, step, i, j)
    relative, normal = (x - base_x, y - base_y), wall.normal(i, j)
    free_x, free_y = wall.contact.touch(relative, normal)
    if ti.static(getattr(wall, "banded", False)):
        free_x, free_y = wall.bands.touch(relative, normal, wall.slot(i, j))
    if ti.static(getattr(wall, "bears_from", 0) > 0):  # noqa: SIM102 (compiled in or not)
        if j < wall.bears_from:
            free_x, free_y = KEEPS_IN.touch(relative, normal)
    if ti.static(getattr(wall, "carries", False)):  # noqa: SIM102 (compiled in or not)
        if wall.beyond(i, j) > 0:
            free_x, free_y = STICKS.touch(relative, normal)
    return base_x + free_x, base_y + free_y


@ti.func
def held_by_delayed_friction(
    wall: ti.template(), number: ti.template(), friction: ti.template(), step, i, j, k, m, x, y
):  # fmt: skip
    """As `held`, by wall `number`, whose friction on node k of mass m follows the normal force with a delay."""
    base_x, base_y = velocity_of_wall(wall, step, i, j)
    relative, normal = (x - base_x, y - base_y), wall.normal(i, j)
    along, sliding = (
        relative[0] * normal[0] + relative[1] * normal[1],
        relative[0] * normal[1] - relative[1] * normal[0],
    )
    pressed = wall.contact.coefficient * ti.max(along, 0.0)
    limit = friction.of_node(number, k, m * pressed, sliding, step.dt)
    free_x, free_y = wall.contact.slow(relative, normal, along, limit / m)
    return base_x + free_x, base_y + free_y


@ti.func
def motion_of_node(
    grid: ti.template(), walls: ti.template(), surfaces: ti.template(), friction: ti.template(),
    control: ti.template(), impulses: ti.template(), down: ti.template(), i, j, step, m, old, push,
):  # fmt: skip
    """Velocity (x, y) [m/s] after the step of a node of mass m > 0 [kg/m], velocity `old` and acceleration `push`.

    In this order: internal force and gravity, surfaces, noise control, walls.
    """
    k = j * grid.columns + i
    x = old[0] + step.dt * (push[0] + step.gravity * down[0])
    y = old[1] + step.dt * (push[1] + step.gravity * down[1])
    if ti.static(surfaces.ACTIVE):
        pressed_x, pressed_y = surfaces.press_on(impulses, k, j, step.dt)
        x, y = x + step.dt / m * pressed_x, y + step.dt / m * pressed_y
    if ti.static(control.drag > 0.0 or control.filling_drag > 0.0):
        recent_x, recent_y = grid.recent_velocity(step, j, k, m)
        braking_x = step.dt * (step.drag * (recent_x - old[0]) - step.filling_drag * old[0])
        braking_y = step.dt * (step.drag * (recent_y - old[1]) - step.filling_drag * old[1])
        x, y = x + braking_x, y + braking_y
        impulses.add_damping(j, k, (m * braking_x, m * braking_y))
    for number, wall in ti.static(enumerate(walls)):
        if wall.holds(i, j):
            free_x, free_y = x, y
            if ti.static(friction.ACTIVE and getattr(wall.contact, "coefficient", 0.0) > 0.0):
                x, y = held_by_delayed_friction(wall, number, friction, step, i, j, k, m, free_x, free_y)
            else:
                x, y = held(wall, step, i, j, free_x, free_y)
            impulses.add_wall(number, wall.slot(i, j), k, (m * (x - free_x), m * (y - free_y)))
    if ti.static(control.drag > 0.0):
        grid.remember(k, step.dt / control.memory_time, m, (x, y))
    if ti.static(surfaces.ACTIVE):
        surfaces.note(k, m, x, y)
    return x, y


@ti.func
def pass_by(grid: ti.template(), surfaces: ti.template(), friction: ti.template(), k):
    """Node k has no sand in this step: it forgets."""
    grid.forget(k)
    friction.leave(k)
    if ti.static(surfaces.ACTIVE):
        surfaces.note(k, 0.0, 0.0, 0.0)


@ti.func
def integrate_node(
    nodes: ti.template(), grid: ti.template(), walls: ti.template(), surfaces: ti.template(), friction: ti.template(),
    control: ti.template(), impulses: ti.template(), down: ti.template(), i, j, step, last: ti.template(),
):  # fmt: skip
    """Equation of motion of node (i, j), from its sums, which are emptied for the next step.

    `nodes` is where the executor keeps sums and velocities; `last` says that nobody asks for the nodal mass afterwards.
    """
    m, px, py, fx, fy = nodes.read_sums(i, j, last)
    k = j * grid.columns + i
    if m > 0.0:
        per_m = 1.0 / m
        old, push = (px * per_m, py * per_m), (fx * per_m, fy * per_m)
        x, y = motion_of_node(grid, walls, surfaces, friction, control, impulses, down, i, j, step, m, old, push)
        nodes.write_velocity(k, x, y, old)
    else:
        pass_by(grid, surfaces, friction, k)


@ti.func
def second_velocity_of_node(grid: ti.template(), walls: ti.template(), i, j, step, last: ti.template()):
    """Set the `second_velocity` of node (i, j): momentum over mass, as far as the given walls let it.

    `last` says that nobody asks for the two sums afterwards.
    """
    k = j * grid.columns + i
    m, momentum = 0.0 * step.dt, 0.0 * grid.second_velocity[k]
    for copy in ti.static(range(grid.copies)):
        other = copy * grid.nodes + k
        m, momentum = m + grid.mass[other], momentum + grid.momentum[other]
        if ti.static(last):
            grid.mass[other] = 0.0
            grid.momentum[other] = ti.Vector([0.0, 0.0])
    if m > 0.0:
        x, y = momentum[0] / m, momentum[1] / m
        for wall in ti.static(walls):
            if wall.holds(i, j):
                x, y = held(wall, step, i, j, x, y)
        grid.second_velocity[k] = ti.Vector([x, y])
