"""A servicing spacecraft grasps a tumbling satellite with its arm, stiffens the arm, and lets go again.

No force acts from outside: whatever is welded, locked and broken, momentum and angular momentum stay what they are. Energy does
not: the grasp is an impact.
"""

# %%
import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Polygon

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="a larger step")
options, _ = arguments.parse_known_args()

# %% The tug with an arm of two links, and the satellite, which drifts and tumbles. Gravity is off.
model = mt.Model(gravity=(0, 0, 0))
model.add("tug/hull", mass=320, inertia=(55, 62, 70), joint=mt.Free())
model.add("tug/upper", mass=14, com=(0.45, 0, 0), inertia=(0.05, 0.95, 0.95), parent="tug/hull", at=(0.5, 0, 0), q=0.6,
          joint=mt.Revolute(axis=(0, 0, 1), damping=12))  # fmt: skip
model.add("tug/forearm", mass=11, com=(0.4, 0, 0), inertia=(0.04, 0.6, 0.6), parent="tug/upper", at=(0.9, 0, 0), q=-1.1,
          joint=mt.Revolute(axis=(0, 0, 1), damping=8))  # fmt: skip
model.add("satellite/hull", mass=420, inertia=(60, 75, 48), joint=mt.Free(), q=(3.3, 0.15, 0.1, 1, 0, 0, 0),
          v=(-0.25, 0.0, 0.0, 0.02, 0.05, 0.35))  # fmt: skip
tip = (0.8, 0, 0)

# %% The tug grasps when the satellite's centre is within 1 m of the hand, stiffens a second later, and lets go after five more.
sim = mt.Simulation(model, step=5e-3 if options.quick else 1e-3)
near = mt.distance("tug/forearm", "satellite/hull", tip) < 1.0
sim.when(near).then(mt.weld("satellite/hull", "tug/forearm")).named("grasp")
sim.after("grasp", delay=1.0).then(mt.lock("tug/upper"), mt.lock("tug/forearm")).named("stiffen")
sim.after("grasp", delay=6.0).then(mt.break_joint("grasp"), mt.unlock("tug/upper"), mt.unlock("tug/forearm")).named("let go")
run = sim.run(until=20.0, record_every=0.05)
grasp, stiffen, release = run.events

# %% What is conserved, and what is not.
momenta = np.stack([run.energy[f"{kind}.{axis}"] for kind in ("linear", "angular") for axis in "xyz"], axis=1)
drift = np.abs(momenta - momenta[0]).max() / np.abs(momenta[0]).max()
print(f"momenta changed by at most {drift:.1e} of their size")
print(f"the grasp at {grasp.time:.3f} s took {grasp.lost:.3f} J of {grasp.before.kinetic:.3f} J; stiffening took {stiffen.lost:.3f} J")

# %% The picture: seen from above at five instants, and the energies.
def outline(row, name, x, y):
    w, qx, qy, qz = run.bodies[name].quaternion[row]
    turn = np.array([[1 - 2 * (qy**2 + qz**2), 2 * (qx * qy - w * qz)], [2 * (qx * qy + w * qz), 1 - 2 * (qx**2 + qz**2)]])
    return run.bodies[name].position[row, :2] + np.stack([x, y], axis=1) @ turn.T


figure, (above, below) = plt.subplots(2, 1, figsize=(9, 5.2), height_ratios=[1, 1.15], layout="constrained")
box = np.array([-0.5, 0.5, 0.5, -0.5]), np.array([-0.5, -0.5, 0.5, 0.5])
instants = [0.0, grasp.time, grasp.time + 3.0, release.time, 20.0]
for k, instant in enumerate(instants):
    row, across = int(np.argmin(np.abs(run.time - instant))), np.array([6 * k + 1.6, 0.0])
    across = across - (run.bodies["tug/hull"].position[row, :2] + run.bodies["satellite/hull"].position[row, :2]) / 2
    above.add_patch(Polygon(outline(row, "tug/hull", *box) + across, facecolor="#5b7fa6", edgecolor="#2e4660"))
    above.add_patch(Polygon(outline(row, "satellite/hull", *box) + across, facecolor="#e0a050", edgecolor="#80551d"))
    panels = (np.array([-1.4, -0.5]), np.array([0.5, 1.4]))
    for panel in panels:
        above.plot(*(outline(row, "satellite/hull", np.zeros(2), panel) + across).T, color="#3d6fd1", linewidth=5, solid_capstyle="butt")
    joints = [outline(row, name, np.zeros(1), np.zeros(1))[0] for name in ("tug/upper", "tug/forearm")]
    hand = outline(row, "tug/forearm", np.array([0.8]), np.zeros(1))[0]
    above.plot(*(np.array([*joints, hand]) + across).T, "o-", color="#333", linewidth=3, markersize=4)
    above.text(6 * k + 1.6, -2.4, f"{run.time[row]:.2f} s", ha="center")
above.set(aspect="equal", title="Grasp, hold and release of a tumbling satellite", xlim=(-1, 28.2), ylim=(-2.8, 2.2))
above.axis("off")
below.plot(run.time, run.energy["kinetic"], color="#2e4660", label="kinetic energy")
below.plot(run.time, run.energy["lost"], color="#c0392b", label="lost in impacts")
below.plot(run.time, run.energy["dissipated"], color="#e0a050", label="dissipated in the arm's joints")
for event in run.events:
    below.axvline(event.time, color="0.7", linewidth=0.8, linestyle="--")
    below.text(event.time + 0.1, 13.5, event.name, color="0.4", fontsize=9, rotation=90)
below.set(xlabel="time (s)", ylabel="energy (J)", xlim=(0, run.time[-1]))
below.legend(frameon=False, loc="upper right")
below.spines[["top", "right"]].set_visible(False)
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "capture_and_release.png", dpi=110)
