"""An arm learns to go on after it has lost a joint, by CMA-ES on a batch of worlds.

In ``momentree/ArmLosesJoint-v0`` an arm of four joints reaches for targets; at a random instant a joint jams or goes limp. The
policy is small: the torque of each joint is a gain times the pull of the target on it (the transposed Jacobian times the way to go),
minus another gain times its velocity, with a set of gains for the intact arm and one for each lost joint: 40 numbers, which begin at
zero. One vectorised environment runs the episodes of a whole generation at once. Needs ``pip install gymnasium cma matplotlib``.
"""

# %%
import argparse
from pathlib import Path
from time import perf_counter

import cma
import gymnasium
import matplotlib.pyplot as plt
import numpy as np

import momentree.envs  # noqa: F401 (registers the environments)
from momentree.envs.arm_loses_joint import ARM

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="fewer generations and episodes")
options, _ = arguments.parse_known_args()
generations, population, episodes = (12, 16, 12) if options.quick else (40, 24, 24)
joints, steps = 4, 200


# %% The policy, for all worlds at once. The observation has cosines, sines, velocities, target, the way to it, and working motors.
def policy(gains, observation):
    """Actions, shape (worlds, 4), of gains (worlds, 5, 2, 4)."""
    cosines, sines, v, _, way, works = np.split(observation, [4, 8, 12, 14, 16], axis=1)
    points = ARM.points(np.arctan2(sines, cosines))
    lever = points[:, -1:] - points[:, :-1]
    pull = lever[:, :, 0] * way[:, 1:] - lever[:, :, 1] * way[:, :1]
    state = np.where(works.all(axis=1), 0, 1 + works.argmin(axis=1))
    stiff, damp = np.moveaxis(gains[np.arange(len(gains)), state], 1, 0)
    return np.tanh(20 * stiff * pull - damp * v)


def returns(env, candidates, seed):
    """Mean return and targets reached of each candidate, shape (candidates,), on the same episodes for all of them."""
    each = env.num_envs // len(candidates)
    gains = np.repeat(np.reshape(candidates, (-1, 1 + joints, 2, joints)), each, axis=0)
    observation, info = env.reset(seed=[seed + i for _ in candidates for i in range(each)])
    total = np.zeros(env.num_envs)
    for _ in range(steps):
        observation, reward, _, _, info = env.step(policy(gains, observation))
        total += reward
    return total.reshape(-1, each).mean(axis=1), info["targets_reached"].reshape(-1, each).mean(axis=1)


def make(worlds):
    return gymnasium.make_vec(
        "momentree/ArmLosesJoint-v0",
        num_envs=worlds,
        vectorization_mode="vector_entry_point",
        autoreset_mode="Disabled",
        max_steps=steps,
    )


# %% Learn. Every generation meets new targets and failures.
strategy = cma.CMAEvolutionStrategy(np.zeros(8 * (1 + joints)), 0.3, {"popsize": population, "seed": 1, "verbose": -9})
env, test = make(population * episodes), make(64 if options.quick else 256)
began, curve = perf_counter(), []
before, reached_before = returns(test, [strategy.mean], seed=10**6)
for generation in range(generations):
    candidates = strategy.ask()
    values, reached = returns(env, candidates, seed=generation * episodes)
    strategy.tell(candidates, -values)
    curve.append((values.mean(), values.min(), values.max(), reached.mean()))
after, reached_after = returns(test, [strategy.mean], seed=10**6)
took = perf_counter() - began
print(f"mean return {before[0]:.2f} before, {after[0]:.2f} after {generations} generations")
print(f"targets reached per episode: {reached_before[0]:.2f} before, {reached_after[0]:.2f} after, with episodes not seen before")
print(f"{generations * population * episodes * steps / took:.0f} steps per second, {took:.1f} s")

# %% The learning curve, and an arm that has lost its elbow and reaches its target.
mean, worst, best, reached = np.transpose(curve)
figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.4), width_ratios=[1.4, 1], layout="constrained")
left.fill_between(range(1, generations + 1), worst, best, color="#1f6fb2", alpha=0.2, label="worst and best of a generation")
left.plot(range(1, generations + 1), mean, color="#1f6fb2", label="mean of a generation")
left.axhline(after[0], color="#2a9d5c", linestyle="--", label="learned policy, on other episodes")
left.axhline(before[0], color="0.5", linestyle=":", label="before")
left.set(xlabel="generation", ylabel="return of an episode", title="Learning to reach with a joint that fails")
left.legend(edgecolor="white", framealpha=1, fontsize=9, loc="lower right")
left.spines[["top", "right"]].set_visible(False)
single = gymnasium.make("momentree/ArmLosesJoint-v0", render_mode="rgb_array", max_steps=steps).unwrapped
single.picture_size = 480
observation, info = single.reset(seed=3, options={"fault": {"kind": "jam", "joint": 1, "time": 0.5}})
trail = []
while info["targets_reached"] < 3 and len(trail) < steps:
    observation, _, _, _, info = single.step(policy(strategy.mean.reshape(1, 5, 2, 4), observation[None])[0])
    trail.append(observation[12:14] - observation[14:16])
extent = 1.12 * ARM.reach
right.imshow(single.render(), extent=(-extent, extent, -extent, extent))
right.plot(*np.transpose(trail), color="#d1603d", linewidth=1)
right.axis("off")
right.set_title(f"Elbow jammed; {info['targets_reached']} targets in {0.04 * len(trail):.1f} s")
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "learn_after_failure.png", dpi=110)
