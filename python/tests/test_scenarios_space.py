"""The scenarios in space do what docs/examples says: hand estimates and conservation laws."""

import numpy as np
import pytest
from scenario_run import Run


def test_debris_tug_the_tether_parts_at_its_strength() -> None:
    run = Run("debris_tug")
    assert run.names() == ["strength of tether"]
    event = run.events[0]
    # The engine gives the momentum, 400 N less a ramp of 0.1 s; the mast bends it aside by less than a degree.
    assert np.linalg.norm(event["before"]["linear"]) == pytest.approx(400 * (event["time"] - 1.05), rel=1e-3)
    assert event["before"]["linear"] == event["after"]["linear"]
    rate = run["tether.rate"][run.row(event["time"])]
    assert event["released"] == pytest.approx((1200 - 20 * rate) ** 2 / (2 * 2500), rel=0.02)
    assert abs(run.energy["error"]) < 1e-5 * run.energy["largest_kinetic"]


@pytest.mark.parametrize("slack", [1.0, 3.0])
def test_debris_tug_the_jerk_is_that_of_two_masses_and_a_spring(slack: float) -> None:
    still = ["--set", "mechanism.stage.state.velocity.angular=[0, 0, 0]", "--set", "spring.tether.strength=1e9"]
    run = Run("debris_tug", *still, "--set", f"spring.tether.rest={37 + slack}", "--until", "9")
    chaser, stage = 1520.0, 1434.0
    reduced = chaser * stage / (chaser + stage)
    bridle = 4 * 40e3 * 5**2 / (5**2 + 1.2**2)  # four lines, inclined to the tether
    stiffness = 1 / (1 / 2500 + 1 / bridle)
    speed = np.sqrt(2 * 400 / chaser * slack)
    share = 400 * stage / (chaser + stage)  # what tows the stage in the long run
    estimate = share + np.sqrt(share**2 + stiffness * reduced * speed**2)
    assert np.max(run["tether.tension"]) == pytest.approx(estimate, rel=0.03)


def cross(a: np.ndarray, b: np.ndarray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def wing(s: float, side: int) -> list[tuple[np.ndarray, float]]:
    """Centres (y, z) and angles about x of a wing's three panels in the hull's axes, the root hinge at angle ``s``."""
    joint, heading, panels = np.array([0.6 * side, 0.8]), 0.0, []
    for sign, angle in ((1, s), (-1, 2 * s), (1, 2 * s)):
        heading += side * sign * angle
        along = side * np.array([np.cos(heading), np.sin(heading)])
        panels.append((joint + 0.6 * along, heading))
        joint = joint + 1.2 * along
    return panels


def test_solar_array_jam_turns_the_hull_as_its_angular_momentum_says() -> None:
    run = Run("solar_array_jam")
    assert run.names() == ["left wing jams", "right wing latches"]
    for event in run.events:
        assert np.linalg.norm(event["after"]["angular"]) < 1e-9
    # One wing straight, the other half-way: so much energy is left in the springs, 0.15 N m/rad from -60 degrees on.
    turns = np.radians([60, 60, 60, 60 + 45, 60 + 90, 60 + 90])
    assert run.energy["final"] == pytest.approx(0.5 * 0.15 * np.sum(turns**2), rel=1e-4)
    assert run.energy["dissipated"] + run.energy["lost_in_impacts"] == pytest.approx(
        run.energy["initial"] - run.energy["final"], rel=1e-8
    )
    # Both wings together do not turn the hull.
    hull = 2 * np.degrees(np.arctan2(run["sat/hull.qx"], run["sat/hull.qw"]))
    assert np.max(np.abs(hull[: run.row(run.events[0]["time"])])) < 1e-6
    # From then on the angular momentum about x stays 0: the turn of the hull is an integral over the angle of the right wing.
    turned, mass, spin = 0.0, 8.6, 1.03
    angles = np.linspace(np.pi / 4, 0, 2001)
    for one, other in zip(angles[:-1], angles[1:], strict=True):
        before, after = (wing(s, 1) + wing(np.pi / 4, -1) for s in (one, other))
        centre = [mass * sum(place for place, _ in panels) / (600 + 6 * mass) for panels in (before, after)]
        inertia, relative = 120.0 + 600 * centre[0] @ centre[0], 600 * cross(centre[0], centre[1] - centre[0])
        for (here, angle), (there, next_angle) in zip(before, after, strict=True):
            arm, step = here - centre[0], there - here - (centre[1] - centre[0])
            inertia += mass * arm @ arm + spin
            relative += mass * cross(arm, step) + spin * (next_angle - angle)
        turned -= float(relative) / inertia
    assert abs(hull[-1]) == pytest.approx(abs(np.degrees(turned)), rel=0.01)
    assert abs(hull[-1]) > 3


def test_chain_to_ring_momentum_is_that_of_the_blow() -> None:
    run = Run("chain_to_ring")
    assert run.names() == ["clasp", "blow", "cut"]
    clasp, blow, cut = run.events
    assert clasp["lost"] == pytest.approx(clasp["before"]["kinetic"] - clasp["after"]["kinetic"], rel=1e-9)
    assert np.linalg.norm(clasp["after"]["linear"]) < 1e-12
    assert cut["after"]["linear"] == pytest.approx([0, 0.2, 0], abs=1e-12)
    assert cut["after"]["angular"] == pytest.approx(blow["after"]["angular"], abs=1e-12)
    links = [f"chain/{k}" for k in range(1, 13)]
    centre = run.centre(*links)
    since = run.row(blow["time"]) + 1
    drift = (centre[-1] - centre[since]) / (run.time[-1] - run.time[since])
    assert drift == pytest.approx([0, 0.2 / (12 * 0.115), 0], abs=1e-8)
