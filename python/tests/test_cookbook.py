"""The scenarios of the cookbook show the physics that their recipes promise. Its Python blocks assert theirs, see test_docs."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import momentree as mt
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "docs/cookbook.md", ROOT / "docs/cookbook-runs.md"]


def text_of_pages() -> str:
    return "".join(page.read_text(encoding="utf-8") for page in PAGES)


def held(sim: mt.Simulation) -> None:
    sim.run()
    assert abs(sim["ur5/shoulder_lift_joint"].q[0] - np.radians(-60)) < 0.05


def dropped(sim: mt.Simulation) -> None:
    run = sim.run()
    assert run.bodies["box/box"].position[:, 2].min() > 0.1 - 1e-6
    assert abs(run.bodies["box/box"].position[-1, 2] - 0.1) < 1e-6


def loaded(sim: mt.Simulation) -> None:
    assert np.isclose(sim["panda/panda_joint4"].q[0], np.radians(-135))
    balance = sim.run().energy
    assert abs(balance["error"][-1]) < 1e-6 * np.abs(balance["kinetic"]).max()


def broken_at_the_load(sim: mt.Simulation) -> None:
    run = sim.run(reactions=True)
    wrist = next(event for event in run.events if "wrist_1_joint" in str(event.actions[0]))
    before = run.time < wrist.time
    force = np.linalg.norm(run.joints["ur5/wrist_1_joint"].reaction.force[before], axis=1)
    assert force.max() < 60 + 1e-6 and force[-1] > 55
    assert wrist.lost == 0
    assert np.allclose(wrist.before.linear, wrist.after.linear, atol=1e-12)


def snapped(sim: mt.Simulation) -> None:
    run = sim.run()
    (snap,) = run.events
    tension = run.springs["rope"].tension[run.time < snap.time]
    assert 3500 < tension.max() < 4000
    assert sim.world.springs["rope"].broken


def captured(sim: mt.Simulation) -> None:
    run = sim.run()
    (capture,) = run.events
    assert capture.lost > 0
    for before, after in ((capture.before.linear, capture.after.linear), (capture.before.angular, capture.after.angular)):
        assert np.allclose(before, after, atol=1e-9)
    apart = run.bodies["sat/hull"].position - run.bodies["tug/hull"].position
    distance = np.linalg.norm(apart[run.time >= capture.time], axis=1)
    assert np.allclose(distance, 1.5, atol=1e-6)


def docked(sim: mt.Simulation) -> None:
    run = sim.run()
    assert [str(event.actions[0]).split()[0] for event in run.events] == ["attach", "break"]
    push = run.bodies["sat/hull"].linear[-1] - run.bodies["sat/hull"].linear[run.time < 4][-1]
    assert np.allclose(push, (20 / 400, 0, 0), atol=1e-9)


def jammed(sim: mt.Simulation) -> None:
    run = sim.run()
    jam = run.events[0].time
    during = (run.time > jam) & (run.time < jam + 0.5)
    assert np.ptp(run.joints["ur5/elbow_joint"].q[during]) == 0
    assert np.ptp(run.joints["ur5/elbow_joint"].q[run.time > jam + 0.5]) > 0.01
    assert run.events[0].lost > 0


CHECKS: dict[str, Callable[[mt.Simulation], None]] = {
    "load_a_robot": loaded,
    "hold_a_pose": held,
    "drop_a_box": dropped,
    "break_at_a_load": broken_at_the_load,
    "fuse": broken_at_the_load,
    "snap_a_cable": snapped,
    "capture": captured,
    "dock_and_release": docked,
    "jam": jammed,
}


def scenarios() -> dict[str, str]:
    blocks = re.findall(r"^```toml\n# (\w+)\.toml\n(.*?)^```$", text_of_pages(), re.M | re.S)
    return {name: text for name, text in blocks if not re.search(r"^scenario *=", text, re.M)}


@pytest.mark.parametrize("name", sorted(CHECKS))
def test_scenario(name: str, tmp_path: Path) -> None:
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    path = tmp_path / f"{name}.toml"
    path.write_text(scenarios()[name], encoding="utf-8")
    sim = mt.load(path)
    assert not [each for each in sim.warnings if ": warning:" in each]
    CHECKS[name](sim)


def test_each_scenario_is_checked() -> None:
    assert set(scenarios()) == set(CHECKS)


def test_recipes_are_short() -> None:
    for language, block in re.findall(r"^```(python|toml)\n(.*?)^```$", text_of_pages(), re.M | re.S):
        assert sum(line.strip() != "" for line in block.split("\n")) <= (15 if language == "python" else 18), block
