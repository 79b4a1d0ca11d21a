"""What one point gives to its nodes, what one node does with it, and what one point takes back.

Formulas only; the loops over points and nodes are in solver.py.
"""

import taichi as ti

from taichi_silo.grid import MARGIN
from taichi_silo.laws import integrate
from taichi_silo.maths import growth
from taichi_silo.tensors import norm


@ti.func
def weights(grid: ti.template(), shape: ti.template(), place):
    """First node (flat index), weights and gradients [1/m] of a point along both axes."""
    ix, sx, gx = shape.axis(place[0] / grid.cell_size)
    iy, sy, gy = shape.axis(place[1] / grid.cell_size)
    # a point that has gone astray (the guard will stop the run) must not write outside the grid
    i = ti.max(0, ti.min(ti.cast(ix, ti.i32) + MARGIN, grid.columns - shape.NODES))
    j = ti.max(0, ti.min(ti.cast(iy, ti.i32) + MARGIN, grid.rows - shape.NODES))
    return j * grid.columns + i, sx, gx, sy, gy


@ti.func
def scatter(particles: ti.template(), grid: ti.template(), shape: ti.template(), p, offset, shared: ti.template()):
    """Particles to grid: mass, momentum and internal force of point p.

    `offset` picks a copy of the sums; `shared` says that other threads add to the same copy.
    """
    first, sx, gx, sy, gy = weights(grid, shape, particles.position[p])
    m = particles.mass[p]
    mv = m * particles.velocity[p]
    stress = particles.stress[p]
    volume = particles.volume[p]
    per_metre = 1.0 / grid.cell_size
    txx, tyy, txy = -volume * stress[0] * per_metre, -volume * stress[1] * per_metre, -volume * stress[3] * per_metre
    for b in ti.static(range(shape.NODES)):
        for a in ti.static(range(shape.NODES)):
            k = offset + first + b * grid.columns + a
            s, dx, dy = sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]
            force = ti.Vector([txx * dx + txy * dy, txy * dx + tyy * dy])
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
    frame = ti.Vector([0.0, step.frame_velocity])
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
                base = frame if ti.static(wall.moves) else 0.0 * frame
                free = new
                new = base + wall.contact.touch(free - base, wall.normal())
                books.reaction[number, wall.slot(i, j)] += m * (new - free)
        grid.velocity[k] = new
        grid.change[k] = new - old
        if ti.static(control.drag > 0.0):
            grid.memory[k] += step.dt / control.memory_time * (new - grid.memory[k])
    else:
        grid.memory[k] = frame


@ti.func
def gather(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), law: ti.template(), control: ti.template(),
    p, step,
):  # fmt: skip
    """Grid to particles: velocity, position, then stress and volume of point p (stress last)."""
    first, sx, gx, sy, gy = weights(grid, shape, particles.position[p])
    v = ti.Vector([0.0, 0.0])
    dv = ti.Vector([0.0, 0.0])
    lx = ti.Vector([0.0, 0.0])  # dv/dx
    ly = ti.Vector([0.0, 0.0])  # dv/dy
    for b in ti.static(range(shape.NODES)):
        for a in ti.static(range(shape.NODES)):
            k = first + b * grid.columns + a
            node, change = grid.velocity[k], grid.change[k]
            s = sx[a] * sy[b]
            v += s * node
            dv += s * change
            lx += gx[a] * sy[b] * node
            ly += sx[a] * gy[b] * node
    lx /= grid.cell_size
    ly /= grid.cell_size
    moved = particles.velocity[p] + dv  # FLIP: only the change is taken, so nothing is smeared
    if ti.static(control.relaxation > 0.0):
        moved += control.relaxation * step.dt * (v - moved)
    particles.velocity[p] = moved
    particles.position[p] += step.dt * (v - ti.Vector([0.0, step.frame_velocity]))

    zero = 0.0 * lx[0]
    D = (lx[0], ly[1], zero, 0.5 * (ly[0] + lx[1]))
    spin = 0.5 * (ly[0] - lx[1])
    length = norm(D)
    volume = particles.volume[p]
    void_ratio = volume * law.grain_density / particles.mass[p] - 1.0
    old = particles.stress[p]
    s0, s1, s2, s3, _ = integrate.update(
        law, (old[0], old[1], old[2], old[3]), void_ratio, D, spin, length, step.dt
    )  # fmt: skip
    particles.stress[p] = ti.Vector([s0, s1, s2, s3])
    particles.volume[p] = volume * growth((D[0] + D[1]) * step.dt)
    particles.path[p] += length * step.dt
