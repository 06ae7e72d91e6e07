"""Closed solids as lists of triangles, each three points (x, y, z) in metres, counter-clockwise from outside."""

from math import acos, cos, hypot, pi, sin

Point = tuple[float, float, float]
Triangles = list[tuple[Point, Point, Point]]


def outward(triangles: Triangles) -> Triangles:
    """Without triangles that have no area; turned over if the enclosed volume is negative."""
    whole = [t for t in triangles if len(set(t)) == 3]
    volume = sum(
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        for a, b, c in whole
    )
    return whole if volume > 0 else [(a, c, b) for a, b, c in whole]


def moved(triangles: Triangles, x: float = 0, y: float = 0, z: float = 0) -> Triangles:
    return [tuple((p[0] + x, p[1] + y, p[2] + z) for p in t) for t in triangles]


def turned(triangles: Triangles, axis: str, degrees: float) -> Triangles:
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    c, s = cos(degrees * pi / 180), sin(degrees * pi / 180)

    def turn(p: Point) -> Point:
        q = list(p)
        q[i], q[j] = c * p[i] - s * p[j], s * p[i] + c * p[j]
        return tuple(q)

    return [tuple(turn(p) for p in t) for t in triangles]


def mirrored(triangles: Triangles) -> Triangles:
    """On the other side of the plane y = 0."""
    return [tuple((p[0], -p[1], p[2]) for p in (a, c, b)) for a, b, c in triangles]


def both_sides(triangles: Triangles) -> Triangles:
    return triangles + mirrored(triangles)


def loft(rings: list[list[Point]]) -> Triangles:
    """A skin over rings with the same number of points; the first and the last ring are closed."""
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(len(low)):
            j = (i + 1) % len(low)
            triangles += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    for ring, last in ((rings[0], False), (rings[-1], True)):
        middle = tuple(sum(p[k] for p in ring) / len(ring) for k in range(3))
        for i in range(len(ring)):
            j = (i + 1) % len(ring)
            triangles.append((middle, ring[i], ring[j]) if last else (middle, ring[j], ring[i]))
    return outward(triangles)


def oval(a: float, b: float, around: int, power: float = 2) -> list[tuple[float, float]]:
    """Points of a superellipse with half axes a and b: an ellipse for power 2, nearly a rectangle for a large power."""
    points = []
    for k in range(around):
        c, s = cos(2 * pi * (k + 0.5) / around), sin(2 * pi * (k + 0.5) / around)
        scale = (abs(c) ** power + abs(s) ** power) ** (-1 / power)
        points.append((a * c * scale, b * s * scale))
    return points


def along_z(sections: list[tuple[float, ...]], around: int = 10, power: float = 2) -> Triangles:
    """A loft of ovals in planes of constant z: entries (z, half axis along x, along y), and optionally the centre (x, y)."""
    rings = []
    for z, a, b, *middle in sections:
        x, y = middle or (0, 0)
        rings.append([(x + u, y + v, z) for u, v in oval(a, b, around, power)])
    return loft(rings)


def along_x(sections: list[tuple[float, ...]], around: int = 16, power: float = 6) -> Triangles:
    """A loft of ovals in planes of constant x: entries (x, half axis along y, along z, z of the centre)."""
    return loft([[(x, u, z + v) for u, v in oval(a, b, around, power)] for x, a, b, z in sections])


def lathe(profile: list[tuple[float, float]], around: int = 24) -> Triangles:
    """A surface of revolution about z; profile: (radius, z) from the bottom up, each end on the axis."""
    rings = [[(r * cos(2 * pi * i / around), r * sin(2 * pi * i / around), z) for i in range(around)] for r, z in profile]
    triangles = []
    for low, high in zip(rings, rings[1:]):
        for i in range(around):
            j = (i + 1) % around
            triangles += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    return outward(triangles)


def rounded(profile: list[tuple[float, float, float]]) -> list[tuple[float, float]]:
    """A profile with rounded corners: entries (radius, z, size of the corner)."""
    points = []
    for k, (r, z, size) in enumerate(profile):
        if size == 0:
            points.append((r, z))
            continue
        (r0, z0), (r1, z1) = profile[k - 1][:2], profile[k + 1][:2]
        before, after = hypot(r0 - r, z0 - z), hypot(r1 - r, z1 - z)
        a = (r + (r0 - r) * size / before, z + (z0 - z) * size / before)
        b = (r + (r1 - r) * size / after, z + (z1 - z) * size / after)
        n = 3
        points += [
            tuple((1 - s) ** 2 * p + 2 * s * (1 - s) * q + s**2 * t for p, q, t in zip(a, (r, z), b))
            for s in (i / n for i in range(n + 1))
        ]
    return points


def cylinder(radius: float, z0: float, z1: float, around: int = 16) -> Triangles:
    return lathe([(0, z0), (radius, z0), (radius, z1), (0, z1)], around)


def ball(a: float, b: float, c: float, around: int = 12) -> Triangles:
    """An ellipsoid with these half axes."""
    rows = around // 2
    unit = lathe([(sin(pi * k / rows), -cos(pi * k / rows)) for k in range(rows + 1)], around)
    return [tuple((a * p[0], b * p[1], c * p[2]) for p in t) for t in unit]


def box(low: Point, high: Point) -> Triangles:
    (x0, y0, z0), (x1, y1, z1) = low, high
    return loft([[(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)] for z in (z0, z1)])


def rod(start: Point, end: Point, radius: float, sides: int = 6) -> Triangles:
    along = [e - s for s, e in zip(start, end)]
    length = hypot(*along)
    x, y, z = (c / length for c in along)
    u = (y, -x, 0) if hypot(x, y) > 1e-3 else (1, 0, 0)
    u = tuple(c / hypot(*u) for c in u)
    v = (y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0])
    circle = [(radius * cos(2 * pi * k / sides), radius * sin(2 * pi * k / sides)) for k in range(sides)]
    return loft([[tuple(p[k] + a * u[k] + b * v[k] for k in range(3)) for a, b in circle] for p in (start, end)])


def triangulated(outline: list[tuple[float, float]]) -> list[tuple[int, int, int]]:
    """Triangles of a polygon without holes, counter-clockwise, by clipping ears."""

    def turn(a: int, b: int, c: int) -> float:
        (ax, ay), (bx, by), (cx, cy) = outline[a], outline[b], outline[c]
        return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)

    left, found = list(range(len(outline))), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            inside = (min(turn(a, b, p), turn(b, c, p), turn(c, a, p)) >= 0 for p in left if p not in (a, b, c))
            if turn(a, b, c) > 0 and not any(inside):
                break
        else:
            raise ValueError("the outline crosses itself")
        found.append((a, b, c))
        left.remove(b)
    return [*found, tuple(left)]


def plate(outline: list[tuple[float, float]], y0: float, y1: float) -> Triangles:
    """A polygon (x, z), in either direction, extruded along y."""
    if sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(outline, outline[1:] + outline[:1])) < 0:
        outline = outline[::-1]
    corners = triangulated(outline)
    triangles = []
    for y, last in ((y0, False), (y1, True)):
        at = [(x, y, z) for x, z in outline]
        triangles += [(at[a], at[c], at[b]) if last else (at[a], at[b], at[c]) for a, b, c in corners]
    for (x, z), (u, w) in zip(outline, outline[1:] + outline[:1]):
        triangles += [((x, y0, z), (u, y1, w), (u, y0, w)), ((x, y0, z), (x, y1, z), (u, y1, w))]
    return outward(triangles)


def link(length: float, r0: float, r1: float, width: float, bevel: float = 0.008, steps: int = 24) -> Triangles:
    """Two eyes about y, at the origin and at z = length, and the web between them: an outline with bevelled edges."""
    lean = acos((r0 - r1) / length)
    angles0 = [lean + (2 * pi - 2 * lean) * i / steps for i in range(steps + 1)]
    angles1 = [-lean + 2 * lean * i / steps for i in range(steps + 1)]

    def outline(y: float, shrink: float) -> list[Point]:
        far = [(sin(a) * (r1 - shrink), y, length + cos(a) * (r1 - shrink)) for a in angles1]
        return far + [(sin(a) * (r0 - shrink), y, cos(a) * (r0 - shrink)) for a in angles0]

    half = width / 2
    return loft([outline(-half, bevel), outline(-half + bevel, 0), outline(half - bevel, 0), outline(half, bevel)])


def indexed(triangles: Triangles) -> tuple[list[Point], list[list[int]]]:
    """Points without repetition, rounded to micrometres, and the triangles as numbers of these."""
    numbers: dict[Point, int] = {}
    corners = [[numbers.setdefault(tuple(round(c, 6) + 0.0 for c in p), len(numbers)) for p in t] for t in triangles]
    return list(numbers), corners
