"""Ten thousand double pendulums in one batch: when does each of them flip over?

Each world starts from other angles. The time until the lower rod turns over is smooth in some regions and fractal in others: the
double pendulum is chaotic. Where the energy does not suffice, it never does.
"""

# %%
import argparse
from pathlib import Path
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="fewer worlds")
options, _ = arguments.parse_known_args()

# %% Two equal uniform rods, and a world for each pair of start angles.
model = mt.Model(gravity=(0, 0, -9.81))
for name, parent in (("pendulum/upper", None), ("pendulum/lower", "pendulum/upper")):
    model.add(name, mass=1, com=(0, 0, -0.5), inertia=1 / 12, parent=parent, at=(0, 0, -1 if parent else 0),
              joint=mt.Revolute(axis=(0, 1, 0)))  # fmt: skip
side = 40 if options.quick else 100
angles = (np.arange(side) + 0.5) / side * 2 * np.pi - np.pi
upper, lower = (each.ravel() for each in np.meshgrid(angles, angles, indexing="ij"))  # both from the vertical
batch = mt.Batch(model, side**2)
batch.set_state(q=np.stack([upper, lower - upper], axis=1), v=np.zeros((side**2, 2)))


def energy(q, v):
    """Of all worlds (J): kinetic and potential, from the equations of the double pendulum."""
    a, b, va, vb = q[:, 0], q.sum(axis=1), v[:, 0], v.sum(axis=1)
    kinetic = va**2 * (1 / 6 + 1 / 2) + vb**2 / 6 + va * vb * np.cos(a - b) / 2
    return kinetic - 9.81 * (1.5 * np.cos(a) + 0.5 * np.cos(b))


# %% Ten seconds; the lower rod has flipped when its angle passes ±180° from the vertical.
h, end = 0.005, 10.0
start = energy(batch.q, batch.v)
flipped = np.full(side**2, np.nan)
began = perf_counter()
for k in range(round(end / (4 * h))):
    batch.run(h, 4)
    turned = np.abs(batch.q.sum(axis=1)) > np.pi
    flipped[turned & np.isnan(flipped)] = (k + 1) * 4 * h
took = perf_counter() - began
error = np.abs(energy(batch.q, batch.v) - start)
impossible = start < -9.81  # the lower rod upright over the hanging upper one needs −9.81 J
print(f"{len(batch) * round(end / h) / took / 1e6:.2f} million steps per second")
print(f"{np.isfinite(flipped).mean():.1%} flip within {end:g} s; of those without the energy for it, {np.isfinite(flipped[impossible]).sum()}")
print(f"median energy error {np.median(error):.1e} J")

# %% The picture.
figure, axes = plt.subplots(figsize=(6.6, 5.6), layout="constrained")
grid = flipped.reshape(side, side).T
image = axes.imshow(np.log10(grid), origin="lower", extent=(-180, 180, -180, 180), cmap="magma_r", vmin=-0.5)
axes.contour(np.degrees(angles), np.degrees(angles), start.reshape(side, side).T, levels=[-9.81], colors="#2a7f9e", linewidths=1.2)
axes.set_facecolor("#dfe9ec")
axes.set(xlabel="upper rod (degrees from the vertical)", ylabel="lower rod (degrees from the vertical)")
axes.set_title(f"{side**2} double pendulums: time until the lower rod flips")
axes.set(xticks=range(-180, 181, 90), yticks=range(-180, 181, 90))
bar = figure.colorbar(image, ax=axes, label="time (s)", ticks=np.log10([0.32, 0.5, 1, 2, 5, 9.9]))
bar.set_ticklabels(["0.3", "0.5", "1", "2", "5", "10"])
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "batch_of_10000.png", dpi=110)
