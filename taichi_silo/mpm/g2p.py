"""What one point gives to its nodes, what it takes back, and what it does with that; nodes are in nodes.py.

Formulas only; the loops over points and nodes are in loops.py and lanes.py, the order of the phases in solver.py. A
function with an argument `lanes` works on point p of the fields, or, in a kernel over lanes, on the eight points of
group p (see `Particles.read`); the others are of the plain loop. `t` is the number of the thread: which copy of the
sums and of the grid's height it uses. `shared` says that other threads add to the same copy.

Between a point and a node stand eight slots, each a sum of a value times a weight:

    weight          S     S            S             dS/dx       dS/dy
    point gives     mass  momentum (2) hoop force    force (2)   force (2)
    point takes     velocity (2), its change (2)     d/dx (2)    d/dy (2)
"""

import taichi as ti

from taichi_silo.mpm.grid import MARGIN
from taichi_silo.mpm.laws import integrate
from taichi_silo.mpm.tensors import shifted

TINY = 1e-9  # of a cell squared: less spread than this, and a point's affine velocity field has no slope


@ti.func
def add(sums: ti.template(), k, value, shared: ti.template()):
    """Add to entry k of a sum."""
    if ti.static(shared):
        sums[k] += value
    else:
        sums[k] = sums[k] + value


# --- a point and its nodes --------------------------------------------------------------------------------------------


@ti.func
def domain_of(particles: ti.template(), shape: ti.template(), lanes: ti.template(), p, per_dx, per_dy):
    """The point's domain in cells; nothing for a shape without."""
    if ti.static(shape.DOMAIN):
        ax, ay, bx, by = particles.read(lanes, "domain", p)
        return ax * per_dx, ay * per_dy, bx * per_dx, by * per_dy
    return 0.0 * per_dx, 0.0 * per_dx, 0.0 * per_dx, 0.0 * per_dx


@ti.func
def weights(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), lanes: ti.template(), p, t,
    patch: ti.template(),
):  # fmt: skip
    """First column, weights and derivatives along x, first row, the same along y, of one patch of nodes of a point.

    Columns and rows are whole numbers, but real; derivatives are per cell.
    """
    cell_height = grid.cell_height(t)
    per_dx, per_dy = 1.0 / grid.cell_size, 1.0 / cell_height
    x, y = particles.read(lanes, "position", p)
    domain = domain_of(particles, shape, lanes, p, per_dx, per_dy)
    i, sx, gx, j, sy, gy = shape.patch(patch, x * per_dx, y * per_dy, domain)
    i, j = i + MARGIN, j + MARGIN
    # a point that has gone astray (the guard will stop the run) must not write outside the grid
    if ti.static(not grid.periodic):
        i = ti.max(0.0, ti.min(i, grid.columns - shape.NODES))
    j = ti.max(0.0, ti.min(j, grid.rows - shape.NODES))
    return i, sx, gx, j, sy, gy


@ti.func
def point_contributions(
    particles: ti.template(), grid: ti.template(), surroundings: ti.template(), lanes: ti.template(), p, t
):
    """The eight slots that a point gives."""
    m, volume = particles.read(lanes, "mass", p), particles.read(lanes, "volume", p)
    vx, vy = particles.read(lanes, "velocity", p)
    xx, yy, zz, xy = shifted(particles.read(lanes, "stress", p), surroundings.ambient_pressure)
    hoop = 0.0 * volume
    if ti.static(surroundings.geometry.HOOP):
        x, _y = particles.read(lanes, "position", p)
        hoop = 0.0 - volume * zz / x
    bx, by = volume * (-1.0 / grid.cell_size), volume * (-1.0 / grid.cell_height(t))
    return m, m * vx, m * vy, hoop, bx * xx, bx * xy, by * xy, by * yy


@ti.func
def arm(particles: ti.template(), grid: ti.template(), p, t, i, j):
    """From point p to node (i, j) [m]."""
    node = ti.Vector([(i - MARGIN) * grid.cell_size, (j - MARGIN) * grid.cell_height(t)])
    return node - particles.position[p]


@ti.func
def scatter(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), transfer: ti.template(),
    surroundings: ti.template(), p, t, motion: ti.template(), force: ti.template(), shared: ti.template(),
):  # fmt: skip
    """Particles to grid: mass and momentum (`motion`) and internal force (`force`) of point p."""
    m, mvx, mvy, hoop, xx, xy, yx, yy = point_contributions(particles, grid, surroundings, 0, p, t)
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, gx, j, sy, gy = weights(particles, grid, shape, 0, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                column, row = ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b
                k = t * grid.nodes + grid.node(column, row)
                s, dx, dy = sx[a] * sy[b], gx[a] * sy[b], sx[a] * gy[b]
                if ti.static(motion):
                    given = ti.Vector([mvx, mvy])
                    if ti.static(transfer.GRADIENT != "none"):
                        L, r = particles.affine[p], arm(particles, grid, p, t, column, row)
                        given += m * ti.Vector([L[0] * r[0] + L[1] * r[1], L[2] * r[0] + L[3] * r[1]])
                    add(grid.mass, k, s * m, shared)
                    add(grid.momentum, k, s * given, shared)
                if ti.static(force):
                    add(grid.force, k, ti.Vector([s * hoop + dx * xx + dy * yx, dx * xy + dy * yy]), shared)


@ti.func
def gather(particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), p, t):
    """The eight slots that a point takes (velocity, change, and per cell the gradient of a nodal field); S field_x."""
    v, dv = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    along_x, along_y = ti.Vector([0.0, 0.0]), ti.Vector([0.0, 0.0])
    across = 0.0 * v[0]
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, gx, j, sy, gy = weights(particles, grid, shape, 0, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                k = grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)
                s, node = sx[a] * sy[b], field[k]
                v += s * grid.velocity[k]
                dv += s * grid.change[k]
                along_x += gx[a] * sy[b] * node
                along_y += sx[a] * gy[b] * node
                across += s * node[0]
    return v[0], v[1], dv[0], dv[1], along_x[0], along_x[1], along_y[0], along_y[1], across


@ti.func
def gradient_of(
    particles: ti.template(), grid: ti.template(), geometry: ti.template(), lanes: ti.template(), p, t, gathered
):
    """Gradient (xx, xy, yx, yy) of what `gather` took, and the strain rate around the axis [1/s]."""
    _vx, _vy, _dvx, _dvy, xx, yx, xy, yy, across = gathered
    per_dx, per_dy = 1.0 / grid.cell_size, 1.0 / grid.cell_height(t)
    hoop = 0.0 * xx
    if ti.static(geometry.HOOP):
        x, _y = particles.read(lanes, "position", p)
        hoop = across / x
    return xx * per_dx, xy * per_dy, yx * per_dx, yy * per_dy, hoop


@ti.func
def gradient(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), geometry: ti.template(),
    p, t,
):  # fmt: skip
    """Gradient (xx, xy, yx, yy) of a nodal velocity at point p, and the strain rate around the axis [1/s]."""
    return gradient_of(particles, grid, geometry, 0, p, t, gather(particles, grid, shape, field, p, t))


@ti.func
def at_point(particles: ti.template(), grid: ti.template(), shape: ti.template(), field: ti.template(), p, t):
    """A nodal field at point p."""
    value = ti.Vector([0.0, 0.0])
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, _gx, j, sy, _gy = weights(particles, grid, shape, 0, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                value += sx[a] * sy[b] * field[grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)]
    return value


@ti.func
def second_scatter(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), p, t, value, shared: ti.template()
):
    """A velocity of point p to the nodes, once more."""
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, _gx, j, sy, _gy = weights(particles, grid, shape, 0, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                k = t * grid.nodes + grid.node(ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b)
                add(grid.momentum, k, particles.mass[p] * sx[a] * sy[b] * value, shared)


@ti.func
def affine_of(particles: ti.template(), grid: ti.template(), shape: ti.template(), p, t):
    """B D^-1 of the affine transfer: moments of the nodal velocity over those of the nodes' places [1/s]."""
    B = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
    D = ti.Matrix([[0.0, 0.0], [0.0, 0.0]])
    for patch in ti.static(range(shape.PATCHES)):
        i, sx, _gx, j, sy, _gy = weights(particles, grid, shape, 0, p, t, patch)
        for b in ti.static(range(shape.NODES)):
            for a in ti.static(range(shape.NODES)):
                column, row = ti.cast(i, ti.i32) + a, ti.cast(j, ti.i32) + b
                r = arm(particles, grid, p, t, column, row)
                s = sx[a] * sy[b]
                B += s * grid.velocity[grid.node(column, row)].outer_product(r)
                D += s * r.outer_product(r)
    least = TINY * grid.cell_size**2
    D[0, 0], D[1, 1] = D[0, 0] + least, D[1, 1] + least
    C = B @ D.inverse()
    return C[0, 0], C[0, 1], C[1, 0], C[1, 1]


# --- the point itself -------------------------------------------------------------------------------------------------


@ti.func
def move(
    particles: ti.template(), grid: ti.template(), transfer: ti.template(), control: ti.template(),
    lanes: ti.template(), p, step, gathered, second,
):  # fmt: skip
    """Velocity and position of point p from what it took of the grid, and of the second."""
    vx, vy, dvx, dvy = gathered[0], gathered[1], gathered[2], gathered[3]
    old_x, old_y = particles.read(lanes, "velocity", p)
    new_x = transfer.carried(old_x, vx, dvx, second[0], step.dt)
    new_y = transfer.carried(old_y, vy, dvy, second[1], step.dt)
    if ti.static(control.relaxation > 0.0):
        new_x = new_x + control.relaxation * step.dt * (vx - new_x)
        new_y = new_y + control.relaxation * step.dt * (vy - new_y)
    particles.write(lanes, "velocity", p, (new_x, new_y))
    x, y = particles.read(lanes, "position", p)
    origin = grid.velocity_of_origin(step)
    particles.write(lanes, "position", p, (x + step.dt * (vx - origin[0]), y + step.dt * (vy - origin[1])))


@ti.func
def deform(
    particles: ti.template(), grid: ti.template(), shape: ti.template(), transfer: ti.template(), lanes: ti.template(),
    p, t, L, dt,
):  # fmt: skip
    """The point's domain after a step of a velocity gradient, which it keeps for the nodes if the transfer asks."""
    xx, xy, yx, yy, _hoop = L
    if ti.static(transfer.GRADIENT == "strain"):
        particles.write(lanes, "affine", p, (xx, xy, yx, yy))
    if ti.static(shape.DOMAIN):
        dx, dy = grid.cell_size, grid.cell_height(t)
        domain = domain_of(particles, shape, lanes, p, 1.0 / dx, 1.0 / dy)
        a, b, c, d = shape.convected(domain, (xx * dt, xy * dt * dy / dx, yx * dt * dx / dy, yy * dt))
        particles.write(lanes, "domain", p, (a * dx, b * dy, c * dx, d * dy))


@ti.func
def memory_of(particles: ti.template(), law: ti.template(), lanes: ti.template(), p):
    """The point's intergranular strain; nothing for a law that does not remember."""
    if ti.static(law.REMEMBERS):
        return particles.read(lanes, "intergranular", p)
    nothing = 0.0 * particles.read(lanes, "volume", p)
    return nothing, nothing, nothing, nothing


@ti.func
def respond(particles: ti.template(), law: ti.template(), lanes: ti.template(), p, D, spin, length, d_bar, dt):
    """Stress and volume of point p after a strain rate D of norm `length` and its non-local mean d_bar [1/s]."""
    volume, mass = particles.read(lanes, "volume", p), particles.read(lanes, "mass", p)
    void_ratio = volume * law.grain_density / mass - 1.0
    s0, s1, s2, s3, h0, h1, h2, h3, e = integrate.update(
        law, particles.read(lanes, "stress", p), memory_of(particles, law, lanes, p), void_ratio, D, spin, d_bar, dt
    )
    particles.write(lanes, "stress", p, (s0, s1, s2, s3))
    if ti.static(law.REMEMBERS):
        particles.write(lanes, "intergranular", p, (h0, h1, h2, h3))
    # separated grains fly apart, but land as loosely packed sand, not as less
    solid = mass * (1.0 / law.grain_density)
    particles.write(lanes, "volume", p, solid * (1.0 + ti.min(e, law.loosest)))
    particles.write(lanes, "path", p, particles.read(lanes, "path", p) + length * dt)
