"""What one node does with what the points have given it: equation of motion, noise control, walls.

    v_i = (m v)_i / m_i,   v_i += dt f_i / m_i + dt g,   then walls: v_i as far as contact lets it (paper, section 3.1)

Formulas only; the executors loop over the nodes.
"""

from taichi_silo.mpm.language import ti
from taichi_silo.mpm.simd.lane_maths import larger, total
from taichi_silo.mpm.simd.vectors import LANES, eight
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
def recalled(grid: ti.template(), step, j, m, memory):
    """The memory of a node of row j and of mass m; without sand it remembers the velocity of the frame."""
    frame = grid.velocity_of_frame(step, j)
    anew = memory[2] == 0.0
    return (
        ti.select(anew, m * frame[0], memory[0]), ti.select(anew, m * frame[1], memory[1]),
        ti.select(anew, m, memory[2]),
    )  # fmt: skip


@ti.func
def braking(step, m, old, memory):
    """Change (x, y) [m/s] by the noise control of the velocity `old` of a node of mass m.

    The recent velocity is mean momentum over mean mass, the latter at least the present one: so the wild velocity of a
    node that hardly any sand touched does not outlive that touch, and sand that lands is braked.
    """
    per_mass = 1.0 / larger(memory[2], m)
    return (
        step.dt * (step.drag * (memory[0] * per_mass - old[0]) - step.filling_drag * old[0]),
        step.dt * (step.drag * (memory[1] * per_mass - old[1]) - step.filling_drag * old[1]),
    )


@ti.func
def remembered(memory, share, m, x, y):
    """The memory after a share of the present mass m and velocity (x, y) has entered it."""
    return (
        memory[0] + share * (m * x - memory[0]), memory[1] + share * (m * y - memory[1]),
        memory[2] + share * (m - memory[2]),
    )  # fmt: skip


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
    memory = recalled(grid, step, j, m, grid.memory_of(k))
    if ti.static(control.brakes):
        braking_x, braking_y = braking(step, m, old, memory)
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
        grid.remember(k, remembered(memory, step.dt / control.memory_time, m, x, y))
    if ti.static(surfaces.ACTIVE):
        surfaces.note(k, m, x, y)
    return x, y


@ti.func
def integrate_eights(
    nodes: ti.template(), grid: ti.template(), control: ti.template(), impulses: ti.template(), down: ti.template(),
    first, count, j, step,
):  # fmt: skip
    """As `integrate_node`, for `count` times eight nodes of row j from column `first` on, which no wall holds."""
    impulse_x, impulse_y = eight(0.0), eight(0.0)
    for n in range(count):
        # so limited addresses are known not to overflow
        k = ti.max(0, ti.min(j * grid.columns + first + n * LANES, grid.nodes - LANES))
        m, px, py, fx, fy = nodes.read_eight_sums(k)
        some = ti.select(m > 0.0, m, eight(1.0))
        per_m = 1.0 / some
        old = px * per_m, py * per_m
        x = old[0] + step.dt * (fx * per_m + step.gravity * down[0])
        y = old[1] + step.dt * (fy * per_m + step.gravity * down[1])
        memory = recalled(grid, step, j, m, nodes.memories_of(k))
        if ti.static(control.brakes):
            braking_x, braking_y = braking(step, some, old, memory)
            x, y = x + braking_x, y + braking_y
            impulse_x, impulse_y = impulse_x + m * braking_x, impulse_y + m * braking_y
        if ti.static(control.drag > 0.0):
            a, b, c = remembered(memory, step.dt / control.memory_time, m, x, y)
            nodes.remember_eight(k, (a, b, ti.select(m > 0.0, c, eight(0.0))))
        nodes.write_eight_velocities(k, x, y, old)
    if ti.static(control.brakes):
        impulses.add_damping(j, j * grid.columns, (total(impulse_x), total(impulse_y)))


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
