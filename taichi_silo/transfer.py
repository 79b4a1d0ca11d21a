"""What one point gives to its nodes, what one node does with it, and what one point takes back.

Formulas only; the loops over points and nodes are in solver.py. `t` is the number of the thread: which copy of the
sums and of the grid's height it uses.
"""

import taichi as ti

from taichi_silo.grid import MARGIN
from taichi_silo.laws import integrate
from taichi_silo.maths import growth
from taichi_silo.tensors import shifted


@ti.func
def weights(grid: ti.template(), shape: ti.template(), place, t):
    """First column and row, weights, and gradients [1/m] of a point along both axes."""
    cell_height = grid.cell_height(t)
    ix, sx, gx = shape.axis(place[0] / grid.cell_size)
    iy, sy, gy = shape.axis(place[1] / cell_height)
    # a point that has gone astray (the guard will stop the run) must not write outside the grid
    i = ti.cast(ix, ti.i32) + MARGIN
    if ti.static(not grid.periodic):
        i = ti.max(0, ti.min(i, grid.columns - shape.NODES))
    j = ti.max(0, ti.min(ti.cast(iy, ti.i32) + MARGIN, grid.rows - shape.NODES))
    return i, j, sx, gx, sy, gy, 1.0 / grid.cell_size, 1.0 / cell_height


@ti.func
def scatter(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), setting: ti.template(), p, t,
    shared: ti.template(),
):  # fmt: skip
    """Particles to grid: mass, momentum and internal force of point p.

    `shared` says that other threads add to the same copy.
    """
    place = particles.position[p]
    i, j, sx, gx, sy, gy, per_dx, per_dy = weights(grid, shape, place, t)
    m = particles.mass[p]
    mv = m * particles.velocity[p]
    volume = particles.volume[p]
    stress = particles.stress[p]
    xx, yy, zz, xy = shifted((stress[0], stress[1], stress[2], stress[3]), setting.ambient_pressure)
    fx, fy, fxy, fyx = -volume * xx * per_dx, -volume * yy * per_dy, -volume * xy * per_dx, -volume * xy * per_dy
    for b in ti.static(range(shape.NODES)):
        for a in ti.static(range(shape.NODES)):
            k = t * grid.nodes + grid.node(i + a, j + b)
            s, dx, dy = sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]
            force = ti.Vector([fx * dx + fyx * dy, fxy * dx + fy * dy])
            if ti.static(setting.geometry.HOOP):
                force[0] -= volume * zz / place[0] * s
            if ti.static(shared):
                grid.mass[k] += s * m
                grid.momentum[k] += s * mv
                grid.force[k] += force
            else:
                grid.mass[k] = grid.mass[k] + s * m
                grid.momentum[k] = grid.momentum[k] + s * mv
                grid.force[k] = grid.force[k] + force


@ti.func
def integrate_node(
    grid: ti.template(), walls: ti.template(), control: ti.template(), books: ti.template(), down: ti.template(),
    i, j, step, shared: ti.template(),
):  # fmt: skip
    """Equation of motion of node (i, j), noise control and walls; empties the sums for the next step.

    `shared` says that other threads work on the same row.
    """
    k = j * grid.columns + i
    m, momentum, force = grid.mass[k], grid.momentum[k], grid.force[k]
    for copy in ti.static(range(1, grid.copies)):
        other = copy * grid.nodes + k
        m, momentum, force = m + grid.mass[other], momentum + grid.momentum[other], force + grid.force[other]
    if m > 0.0:
        for copy in ti.static(range(grid.copies)):
            other = copy * grid.nodes + k
            grid.mass[other] = 0.0
            grid.momentum[other] = ti.Vector([0.0, 0.0])
            grid.force[other] = ti.Vector([0.0, 0.0])
        old = momentum / m
        new = old + step.dt * (force / m + step.gravity * down)
        if ti.static(control.drag > 0.0 or control.filling_drag > 0.0):
            braking = -step.dt * (control.drag * (old - grid.memory[k]) + step.filling_drag * old)
            new += braking
            if ti.static(shared):
                books.control[j] += m * braking
            else:
                books.control[j] = books.control[j] + m * braking
        for number, wall in ti.static(enumerate(walls)):
            if wall.holds(i, j):
                base = step.plate_velocity * ti.Vector(wall.motion)
                free = new
                new = base + wall.contact.touch(free - base, wall.normal())
                books.reaction[number, wall.slot(i, j)] += m * (new - free)
        grid.velocity[k] = new
        grid.change[k] = new - old
        if ti.static(control.drag > 0.0):
            grid.memory[k] += step.dt / control.memory_time * (new - grid.memory[k])
    else:
        grid.memory[k] = grid.velocity_of_frame(step, j)


@ti.func
def move(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), control: ti.template(),
    setting: ti.template(), p, step, t,
):  # fmt: skip
    """Grid to particles: velocity and position of point p; returns its strain rate (4) and spin [1/s]."""
    place = particles.position[p]
    i, j, sx, gx, sy, gy, per_dx, per_dy = weights(grid, shape, place, t)
    v = ti.Vector([0.0, 0.0])
    dv = ti.Vector([0.0, 0.0])
    lx = ti.Vector([0.0, 0.0])  # dv/dx
    ly = ti.Vector([0.0, 0.0])  # dv/dy
    for b in ti.static(range(shape.NODES)):
        for a in ti.static(range(shape.NODES)):
            k = grid.node(i + a, j + b)
            node, change = grid.velocity[k], grid.change[k]
            s = sx[a] * sy[b]
            v += s * node
            dv += s * change
            lx += gx[a] * sy[b] * node
            ly += sx[a] * gy[b] * node
    lx *= per_dx
    ly *= per_dy
    hoop = 0.0 * lx[0]
    if ti.static(setting.geometry.HOOP):
        hoop = v[0] / place[0]
    moved = particles.velocity[p] + dv  # FLIP: only the change is taken, so nothing is smeared
    if ti.static(control.relaxation > 0.0):
        moved += control.relaxation * step.dt * (v - moved)
    particles.velocity[p] = moved
    particles.position[p] = place + step.dt * (v - grid.velocity_of_origin(step))
    return lx[0], ly[1], hoop, 0.5 * (ly[0] + lx[1]), 0.5 * (ly[0] - lx[1])


@ti.func
def respond(particles: ti.template(), law: ti.template(), p, D, spin, length, d_bar, dt):
    """Stress and volume of point p after a strain rate D of norm `length` and its non-local mean d_bar [1/s]."""
    volume = particles.volume[p]
    void_ratio = volume * law.grain_density / particles.mass[p] - 1.0
    old = particles.stress[p]
    zero = 0.0 * length
    h = ti.Vector([zero, zero, zero, zero])
    if ti.static(law.REMEMBERS):
        h = particles.intergranular[p]
    s0, s1, s2, s3, h0, h1, h2, h3, _ = integrate.update(
        law, (old[0], old[1], old[2], old[3]), (h[0], h[1], h[2], h[3]), void_ratio, D, spin, d_bar, dt
    )
    particles.stress[p] = ti.Vector([s0, s1, s2, s3])
    if ti.static(law.REMEMBERS):
        particles.intergranular[p] = ti.Vector([h0, h1, h2, h3])
    particles.volume[p] = volume * growth((D[0] + D[1] + D[2]) * dt)
    particles.path[p] += length * dt
