"""A controller that survives the loss of a joint: computed torque with the matrices of the mechanism that there is at present.

An arm of four joints draws a circle. At 2.5 s its elbow jams. The controller asks the simulation for mass matrix, bias and Jacobian
of the arm as it is: from then on the column of the jammed joint is zero in the Jacobian, and the law goes on as before.
"""

# %%
import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="a longer control period")
options, _ = arguments.parse_known_args()

# %% A planar arm in a vertical plane.
lengths, masses = (0.45, 0.4, 0.3, 0.2), (3.0, 2.0, 1.2, 0.5)
model = mt.Model(gravity=(0, 0, -9.81))
for k, (length, mass) in enumerate(zip(lengths, masses, strict=True)):
    model.add(
        f"arm/{k + 1}",
        mass=mass,
        com=(length / 2, 0, 0),
        inertia=mass * length**2 / 12,
        parent=f"arm/{k}" if k else None,
        at=(lengths[k - 1], 0, 0) if k else (0, 0, 0),
        joint=mt.Revolute(axis=(0, -1, 0)),
        q=(0.9, -1.2, 0.5, -0.6)[k],
    )
hand, tip = "arm/4", (lengths[3], 0, 0)
sim = mt.Simulation(model, step=1e-3)


# %% The circle, and the law: the tip's acceleration is to be that of the circle plus a correction. What is left of the joints'
# freedom is damped.
def reach(sim):
    """Where the tip is, and its Jacobian in the plane."""
    heading = sim.world.bodies[hand]
    w, _, y, _ = heading.quaternion
    turn = 2 * np.arctan2(y, w)
    return heading.position[[0, 2]] + lengths[3] * np.array([np.cos(turn), -np.sin(turn)]), sim.jacobian(hand, tip)[[0, 2]]


first, _ = reach(sim)
centre, radius, rate = first - [0.18, 0], 0.18, 2 * np.pi / 2.5


def circle(time):
    """Position, velocity and acceleration."""
    phase = np.array([np.cos(rate * time), np.sin(rate * time)])
    across = np.array([-phase[1], phase[0]])
    return centre + radius * phase, radius * rate * across, -radius * rate**2 * phase


def law(sim, turning):
    place, J = reach(sim)
    wanted, velocity, acceleration = circle(sim.time)
    v = np.array(sim.v)
    task = acceleration + 400 * (wanted - place) + 40 * (velocity - J @ v) - turning
    M, c = sim.mass_matrix(), sim.bias()
    inverse = np.linalg.solve(M, J.T)
    project = inverse @ np.linalg.inv(J @ inverse)
    a = project @ task
    a += (np.eye(len(v)) - project @ J) @ (-4 * v - a)
    return M @ a + c


# %% The run: a new torque every few milliseconds.
joints = list(sim.world.joints.values())
period = 5e-3 if options.quick else 2e-3
sim.at(2.5).then(mt.lock("arm/2")).named("jam")
rows, J_before = [], reach(sim)[1]
while sim.time < 7.5 - 1e-9:
    _, J = reach(sim)
    turning = (J - J_before) / period @ np.array(sim.v)  # the part of the tip's acceleration that comes from J's change
    sim.effort = law(sim, turning)
    J_before = J
    sim.step(period)
    place, J = reach(sim)
    points = [sim.world.bodies[f"arm/{k + 1}"].position[[0, 2]] for k in range(4)] + [place]
    rows.append((sim.time, np.linalg.norm(place - circle(sim.time)[0]), np.array(points), sum(not len(joint.locked) for joint in joints)))
time, error, arms, freedom = (np.array(column) for column in zip(*rows, strict=True))

before, after = (time > 0.5) & (time < 2.5), time > 3.5
print(f"degrees of freedom: {freedom[0]} before the jam, {freedom[-1]} after it; it took {sim.events[0].lost:.3f} J")
print(f"tracking error: {1e3 * error[before].max():.3f} mm before, {1e3 * error[after].max():.3f} mm a second after the jam")

# %% The picture.
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.6), width_ratios=[1, 1.25], layout="constrained")
for instants, colour in (((0.6, 1.2, 1.8), "#1f6fb2"), ((4.0, 4.8, 5.6), "#d1603d")):
    for k, instant in enumerate(instants):
        row = int(np.argmin(np.abs(time - instant)))
        label = ("intact" if colour == "#1f6fb2" else "elbow jammed") if k == 0 else None
        left.plot(*arms[row].T, "o-", color=colour, linewidth=3, markersize=5, alpha=0.35 + 0.3 * k, label=label)
left.plot(*arms[:, -1].T, color="k", linewidth=1, label="path of the tip")
left.set(aspect="equal", xlabel="x (m)", ylabel="z (m)", ylim=(-0.5, 0.5), title="The arm before and after the jam")
left.legend(frameon=False, loc="lower left", fontsize=9)
right.semilogy(time, 1e3 * error, color="#333")
right.axvline(2.5, color="#d1603d", linestyle="--")
right.text(2.56, right.get_ylim()[1] * 0.5, "the elbow jams", color="#d1603d")
right.set(xlabel="time (s)", ylabel="distance of the tip from its circle (mm)", title="Tracking error", xlim=(0, 7.5))
for axes in (left, right):
    axes.spines[["top", "right"]].set_visible(False)
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "lost_joint_controller.png", dpi=110)
