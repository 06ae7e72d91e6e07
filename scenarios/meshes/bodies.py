"""People, bones, and a robot that climbs."""

from solids import Triangles, ball, both_sides, cylinder, along_x, along_z, link, moved, rod, turned

BONE, CARTILAGE = "#e2d3b1", "#c98f8f"
SKIN, HAIR, RED, BLUE = "#d9a066", "#4a3426", "#b5433c", "#3f6fa8"


def knee() -> dict:
    shaft = [
        (0, 0.019, 0.019), (-0.06, 0.0155, 0.0155), (-0.2, 0.0145, 0.0145), (-0.3, 0.0165, 0.019), (-0.345, 0.021, 0.029, 0.002, 0),
        (-0.375, 0.026, 0.042, 0.002, 0), (-0.4, 0.022, 0.044, 0, 0),
    ]  # fmt: skip
    condyles = both_sides(moved(ball(0.026, 0.0185, 0.022, 14), x=-0.003, y=0.031, z=-0.402))
    shin = [
        (-0.0225, 0.021, 0.04, -0.004, 0), (-0.034, 0.0225, 0.0415, -0.004, 0), (-0.06, 0.0185, 0.03, 0.002, -0.002),
        (-0.09, 0.0165, 0.019, 0.004, -0.006), (-0.2, 0.0125, 0.0125, 0.002, -0.006), (-0.34, 0.0115, 0.012, 0, -0.004),
        (-0.385, 0.016, 0.018, 0, -0.002), (-0.402, 0.0155, 0.017, 0, 0),
    ]  # fmt: skip
    splint = [
        (-0.05, 0.007, 0.007, -0.014, 0.036), (-0.08, 0.0055, 0.0055, -0.013, 0.033), (-0.3, 0.005, 0.005, -0.008, 0.026),
        (-0.4, 0.008, 0.006, -0.004, 0.026), (-0.418, 0.005, 0.004, -0.004, 0.026),
    ]  # fmt: skip
    ankle = moved(ball(0.026, 0.02, 0.018, 12), x=0.002, z=-0.412)
    heel = along_x(
        [(-0.055, 0.012, 0.012, -0.43), (-0.045, 0.02, 0.02, -0.428), (0.0, 0.022, 0.02, -0.424), (0.06, 0.026, 0.014, -0.424)],
        12,
        2.5,
    )
    return {
        "thigh_bone": {
            BONE: along_z(shaft, 14) + condyles,
            CARTILAGE: both_sides(moved(ball(0.0265, 0.017, 0.0085, 12), x=-0.003, y=0.031, z=-0.4165)),
        },
        "shin_bone": {BONE: along_z(shin, 14) + along_z(splint, 8) + ankle + heel + foot_bones()},
        "menisci": {CARTILAGE: both_sides(moved(ball(0.021, 0.02, 0.0035, 12), y=0.022, z=-0.0185))},
    }


def foot_bones() -> Triangles:
    bones = []
    for k, reach in enumerate((0.185, 0.182, 0.175, 0.165, 0.15)):
        y, thick = -0.026 + 0.0135 * k, 0.0075 if k == 0 else 0.005
        middle = 0.62 * reach
        bones += moved(
            along_x(
                [
                    (0.045, thick, thick, -0.426),
                    (0.5 * middle + 0.02, 0.8 * thick, 0.8 * thick, -0.428),
                    (middle, thick, thick, -0.434),
                ],
                8,
                2,
            ),
            y=y,
        )
        bones += moved(
            along_x(
                [
                    (middle + 0.003, thick, thick, -0.434),
                    (reach - 0.01, 0.75 * thick, 0.7 * thick, -0.437),
                    (reach, 0.5 * thick, 0.5 * thick, -0.437),
                ],
                8,
                2,
            ),
            y=1.06 * y,
        )
    return bones


def trapeze() -> dict:
    arm = [
        (0.0, 0.035, 0.03),
        (-0.05, 0.028, 0.026),
        (-0.25, 0.036, 0.034),
        (-0.29, 0.034, 0.033),
        (-0.42, 0.046, 0.042),
        (-0.54, 0.05, 0.045),
        (-0.6, 0.03, 0.035, 0, -0.02),
    ]
    trunk = [
        (-0.555, 0.045, 0.06), (-0.6, 0.075, 0.15), (-0.64, 0.1, 0.2), (-0.74, 0.115, 0.19), (-0.95, 0.095, 0.145), (-1.1, 0.1, 0.15),
        (-1.25, 0.12, 0.175), (-1.36, 0.11, 0.165),
    ]  # fmt: skip
    leg = [
        (0.03, 0.075, 0.07),
        (-0.06, 0.085, 0.08),
        (-0.38, 0.055, 0.055),
        (-0.42, 0.055, 0.054),
        (-0.55, 0.052, 0.05, -0.01, 0),
        (-0.78, 0.032, 0.032),
        (-0.82, 0.03, 0.032),
    ]
    toes = [
        (-0.8, 0.035, 0.033, 0, 0),
        (-0.86, 0.035, 0.035, 0.02, 0),
        (-0.95, 0.025, 0.035, 0.05, 0),
        (-1.0, 0.012, 0.025, 0.06, 0),
    ]
    head = along_z([(-0.56, 0.05, 0.05), (-0.5, 0.055, 0.055)], 10) + moved(ball(0.095, 0.08, 0.12, 14), z=-0.42)
    thigh = [(0.0, 0.06, 0.058), (-0.04, 0.064, 0.06), (-0.2, 0.075, 0.072), (-0.42, 0.095, 0.09), (-0.5, 0.09, 0.085)]
    chest = [
        (-0.42, 0.12, 0.17), (-0.5, 0.125, 0.18), (-0.62, 0.11, 0.16), (-0.8, 0.125, 0.19), (-0.95, 0.13, 0.23), (-1.02, 0.1, 0.2),
        (-1.06, 0.06, 0.1),
    ]  # fmt: skip
    reach = [
        (0.03, 0.04, 0.045, 0, -0.01),
        (-0.04, 0.058, 0.055),
        (-0.16, 0.052, 0.05),
        (-0.3, 0.04, 0.038),
        (-0.36, 0.042, 0.038),
        (-0.54, 0.028, 0.026),
        (-0.62, 0.035, 0.02),
    ]
    neck = along_z([(-1.04, 0.06, 0.06), (-1.14, 0.055, 0.055)], 10) + moved(ball(0.1, 0.085, 0.125, 14), z=-1.23)
    shanks = both_sides(moved(turned(along_z([(0, 0.055, 0.055), (0.12, 0.058, 0.055), (0.36, 0.035, 0.035)]), "y", -80), y=0.13))
    return {
        "flyer_trunk": {
            SKIN: both_sides(moved(along_z(arm), y=0.2)) + head,
            HAIR: moved(ball(0.1, 0.085, 0.075, 12), x=-0.015, z=-0.365),
            RED: along_z(trunk, 14, 2.6),
        },
        "flyer_legs": {RED: both_sides(moved(along_z(leg), y=0.09)), SKIN: both_sides(moved(along_z(toes), y=0.09))},
        "catcher_body": {
            BLUE: both_sides(moved(along_z(thigh), y=0.11)) + along_z(chest, 14, 2.6) + shanks,
            SKIN: neck,
            HAIR: moved(ball(0.105, 0.09, 0.07, 12), x=-0.01, z=-1.3),
        },
        "catcher_arms": {SKIN: both_sides(moved(along_z(reach), y=0.2))},
    }


def about_x(solid: Triangles) -> Triangles:
    """Turns z to x."""
    return turned(solid, "y", 90)


def climbing_robot() -> dict:
    pad = about_x(cylinder(0.06, 0, 0.014, 24)) + about_x(cylinder(0.05, 0.014, 0.03, 24))
    housing = about_x(cylinder(0.036, 0.03, 0.085, 20))
    coils = []
    for k in range(6):
        coils += turned(moved(about_x(cylinder(0.012, 0.014, 0.04, 10)), z=0.044), "x", 60 * k)
    ankle = about_x(cylinder(0.034, -0.075, -0.03, 20)) + rod((0, -0.045, 0), (0, 0.045, 0), 0.03, 16)
    fork = both_sides(moved(turned(link(0.045, 0.028, 0.02, 0.012, 0.003, 10), "y", -90), y=0.036))
    upper, lower = link(0.35, 0.042, 0.036, 0.056), link(0.35, 0.036, 0.042, 0.046)
    caps = {z: rod((0, -0.034, z), (0, 0.034, z), 0.02, 14) for z in (0, 0.35)}
    return {
        "foot": {"#3c4047": pad, "#b5533c": housing, "#c9a24a": coils},
        "ankle": {"#6b7a8f": ankle, "#59657a": fork},
        "leg_a": {"#c8963e": upper, "#4c525c": caps[0] + caps[0.35]},
        "leg_b": {"#4a7fb5": lower, "#4c525c": caps[0] + caps[0.35]},
    }
