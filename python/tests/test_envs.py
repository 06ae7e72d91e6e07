"""The Gymnasium environments: their API, their physics, and many worlds against one."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.error import ResetNeeded  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402

import momentree as mt  # noqa: E402
import momentree.envs  # noqa: E402
from momentree.envs.arm_loses_joint import ARM, ArmLosesJointEnv, ArmLosesJointVectorEnv  # noqa: E402
from momentree.envs.gripper import ARM as GRIPPER_ARM  # noqa: E402
from momentree.envs.gripper import GripperEnv, GripperVectorEnv  # noqa: E402

NAMES = ("momentree/Gripper-v0", "momentree/ArmLosesJoint-v0")


def towards(arm: momentree.envs.PlanarArm, observation: Any, way: Any, stiffness: float = 30.0) -> Any:
    """Actions that pull the tip along ``way``, by the transposed Jacobian; all with a row per world."""
    n = arm.joints
    points = arm.points(np.arctan2(observation[:, n : 2 * n], observation[:, :n]))
    lever = points[:, -1:] - points[:, :-1]
    torque = stiffness * (lever[:, :, 0] * way[:, 1:] - lever[:, :, 1] * way[:, :1]) - 1.5 * observation[:, 2 * n : 3 * n]
    return np.clip(torque / np.asarray(arm.torques), -1, 1)


def skilled(name: str, observation: Any) -> Any:
    """Actions of a policy that solves the task, a row per world."""
    if "ArmLoses" in name:
        return towards(ARM, observation, observation[:, 14:16])
    held = observation[:, 13:14] > 0
    action = towards(GRIPPER_ARM, observation, np.where(held, observation[:, 11:13], observation[:, 9:11]))
    there = np.linalg.norm(observation[:, 11:13], axis=1) < 0.03
    return np.concatenate([action, np.where(held[:, 0] & there, -1.0, 1.0)[:, None]], axis=1)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("options", [{}, {"actions": "discrete"}])
def test_gymnasiums_checker_accepts_the_environment(name: str, options: dict[str, Any]) -> None:
    if options and "Gripper" not in name:
        options = {"observe_fault": False}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*observation space m.*imum value is.*infinity.*")
        env = gymnasium.make(name, render_mode="rgb_array", **options).unwrapped
        check_env(env)


@pytest.mark.parametrize("name", NAMES)
def test_a_seed_determines_the_episode(name: str) -> None:
    def episode(env: Any, seed: int | None) -> Any:
        rows = [env.reset(seed=seed)[0]]
        for _ in range(60):
            rows.append(env.step(np.asarray(skilled(name, rows[-1][None])[0]))[0])
        return np.array(rows)

    one, other = gymnasium.make(name).unwrapped, gymnasium.make(name).unwrapped
    first = episode(one, 3)
    assert np.array_equal(first, episode(other, 3))
    second = episode(one, None)
    assert not np.array_equal(first, second)
    assert np.array_equal(second, episode(other, None))
    assert np.array_equal(first, episode(one, 3))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_worlds_of_a_batch_do_what_single_environments_do(name: str, mode: str) -> None:
    worlds, length = 6, 60 if "ArmLoses" in name else 90
    many = gymnasium.make_vec(
        name, num_envs=worlds, vectorization_mode="vector_entry_point", autoreset_mode=mode, max_steps=length, threads=2
    )
    singles = [gymnasium.make(name, max_steps=length).unwrapped for _ in range(worlds)]
    observation, _ = many.reset(seed=11)
    begins = [env.reset(seed=11 + i)[0] for i, env in enumerate(singles)]
    assert np.array_equal(observation, begins)
    over, ends = np.zeros(worlds, dtype=bool), 0
    names: set[str] = set()
    for _ in range(3 * length):
        if mode == "Disabled" and over.any():
            observation, _ = many.reset(options={"reset_mask": over})
            for world in np.flatnonzero(over):
                assert np.array_equal(observation[world], singles[world].reset()[0])
            over[:] = False
        begin = over.copy() if mode == "NextStep" else np.zeros(worlds, dtype=bool)
        action = skilled(name, observation)
        observation, reward, terminated, truncated, info = many.step(action)
        over = terminated | truncated
        ends += int(over.sum())
        for i, env in enumerate(singles):
            if begin[i]:
                assert np.array_equal(observation[i], env.reset()[0])
                assert (reward[i], over[i]) == (0.0, False)
                continue
            expected = env.step(action[i])
            last = info["final_obs"][i] if mode == "SameStep" and over[i] else observation[i]
            assert last == pytest.approx(expected[0], abs=1e-9)
            assert reward[i] == pytest.approx(expected[1], abs=1e-9)
            assert (terminated[i], truncated[i]) == expected[2:4]
            events = info["events"][i] if "events" in info and info["_events"][i] else []
            assert [each.name for each in events] == [each.name for each in expected[4]["events"]]
            for one, other in zip(events, expected[4]["events"], strict=True):
                names.add(one.name)
                assert one.time == pytest.approx(other.time, abs=1e-9)
                assert one.lost == pytest.approx(other.lost, abs=1e-9)
            if mode == "SameStep" and over[i]:
                assert info["final_info"]["distance"][i] == pytest.approx(expected[4]["distance"], abs=1e-9)
                assert np.array_equal(observation[i], env.reset()[0])
    assert ends > worlds
    assert names == ({"jam", "limp"} if "ArmLoses" in name else {"lift", "grasp", "drop"})


@pytest.mark.parametrize("name", NAMES)
def test_worlds_with_the_same_changes_share_a_topology(name: str) -> None:
    env = gymnasium.make_vec(name, num_envs=40, vectorization_mode="vector_entry_point", max_steps=110)
    observation, _ = env.reset(seed=0)
    most = 0
    for _ in range(200):
        observation, *_ = env.step(skilled(name, observation))
        most = max(most, int(env.unwrapped.batch.group.max()) + 1)
    # Gripper: resting, held, flying. Arm: intact, and limp at each of four joints, jammed at each of four.
    assert 2 < most <= (3 if "Gripper" in name else 9)


def test_the_gripper_carries_the_part_to_its_target() -> None:
    env = GripperVectorEnv(num_envs=40, autoreset_mode="Disabled", max_steps=400)
    observation, _ = env.reset(seed=5)
    landed = succeeded = np.zeros(40, dtype=bool)
    task = env._task
    for _ in range(400):
        active = ~landed
        outcome = task.step(task.checked(skilled("Gripper", observation)), active)
        observation, info = task.observe(), task.info()
        landed, succeeded = landed | outcome.terminated, succeeded | info["success"]
    assert landed.mean() > 0.8
    assert succeeded.sum() > 0.8 * landed.sum()


def test_a_grasp_is_an_impact_that_keeps_the_momentum_and_a_drop_takes_nothing() -> None:
    env = GripperEnv()
    observation, _ = env.reset(seed=5, options={"part": (0.7, 0.3), "target": (-0.6, 0.4), "q": (0.3, 0.3, 0.3)})
    events: dict[str, mt.Event] = {}
    closed = 1.0
    while len(events) < 3:
        action = skilled("Gripper", observation[None])[0]
        if "grasp" in events:
            closed = 1.0 if np.linalg.norm(observation[6:9]) < 1.0 else -1.0  # lets go in full motion
        action[-1] = closed
        observation, _, _, over, info = env.step(action)
        assert not over
        events.update({event.name: event for event in info["events"]})
    grasp, drop = events["grasp"], events["drop"]
    assert grasp.lost > 0
    assert grasp.before.energy - grasp.after.energy == pytest.approx(grasp.lost, rel=1e-9)
    assert grasp.linear_error < 1e-12
    assert drop.lost == pytest.approx(0, abs=1e-12)
    assert drop.linear_error < 1e-12
    # It falls freely: it lands where a thrown body lands.
    world = env.simulation.world
    part = world.bodies["part/part"]
    position, velocity = np.array(part.position), np.array(part.linear)
    seconds = (velocity[2] + np.sqrt(velocity[2] ** 2 + 2 * 9.81 * position[2])) / 9.81
    lands = position[:2] + velocity[:2] * seconds
    over = False
    while not over:
        _, _, over, _, info = env.step(action)
    assert info["distance"] == pytest.approx(np.linalg.norm(lands - [-0.6, 0.4]), abs=1e-7)


def test_the_arm_is_where_its_bodies_are() -> None:
    for env in (GripperEnv(), ArmLosesJointEnv(faults=("jam",))):
        arm = env._task.arm
        env.reset(seed=2)
        for _ in range(150):
            env.step(env.action_space.sample() * 0.5)
        for k in range(arm.joints):
            assert env._task.points[0, k] == pytest.approx(env.simulation.world.bodies[f"arm/{k + 1}"].position[:2], abs=1e-12)
        J = env.simulation.jacobian(f"arm/{arm.joints}", (arm.lengths[-1], 0, 0))
        tip_velocity = (J @ np.array(env.simulation.v))[:2]
        assert arm.tip_velocity(env._task.points, env._task.v)[0] == pytest.approx(tip_velocity, abs=1e-12)


@pytest.mark.parametrize("kind", ["jam", "limp"])
def test_a_joint_fails_at_its_instant(kind: str) -> None:
    env = ArmLosesJointEnv()
    env.reset(seed=1, options={"fault": {"kind": kind, "joint": 1, "time": 0.1234}})
    speeds, angles = [], []
    for step in range(30):
        observation, _, _, _, info = env.step(np.array([0.3, 0.9 if kind == "jam" else 0.6, 0.0, 0.0]))
        assert info["faulty_joint"] == (-1 if step < 3 else 1)
        assert list(observation[16:20]) == ([1, 1, 1, 1] if step < 3 else [1, 0, 1, 1])
        for event in info["events"]:
            assert step == 3
            assert event.time == pytest.approx(0.1234, abs=1e-12)
            assert (event.lost > 0) == (kind == "jam")
        speeds.append(observation[9])
        angles.append(np.arctan2(observation[5], observation[1]))
    if kind == "jam":
        assert np.ptp(angles[3:]) == 0.0
        assert not np.any(speeds[3:])
    else:
        assert np.ptp(angles[3:]) > 0.1
        assert env.simulation.effort[1] == 0.0


def constant(torque: float) -> Callable[[mt.Context], float]:
    return lambda _: torque


def test_a_jam_within_a_period_is_that_of_a_scheduled_event() -> None:
    env = ArmLosesJointEnv()
    env._task.substeps = 32
    start = [0.3, -0.4, 0.2, 0.5]
    env.reset(seed=1, options={"fault": {"kind": "jam", "joint": 2, "time": 0.5139}, "q": start})
    model = mt.Model()
    ARM.add_to(model)
    other = mt.Simulation(model, method="dop853", step=1e-3, rtol=1e-12, atol=1e-13)
    other.q = start
    other.at(0.5139).then(mt.lock("arm/3"))
    random = np.random.default_rng(0)
    for step in range(25):
        action = random.uniform(-1, 1, 4)
        env.step(action)
        for joint in range(4):
            torque = float(action[joint] * ARM.torques[joint])
            other.drive(f"arm/{joint + 1}", constant(torque))
        other.run(until=(step + 1) * env._task.period)
        assert env.simulation.time == pytest.approx(other.time, abs=1e-12)
        assert np.array(env.simulation.q) == pytest.approx(np.array(other.q), abs=1e-8)
    assert len(other.events) == len(env.simulation.events) == 1


def test_an_episode_without_fault_and_given_targets() -> None:
    env = ArmLosesJointEnv(max_steps=50)
    observation, info = env.reset(seed=1, options={"fault": None, "target": (0.5, 0.5), "q": [0.1, 0.2, 0.3, 0.4]})
    assert list(observation[12:14]) == [0.5, 0.5]
    assert np.arctan2(observation[4:8], observation[:4]) == pytest.approx([0.1, 0.2, 0.3, 0.4])
    for step in range(50):
        observation, _, terminated, truncated, info = env.step(skilled("ArmLoses", observation[None])[0])
        assert (terminated, truncated) == (False, step == 49)
        assert info["faulty_joint"] == -1
    assert info["targets_reached"] >= 1
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(4))


def test_pictures_show_the_world() -> None:
    env = gymnasium.make("momentree/Gripper-v0", render_mode="rgb_array").unwrapped
    env.reset(seed=1)
    before = env.render()
    assert before.shape == (320, 320, 3)
    assert before.dtype == np.uint8
    env.step(np.array([1.0, 1.0, 1.0, -1.0]))
    after = env.render()
    assert 50 < (before != after).any(axis=2).sum() < 0.2 * 320 * 320
    many = GripperVectorEnv(num_envs=2, render_mode="rgb_array")
    many.reset(seed=[1, 2])
    pictures = many.render()
    assert pictures is not None
    first, second = pictures
    assert np.array_equal(first, before)
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("worlds", [None, 3])
def test_bad_actions_are_refused(name: str, worlds: int | None) -> None:
    env: Any
    shape: tuple[int, ...]
    if worlds is None:
        env, shape = gymnasium.make(name).unwrapped, (4,)
    else:
        env, shape = gymnasium.make_vec(name, num_envs=3, vectorization_mode="vector_entry_point"), (3, 4)
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(shape))
    env.reset(seed=0)
    with pytest.raises(mt.Error, match=r"action: expected an array of shape .*found \(7,\)"):
        env.step(np.zeros(7))
    bad = np.zeros(shape)
    bad[..., 2] = np.nan
    with pytest.raises(mt.Error, match=r"action: world 0 has nan in component 2"):
        env.step(bad)
    with pytest.raises(mt.Error, match=r"action: expected numbers"):
        env.step(np.full(shape, "a"))
    env.step(np.full(shape, 50.0))  # clipped


def test_bad_options_are_refused() -> None:
    env = ArmLosesJointEnv()
    with pytest.raises(mt.Error, match="unknown key 'goal'"):
        env.reset(options={"goal": (0, 0)})
    with pytest.raises(mt.Error, match="target: expected two finite numbers"):
        env.reset(options={"target": (0, np.nan)})
    with pytest.raises(mt.Error, match="fault: expected kind"):
        env.reset(options={"fault": {"kind": "melt", "joint": 0, "time": 1}})
    with pytest.raises(mt.Error, match="q: expected 4 finite numbers"):
        env.reset(options={"q": [0.0]})
    for make in (
        lambda: GripperEnv(actions="other"),
        lambda: GripperEnv(render_mode="human"),
        lambda: ArmLosesJointEnv(faults=()),
    ):
        with pytest.raises(mt.Error):
            make()
    many = ArmLosesJointVectorEnv(num_envs=3, autoreset_mode="Disabled", max_steps=1)
    with pytest.raises(mt.Error, match="seed: expected one number or 3"):
        many.reset(seed=[1, 2])
    many.reset(seed=1)
    with pytest.raises(mt.Error, match="reset_mask"):
        many.reset(options={"reset_mask": [True]})
    many.step(np.zeros((3, 4)))
    with pytest.raises(ResetNeeded):
        many.step(np.zeros((3, 4)))


def test_discrete_actions_drive_the_motors() -> None:
    env = GripperEnv(actions="discrete")
    other = GripperEnv()
    env.reset(seed=4)
    other.reset(seed=4)
    discrete = env.step(np.array([2, 0, 1, 0]))
    continuous = other.step(np.array([1.0, -1.0, 0.0, -1.0]))
    assert np.array_equal(discrete[0], continuous[0])
    with pytest.raises(mt.Error, match="integers from 0"):
        env.step(np.array([3, 0, 1, 0]))
