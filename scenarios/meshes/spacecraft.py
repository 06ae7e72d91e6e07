"""Spacecraft: a tug, a spent rocket stage, a satellite with folded wings."""

from solids import Triangles, ball, both_sides, box, cylinder, lathe, moved, rod, rounded, turned

FOIL, CELLS, FRAME, WHITE, DARK = "#c8963e", "#27406e", "#c4c9d1", "#e4e6ea", "#3c4047"


def about_x(solid: Triangles) -> Triangles:
    """Turns z to x."""
    return turned(solid, "y", 90)


def panel(length: float, width: float, columns: int, rows: int, thickness: float = 0.03) -> dict:
    """A solar panel in the plane z = 0, with cells on both faces; length along y, width along x."""
    edge = 0.03
    cells = []
    dx, dy = (width - 2 * edge) / columns, (length - 2 * edge) / rows
    for i in range(columns):
        for j in range(rows):
            x, y = -width / 2 + edge + i * dx, -length / 2 + edge + j * dy
            cells += box((x + 0.008, y + 0.008, -0.6 * thickness), (x + dx - 0.008, y + dy - 0.008, 0.6 * thickness))
    return {FRAME: box((-width / 2, -length / 2, -thickness / 2), (width / 2, length / 2, thickness / 2)), CELLS: cells}


def nozzle(radius: float, length: float) -> Triangles:
    """A bell about z, its mouth at z = -length."""
    outside = [(radius, -length), (0.8 * radius, -0.72 * length), (0.5 * radius, -0.35 * length), (0.25 * radius, -0.1 * length)]
    return lathe([(0, -0.85 * length), (0.94 * radius, -length), *outside, (0.3 * radius, 0), (0, 0)], 20)


def dish(radius: float) -> Triangles:
    depth = 0.3 * radius
    back = [(0, 0), (0.35 * radius, 0.04 * radius), (0.7 * radius, 0.4 * depth), (radius, depth)]
    front = [(0.97 * radius, depth), (0.68 * radius, 0.5 * depth), (0.33 * radius, 0.12 * depth + 0.02), (0, 0.1 * depth + 0.02)]
    return lathe(back + front, 24)


def debris_capture() -> dict:
    body = box((-0.95, -0.78, -0.78), (0.95, 0.78, 0.78))
    edges = []
    for y in (-0.78, 0.78):
        for z in (-0.78, 0.78):
            edges += box((-1, y - 0.05, z - 0.05), (1, y + 0.05, z + 0.05))
    for x in (-0.97, 0.97):
        for s in (-0.78, 0.78):
            edges += box((x - 0.04, -0.8, s - 0.05), (x + 0.04, 0.8, s + 0.05)) + box(
                (x - 0.04, s - 0.05, -0.8), (x + 0.04, s + 0.05, 0.8)
            )
    bells = []
    for y in (-0.5, 0.5):
        for z in (-0.5, 0.5):
            bells += moved(about_x(nozzle(0.17, 0.34)), x=-1, y=y, z=z)
    wing = panel(2.6, 1, 4, 10, 0.04)
    wings = {colour: both_sides(moved(part, x=0.4, y=2.2)) for colour, part in wing.items()}
    boom = both_sides(rod((0.4, 0.8, 0), (0.4, 1.0, 0), 0.05))
    antenna = (
        moved(dish(0.42), x=0.2, z=0.95) + rod((0.2, 0, 0.8), (0.2, 0, 0.97), 0.04) + rod((0.2, 0, 0.95), (0.2, 0, 1.2), 0.015)
    )
    mast = rod((0, 0, 0), (-1.9, 0, 0), 0.07, 12)
    rings = []
    for x in (-0.05, -0.5, -1.0, -1.5):
        rings += rod((x - 0.04, 0, 0), (x + 0.04, 0, 0), 0.1, 12)
    tank = [(0, -3, 0), (1.2, -3, 0.05), (1.2, 2.1, 0.25), (0.62, 2.4, 0.02), (0.62, 3.0, 0.02), (0, 3.0, 0)]
    bands = []
    for z, width in ((-2.4, 0.3), (-0.6, 0.08), (1.3, 0.08)):
        bands += cylinder(1.206, z - width / 2, z + width / 2, 28)
    tunnel = moved(box((-2.7, -0.09, -0.06), (1.9, 0.09, 0.06)), z=1.22)
    thrust = lathe([(0, -3.35), (0.35, -3.35), (0.75, -3.0), (0, -3.0)], 20)
    stage = {
        WHITE: about_x(lathe(rounded(tank), 28)),
        DARK: about_x(bands) + tunnel,
        "#7d828c": about_x(thrust) + moved(about_x(nozzle(0.8, 1.3)), x=-3.3) + about_x(cylinder(0.66, 2.9, 3.02, 24)),
    }
    knot = ball(0.12, 0.12, 0.12) + about_x(lathe([(0, -0.03), (0.14, -0.03), (0.2, 0), (0.14, 0.03), (0, 0.03)], 16))
    return {
        "tug": {FOIL: body, FRAME: edges + boom + wings[FRAME], CELLS: wings[CELLS], DARK: bells, WHITE: antenna},
        "mast": {"#9aa4b2": mast, DARK: rings},
        "stage": stage,
        "ring": {"#6b7a8f": knot},
    }


def satellite() -> dict:
    body = box((-0.63, -0.57, -0.8), (0.63, 0.57, 0.74))
    frame = []
    for x in (-0.62, 0.62):
        for y in (-0.56, 0.56):
            frame += box((x - 0.035, y - 0.035, -0.8), (x + 0.035, y + 0.035, 0.8))
    for z in (-0.77, 0.77):
        frame += both_sides(box((-0.65, 0.53, z - 0.03), (0.65, 0.6, z + 0.03)))
        frame += box((-0.65, -0.6, z - 0.03), (-0.59, 0.6, z + 0.03)) + box((0.59, -0.6, z - 0.03), (0.65, 0.6, z + 0.03))
    lid = box((-0.6, -0.55, 0.74), (0.6, 0.55, 0.77))
    radiator = box((0.63, -0.42, -0.6), (0.66, 0.42, 0.5))
    antenna = (
        moved(turned(dish(0.5), "y", -90), x=-0.72)
        + rod((-0.6, 0, 0), (-0.72, 0, 0), 0.05)
        + rod((-0.75, 0, 0), (-1.02, 0, 0), 0.02)
    )
    engine = (
        moved(nozzle(0.22, 0.4), z=-0.8)
        + moved(cylinder(0.12, 0, 0.06), x=0.25, z=0.77)
        + moved(cylinder(0.06, 0, 0.22), x=-0.3, y=0.3, z=0.77)
    )
    sheet = panel(1.16, 1.8, 6, 4)
    hinges = []
    for x in (-0.6, 0.6):
        hinges += rod((x - 0.06, 0, 0), (x + 0.06, 0, 0), 0.03, 8)
    return {
        "hull": {FOIL: body, FRAME: frame + lid, WHITE: radiator + antenna, DARK: engine},
        "panel": {FRAME: moved(sheet[FRAME], y=0.6) + hinges, CELLS: moved(sheet[CELLS], y=0.6)},
    }
