"""The scenarios with machines do what docs/examples says: statics, hand estimates, conservation laws."""

import numpy as np
import pytest
from scenario_run import Run

G = 9.81


def test_excavator_pin_bears_the_moment_of_what_it_holds_and_breaks() -> None:
    still = ["--set", "mechanism.digger.body.boom rod.joint.drive.pd.target=1.41", "--until", "8", "--reactions"]
    rest = Run("excavator_pin", *still)
    assert rest.names() == []
    held = ["digger/boom", "digger/stick", "digger/bucket", "digger/stick cylinder", "digger/stick rod"]
    weight = G * rest.mass(*held)
    foot, pin = rest.point("digger/boom")[-1], rest.point("digger/boom rod")[-1]
    cylinder = pin - rest.point("digger/boom cylinder")[-1]
    lever = np.linalg.norm(np.cross(pin - foot, cylinder / np.linalg.norm(cylinder)))
    estimate = weight * (rest.centre(*held)[-1] - foot)[0] / lever
    assert np.linalg.norm(rest.force("boom eye")[-1]) == pytest.approx(estimate, rel=0.01)

    run = Run("excavator_pin", "--reactions")
    assert run.names()[:3] == ["pin breaks", "impact", "rest"]
    fall, landing = run.events[:2]
    assert landing["bodies"] == ["digger/bucket", "ground"]
    assert np.linalg.norm(run.force("boom eye")[run.row(fall["time"] - 1e-6)]) < 160e3
    # Nothing holds the boom then: what it loses in height it gains in speed, but for dampers and the stick's cylinder.
    gained = landing["before"]["kinetic"] - fall["after"]["kinetic"]
    assert gained == pytest.approx(fall["after"]["potential"] - landing["before"]["potential"], rel=0.02)
    assert landing["lost"] == pytest.approx(landing["before"]["kinetic"], rel=0.03)  # the free cylinder goes on
    assert abs(run.energy["error"]) < 1e-8 * run.energy["largest_kinetic"]


def test_crane_the_rope_bears_weight_and_swing() -> None:
    run = Run("crane", "--reactions")
    tension = np.linalg.norm(run.force("crane/rope3"), axis=1)
    assert tension[run.row(0)] == pytest.approx(830 * G, rel=1e-3)
    parts = run.event("strength of crane/rope3")["time"]
    # Just before it parts the load swings through: Newton's law for it and the two pieces of rope above it.
    k = run.row(parts) - 1
    centre, step = run.centre("crane/load", "crane/rope3", "crane/rope4"), 0.02
    acceleration = (centre[k + 1] - 2 * centre[k] + centre[k - 1]) / step**2
    wind = [0, 0, 0]  # and drag: below 1 kN to the side, which changes the size of the force by less than 1 %
    force = 830 * (acceleration + [0, 0, G]) + wind
    assert tension[k] == pytest.approx(np.linalg.norm(force), rel=0.01)
    assert 0.9 * 9.9e3 < tension[k] < 9.9e3


def test_crane_the_load_lands_on_a_corner_and_slides_as_friction_says() -> None:
    run = Run("crane")
    parting, landing = run.event("strength of crane/rope3"), run.event("impact landing")
    # It falls freely, but for drag, which takes less than 2 %.
    assert landing["before"]["kinetic"] == pytest.approx(
        parting["after"]["kinetic"] + parting["after"]["potential"] - landing["before"]["potential"], rel=0.02
    )
    # One corner hits the ground: an impulse there, within the cone of friction, and no moment about it.
    before, after = landing["before"], landing["after"]
    impulse = np.subtract(after["linear"], before["linear"])
    assert impulse == pytest.approx(landing["impulse"], rel=1e-9)
    assert np.hypot(impulse[0], impulse[1]) < (0.5 + 1e-9) * impulse[2]
    moment = np.subtract(after["angular"], before["angular"])
    assert moment == pytest.approx(np.cross(landing["point"], impulse), rel=1e-7)
    # Flat on the ground it slides to v² / (2 μ g). What is left of the rope pulls a little.
    corners = [run.point("crane/load", (x, y, -1.5)) for x in (-0.9, 0.9) for y in (-0.9, 0.9)]
    assert min(np.min(corner[:, 2]) for corner in corners) > -1e-9
    k = run.row(4.8)
    assert max(corner[k, 2] for corner in corners) < 1e-6
    centre = run.centre("crane/load")
    speed = np.linalg.norm(centre[k + 1] - centre[k - 1]) / 0.04
    assert speed > 2
    assert np.linalg.norm(centre[-1] - centre[k]) == pytest.approx(speed**2 / (2 * 0.5 * G), rel=0.02)
    stick = run.event("stick landing")["time"]
    assert stick - 4.8 == pytest.approx(speed / (0.5 * G), rel=0.02)
    for body in ("crane/load", "crane/rope3", "crane/rope4"):
        assert np.linalg.norm(run.point(body)[-1] - run.point(body)[-25]) < 1e-6
    assert abs(run.energy["error"]) < 1e-8 * run.energy["largest_kinetic"]


def test_hand_over_each_hand_bears_the_tube_in_turn() -> None:
    run = Run("hand_over", "--reactions")
    assert run.names() == ["hold", "grasp", "lets go"]
    weight = 3 * G
    left, right = np.linalg.norm(run.force("hold"), axis=1), np.linalg.norm(run.force("grasp"), axis=1)
    before, both, after = run.row(1.79), run.row(2.99), run.row(4.19)
    assert left[before] == pytest.approx(weight, rel=1e-3)
    assert right[after] == pytest.approx(weight, rel=1e-3)
    # About the tube's centre, which is 25 cm beside either hand, it has no moment.
    assert np.linalg.norm(run.torque("hold")[before]) < 1e-3 * weight
    assert np.linalg.norm(run.torque("grasp")[after]) < 1e-3 * weight
    grasp, release = run.event("grasp"), run.event("lets go")
    assert grasp["after"]["loops"]["rank"] == 6
    assert "loops" not in release["after"]
    assert abs(grasp["lost"]) < 1e-9
    assert right[both] > 1


def test_climbing_robot_one_foot_bears_weight_and_moment() -> None:
    run = Run("climbing_robot", "--reactions")
    assert run.names() == ["B lets go", "B holds again", "A lets go"]
    bodies = [name for name in run.model["bodies"] if name != "wall/wall"]
    weight, centre = G * run.mass(*bodies), run.centre(*bodies)
    assert weight == pytest.approx(9.2 * G)
    # While nothing moves, the foot bears the weight, and its moment about the foot: it peels the magnet off the wall.
    k = run.row(0.69)
    assert run.force("robot/magnet A")[k] == pytest.approx([0, 0, weight], abs=0.02 * weight)
    assert run.torque("robot/magnet A")[k][1] == pytest.approx(-weight * centre[k][0], rel=0.02)
    # With the arm to the side, half-way, it turns the foot on the wall, too.
    k = run.row(2.5)
    assert abs(centre[k][1]) > 0.15
    assert abs(run.torque("robot/magnet A")[k][0]) == pytest.approx(weight * abs(centre[k][1]), rel=0.05)
    # A full step up, and the other foot bears it all.
    assert run.point("robot/foot B")[-1] - run.point("robot/foot B")[0] == pytest.approx([0, 0, 1.0], abs=0.02)
    magnet = run.final["joints"]["B holds again"]["reaction"]
    assert np.linalg.norm(magnet["force"]) == pytest.approx(weight, rel=0.02)
    assert np.linalg.norm(run.final["joints"]["B holds again"]["v"] or 0) == 0


def legs(run: Run, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the six legs, and their upper ends."""
    feet = np.array([run.point(f"hexapod/cylinder {n}")[k] for n in range(1, 7)])
    heads = np.array([run.point(f"hexapod/rod {n}")[k] for n in range(1, 7)])
    along = heads - feet
    return along / np.linalg.norm(along, axis=1)[:, None], heads


def test_hexapod_six_legs_bear_the_cabin_and_five_let_it_fall() -> None:
    start = Run("hexapod", "--until", "0")["hexapod/rod 1.q0"].flat[0]
    still = [f"mechanism.hexapod.body.rod {n}.joint.drive.pd.target={start}" for n in range(1, 7)]
    run = Run("hexapod", "--reactions", "--until", "0.7", *(w for s in [*still, "event.eye breaks.at=0.45"] for w in ("--set", s)))
    k = run.row(0.449)
    along, heads = legs(run, k)
    centre = run.centre("hexapod/cabin")[k]
    wrenches = np.vstack([along.T, np.cross(heads - centre, along).T])
    forces = np.linalg.solve(wrenches, [0, 0, 2000 * G, 0, 0, 0])
    # In each joint the cabin is pushed by its leg: along it, and across it by part of the leg's own weight.
    assert np.linalg.norm(run.force("eye 3")[k]) == pytest.approx(forces[2], rel=0.05)
    assert np.linalg.norm(run.force("eye 6")[k]) == pytest.approx(forces[5], rel=0.05)
    # Then: five stiff legs without mass, and a rigid cabin that starts from rest.
    kept = [0, 1, 3, 4, 5]
    mass = np.diag([2000, 2000, 2000, 1300, 1500, 1400])
    system = np.block([[mass, -wrenches[:, kept]], [wrenches[:, kept].T, np.zeros((5, 5))]])
    fall = np.linalg.solve(system, [0, 0, -2000 * G, 0, 0, 0, *([0] * 5)])
    moved = run.centre("hexapod/cabin")[run.row(0.65)] - centre
    assert moved == pytest.approx(0.5 * fall[:3] * 0.2**2, rel=0.15, abs=0.003)
    assert run.events[0]["lost"] == 0
    assert abs(run.energy["error"]) < 1e-6 * run.energy["largest_kinetic"]
