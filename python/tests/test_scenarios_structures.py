"""Trapeze, knee, wind turbine and transmission line do what docs/examples says: closed forms, statics, conservation laws."""

import numpy as np
import pytest
from scenario_run import Array, Run

G = 9.81


def off_parabola(time: Array, centre: Array) -> float:
    """How far a centre of mass is from the best parabola of free fall."""
    fall = centre + np.outer(0.5 * G * time**2, [0, 0, 1])
    line = np.stack([np.ones_like(time), time], axis=1)
    return float(np.max(np.abs(fall - line @ np.linalg.lstsq(line, fall, rcond=None)[0])))


def test_trapeze_catch_a_free_flight_and_the_impulse_of_the_catch() -> None:
    run = Run("trapeze_catch", "--reactions", "--set", "output.every=0.002")
    assert run.names() == ["lets go", "catch"]
    release, catch = run.events
    flight = slice(run.row(release["time"]) + 1, run.row(catch["time"]) + 1)
    centre = run.centre("flyer/trunk", "flyer/legs")
    assert off_parabola(run.time[flight], centre[flight]) < 1e-6
    # The catch is a plastic impact in one point: it takes half of the impulse times the speed at which the hands meet.
    k = run.row(catch["time"])
    gap = run.point("flyer/trunk") - run.point("catcher/arms", [0, 0, -0.6])
    speed = (gap[k] - gap[k - 1]) / (run.time[k] - run.time[k - 1])
    impulse = np.asarray(catch["impulse"]["catch"][:3])
    assert catch["lost"] == pytest.approx(0.5 * np.linalg.norm(impulse) * np.linalg.norm(speed), rel=0.15)
    before, after = (np.asarray(catch[side]["linear"]) for side in ("before", "after"))
    assert after - before == pytest.approx(catch["ground_impulse"][:3], abs=1e-9)
    # At the lowest point of the swing after it: weight and centripetal force.
    held = np.linalg.norm(run.force("catch"), axis=1)
    lowest = int(np.nanargmax(held))
    path = centre[lowest - 5 : lowest + 6 : 5]
    force = 58 * ((path[2] - 2 * path[1] + path[0]) / 0.01**2 + [0, 0, G])
    assert held[lowest] == pytest.approx(np.linalg.norm(force), rel=0.02)
    assert 1.5 * 58 * G < held[lowest] < 5 * 58 * G


LIGAMENTS = {  # thigh, shin, stiffness, rest
    "ACL": ([-0.014, 0.004, 0.009], [0.010, 0, -0.012], 242e3, 0.0323),
    "PCL": ([0.006, -0.004, 0.006], [-0.024, 0, -0.016], 200e3, 0.0383),
    "MCL": ([0, -0.045, 0.02], [0.005, -0.03, -0.07], 63e3, 0.0909),
    "LCL": ([0, 0.042, 0.02], [-0.015, 0.045, -0.04], 59e3, 0.0591),
}


def drawer(pull: float, torn: tuple[str, ...] = ()) -> float:
    """How far the shin slides at rest, from the least potential energy."""

    def energy(slide: float, bend: float) -> float:
        flexed, turned = np.radians(25), np.radians(25) + bend
        x, z = slide * np.cos(flexed), -slide * np.sin(flexed)
        v = 0.5 * 8e3 * slide**2 + 0.5 * 300 * bend**2 - pull * slide
        v += G * (0.1 * z + 4.6 * (z - 0.21 * np.cos(turned)))
        for name, (thigh, shin, stiffness, rest) in LIGAMENTS.items():
            here = [x + shin[0] * np.cos(turned) + shin[2] * np.sin(turned), shin[1]]
            here.append(z - shin[0] * np.sin(turned) + shin[2] * np.cos(turned))
            stretch = np.linalg.norm(np.asarray(here) - thigh) - rest
            v += 0 if name in torn else 0.5 * stiffness * max(stretch, 0.0) ** 2
        return float(v)

    at, h = np.array([2e-3, -0.01]), np.array([1e-6, 1e-5])
    for _ in range(200):  # Newton's method with differences; steps limited, as ligaments become taut
        e0, e1 = np.array([h[0], 0]), np.array([0, h[1]])
        slope = np.array([(energy(*(at + e)) - energy(*(at - e))) / (2 * np.sum(e)) for e in (e0, e1)])
        second = np.empty((2, 2))
        for i, a in enumerate((e0, e1)):
            for j, b in enumerate((e0, e1)):
                four = energy(*(at + a + b)) - energy(*(at + a - b)) - energy(*(at - a + b)) + energy(*(at - a - b))
                second[i, j] = four / (4 * np.sum(a) * np.sum(b))
        at = at - np.clip(np.linalg.solve(second, slope), -3e-4, 3e-4)
    return float(at[0])


def test_knee_ligament_the_shin_slides_as_statics_says() -> None:
    run = Run("knee_ligament")
    assert run.names() == ["blow", "strength of ACL"]
    slide = run["leg/slide.q0"]
    relaxed, intact, torn = (slide[run.row(t)] for t in (0.15, 0.79, 2.59))
    assert relaxed == pytest.approx(drawer(0), rel=0.01)
    assert intact == pytest.approx(drawer(134), rel=0.01)
    assert torn == pytest.approx(drawer(134, ("ACL",)), rel=0.01)
    assert torn - intact > 3e-3  # what doctors take as a torn ligament
    tear = run.event("strength of ACL")
    rate = run["ACL.rate"][run.row(tear["time"] - 1e-9)]
    assert tear["released"] == pytest.approx((2160 - 20 * rate) ** 2 / (2 * 242e3), rel=0.01)
    assert abs(run.energy["error"]) < 1e-4 * run.energy["largest_kinetic"]


def test_blade_loss_the_blade_flies_and_the_tower_sways() -> None:
    run = Run("blade_loss")
    assert run.names()[:3] == ["blade breaks", "brake", "impact"]
    release, landing = run.events[0]["time"], run.events[2]["time"]
    flight = slice(run.row(release), run.row(landing))
    centre = run.centre("turbine/blade 1")
    assert off_parabola(run.time[flight], centre[flight]) < 1e-6
    # Where its centre is when it hits the ground: from the height of the hub, 22 m outside of it, with the speed of its centre on
    # the circle, while it turns as fast as the rotor did.
    omega, arm, azimuth = 12.1 * np.pi / 30, 21.975, np.radians(170) + 12.1 * np.pi / 30 * 2
    y, z = -arm * np.sin(azimuth), 90 + arm * np.cos(azimuth)
    vy, vz = -omega * arm * np.cos(azimuth), -omega * arm * np.sin(azimuth)
    t = np.linspace(0, 8, 80001)
    angle = azimuth + omega * t
    tip, edge = np.maximum(-41.025 * np.cos(angle), 20.475 * np.cos(angle)), 1.5 * np.abs(np.sin(angle))
    duration = t[np.argmax(z + vz * t - G * t**2 / 2 < tip + edge)]
    assert landing - release == pytest.approx(duration, rel=0.01)
    assert centre[run.row(landing)][1] == pytest.approx(y + vy * duration, rel=0.02)
    # Each impact is one impulse of the ground at the points that hit it, with friction of at most half of it, and takes energy.
    for impact in (event for event in run.events if event["event"] == "impact"):
        push = np.subtract(impact["after"]["linear"], impact["before"]["linear"])
        assert push == pytest.approx(impact["impulse"], rel=1e-6, abs=1e-3)
        assert np.hypot(push[0], push[1]) < 0.5001 * push[2]
        assert impact["lost"] > 0
    first = run.events[2]
    turn = np.subtract(first["after"]["angular"], first["before"]["angular"])
    assert turn == pytest.approx(np.cross(first["point"], first["impulse"]), rel=1e-6)
    # It comes to lie flat, its centre not far from where it came down.
    assert centre[-1][2] == pytest.approx(0.25, abs=1e-6)
    assert np.linalg.norm(centre[-1] - centre[run.row(11)]) < 1e-6
    assert 0 < centre[run.row(landing)][1] - centre[-1][1] < 5
    # The nacelle sways by what the missing blade's force does to a tower with these hinges, between one and two times.
    hinges = {10.95: 23.6e9, 32.85: 16.3e9, 54.75: 10.8e9, 76.65: 6.8e9}
    give = sum((90 - height) ** 2 / stiffness for height, stiffness in hinges.items())
    top = 240e3 + 56780 + 2 * 17740 + 0.24 * 288.5e3
    resonance = 1 / (1 - omega**2 * top * give)
    sway = 17740 * arm * omega**2 * give * resonance
    assert sway < np.max(np.abs(run["turbine/nacelle.y"])) < 2 * sway
    assert abs(run["turbine/shaft.v0"][-1]) < 0.02 * omega
    assert abs(run.energy["error"]) < 1e-9 * run.energy["largest_kinetic"]


def test_line_cascade_three_towers_fall_and_the_strong_one_holds() -> None:
    run = Run("line_cascade")
    assert [event["released"] for event in run.events[:3]] == pytest.approx([0.5 * 17e3 * 1.47**2] * 3)
    yields = [event["actions"][0] for event in run.events if event["event"].startswith("yields")]
    assert yields == [f"set tower {k}/foot {k}" for k in (5, 6, 4, 3)]
    assert [event["actions"][0] for event in run.events[7:]] == [f"lock tower {k}/foot {k}" for k in (5, 4, 6, 3)]
    # What stands, leans: the feet's springs against the three conductors of the spans to the left, in equilibrium.
    heights, tension, stiffness = np.array([26, 26, 34]), 25e3, 17e3
    squares, moment = stiffness * np.sum(heights**2), tension * np.sum(heights)
    weights = np.array([6000, 9000]) * G * 13
    system = np.diag([40e6, 60e6] - weights) + squares * np.array([[2, -1], [-1, 1]])
    lean = np.linalg.solve(system, [0, -moment])
    last = run.time > 11
    for angle, joint in zip(lean, ("tower 1/foot 1", "tower 2/strong foot"), strict=True):
        assert np.mean(run[f"{joint}.q0"][last]) == pytest.approx(angle, rel=0.05)
    assert np.min(run["tower 2/strong foot.q0"]) > np.radians(-2.39)
    assert abs(run.energy["error"]) < 1e-5 * run.energy["largest_kinetic"]


def test_line_cascade_runs_through_a_tower_that_is_as_weak_as_the_others() -> None:
    weak = ["event.the strong tower yields.when.below=-0.03", "event.the strong tower yields.set.friction.coulomb=60e3"]
    run = Run("line_cascade", *(word for value in weak for word in ("--set", value)))
    assert "lock tower 2/strong foot" in [action for event in run.events for action in event["actions"]]
