"""A hanging chain is cut while it swings: its outer part flies off as a mechanism of its own.

A chain of 100 links starts horizontal at the ground, curls upwards and falls. At 1.8 s a pin breaks. From then on the centre of mass
of the loose part, however wildly it folds, moves on a parabola.
"""

# %%
import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="a shorter chain")
options, _ = arguments.parse_known_args()

# %% The chain: each link hangs on the one before, with a little friction in its pin.
links = 40 if options.quick else 100
cut = round(0.41 * links)
length, mass = 5.0 / links, 1.0 / links
model = mt.Model(gravity=(0, -9.81, 0))
for k in range(1, links + 1):
    model.add(
        f"chain/{k}",
        mass=mass,
        com=(length / 2, 0, 0),
        inertia=mass * length**2 / 12,
        parent=f"chain/{k - 1}" if k > 1 else None,
        at=(length, 0, 0) if k > 1 else (0, 0, 0),
        joint=mt.Revolute(axis=(0, 0, 1), damping=1e-5),
        q=0.001 * k * (100 / links) ** 2,
    )

# %% The pin breaks at 1.8 s.
sim = mt.Simulation(model, method="dopri5", rtol=1e-7, atol=1e-9)
sim.at(1.8).then(mt.break_joint(f"chain/{cut}")).named("cut")
run = sim.run(until=2.7, record_every=0.02)

# %% Positions of all pins in all rows, and the centre of mass of the loose part.
pins = np.stack([run.bodies[f"chain/{k}"].position[:, :2] for k in range(1, links + 1)], axis=1)
turns = np.stack([run.bodies[f"chain/{k}"].quaternion for k in range(1, links + 1)], axis=1)
angle = 2 * np.arctan2(turns[:, :, 3], turns[:, :, 0])
along = np.stack([np.cos(angle), np.sin(angle)], axis=2) * length
centre = (pins + along / 2)[:, cut - 1 :].mean(axis=1)
flight = run.time > 1.8
height = np.polyfit(run.time[flight], centre[flight, 1], 2)
error = np.abs(np.polyval(height, run.time[flight]) - centre[flight, 1]).max()
print(f"the loose part falls with {-2 * height[0]:.6f} m/s², off its parabola by at most {error:.1e} m")
print(f"the break took {run.events[0].lost:.1e} J; momentum changed by {run.events[0].linear_error:.1e} N s")

# %% The picture: the chain every 60 ms.
figure, axes = plt.subplots(figsize=(8, 6.4), layout="constrained")
tips = pins + along
held = np.concatenate([pins[:, : cut - 1], tips[:, cut - 2 : cut - 1]], axis=1)
loose = np.concatenate([pins[:, cut - 1 :], tips[:, -1:]], axis=1)
for row in range(0, len(run), 3):
    shade = 0.25 + 0.75 * run.time[row] / run.time[-1]
    for part, colours in ((held, plt.cm.Blues), (loose, plt.cm.Oranges if flight[row] else plt.cm.Blues)):
        axes.add_collection(LineCollection([part[row]], colors=[colours(shade)], linewidths=1.4, capstyle="round"))
axes.plot(*centre[flight].T, "k--", linewidth=1, label="centre of mass of the loose part")
axes.plot(0, 0, "ks", markersize=7)
axes.autoscale()
axes.set(aspect="equal", xlabel="x (m)", ylabel="y (m)", title=f"A chain of {links} links, cut at 1.8 s")
axes.legend(loc="upper left", frameon=False)
axes.spines[["top", "right"]].set_visible(False)
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "breaking_chain.png", dpi=110)
