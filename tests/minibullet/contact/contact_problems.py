"""One-step friction problems (W, q, mu) built from simple scenes, without the engine: the diet of the solver's tests.

A scene is a list of bodies (mass, inertia in world axes, centre) and of contacts (body, other body or None for the fixed world,
point, normal pointing into the first body). W = H^T M^-1 H and q = H^T (twist + gravity dt), as in a real step. Every maker takes
a NumPy generator, so that the same seed gives the same problem. Run as a script for a table of what the solver reaches.
"""

import sys
import time

import numpy as np

GRAVITY, TIME_STEP = 9.81, 1.0 / 240.0
STILL, UPRIGHT = np.zeros(6), np.eye(3)


class Scene:
    """Bodies and contacts; `problem` assembles (W, q, mu)."""

    def __init__(self):
        self.inverse_mass, self.inverse_inertia, self.centre, self.twist, self.contacts = [], [], [], [], []

    def body(self, mass, inertia, centre, twist=STILL):
        """Add a body; inertia (3,) along the axes or (3, 3). Returns its number."""
        inertia = np.diag(inertia) if np.ndim(inertia) == 1 else inertia
        self.inverse_mass.append(1.0 / mass)
        self.inverse_inertia.append(np.linalg.inv(inertia))
        self.centre.append(np.asarray(centre, dtype=float))
        self.twist.append(np.asarray(twist, dtype=float))
        return len(self.centre) - 1

    def box(self, size, centre, density=1000.0, mass=None, twist=STILL, axes=UPRIGHT):
        """Add a box of edge lengths `size`; the columns of `axes` are its axes in the world."""
        size = np.asarray(size, dtype=float)
        mass = density * size.prod() if mass is None else mass
        inertia = mass / 12.0 * (np.sum(size**2) - size**2)
        return self.body(mass, axes @ np.diag(inertia) @ axes.T, centre, twist)

    def ball(self, radius, centre, density=1000.0, twist=STILL):
        """Add a homogeneous ball."""
        mass = density * 4.0 / 3.0 * np.pi * radius**3
        return self.body(mass, np.full(3, 0.4 * mass * radius**2), centre, twist)

    def touch(self, body, other, point, normal):
        """Add one contact; normal points from `other` (None: fixed world) into `body`."""
        self.contacts.append((body, other, np.asarray(point, float), np.asarray(normal, float) / np.linalg.norm(normal)))

    def rest_on(self, body, other, low, high, z, count=2):
        """Upward contacts on a grid of count x count points of the rectangle low..high at height z."""
        for x in np.linspace(low[0], high[0], count):
            for y in np.linspace(low[1], high[1], count):
                self.touch(body, other, (x, y, z), (0.0, 0.0, 1.0))

    def problem(self, mu, gravity=GRAVITY, dt=TIME_STEP):
        """Dense W (3m, 3m), q (3m,) and mu (m,)."""
        m, n = len(self.contacts), len(self.centre)
        H, weighted, q = np.zeros((6 * n, 3 * m)), np.zeros((6 * n, 3 * m)), np.zeros(3 * m)
        twist = np.array(self.twist)
        twist[:, 2] -= gravity * dt
        for c, (body, other, point, normal) in enumerate(self.contacts):
            helper = np.eye(3)[np.argmin(np.abs(normal))]
            first = np.cross(normal, helper)
            first /= np.linalg.norm(first)
            frame = np.array([normal, first, np.cross(normal, first)]).T
            for who, sign in ((body, 1.0), (other, -1.0)):
                if who is not None:
                    arm = point - self.centre[who]
                    H[6 * who : 6 * who + 3, 3 * c : 3 * c + 3] = sign * frame
                    H[6 * who + 3 : 6 * who + 6, 3 * c : 3 * c + 3] = sign * np.cross(arm, frame.T).T
        for b in range(n):
            weighted[6 * b : 6 * b + 3] = self.inverse_mass[b] * H[6 * b : 6 * b + 3]
            weighted[6 * b + 3 : 6 * b + 6] = self.inverse_inertia[b] @ H[6 * b + 3 : 6 * b + 6]
        q = H.T @ twist.ravel()
        return H.T @ weighted, q, np.broadcast_to(np.asarray(mu, float), (m,)).copy()


def random_rotation(generator):
    """A random rotation matrix (3, 3)."""
    q, r = np.linalg.qr(generator.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0.0 else -q


def one_body(generator, count=5, mu=0.3, speed=1.0):
    """A box with count x count redundant contacts on the floor, moving and turning."""
    scene = Scene()
    size = generator.uniform(0.5, 2.0, 3)
    box = scene.box(size, (0.0, 0.0, size[2] / 2), twist=speed * generator.normal(size=6))
    scene.rest_on(box, None, -size[:2] / 2, size[:2] / 2, 0.0, count)
    return scene.problem(mu)


def curved_body(generator, count=25, mu=0.3, speed=1.0):
    """One body held at many points of its surface with scattered normals: contacts of an object in a bowl."""
    scene = Scene()
    body = scene.body(1.0, generator.uniform(0.3, 0.5, 3), np.zeros(3), speed * generator.normal(size=6))
    for direction in generator.normal(size=(count, 3)):
        direction[2] = -abs(direction[2])
        direction /= np.linalg.norm(direction)
        scene.touch(body, None, direction * generator.uniform(0.5, 1.5, 3), -direction + 0.2 * generator.normal(size=3))
    return scene.problem(mu)


def stack(generator, levels=10, mu=0.6, ratio=1.0, speed=0.0, count=2):
    """Cubes on one another, count x count contacts each; the top one weighs `ratio` times as much as the bottom one."""
    scene, below = Scene(), None
    for level in range(levels):
        mass = ratio ** (level / max(levels - 1, 1))
        twist = speed * generator.normal(size=6)
        centre = (*(0.02 * generator.normal(size=2)), level + 0.5)
        box = scene.box((1.0, 1.0, 1.0), centre, mass=mass, twist=twist)
        scene.rest_on(box, below, (-0.45, -0.45), (0.45, 0.45), float(level), count)
        below = box
    return scene.problem(mu)


def wall(generator, rows=10, columns=10, mu=0.6, speed=0.0, jammed=False):
    """Bricks in running bond, four contacts on each overlap; `jammed` adds the side faces between fixed abutments."""
    scene, previous = Scene(), []
    length, depth, height = 2.0, 1.0, 1.0
    for row in range(rows):
        current, shift = [], 0.5 * length * (row % 2)
        for column in range(columns - row % 2):
            left = column * length + shift
            twist = speed * generator.normal(size=6)
            brick = scene.box((length, depth, height), (left + length / 2, 0.0, row + 0.5), twist=twist)
            if row == 0:
                scene.rest_on(brick, None, (left, -0.5), (left + length, 0.5), 0.0)
            for other, start in previous:
                low, high = max(left, start), min(left, start) + length
                if high - low > 1e-9:
                    scene.rest_on(brick, other, (low, -0.5), (high, 0.5), float(row))
            if jammed:
                for other, x in ((current[-1][0] if current else None, left),):
                    for y in (-0.5, 0.5):
                        for z in (row, row + 1.0):
                            scene.touch(brick, other, (x, y, z), (1.0, 0.0, 0.0))
                if column == columns - row % 2 - 1:
                    for y in (-0.5, 0.5):
                        for z in (row, row + 1.0):
                            scene.touch(brick, None, (left + length, y, z), (-1.0, 0.0, 0.0))
            current.append((brick, left))
        previous = current
    return scene.problem(mu)


def arch(generator, blocks=20, mu=0.9, thickness=0.2, speed=0.0):
    """Semicircular voussoir arch, four contacts a joint, both feet on the fixed ground."""
    scene, before = Scene(), None
    angles = np.linspace(0.0, np.pi, blocks + 1)
    for k in range(blocks + 1):
        if k < blocks:
            middle = 0.5 * (angles[k] + angles[k + 1])
            radial, along = np.array([np.cos(middle), 0.0, np.sin(middle)]), np.array([-np.sin(middle), 0.0, np.cos(middle)])
            axes = np.array([radial, along, np.cross(radial, along)]).T
            size = (thickness, np.pi / blocks, 0.5)
            block = scene.box(size, radial, axes=axes, twist=speed * generator.normal(size=6))
        normal = np.array([-np.sin(angles[k]), 0.0, np.cos(angles[k])])
        for radius in (1.0 - thickness / 2, 1.0 + thickness / 2):
            for y in (-0.25, 0.25):
                point = (radius * np.cos(angles[k]), y, radius * np.sin(angles[k]))
                if k < blocks:
                    scene.touch(block, before, point, normal)
                else:
                    scene.touch(before, None, point, -normal)
        before = block
    return scene.problem(mu)


def tower(generator, levels=25, mu=0.3, speed=0.0):
    """Thin planks, three a level, crossing: nine crossings of four contacts between levels."""
    scene, previous = Scene(), []
    length, width, height = 0.12, 0.024, 0.008
    for level in range(levels):
        along = level % 2
        current = []
        for offset in (-0.048, 0.0, 0.048):
            size = np.array([length, width, height]) if along == 0 else np.array([width, length, height])
            centre = np.array([0.0, offset, 0.0]) if along == 0 else np.array([offset, 0.0, 0.0])
            centre[2] = (level + 0.5) * height
            plank = scene.box(size, centre, density=600.0, twist=speed * generator.normal(size=6))
            low, high = centre[:2] - size[:2] / 2, centre[:2] + size[:2] / 2
            if level == 0:
                scene.rest_on(plank, None, low, high, 0.0)
            for other, a, b in previous:
                scene.rest_on(plank, other, np.maximum(low, a), np.minimum(high, b), level * height)
            current.append((plank, low, high))
        previous = current
    return scene.problem(mu)


def ball_pile(generator, side=5, layers=5, mu=0.3, radius=1.0, speed=0.0, spread=0.02, dt=TIME_STEP):
    """Balls on a disturbed hexagonal packing in a box with floor and walls; contact where the gap is below 4 % of the radius."""
    scene, balls = Scene(), []
    step = 2.0 * radius
    for layer in range(layers):
        for row in range(side):
            for column in range(side):
                x = (column + 0.5 * ((row + layer) % 2)) * step
                y = (row * np.sqrt(3.0) / 2.0 + layer % 2 * np.sqrt(3.0) / 6.0) * step
                centre = np.array([x, y, radius + layer * np.sqrt(2.0 / 3.0) * step]) + spread * radius * generator.normal(size=3)
                twist = speed * generator.normal(size=6) / np.array([1.0, 1.0, 1.0, radius, radius, radius])
                balls.append((scene.ball(radius, centre, density=2500.0, twist=twist), centre))
    limits = np.array([c for _, c in balls])
    low, high = limits.min(axis=0) - radius, limits.max(axis=0) + radius
    for number, (ball, centre) in enumerate(balls):
        for other, place in balls[:number]:
            apart = centre - place
            if np.linalg.norm(apart) < 2.04 * radius:
                scene.touch(ball, other, 0.5 * (centre + place), apart)
        for axis in range(3):
            for wall_at, sign in ((low, 1.0), (high, -1.0)):
                if abs(centre[axis] - wall_at[axis]) < 1.04 * radius and not (axis == 2 and sign < 0):
                    point, normal = centre.copy(), np.zeros(3)
                    point[axis], normal[axis] = wall_at[axis], sign
                    scene.touch(ball, None, point, normal)
    return scene.problem(mu, dt=dt)


def rubble(generator, bodies=60, mu=0.7, points=2, neighbours=4, ratio=1.0, speed=0.3, asymmetry=0.0):
    """Irregular bodies in a heap: each touches near neighbours at several points with slightly different normals."""
    scene = Scene()
    side = max(int(np.ceil(bodies ** (1.0 / 3.0))), 1)
    centres = np.array([(k % side, k // side % side, k // side**2 + 0.5) for k in range(bodies)], dtype=float)
    centres += 0.25 * generator.uniform(-1.0, 1.0, centres.shape)
    for centre in centres:
        axes = random_rotation(generator)
        mass = ratio ** generator.uniform(-0.5, 0.5)
        scene.box(generator.uniform(0.5, 1.2, 3), centre, mass=mass, axes=axes, twist=speed * generator.normal(size=6))
    for number, centre in enumerate(centres):
        others = np.argsort(np.linalg.norm(centres[:number] - centre, axis=1), kind="stable")[:neighbours]
        places = [(int(o), centres[o]) for o in others]
        if centre[2] < 1.0:
            places.append((None, centre * (1.0, 1.0, 0.0) - (0.0, 0.0, centre[2])))
        for other, place in places:
            normal = (centre - place) / np.linalg.norm(centre - place)
            for _ in range(generator.integers(1, points + 1)):
                point = 0.5 * (centre + place) + 0.2 * generator.normal(size=3)
                scene.touch(number, other, point, normal + 0.1 * generator.normal(size=3))
    W, q, mu = scene.problem(mu)
    return W * (1.0 + asymmetry * generator.uniform(-1.0, 1.0, W.shape)), q, mu


def wedge(generator, mu=1.0, half_angle=0.3, load=1000.0, count=3):
    """A wedge jammed in a V of two fixed walls under a heavy block: friction alone could hold it, in many ways."""
    scene = Scene()
    block = scene.box((1.0, 1.0, 1.0), (0.0, 0.0, 0.5), mass=1.0, twist=0.1 * generator.normal(size=6))
    for sign in (-1.0, 1.0):
        for z in np.linspace(0.0, 1.0, count):
            for y in (-0.5, 0.5):
                normal = (-sign * np.cos(half_angle), 0.0, np.sin(half_angle))
                scene.touch(block, None, (sign * (0.2 + z * np.tan(half_angle)), y, z), normal)
    weight = scene.box((1.0, 1.0, 1.0), (0.0, 0.0, 1.5), mass=load, twist=(0.3, 0.0, -1.0, 0.0, 0.0, 0.0))
    scene.rest_on(weight, block, (-0.5, -0.5), (0.5, 0.5), 1.0)
    return scene.problem(mu)


def rods(generator, bodies=1, mu=2.0, speed=3.0):
    """Painleve rods: thin rods sliding on their lower end at 60 degrees, friction above the paradox."""
    scene = Scene()
    for k in range(bodies):
        angle = np.pi / 3.0 + 0.2 * generator.uniform(-1.0, 1.0)
        axis = np.array([np.cos(angle), 0.0, np.sin(angle)])
        across = np.array([-np.sin(angle), 0.0, np.cos(angle)])
        axes = np.array([axis, across, np.cross(axis, across)]).T
        centre = axis + (0.0, 3.0 * k, 0.0)
        rod = scene.box((2.0, 0.01, 0.01), centre, mass=1.0, axes=axes, twist=(speed, 0.0, 0.0, 0.0, generator.normal(), 0.0))
        scene.touch(rod, None, (0.0, 3.0 * k, 0.0), (0.0, 0.0, 1.0))
    return scene.problem(mu)


def two_cubes(generator, mu=0.8, speed=2.0):
    """One cube strikes another that stands on the ground: eight contacts, the hardest small problem for Gauss-Seidel."""
    scene = Scene()
    low = scene.box((1.0, 1.0, 1.0), (0.0, 0.0, 0.5), mass=1.0, twist=0.1 * generator.normal(size=6))
    mass = 10.0 ** generator.uniform(0, 4)
    high = scene.box((1.0, 1.0, 1.0), (0.2, 0.1, 1.5), mass=mass, twist=speed * generator.normal(size=6))
    scene.rest_on(low, None, (-0.5, -0.5), (0.5, 0.5), 0.0)
    scene.rest_on(high, low, (-0.3, -0.4), (0.5, 0.5), 1.0)
    return scene.problem(mu)


CLASSES = {
    "one body, 25 contacts": lambda g: one_body(g),
    "one body, 100 contacts": lambda g: one_body(g, count=10, mu=0.7),
    "one body in a bowl": lambda g: curved_body(g),
    "one body in a bowl, mu 1": lambda g: curved_body(g, count=60, mu=1.0),
    "two cubes": lambda g: two_cubes(g),
    "stack of 10": lambda g: stack(g),
    "stack of 50, struck": lambda g: stack(g, 50, speed=0.3),
    "stack, ratio 1e4": lambda g: stack(g, 5, ratio=1e4),
    "stack, ratio 1e6, struck": lambda g: stack(g, 10, ratio=1e6, speed=0.1),
    "stack, 16 contacts a face": lambda g: stack(g, 15, speed=0.1, count=4),
    "wall of 95": lambda g: wall(g),
    "wall of 95, struck": lambda g: wall(g, speed=0.5),
    "jammed wall": lambda g: wall(g, 6, 6, mu=0.9, speed=0.3, jammed=True),
    "arch of 20": lambda g: arch(g),
    "arch of 20, thin": lambda g: arch(g, thickness=0.108, speed=1e-3),
    "arch of 60, struck": lambda g: arch(g, 60, speed=0.2),
    "tower of planks": lambda g: tower(g, 17),
    "tower of planks, struck": lambda g: tower(g, 17, speed=0.1),
    "ball pile": lambda g: ball_pile(g),
    "ball pile, struck": lambda g: ball_pile(g, speed=0.5),
    "ball pile, 1 mm": lambda g: ball_pile(g, radius=1e-3, speed=0.05, mu=0.1, dt=1e-4),
    "ball pile, frictionless": lambda g: ball_pile(g, mu=0.0, speed=0.1),
    "rubble": lambda g: rubble(g),
    "rubble, mu 1, unsymmetric": lambda g: rubble(g, 100, mu=1.0, asymmetry=2.5e-3),
    "rubble, ratio 1e4": lambda g: rubble(g, ratio=1e4),
    "rubble, dense": lambda g: rubble(g, 40, points=6, neighbours=6, speed=0.1),
    "wedge": lambda g: wedge(g),
    "wedge, narrow": lambda g: wedge(g, half_angle=0.1, load=1e4),
    "rods": lambda g: rods(g, 10),
}


def table(solve, repeats=3, tolerance=1e-8, only=""):
    """Print share solved, residuals and times of `solve(W, q, mu)` -> (impulse, residual, iterations) for every class."""
    print(f"{'class':28s} contacts  solved  median    worst     time: median   worst [s]")
    for number, (name, make) in enumerate(CLASSES.items()):
        if only not in name:
            continue
        residuals, times = [], []
        for repeat in range(repeats):
            W, q, mu = make(np.random.default_rng((number, repeat)))
            start = time.perf_counter()
            residuals.append(solve(W, q, mu)[1])
            times.append(time.perf_counter() - start)
        share = np.mean(np.array(residuals) <= tolerance)
        print(
            f"{name:28s} {len(mu):8d}  {share:6.0%}  {np.median(residuals):.1e}   {max(residuals):.1e}   "
            f"{np.median(times):12.4f} {max(times):7.3f}",
            flush=True,
        )


if __name__ == "__main__":
    from minibullet.contact.exact import solve_contacts

    solve_contacts(np.eye(3), [-1.0, 1.0, 0.0], 0.5)  # compile
    table(solve_contacts, int(sys.argv[1]) if len(sys.argv) > 1 else 3, only=sys.argv[2] if len(sys.argv) > 2 else "")
