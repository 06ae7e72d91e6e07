"""Machines and structures: excavator, wind turbine, crane, towers of a transmission line, motion platform."""

from math import cos, pi, sin

from solids import (
    Triangles,
    ball,
    both_sides,
    box,
    cylinder,
    along_x,
    lathe,
    link,
    loft,
    moved,
    oval,
    plate,
    rod,
    rounded,
    turned,
)

YELLOW, DARK, STEEL, GLASS = "#d09a33", "#3c4047", "#8b939e", "#33475c"


ROOT_RADIUS = 1.75  # of a blade (m)


def pin(x: float, z: float, width: float, radius: float = 0.06) -> Triangles:
    return rod((x, -width / 2, z), (x, width / 2, z), radius, 12)


def excavator() -> dict:
    ends = [(0.35 * sin(pi * k / 8), 0.35 * cos(pi * k / 8)) for k in range(9)]
    track = [(0.7 + x, 0.35 + z) for x, z in ends] + [(-2.1 - x, 0.35 - z) for x, z in ends]
    inner = [(0.7 + 0.75 * x, 0.35 + 0.75 * z) for x, z in ends] + [(-2.1 - 0.75 * x, 0.35 - 0.75 * z) for x, z in ends]
    tracks = both_sides(plate(track, 0.55, 1.0))
    for x in (-2.1, -1.4, -0.7, 0, 0.7):
        tracks += both_sides(rod((x, 1.0, 0.3), (x, 1.04, 0.3), 0.17, 12))
    frames = (
        both_sides(plate(inner, 0.5, 1.02))
        + box((-1.6, -0.55, 0.25), (0.2, 0.55, 0.55))
        + moved(cylinder(0.6, 0.5, 0.72), x=-0.7)
    )
    rear = [(-2.25, 0.95), (-2.05, 0.72), (-0.55, 0.72), (-0.55, 1.62), (-1.9, 1.62), (-2.2, 1.45)]
    right = [(-0.6, 0.72), (0.3, 0.72), (0.3, 1.05), (-0.1, 1.35), (-0.6, 1.4)]
    cab = [(-0.7, 0.72), (0.5, 0.72), (0.5, 1.35), (0.28, 2.3), (-0.6, 2.3), (-0.7, 2.1)]
    house = plate(rear, -0.85, 0.85) + plate(right, -0.85, -0.25) + plate(cab, 0.22, 0.85)
    house += both_sides(plate([(-0.1, 0.72), (0.45, 0.3), (0.6, 0.32), (0.62, 0.48), (0.15, 1.1), (-0.1, 1.1)], 0.13, 0.19))
    window = [(-0.52, 1.2), (0.38, 1.2), (0.4, 1.35), (0.2, 2.15), (-0.52, 2.15)]
    front = loft([[(x, y, z) for x, z in ((0.515, 1.36), (0.5, 1.36), (0.29, 2.2), (0.305, 2.2))] for y in (0.28, 0.79)])
    dark = box((-1.75, -0.866, 1.0), (-0.8, 0.866, 1.4)) + moved(cylinder(0.07, 1.62, 1.95, 10), x=-1.6, y=-0.5)
    weight = plate([(-2.4, 0.95), (-2.2, 0.74), (-2.0, 0.74), (-2.0, 1.5), (-2.3, 1.42)], -0.8, 0.8)
    boom = [(-0.13, 0), (-0.08, 0.11), (0.6, 0.33), (1.25, 0.46), (1.65, 0.46), (2.4, 0.28), (3.0, 0.13), (3.1, 0.06)]
    boom += [
        (3.1, -0.06),
        (3.0, -0.12),
        (2.3, 0.0),
        (1.6, 0.08),
        (1.42, -0.17),
        (1.2, -0.17),
        (1.05, 0.0),
        (0.1, -0.12),
        (-0.08, -0.11),
    ]
    stick = [(-0.56, 0.12), (-0.52, 0.22), (-0.38, 0.24), (0, 0.17), (0.9, 0.13), (1.6, 0.08), (1.69, 0)]
    stick += [(1.6, -0.08), (0.7, -0.13), (0.1, -0.14), (-0.1, -0.1)]
    outer = [(-0.08, 0.3), (-0.1, 0.05), (-0.02, -0.18), (0.18, -0.33), (0.45, -0.34), (0.68, -0.2), (0.82, 0.02), (0.9, 0.22)]
    shell = outer + [
        (0.86, 0.24),
        (0.78, 0.05),
        (0.65, -0.15),
        (0.44, -0.28),
        (0.2, -0.27),
        (0.03, -0.14),
        (-0.05, 0.06),
        (-0.03, 0.3),
    ]
    bucket = plate(shell, -0.4, 0.4) + both_sides(plate(outer, 0.37, 0.41))
    bucket += both_sides(plate([(-0.15, -0.1), (-0.1, 0.12), (0.02, 0.06), (0, -0.15)], 0.1, 0.14))
    teeth = []
    for y in (-0.36, -0.18, 0, 0.18, 0.36):
        teeth += moved(plate([(0.87, 0.14), (0.92, 0.36), (0.83, 0.22)], -0.04, 0.04), y=y)
    return {
        "car": {YELLOW: house, DARK: tracks + dark + weight, STEEL: frames, GLASS: plate(window, 0.2, 0.87) + front},
        "boom": {
            YELLOW: plate(boom, -0.12, 0.12),
            STEEL: pin(0, 0, 0.4) + pin(1.3, -0.1, 0.32) + pin(1.5, 0.35, 0.32) + pin(3, 0, 0.32),
        },
        "stick": {YELLOW: plate(stick, -0.09, 0.09), STEEL: pin(-0.45, 0.15, 0.28) + pin(1.6, 0, 0.26)},
        "bucket": {"#6b7480": bucket, STEEL: teeth},
        "stone": {"#8d8473": stone(0.48)},
    }


def stone(radius: float) -> Triangles:
    def rough(p):
        x, y, z = p
        r = radius * (1 + 0.09 * sin(4 * x + 2 * y + 1) + 0.07 * sin(3 * y - 5 * z) + 0.06 * cos(6 * z + 3 * x) - 0.06)
        return (r * x, r * y, r * z)

    return [tuple(rough(p) for p in t) for t in ball(1, 1, 1, 14)]


def aerofoil(chord: float, thickness: float, twist: float, round_part: float, z: float, points: int = 14):
    """A section across a blade, with the chord mainly along y: a NACA profile, blended with a circle near the root."""
    ring = []
    for k in range(points):
        a = 2 * pi * k / points
        s = 0.5 * (1 + cos(a))
        t = 5 * thickness * (0.2969 * s**0.5 - 0.126 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1036 * s**4)
        flat, half = (s - 0.3) * chord, t * chord * (1 if a < pi else -1)
        y = (1 - round_part) * flat + round_part * ROOT_RADIUS * cos(a)
        x = (1 - round_part) * half + round_part * ROOT_RADIUS * sin(a)
        c, d = cos(twist * pi / 180), sin(twist * pi / 180)
        ring.append((c * x + d * y, c * y - d * x, z))
    return ring


def wind_turbine() -> dict:
    stations = [
        (0, 3.5, 0.5, 13, 1), (3, 3.5, 0.5, 13, 1), (7, 4.0, 0.4, 13, 0.5), (12, 4.65, 0.33, 11.5, 0.05), (18, 4.4, 0.28, 9.5, 0),
        (28, 3.7, 0.24, 6.5, 0), (40, 3.0, 0.2, 3.5, 0), (52, 2.3, 0.18, 1, 0), (59, 1.7, 0.18, 0, 0), (61.5, 0.6, 0.18, 0, 0),
    ]  # fmt: skip
    blade = loft([aerofoil(chord, thick, twist, part, z) for z, chord, thick, twist, part in stations])
    tip = loft([aerofoil(chord, 0.181, twist, 0, z) for z, chord, twist in ((46, 2.67, 2.2), (50, 2.43, 1.4))])
    spinner = [(0, -2.2), (1.7, -2.1), (2.05, -1.2), (2.05, 1.2), (1.7, 2.4), (1.0, 3.2), (0, 3.5)]
    house = [
        (-4.4, 1.5, 1.5, 2.2),
        (-3.8, 2.0, 2.0, 2.1),
        (0, 2.25, 2.25, 1.9),
        (7, 2.25, 2.2, 1.95),
        (9.2, 1.9, 1.7, 2.2),
        (9.5, 1.5, 1.3, 2.3),
    ]
    cooler = box((6.4, -1.7, 4.0), (7.0, 1.7, 5.4))
    mast = rod((8.6, 0.8, 3.6), (8.6, 0.8, 6.2), 0.08) + rod((8.2, 0.8, 6.1), (9.0, 0.8, 6.1), 0.06)
    return {
        "blade": {"#e8ebf0": blade, "#c8483c": tip},
        "hub": {"#dfe3ea": turned(lathe(spinner), "y", -90)},
        "nacelle": {"#d5dae2": along_x(house), "#7f8896": cooler, "#4c525c": mast},
    }


def crane() -> dict:
    frame = both_sides(box((-0.8, 0.42, -0.1), (0.8, 0.6, 0.14))) + box((-0.08, -0.5, -0.06), (0.08, 0.5, 0.1))
    frame += box((-0.75, -0.5, -0.04), (-0.6, 0.5, 0.1)) + box((0.6, -0.5, -0.04), (0.75, 0.5, 0.1))
    wheels = []
    for x in (-0.6, 0.6):
        wheels += both_sides(rod((x, 0.6, 0), (x, 0.72, 0), 0.16, 14))
    drum = rod((0, -0.36, -0.12), (0, 0.36, -0.12), 0.18, 16)
    motor = box((-0.62, -0.3, 0.1), (-0.2, 0.1, 0.34))
    ribs, walls = [], box((-0.86, -0.86, -1.48), (0.86, 0.86, -0.32))
    for k in range(9):
        y = -0.68 + 0.17 * k
        ribs += box((-0.89, y - 0.045, -1.4), (0.89, y + 0.045, -0.4)) + box((y - 0.045, -0.89, -1.4), (y + 0.045, 0.89, -0.4))
    posts = []
    for x in (-0.82, 0.82):
        for y in (-0.82, 0.82):
            posts += box((x - 0.08, y - 0.08, -1.5), (x + 0.08, y + 0.08, -0.3))
        posts += box((x - 0.07, -0.8, -0.42), (x + 0.07, 0.8, -0.3)) + box((x - 0.07, -0.8, -1.5), (x + 0.07, 0.8, -1.38))
        posts += box((-0.8, x - 0.07, -0.42), (0.8, x + 0.07, -0.3)) + box((-0.8, x - 0.07, -1.5), (0.8, x + 0.07, -1.38))
    sling = []
    for x in (-0.82, 0.82):
        for y in (-0.82, 0.82):
            sling += rod((0, 0, 0), (x, y, -0.31), 0.025)
    girders = []
    for y in (-0.66, 0.66):
        girders += box((-4, y - 0.06, -0.28), (14, y + 0.06, -0.16)) + box((-4, y - 0.04, 1.2), (14, y + 0.04, 1.28))
        for k in range(18):
            x = -4 + k
            girders += rod((x, y, -0.2), (x + 0.5, y, 1.22), 0.035) + rod((x + 0.5, y, 1.22), (x + 1, y, -0.2), 0.035)
    for x in (-4, 14):
        girders += both_sides(rod((x, 0.66, 0), (x, 2.2, -12), 0.16)) + box((x - 0.2, -0.75, -0.3), (x + 0.2, 0.75, 0.0))
        girders += rod((x, -1.4, -6), (x, 1.4, -6), 0.1)
    return {
        "trolley": {YELLOW: frame, DARK: wheels + drum, "#4a7fb5": motor},
        "load": {"#3f74ab": walls + ribs, "#2f5985": posts, STEEL: sling},
        "gantry": {"#b9a06a": girders},
    }


def tower() -> dict:
    """A suspension tower of 34 m: arms for two conductors at 26 m, the third conductor at the top."""

    def half(z: float) -> float:
        return 2.6 - 1.9 * min(z, 24) / 24 if z < 24 else 0.7 - 0.5 * (z - 24) / 10

    def corner(k: int, z: float):
        h = half(z)
        return ((h, h), (-h, h), (-h, -h), (h, -h))[k % 4] + (z,)

    levels, bars = [0, 6, 11, 15, 18.5, 21.5, 24, 26, 28.5, 31, 34], []
    for low, high in zip(levels, levels[1:]):
        for k in range(4):
            bars += rod(corner(k, low), corner(k, high), 0.13, 4) + rod(corner(k, low), corner(k + 1, high), 0.07, 3)
            bars += rod(corner(k + 1, low), corner(k, high), 0.07, 3) + rod(corner(k, high), corner(k + 1, high), 0.07, 3)
    tip = (0, 8, 26)
    arm = []
    for x in (-1, 1):
        arm += rod((x * half(26), half(26), 26), tip, 0.1, 3) + rod((x * half(28.5), half(28.5), 28.5), tip, 0.1, 3)
        for s in (0.3, 0.6):
            low, high = ((x * half(z) * (1 - s), half(z) + (8 - half(z)) * s, z + (26 - z) * s) for z in (26, 28.5))
            arm += rod(low, high, 0.06, 3)
    return {"tower": {"": bars + both_sides(arm)}}


def motion_platform() -> dict:
    base = cylinder(1.35, 0.04, 0.16, 28)
    eyes = []
    for x, y in ((0.771345, 0.919253), (0.410424, 1.12763), (-1.18177, 0.208378)):
        eyes += both_sides(
            moved(lathe(rounded([(0, -0.09, 0), (0.12, -0.09, 0.02), (0.12, 0.06, 0.02), (0, 0.06, 0)])), x=x, y=y)
        )
    shell = along_x(
        [
            (-1.15, 0.8, 0.6, 0.85),
            (-1.05, 0.9, 0.72, 0.9),
            (0.4, 0.92, 0.78, 0.95),
            (0.85, 0.85, 0.66, 0.85),
            (1.12, 0.7, 0.45, 0.65),
        ]
    )
    screen = along_x([(0.52, 0.8, 0.42, 1.2), (0.9, 0.74, 0.34, 1.12), (1.13, 0.66, 0.2, 0.98)])
    door = box((-0.75, -0.93, 0.3), (-0.1, -0.88, 1.5))
    stripe = box((-1.0, -0.925, 0.5), (0.5, 0.925, 0.62))
    ring = [[(u, v, z) for u, v in oval(1.1, 0.85, 20, 4)] for z in (0.16, 0.24)]
    return {"cabin": {"#e3e6eb": shell, GLASS: screen, STEEL: base + eyes, "#c8963e": stripe, "#9aa4b2": door + loft(ring)}}


def chain_to_ring() -> dict:
    """A module of a snake robot: a tongue at its own joint, a fork around that of the next one, both about z."""

    def eyes(width: float) -> Triangles:
        return turned(turned(link(0.04, 0.013, 0.013, width, 0.0015, 12), "y", 90), "x", 90)

    def above_and_below(solid: Triangles, z: float) -> Triangles:
        return moved(solid, z=z) + moved(solid, z=-z)

    tongue = eyes(0.012)
    fork = above_and_below(moved(eyes(0.006), x=0.068), 0.0135)
    horns = above_and_below(moved(cylinder(0.007, -0.002, 0.002, 14), x=0.108), 0.018)
    case = along_x([(0.016, 0.013, 0.014, 0), (0.022, 0.02, 0.02, 0), (0.08, 0.02, 0.02, 0), (0.086, 0.013, 0.017, 0)], 20)
    band = along_x([(0.032, 0.0206, 0.0206, 0), (0.04, 0.0206, 0.0206, 0)], 20)
    return {"module": {"#4a7fb5": case, DARK: tongue + fork, STEEL: horns, "#e3e6eb": band}}
