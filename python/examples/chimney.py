"""Where a falling chimney breaks: the bending moment in it is largest a third of the height above the ground.

A slender uniform chimney that turns about its foot bends as it falls, since its upper part would fall slower on its own. Theory (a
rigid rod on a pin) gives the moment at the height x as M = (m g L / 4) sin θ · (x/L) (1 − x/L)².
"""

# %%
import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="fewer pieces")
options, _ = arguments.parse_known_args()

# %% A chimney of 30 m, of pieces that stand on one another. Its foot is a pin, all other joints are rigid.
height, mass, pieces = 30.0, 60e3, 15 if options.quick else 60
piece = height / pieces
model = mt.Model(gravity=(0, 0, -9.81))
for k in range(pieces):
    model.add(
        f"chimney/{k}",
        mass=mass / pieces,
        com=(0, 0, piece / 2),
        inertia=(mass / pieces * piece**2 / 12, mass / pieces * piece**2 / 12, 0.1),
        parent=f"chimney/{k - 1}" if k else None,
        at=(0, 0, piece) if k else (0, 0, 0),
        joint=mt.Weld() if k else mt.Revolute(axis=(0, 1, 0)),
        **({} if k else {"q": np.radians(5)}),
    )

# %% As it falls, the torque that each rigid joint transmits is the bending moment there.
intact = mt.Simulation(model, step=2e-3).run(until=4.8, record_every=0.02, reactions=True)
tilt = intact["chimney/0"].q[:, 0]
heights = np.arange(1, pieces) * piece
moment = np.stack([intact[f"chimney/{k}"].reaction.torque[:, 1] for k in range(1, pieces)], axis=1)
theory = mass * 9.81 * height / 4 * np.sin(tilt)[:, None] * (heights / height) * (1 - heights / height) ** 2
deviation = np.abs(np.abs(moment) - theory).max() / theory.max()
weakest = heights[np.argmax(np.abs(moment).max(axis=0))]
print(f"the moment is largest at {weakest / height:.4f} of the height")
print(f"it differs from the theory by at most {deviation:.1e} of its largest value")

# %% If the mortar holds 400 kN m, it breaks there, and what is above becomes a mechanism of its own.
sim = mt.Simulation(model, step=2e-3)
for k in range(1, pieces):
    sim.when(mt.reaction(f"chimney/{k}").torque > 400e3).then(mt.break_joint(f"chimney/{k}")).named(f"break {k}")
run = sim.run(until=4.7, record_every=0.02)
broken = [event for event in run.events if event.name.startswith("break")]
print(f"first break at {broken[0].time:.3f} s, {int(broken[0].name.split()[1]) * piece:.1f} m above the ground")

# %% The picture: the moment along the chimney, and the fall.
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 5), width_ratios=[1, 1.5], layout="constrained")
for degrees, colour in zip((10, 20, 40, 80), plt.cm.viridis(np.linspace(0.1, 0.8, 4)), strict=True):
    row = int(np.argmin(np.abs(np.degrees(tilt) - degrees)))
    left.plot(np.abs(moment[row]) / 1e3, heights, "o", color=colour, markersize=3.5)
    left.plot(theory[row] / 1e3, heights, "-", color=colour, linewidth=1, label=f"{np.degrees(tilt[row]):.0f}°")
left.axhline(height / 3, color="0.6", linestyle="--", linewidth=1)
left.text(-15, height / 3 + 0.4, "1/3", color="0.4")
left.set(xlabel="bending moment (kN m)", ylabel="height along the chimney (m)", title="Computed (dots) and theory (lines)")
left.legend(title="tilt", frameon=False)
for instant in (0, 2.5, 3.3, 3.7, 4.0, 4.3, 4.5, 4.7):
    row, shade = int(np.argmin(np.abs(run.time - instant))), plt.cm.copper(0.1 + 0.8 * instant / 4.7)
    for k in range(pieces):
        w, _, y, _ = run.bodies[f"chimney/{k}"].quaternion[row]
        start, turn = run.bodies[f"chimney/{k}"].position[row, [0, 2]], 2 * np.arctan2(y, w)
        end = start + 0.94 * piece * np.array([np.sin(turn), np.cos(turn)])
        right.plot(*np.array([start, end]).T, color=shade, linewidth=4, solid_capstyle="butt")
right.axhline(0, color="0.3", linewidth=1)
right.set(aspect="equal", xlabel="x (m)", ylabel="z (m)", ylim=(-1, 32), title="The fall: it breaks at a third of its height")
for axes in (left, right):
    axes.spines[["top", "right"]].set_visible(False)
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "chimney.png", dpi=110)
