"""What type checkers must reject: a line that they accept is an error, as its comment is then unused. It does not run."""

from __future__ import annotations

import momentree as mt

model = mt.Model()
sim = mt.Simulation(model)
batch = mt.Batch(model, 4)
condition = mt.reaction("a").force > 1

model.add("a/b", 1.0)  # type: ignore[call-arg]
model.add("a/b", mass=1, joint="revolute")  # type: ignore[arg-type]
model.add("a/b", mass=1, joint=mt.Revolute)  # type: ignore[arg-type]
model.add("a/b", mass=1, parent=sim.world.bodies["a/b"])  # type: ignore[arg-type]
model.add("a/b", mass=1, com=1.0)  # type: ignore[arg-type]
model.add_force("a/b", axes="local")  # type: ignore[arg-type]
model.add_spring("s", start="a/b", stiffness=1)  # type: ignore[call-arg]
model.add_spring("s", start="a/b", end=("ground",), stiffness=1)  # type: ignore[arg-type]
model.add_loop("pin", body="a/b")  # type: ignore[call-arg]
model.add_loop("pin", body="a/b", joint="ball")  # type: ignore[arg-type]
mt.reaction("a", undetermined="least")  # type: ignore[arg-type]
mt.Revolute(pitch=1)  # type: ignore[call-arg]
mt.Revolute(0.1, 0.2)  # type: ignore[arg-type, call-arg]
mt.NoSuchJoint()  # type: ignore[attr-defined]
mt.break_joint(sim.world.bodies["a/b"])  # type: ignore[arg-type]
mt.break_joint(1)  # type: ignore[arg-type]
mt.weld(sim.world.joints["a/b"])  # type: ignore[arg-type]
mt.change_joint("a", "ball")  # type: ignore[arg-type]
mt.reaction("a").component("fw")  # type: ignore[arg-type]
mt.Simulation()  # type: ignore[call-arg]
mt.Simulation(model, "rk4")  # type: ignore[call-arg]
sim.at(None)  # type: ignore[arg-type]
sim.at(1.0).then(mt.break_joint)  # type: ignore[arg-type]
sim.at(1.0).then("break")  # type: ignore[arg-type]
sim.when(mt.reaction("a").force)  # type: ignore[arg-type]
sim.when(condition and condition).then(mt.lock("a")).when(condition)  # type: ignore[attr-defined]
sim.when(lambda world: "high")  # type: ignore[arg-type, return-value]
sim.time = 1.0  # type: ignore[misc]
sim.energy.kinetic = 1.0  # type: ignore[misc]
sim.q = None  # type: ignore[assignment]
sim.drive("a", 1.0)  # type: ignore[arg-type]
sim.drive("a", lambda context: None)  # type: ignore[arg-type, return-value]
sim.drive("a", lambda context: context.v("a").no_such_method())  # type: ignore[attr-defined]
sim.drive("a", lambda: 1.0)  # type: ignore[arg-type, misc]
sim.force("a/b", lambda context: (0, 0, 1))  # type: ignore[arg-type, return-value]
sim.restore(sim.state_json())  # type: ignore[arg-type]
sim.set_state([0.0])  # type: ignore[call-arg]
sim.run(1.0, 0.1)  # type: ignore[call-arg]
sim.run([1.0])  # type: ignore[arg-type]
sim.gravity = (0, 0, 0)  # type: ignore[attr-defined]
sim.misspelt = 1.0  # type: ignore[attr-defined]
sim.world.joints["a"].q = sim.mass_matrix()[0]  # type: ignore[misc]
sim.world.mass_matrix()  # type: ignore[attr-defined]
sim.events[0].impulse.force  # type: ignore[attr-defined]
mt.Batch(model, 4, precision="float16")  # type: ignore[arg-type]
batch.apply(mt.lock("a"), None)  # type: ignore[arg-type]
batch.groups[0].p.no_such_method()  # type: ignore[attr-defined]
