"""How much energy does a jamming knee take? It depends on the instant: a distribution over 4000 swings of a leg.

A leg swings from its hip. In each world of a batch the knee jams at its own random instant, exactly then and not at the end of a
step: an impact, whose loss the event's certificate tells.
"""

# %%
import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="fewer worlds")
options, _ = arguments.parse_known_args()

# %% Thigh and shank with foot, released with the thigh forwards.
model = mt.Model(gravity=(0, 0, -9.81))
model.add("leg/thigh", mass=8, com=(0, 0, -0.19), inertia=(0.13, 0.13, 0.02), joint=mt.Revolute(axis=(0, 1, 0), damping=0.15), q=-1.3)
model.add("leg/shank", mass=4.5, com=(0, 0, -0.23), inertia=(0.09, 0.09, 0.01), parent="leg/thigh", at=(0, 0, -0.42),
          joint=mt.Revolute(axis=(0, 1, 0), damping=0.08), q=0.5)  # fmt: skip

# %% Each world steps to its instant, jams, and completes the step.
worlds, h, end = 500 if options.quick else 4000, 0.005, 2.0
instants = np.random.default_rng(1).uniform(0, end, worlds)
batch = mt.Batch(model, worlds)
lost, before = np.empty(worlds), np.empty(worlds)
for k in range(round(end / h)):
    jams = np.flatnonzero((instants >= k * h) & (instants < (k + 1) * h))
    to_jam = np.full(worlds, h)
    to_jam[jams] = instants[jams] - k * h
    batch.step(to_jam)
    for world, event in zip(jams, batch.apply(jams, mt.lock("leg/shank"), name="jam"), strict=True):
        lost[world], before[world] = event.lost, event.before.kinetic
    batch.step(h - to_jam)

# %% The first hundred once more, one by one on simulations with a scheduled event.
difference = 0.0
for world in range(20 if options.quick else 100):
    sim = mt.Simulation(model, step=h)
    sim.at(instants[world]).then(mt.lock("leg/shank"))
    sim.run(until=instants[world] + h)
    difference = max(difference, abs(sim.events[0].lost - lost[world]))
share = lost / before
print(f"mean loss {lost.mean():.4f} J, 95 % of the jams take less than {np.quantile(lost, 0.95):.4f} J")
print(f"a jam takes {share.min():.2%} to {share.max():.1%} of the kinetic energy")
print(f"batch and simulations differ by at most {difference:.1e} J")

# %% The picture: the loss against the instant, and its distribution.
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), width_ratios=[1.6, 1], sharey=True, layout="constrained")
dots = left.scatter(instants, lost, c=100 * share, s=6, cmap="plasma")
figure.colorbar(dots, ax=left, label="share of the kinetic energy (%)")
left.set(xlabel="instant of the jam (s)", ylabel="energy lost (J)", title=f"A knee that jams, {worlds} worlds")
right.hist(lost, bins=50, orientation="horizontal", color="#7a5195")
right.axhline(lost.mean(), color="k", linestyle="--", linewidth=1)
right.text(right.get_xlim()[1], lost.mean() + 0.02 * lost.max(), "mean", ha="right")
right.set(xlabel="worlds", title="Distribution")
for axes in (left, right):
    axes.spines[["top", "right"]].set_visible(False)
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "jammed_joint_monte_carlo.png", dpi=110)
