"""Energy error against step: what order do the methods have, and which of them keep the energy?

A double pendulum without friction swings for two seconds; its energy should stay what it was.
"""

# %%
import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import momentree as mt

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--out", default=".", help="folder of the picture")
arguments.add_argument("--quick", action="store_true", help="fewer steps")
options, _ = arguments.parse_known_args()

# %% Two uniform rods.
model = mt.Model(gravity=(0, 0, -9.81))
for name, parent in (("pendulum/upper", None), ("pendulum/lower", "pendulum/upper")):
    model.add(name, mass=1, com=(0, 0, -0.25), inertia=1 / 48, parent=parent, at=(0, 0, -0.5 if parent else 0),
              joint=mt.Revolute(axis=(0, 1, 0)), q=1.2)  # fmt: skip
end = 2.0


def energy_error(**integration):
    """Largest error of the energy in a run (J), and the mean step (s)."""
    sim = mt.Simulation(model, **integration)
    run = sim.run(until=end, record_every=0)  # a row for each step
    total = run.energy["kinetic"] + run.energy["gravity"]
    return np.abs(total - total[0]).max(), end / (len(run) - 1)


# %% Methods of fixed steps with smaller and smaller steps, adaptive ones with smaller and smaller tolerances.
steps = np.geomspace(0.04, 0.0025 if options.quick else 0.00125, 5 if options.quick else 8)
tolerances = np.geomspace(1e-4, 1e-10 if options.quick else 1e-12, 5 if options.quick else 9)
curves = {}
for method in ("damped", "rk4", "midpoint"):
    curves[method] = np.array([energy_error(method=method, step=end / round(end / step)) for step in steps])
for method in ("dopri5", "dop853"):
    curves[method] = np.array([energy_error(method=method, step=0.01, rtol=each, atol=each) for each in tolerances])

# %% The slope of a curve is the order of its error.
for method in ("damped", "rk4", "midpoint"):
    errors, sizes = curves[method].T
    print(f"{method}: order {np.polyfit(np.log(sizes[-4:]), np.log(errors[-4:]), 1)[0]:.2f}")

# %% The picture.
figure, axes = plt.subplots(figsize=(7.5, 5), layout="constrained")
colours = {"damped": "#8c6d31", "rk4": "#1f6fb2", "midpoint": "#2a9d5c", "dopri5": "#d1603d", "dop853": "#8e44ad"}
for method, curve in curves.items():
    dots = "s--" if method.startswith("dop") else "o-"
    axes.loglog(curve[:, 1], np.maximum(curve[:, 0], 1e-17), dots, color=colours[method], markersize=4.5, label=method)
axes.set(xlabel="step, or mean step of an adaptive method", ylabel="largest error of the energy (J)")
axes.set_title("Energy error of a double pendulum, 2 s")
axes.set_xticks([0.001, 0.002, 0.005, 0.01, 0.02, 0.05], ["1 ms", "2 ms", "5 ms", "10 ms", "20 ms", "50 ms"])
axes.xaxis.minorticks_off()
axes.grid(color="0.9")
axes.legend(frameon=False)
axes.spines[["top", "right"]].set_visible(False)
Path(options.out).mkdir(parents=True, exist_ok=True)
figure.savefig(Path(options.out) / "energy_against_step.png", dpi=110)
