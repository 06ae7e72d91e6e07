"""Runs each recipe of the cookbook by itself, and checks its physics: see tests/docs for the C++ programs, which print the same.

``SCENARIOS`` and ``PROGRAMS`` have a check for each scenario and each Python program. Where a recipe has both, they agree.
"""

from __future__ import annotations

import contextlib
import io
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import momentree as mt
import numpy as np
import pytest
from test_docs import ROOT, blocks_of

PAGES = sorted((ROOT / "docs").glob("cookbook*.md"))
GRAVITY = 9.81


def recipes() -> dict[str, str]:
    """Titles and texts."""
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    sections = re.split(r"^#{2,3} (.*)$", text, flags=re.M)
    return {title: section for title, section in zip(sections[1::2], sections[2::2], strict=True) if "```" in section}


def block(title: str, language: str) -> str:
    found = re.search(rf"^```{language}\n(.*?)^```$", recipes().get(title, ""), re.M | re.S)
    return found[1] if found else ""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(ROOT / "scenarios", tmp_path / "scenarios")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")


def joint(sim: mt.Simulation, name: str) -> mt.Joint:
    """That joint of the only mechanism, which scenarios name differently."""
    return next(each for each in sim.world.joints.values() if each.name.endswith("/" + name))


# The scenarios, after their run.
def loaded(sim: mt.Simulation, run: mt.Run) -> None:
    assert abs(sim.energy_balance["error"]) < 1e-6 * run.energy["kinetic"].max()
    one, other = (run.joints[f"panda/panda_finger_joint{k}"].q for k in (1, 2))
    assert np.isclose(run.joints["panda/panda_joint4"].q[0, 0], np.radians(-135)) and np.allclose(one, other, atol=1e-9)
    assert np.abs(run.joints["panda/panda_joint2"].q).max() < 1.7628 + 1e-6  # the limit in the file


def stands(sim: mt.Simulation, run: mt.Run | None = None) -> None:
    weight = GRAVITY * sum(body.mass for body in sim.world.bodies.values())
    contacts = sim.world.contacts
    assert {contact.one for contact in contacts} == {f"anymal/{leg}_FOOT" for leg in ("LF", "RF", "LH", "RH")}
    assert np.allclose(sum(contact.force for contact in contacts), (0, 0, weight), atol=0.1)


def held(sim: mt.Simulation, run: mt.Run) -> None:
    assert np.abs(sim.v).max() < 1e-4
    targets = np.array([0, -1, 0, 0, 0, 0])
    assert np.allclose(2000 * (targets - sim.q), sim.bias(), atol=1e-3)  # the servos carry the weight


def dropped(sim: mt.Simulation, run: mt.Run) -> None:
    impact, mass, speed = run.events[0], 500 * 0.2**3, np.sqrt(2 * GRAVITY * 1)
    assert impact.contact is not None
    assert np.isclose(impact.time, speed / GRAVITY, rtol=1e-8) and np.isclose(impact.contact.impulse[2], 1.3 * mass * speed)
    assert np.isclose(impact.lost, 0.5 * mass * speed**2 * (1 - 0.3**2))
    assert run.bodies["box/box"].position[:, 2].min() > 0.1 - 1e-9
    assert np.allclose(sim.world.bodies["box/box"].position, (0, 0, 0.1), atol=1e-8)


def broken_at_the_load(sim: mt.Simulation, run: mt.Run) -> None:
    (event,) = run.events
    assert event.lost == 0 and event.released == 0 and np.allclose(event.before.linear, event.after.linear, rtol=1e-12)
    assert event.before.kinetic == pytest.approx(event.after.kinetic, rel=1e-12)
    assert len(event.mechanisms_after) == len(event.mechanisms_before) + 1
    sim.undo()  # to just before it
    assert np.isclose(np.linalg.norm(joint(sim, "wrist_1_joint").reaction.force), 60, rtol=1e-6)


def snapped(sim: mt.Simulation, run: mt.Run) -> None:
    (event,) = run.events
    assert np.isclose(event.released, 4000**2 / (2 * 20e3), rtol=1e-6)
    assert event.before.kinetic == pytest.approx(event.after.kinetic, rel=1e-12)
    sim.undo()
    assert np.isclose(sim.world.springs["rope"].tension, 4000, rtol=1e-6)


def failed_gradually(sim: mt.Simulation, run: mt.Run) -> None:
    assert [str(event.actions[0]) for event in run.events] == [
        "change sign/sign to revolute",
        "change sign/sign to ball",
        "break sign/sign",
    ]
    for event in run.events:
        assert event.lost == 0 and event.before.kinetic == pytest.approx(event.after.kinetic, rel=1e-12)
    assert abs(sim.energy_balance["error"]) < 1e-6


def captured(sim: mt.Simulation, run: mt.Run) -> None:
    (event,) = run.events
    assert np.allclose(event.before.linear, event.after.linear, atol=1e-11)
    assert np.allclose(event.before.angular, event.after.angular, atol=1e-10)
    apart = run.bodies["sat/hull"].position - run.bodies["tug/hull"].position
    assert np.allclose(np.linalg.norm(apart[run.time >= event.time], axis=1), 1.5, atol=1e-8)
    # Afterwards both are one rigid body.
    arm = apart[np.searchsorted(run.time, event.time)]
    inertia = (60 + 70) * np.eye(3) + 300 * 400 / 700 * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    sat = event.before.linear / 400  # before, only the satellite moves
    spin = np.array([0, 0.1, 0.3]) * 70 + 300 * 400 / 700 * np.cross(arm, sat)
    after = event.before.linear @ event.before.linear / (2 * 700) + spin @ np.linalg.solve(inertia, spin) / 2
    assert np.isclose(event.after.kinetic, after) and np.isclose(event.lost, event.before.kinetic - after)


def docked(sim: mt.Simulation, run: mt.Run) -> None:
    dock, release = run.events
    assert dock.lost == 0 and dock.actions[0].joint == "dock" and release.actions[0].joint == "dock"
    assert np.allclose(sim.world.bodies["sat/hull"].linear, (20 / 400, 0, 0), atol=1e-12)
    assert np.allclose(sim.world.bodies["tug/hull"].linear, (-20 / 300, 0, 0), atol=1e-12)
    assert np.allclose(sim.momentum.linear, 0, atol=1e-12) and np.isclose(release.work, 20**2 / 2 * (1 / 400 + 1 / 300))


def closed(sim: mt.Simulation, run: mt.Run) -> None:
    assert (sim.world.loop_status.rows, sim.world.loop_status.rank) == (3, 2) and sim.world.loop_status.residual < 1e-9
    # The distance between the ends of crank and rocker is the length of the coupler.
    crank, rocker = run.joints["bar/crank"].q[:, 0], run.joints["bar/rocker"].q[:, 0]
    ends = np.stack([0.4 + 0.25 * np.cos(rocker) - 0.12 * np.cos(crank), 0.12 * np.sin(crank) - 0.25 * np.sin(rocker)])
    assert np.allclose(np.linalg.norm(ends, axis=0), 0.38, atol=1e-9)
    assert abs(sim.energy_balance["error"]) < 1e-6 * run.energy["kinetic"].max()


def gripped(sim: mt.Simulation, run: mt.Run) -> None:
    assert np.isclose(sim.world.bodies["can/can"].position[2], 0.055 + 0.3, atol=1e-6)
    on_can = [contact for contact in sim.world.contacts if "can/can" in (contact.one, contact.other)]
    sides = [contact.force if contact.one == "can/can" else -contact.force for contact in on_can]
    assert np.allclose(sum(sides), (0, 0, 0.3 * GRAVITY), atol=1e-6)  # friction carries the weight
    assert np.isclose(sum(max(force[0], 0) for force in sides), 12, rtol=1e-6)  # each finger presses with its drive


def jammed(sim: mt.Simulation, run: mt.Run) -> None:
    jam, free = run.events
    q = run.joints[jam.actions[0].joint].q[:, 0]
    assert (jam.time, free.time) == (0.2, 0.7)
    assert np.ptp(q[(run.time > jam.time) & (run.time < free.time)]) == 0 and np.ptp(q[run.time > free.time]) > 0.1
    assert jam.lost > 0 and np.isclose(jam.lost, jam.before.kinetic - jam.after.kinetic)
    assert free.lost == 0 and free.before.kinetic == pytest.approx(free.after.kinetic, rel=1e-12)


def hit(sim: mt.Simulation, run: mt.Run) -> None:
    (event,) = run.events
    assert np.allclose(event.after.linear - event.before.linear - event.ground_impulse.force, (0, 5, 0), atol=1e-12)
    assert np.isclose(event.work, event.after.kinetic - event.before.kinetic)
    assert np.isclose(np.linalg.norm(event.impulse["ur5/elbow_joint"].force), 2.215, atol=5e-4)


SCENARIOS: dict[str, Callable[[mt.Simulation, mt.Run], None]] = {
    "Load a robot": loaded,
    "Let a robot stand on the floor": stands,
    "Hold a pose": held,
    "Drop something on the floor": dropped,
    "Break a joint at a load": broken_at_the_load,
    "Give a joint a strength": broken_at_the_load,
    "Snap a cable": snapped,
    "Let a joint fail gradually": failed_gradually,
    "Capture on approach": captured,
    "Dock and release": docked,
    "Close a loop": closed,
    "Grip by friction": gripped,
    "Jam a joint for a while": jammed,
    "Hit a body": hit,
}


# What is left of the Python programs: their names.
def read_as_it_is(names: dict[str, Any]) -> None:
    # The tables of the arm: lengths along z, 88 mm along x, and the flange points downwards.
    assert np.allclose(names["hand"].position, (0.088, 0, 0.333 + 0.316 + 0.384 - 0.107), atol=1e-12)


def stood(names: dict[str, Any]) -> None:
    stands(names["sim"])


def hit_now(names: dict[str, Any]) -> None:
    sim, event = names["sim"], names["hit"]
    point = sim.jacobian("ur5_robot/forearm_link", point=(0, 0, 0.2))[:3] @ sim.v
    assert np.isclose(event.work, 0.5 * 5 * point[1])  # of a body that was at rest


def curved(names: dict[str, Any]) -> None:
    at_start = 0.5 * 0.43 * (25**2 + 8**2) + 0.5 * 1.9e-3 * 60**2
    assert np.isclose(names["sim"].energy.total, at_start, rtol=1e-6)  # a force across the velocity does no work


def braked(names: dict[str, Any]) -> None:
    assert np.isclose(names["brakes"].lost, 20, rtol=1e-6) and names["brakes"].after.kinetic < 1e-12


def controlled(names: dict[str, Any]) -> None:
    assert np.allclose(names["goal"] - names["sim"].q, names["goal"] * 11 * np.exp(-10), atol=5e-5)  # critical damping, 5 rad/s, 2 s


def varied(names: dict[str, Any]) -> None:
    results = names["results"]
    assert len(results.world) == 100 and not results.failed.any()
    assert np.allclose(results["kinetic"], GRAVITY * results["length"] / 2 * (1 - np.cos(results["angle"])), rtol=1e-5)
    quarter = np.pi / 2 * np.sqrt(2 * results["length"] / (3 * GRAVITY))
    small = results["angle"] < 0.3
    assert (results["time"] > quarter).all() and np.allclose(results["time"][small], quarter[small], rtol=0.01)


def swung(names: dict[str, Any]) -> None:
    still, away = sorted(names["batch"].groups, key=lambda group: group.q.shape[1])
    assert (still.q.shape[1], away.q.shape[1]) == (1, 7) and len(away.worlds) == names["high"].sum()
    started = np.asarray(still.worlds) / 2000
    energy = still.v[:, 0] ** 2 / 6 + GRAVITY / 2 * (1 - np.cos(still.q[:, 0]))
    assert np.allclose(energy, started**2 / 6, atol=1e-8)


def learned(names: dict[str, Any]) -> None:
    fault = names["fault"]
    assert np.isclose(fault.time, 0.5, atol=1e-12)
    assert np.isclose(fault.before.kinetic - fault.after.kinetic, fault.lost + fault.released)  # that of the rotor is released


def branched(names: dict[str, Any]) -> None:
    assert np.array_equal(names["sim"].p, names["other"].p) and names["sim"].time == names["other"].time == 1.0


def continued(names: dict[str, Any]) -> None:
    assert names["sim"].state_json() == names["again"].state_json()


def started_from_the_end(names: dict[str, Any]) -> None:
    one, heavy = mt.load("scenarios/pendulum.toml"), names["heavy"]
    one.run(1.0)
    again = mt.load("scenarios/pendulum.toml", state="swing/final.json")
    assert np.array_equal(one.q, again.q) and np.array_equal(one.v, again.v)
    assert heavy.time == 2.0 and np.array_equal(heavy.world.gravity, (0, 0, -20))


def plotted(names: dict[str, Any]) -> None:
    last = names["sim"].world.joints["crane/rope3"].reaction.force
    assert np.isclose(names["force"][-1], np.linalg.norm(last)) and Path("rope.png").read_bytes().startswith(b"\x89PNG")


def reported(names: dict[str, Any]) -> None:
    assert mt.load("scenarios/crane.toml").title in Path("crane.html").read_text(encoding="utf-8")
    assert Path("energies.png").read_bytes().startswith(b"\x89PNG")


def saved(names: dict[str, Any]) -> None:
    table = np.genfromtxt("crane_tables/energy.csv", delimiter=",", names=True)
    assert np.array_equal(table["kinetic"], names["run"].energy["kinetic"])
    assert np.array_equal(table["kinetic"], names["frame"]["kinetic"])


def exported(names: dict[str, Any]) -> None:
    for file, start in (("crane.glb", b"glTF"), ("crane.usda", b"#usda 1.0"), ("crane.mcap", b"\x89MCAP")):
        assert Path(file).read_bytes().startswith(start)


def shown(names: dict[str, Any]) -> None:
    assert np.isclose(names["sim"].time, 0.4)


def posed(names: dict[str, Any]) -> None:
    body = names["sim"].world.bodies["ur5_robot/wrist_3_link"]
    assert np.allclose(body.position, (0.4, 0.2, 0.5), atol=1e-8) and abs(body.quaternion[1]) == pytest.approx(1)


def rested(names: dict[str, Any]) -> None:
    sim, rest = names["sim"], names["rest"]
    assert rest.stable and np.allclose(sim.accelerations(), 0, atol=1e-9)
    (q,) = rest.q  # the moment of both ropes about the hinge is that of the weight
    end = 8 * np.array([np.cos(q), np.sin(q)])
    rope = np.array([0, 6]) - end
    arm = abs(end[0] * rope[1] - end[1] * rope[0]) / np.hypot(*rope)
    assert 2 * arm * sim.world.springs["left"].tension == pytest.approx(400 * GRAVITY * 4 * np.cos(q), rel=1e-9)


def linearised(names: dict[str, Any]) -> None:
    assert names["mode"].stable
    # A small push vibrates at that frequency.
    sim = mt.Simulation(names["model"])
    sim.set_state(q=mt.equilibrium(sim).q, v=[1e-4])
    (mode,) = mt.linearize(sim).modes()
    quarter = np.arctan2(abs(mode.eigenvalue.imag), -mode.eigenvalue.real) / abs(mode.eigenvalue.imag)
    sim.run(quarter)
    assert abs(sim.v[0]) < 1e-7


PROGRAMS: dict[str, Callable[[dict[str, Any]], None]] = {
    "Reach a pose": posed,
    "Find where it rests": rested,
    "Linearise it": linearised,
    "Load a robot": read_as_it_is,
    "Let a robot stand on the floor": stood,
    "Hit a body": hit_now,
    "Apply your own force": curved,
    "Use your own trigger": braked,
    "Control a mechanism step by step": controlled,
    "Run 10,000 variations": varied,
    "Step 10,000 copies together": swung,
    "Train after a failure": learned,
    "Try again from an instant": branched,
    "Stop a long run and continue": continued,
    "Start from the end of a run": started_from_the_end,
    "Plot a reaction": plotted,
    "Make a report": reported,
    "Save tables": saved,
    "Export a run": exported,
    "Watch it live": shown,
}


def run_program(title: str) -> dict[str, Any]:
    (found,) = blocks_of(recipes()[title])
    for package in ("gymnasium", "matplotlib", "pandas"):
        if package in found.code or {"matplotlib": ".plot(", "pandas": ".to_pandas("}.get(package, package) in found.code:
            pytest.importorskip(package)
    names: dict[str, Any] = {"__name__": "__main__"}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(found.code, title, "exec"), names)
    if found.printed is not None:
        assert printed.getvalue() == found.printed
    return names


def run_scenario(title: str) -> tuple[mt.Simulation, mt.Run]:
    Path("recipe.toml").write_text(block(title, "toml"), encoding="utf-8")
    sim = mt.load("recipe.toml")
    assert not [each for each in sim.warnings if ": warning:" in each and "anymal" not in each]
    sim.keep_history()
    return sim, sim.run()


@pytest.mark.parametrize("title", [title for title in recipes() if block(title, "python")])
def test_program(title: str) -> None:
    names = run_program(title)
    if title in PROGRAMS:
        PROGRAMS[title](names)
        return
    sim = names["sim"]
    like, _ = run_scenario(title)
    one, other = ([event for event in each.events if event.time > 0] for each in (sim, like))  # at 0, the program may set up
    assert np.allclose([event.time for event in one], [event.time for event in other], atol=1e-9)
    assert np.allclose([event.lost for event in one], [event.lost for event in other], atol=1e-6)
    assert np.allclose(sim.q, like.q, atol=1e-4 if like.world.contacts else 1e-6)


@pytest.mark.parametrize("title", SCENARIOS)
def test_scenario(title: str) -> None:
    SCENARIOS[title](*run_scenario(title))


def test_sweep() -> None:
    Path("failures.toml").write_text(block("Run 10,000 variations", "toml"), encoding="utf-8")
    results = mt.Sweep("failures.toml").run(worlds=range(200))
    fails, strength = results["fails"] == 1, results["event.axle fails.when.exceeds"]
    assert 0 < fails.sum() < 200 and not results.failed.any()
    assert np.allclose(results["largest"][fails], strength[fails], rtol=1e-6)
    assert (results["largest"][~fails] < strength[~fails]).all()


def test_each_recipe_is_checked() -> None:
    scenarios = {title for title in recipes() if re.search(r"^\[integrate\]|^integrate", block(title, "toml"), re.M)}
    assert scenarios == set(SCENARIOS) and len(recipes()) >= 25
    assert {title for title in recipes() if block(title, "python")} == set(PROGRAMS) | scenarios


@pytest.mark.parametrize("language", ["python", "toml", "cpp"])
def test_recipes_are_short(language: str) -> None:
    for title in recipes():
        lines = [line for line in block(title, language).split("\n") if line.strip() and not re.match(r" *(#|//|using )", line)]
        assert len(lines) <= 15, title
