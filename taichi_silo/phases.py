"""What one point gives to its nodes, what one node does with it, and what one point takes back.

Formulas only; the loops over points and nodes, and their order, are in solver.py. `t` is the number of the thread:
which copy of the sums and of the grid's height it uses. `shared` says that other threads add to the same copy.
"""

import taichi as ti

from taichi_silo.grid import MARGIN
from taichi_silo.laws import integrate
from taichi_silo.maths import growth
from taichi_silo.tensors import shifted

TINY = 1e-9  # of a cell squared: less spread than this, and a point's affine velocity field has no slope


@ti.func
def domain_of(particles: ti.template(), shape: ti.template(), p, per_dx, per_dy):
    """The point's domain in cells; nothing for a shape without."""
    if ti.static(shape.DOMAIN):
        r = particles.domain[p]
        return r[0] * per_dx, r[1] * per_dy, r[2] * per_dx, r[3] * per_dy
    return 0.0 * per_dx, 0.0 * per_dx, 0.0 * per_dx, 0.0 * per_dx


@ti.func
def weights(particles: ti.template(), grid: ti.template(), shape: ti.template(), p, t, patch: ti.template()):
    """First column and row, weights, and gradients [1/m] (by two factors) of one patch of nodes of a point."""
    cell_height = grid.cell_height(t)
    per_dx, per_dy = 1.0 / grid.cell_size, 1.0 / cell_height
    place = particles.position[p]
    domain = domain_of(particles, shape, p, per_dx, per_dy)
    ix, sx, gx, iy, sy, gy = shape.patch(patch, place[0] / grid.cell_size, place[1] / cell_height, domain)
    # a point that has gone astray (the guard will stop the run) must not write outside the grid
    i = ti.cast(ix, ti.i32) + MARGIN
    if ti.static(not grid.periodic):
        i = ti.max(0, ti.min(i, grid.columns - shape.NODES))
    j = ti.max(0, ti.min(ti.cast(iy, ti.i32) + MARGIN, grid.rows - shape.NODES))
    return i, j, sx, gx, sy, gy, per_dx, per_dy


@ti.func
def arm(particles: ti.template(), grid: ti.template(), p, t, i, j):
    """From point p to node (i, j) [m]."""
    node = ti.Vector([(i - MARGIN) * grid.cell_size, (j - MARGIN) * grid.cell_height(t)])
    return node - particles.position[p]


@ti.func
def add(sums: ti.template(), k, value, shared: ti.template()):
    """Add to entry k of a sum."""
    if ti.static(shared):
        sums[k] += value
    else:
        sums[k] = sums[k] + value


@ti.func
def scatter(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), transfer: ti.template(),
    setting: ti.template(), p, t, motion: ti.template(), force: ti.template(), shared: ti.template(),
):  # fmt: skip
    """Particles to grid: mass and momentum (`motion`) and internal force (`force`) of point p."""
    place = particles.position[p]
    m = particles.mass[p]
    v = particles.velocity[p]
    volume = particles.volume[p]
    stress = particles.stress[p]
    xx, yy, zz, xy = shifted((stress[0], stress[1], stress[2], stress[3]), setting.ambient_pressure)
    for patch in ti.static(range(shape.PATCHES)):
        i, j, sx, gx, sy, gy, per_dx, per_dy = weights(particles, grid, shape, p, t, patch)
        fx, fy, fxy, fyx = -volume * xx * per_dx, -volume * yy * per_dy, -volume * xy * per_dx, -volume * xy * per_dy
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                k = t * grid.nodes + grid.node(i + a, j + b)
                s, dx, dy = sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]
                if ti.static(motion):
                    given = v
                    if ti.static(transfer.GRADIENT != "none"):
                        L, r = particles.affine[p], arm(particles, grid, p, t, i + a, j + b)
                        given = v + ti.Vector([L[0] * r[0] + L[1] * r[1], L[2] * r[0] + L[3] * r[1]])
                    add(grid.mass, k, s * m, shared)
                    add(grid.momentum, k, s * m * given, shared)
                if ti.static(force):
                    pull = ti.Vector([fx * dx + fyx * dy, fxy * dx + fy * dy])
                    if ti.static(setting.geometry.HOOP):
                        pull[0] -= volume * zz / place[0] * s
                    add(grid.force, k, pull, shared)


@ti.func
def integrate_node(
    grid: ti.template(), walls: ti.template(), control: ti.template(), books: ti.template(), down: ti.template(),
    i, j, step, last: ti.template(), shared: ti.template(),
):  # fmt: skip
    """Equation of motion of node (i, j), noise control and walls; empties the sums for the next step.

    `last` says that nobody asks for the nodal mass afterwards.
    """
    k = j * grid.columns + i
    m, momentum, force = grid.mass[k], grid.momentum[k], grid.force[k]
    for copy in ti.static(range(1, grid.copies)):
        other = copy * grid.nodes + k
        m, momentum, force = m + grid.mass[other], momentum + grid.momentum[other], force + grid.force[other]
    if m > 0.0:
        for copy in ti.static(range(grid.copies)):
            other = copy * grid.nodes + k
            if ti.static(last):
                grid.mass[other] = 0.0
            grid.momentum[other] = ti.Vector([0.0, 0.0])
            grid.force[other] = ti.Vector([0.0, 0.0])
        old = momentum / m
        new = old + step.dt * (force / m + step.gravity * down)
        if ti.static(control.drag > 0.0 or control.filling_drag > 0.0):
            braking = -step.dt * (control.drag * (old - grid.recent_velocity(step, j, k, m)) + step.filling_drag * old)
            new += braking
            add(books.control, j, m * braking, shared)
        for number, wall in ti.static(enumerate(walls)):
            if wall.holds(i, j):
                base = step.plate_velocity * ti.Vector(wall.motion)
                free = new
                new = base + wall.contact.touch(free - base, wall.normal())
                books.reaction[number, wall.slot(i, j)] += m * (new - free)
        grid.velocity[k] = new
        grid.change[k] = new - old
        if ti.static(control.drag > 0.0):
            grid.memory[k] += step.dt / control.memory_time * (m * ti.Vector([new[0], new[1], 1.0]) - grid.memory[k])
    else:
        grid.memory[k] = ti.Vector([0.0, 0.0, 0.0])


@ti.func
def echo_node(grid: ti.template(), walls: ti.template(), i, j, step, last: ti.template()):
    """The `echo` of node (i, j): momentum over mass, as far as the given walls let it.

    `last` says that nobody asks for the two sums afterwards.
    """
    k = j * grid.columns + i
    m, momentum = 0.0 * step.dt, 0.0 * grid.echo[k]
    for copy in ti.static(range(grid.copies)):
        other = copy * grid.nodes + k
        m, momentum = m + grid.mass[other], momentum + grid.momentum[other]
        if ti.static(last):
            grid.mass[other] = 0.0
            grid.momentum[other] = ti.Vector([0.0, 0.0])
    if m > 0.0:
        v = momentum / m
        for wall in ti.static(walls):
            if wall.holds(i, j):
                base = step.plate_velocity * ti.Vector(wall.motion)
                v = base + wall.contact.touch(v - base, wall.normal())
        grid.echo[k] = v


@ti.func
def at_point(particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), p, t):
    """A nodal field at point p."""
    value = ti.Vector([0.0, 0.0])
    for patch in ti.static(range(shape.PATCHES)):
        i, j, sx, _gx, sy, _gy, _dx, _dy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                value += sx[a] * sy[b] * field[grid.node(i + a, j + b)]
    return value


@ti.func
def echo_point(particles: ti.template(), grid: ti.template(), shape: ti.template(), p, t, value, shared: ti.template()):
    """A velocity of point p to the nodes, once more."""
    for patch in ti.static(range(shape.PATCHES)):
        i, j, sx, _gx, sy, _gy, _dx, _dy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                k = t * grid.nodes + grid.node(i + a, j + b)
                add(grid.momentum, k, particles.mass[p] * sx[a] * sy[b] * value, shared)


@ti.func
def gradient(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), geometry: ti.template(),
    p, t,
):  # fmt: skip
    """Gradient (xx, xy, yx, yy) of a nodal velocity at point p, and the strain rate around the axis [1/s]."""
    lx = ti.Vector([0.0, 0.0])  # dv/dx
    ly = ti.Vector([0.0, 0.0])  # dv/dy
    hoop = 0.0 * lx[0]
    for patch in ti.static(range(shape.PATCHES)):
        i, j, sx, gx, sy, gy, _dx, _dy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                node = field[grid.node(i + a, j + b)]
                lx += gx[a] * sy[b] * node
                ly += sx[a] * gy[b] * node
                if ti.static(geometry.HOOP):
                    hoop += sx[a] * sy[b] * node[0]
    lx /= grid.cell_size
    ly /= grid.cell_height(t)
    if ti.static(geometry.HOOP):
        hoop /= particles.position[p][0]
    return lx[0], ly[0], lx[1], ly[1], hoop


@ti.func
def affine_of(particles: ti.template(), grid: ti.template(), shape: ti.template(), p, t):
    """B D^-1 of the affine transfer: moments of the nodal velocity over those of the nodes' places [1/s]."""
    B = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
    D = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
    for patch in ti.static(range(shape.PATCHES)):
        i, j, sx, _gx, sy, _gy, _dx, _dy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                r = arm(particles, grid, p, t, i + a, j + b)
                s = sx[a] * sy[b]
                B += s * grid.velocity[grid.node(i + a, j + b)].outer_product(r)
                D += s * r.outer_product(r)
    least = TINY * grid.cell_size**2
    D[0, 0], D[1, 1] = D[0, 0] + least, D[1, 1] + least
    C = B @ D.inverse()
    return C[0, 0], C[0, 1], C[1, 0], C[1, 1]


@ti.func
def move(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), transfer: ti.template(),
    control: ti.template(), p, step, t,
):  # fmt: skip
    """Grid to particles: velocity and position of point p."""
    v = ti.Vector([0.0, 0.0])
    dv = ti.Vector([0.0, 0.0])
    for patch in ti.static(range(shape.PATCHES)):
        i, j, sx, _gx, sy, _gy, _dx, _dy = weights(particles, grid, shape, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                k = grid.node(i + a, j + b)
                s = sx[a] * sy[b]
                v += s * grid.velocity[k]
                dv += s * grid.change[k]
    echo = v
    if ti.static(transfer.ECHO):
        echo = at_point(particles, grid, shape, grid.echo, p, t)
    moved = transfer.carried(particles.velocity[p], v, dv, echo, step.dt)
    if ti.static(control.relaxation > 0.0):
        moved += control.relaxation * step.dt * (v - moved)
    if ti.static(transfer.GRADIENT == "affine"):
        a, b, c, d = affine_of(particles, grid, shape, p, t)
        particles.affine[p] = ti.Vector([a, b, c, d])
    particles.velocity[p] = moved
    particles.position[p] += step.dt * (v - grid.velocity_of_origin(step))


@ti.func
def deform(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), transfer: ti.template(), p, t, L, dt
):  # fmt: skip
    """The point's domain after a step of a velocity gradient, which it keeps for the nodes if the transfer asks."""
    xx, xy, yx, yy, _hoop = L
    if ti.static(transfer.GRADIENT == "strain"):
        particles.affine[p] = ti.Vector([xx, xy, yx, yy])
    if ti.static(shape.DOMAIN):
        dx, dy = grid.cell_size, grid.cell_height(t)
        domain = domain_of(particles, shape, p, 1.0 / dx, 1.0 / dy)
        a, b, c, d = shape.convected(domain, (xx * dt, xy * dt * dy / dx, yx * dt * dx / dy, yy * dt))
        particles.domain[p] = ti.Vector([a * dx, b * dy, c * dx, d * dy])


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
    # separated grains fly apart, but land as loosely packed sand, not as less
    most = (1.0 + law.loosest) * particles.mass[p] / law.grain_density
    particles.volume[p] = ti.min(volume * growth((D[0] + D[1] + D[2]) * dt), most)
    particles.path[p] += length * dt
