"""Wrong values, names, shapes, types and files are errors that say what is wrong, where, and how to mend it."""

from __future__ import annotations

import pathlib
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from fuzz_values import Raises, cyclic, nested
from test_lifetimes import chain

import momentree as mt

INF, NAN = float("inf"), float("nan")


def refused(act: Callable[[], Any], *words: str) -> mt.Error:
    """The error, which has those words."""
    with pytest.raises(mt.Error) as caught:
        act()
    for word in words:
        assert word in str(caught.value), str(caught.value)
    assert caught.value.problem and str(caught.value).isprintable() or "\n" in str(caught.value)
    return caught.value


@pytest.mark.parametrize("name", ["q", "v", "p", "effort"])
@pytest.mark.parametrize(
    ("value", "words"),
    [
        ([1, 2], ("(3,)", "(2,)")), ([[1, 2, 3]], ("(3,)", "(1, 3)")), (1.0, ("(3,)", "(1,)")), ([1, 2, NAN], ("number 2",
        "not finite")),
        ([INF, 0, 0], ("number 0",)), (["a", "b", "c"], ("real numbers", "str")), (np.ones(3, complex), ("real numbers",
        "complex128")),
        (np.array([1, 2, object()]), ("real numbers", "object")), (np.array([1, 2, 3], "M8[s]"), ("real numbers", "datetime64")),
        ([[1], [2, 3], []], ("array of numbers",)), (None, ("real numbers", "object")), ({}, ("object",)), (b"abc", ("bytes",)),
        (np.zeros(0), ("(3,)", "(0,)")), (np.zeros((3, 1)), ("(3, 1)",)), ([1, 2, 10**400], ("real numbers", "object")),
    ],
)  # fmt: skip
def test_arrays_of_a_simulation(name: str, value: Any, words: tuple[str, ...]) -> None:
    sim = chain()
    before = sim.q.tobytes() + sim.v.tobytes() + sim.effort.tobytes()
    refused(lambda: setattr(sim, name, value), name, *words)
    assert sim.q.tobytes() + sim.v.tobytes() + sim.effort.tobytes() == before


@pytest.mark.parametrize("dtype", [np.float32, np.int8, np.uint64, ">f8", "<f4", bool, np.longdouble])
def test_arrays_of_all_real_dtypes_and_layouts_are_taken(dtype: Any) -> None:
    sim = chain()
    sim.q = np.ones((3, 2), dtype)[:, 0]
    assert sim.q.tolist() == [1, 1, 1]


def test_numbers_that_are_written_into_a_view_are_checked_by_the_next_use() -> None:
    sim = chain()
    sim.q[0] = NAN
    refused(lambda: sim.step(), "c/0", "not a number")
    assert sim.q[0] == 0.1  # as before
    sim.effort[1] = INF
    refused(lambda: sim.energy, "effort", "finite")
    v, p = sim.v, sim.p
    v[0] = p[0] = 1
    refused(lambda: sim.energy, "v", "p")
    sim.step()


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda s: s["c/9"], ("c/9", "did you mean 'c/0'")), (lambda s: s.world.bodies["c/9"], ("no body", "did you mean")),
        (lambda s: s.world.joints["x"], ("no joint 'x'",)), (lambda s: s.jacobian("c/9"), ("did you mean",)),
        (lambda s: s.remove("c/9"), ("did you mean",)),
        (lambda s: s.drive("c/9", None), ("did you mean",)), (lambda s: s.force("c/9", None), ("did you mean",)),
        (lambda s: s.apply(mt.break_joint("c/9")), ("no joint 'c/9'", "did you mean")), (lambda s: s.at(1).then(mt.lock("c/9")),
        ("did you mean",)),
        (lambda s: s.when(mt.speed("c/9") > 1), ("did you mean",)), (lambda s: s.run(0.01)["c/9"], ("did you mean",)),
        (lambda s: s.run(0.01).plot("c/9.q"), ("no column",)), (lambda s: mt.Batch(s.model, 2).bodies["c/9"], ("did you mean",)),
        (lambda s: mt.Batch(s.model, 2).apply(0, mt.lock("c/9")), ("did you mean",)), (lambda s: s.model.add("d", mass=1,
        parent="c/9"), ("did you mean",)),
        (lambda s: s.model.add_force("c/9", force=(0, 0, 1)), ("did you mean",)), (lambda s: mt.Simulation(s.model,
        method="rk5"), ("rk5",)),
        (lambda s: s.after("cut"), ("cut",)), (lambda s: s.model.to_urdf("d"), ("'d'", "'c'")),
        (lambda s: s.apply(mt.Action("brek", "c/0")), ("unknown action 'brek'", "did you mean 'break'")),
    ],
)  # fmt: skip
def test_unknown_names_suggest_the_nearest(act: Callable[[mt.Simulation], Any], words: tuple[str, ...]) -> None:
    refused(lambda: act(chain()), *words)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"mass": -1}, ("mass",)), ({"mass": "heavy"}, ("mass", "heavy")), ({"mass": NAN}, ("mass",)), ({"mass": None},
        ("mass",)), ({"mass": [1]}, ("mass",)),
        ({"mass": 10**400}, ()), ({"mass": Raises()}, ()), ({"inertia": (1, 2)}, ("inertia",)), ({"inertia": (1, 1, 9)},
        ("inertia",)), ({"com": (0, 0)}, ("com",)),
        ({"com": "x"}, ("com",)), ({"joint": 5}, ("joint", "int")), ({"joint": mt.Revolute(axis=(0, 0, 0))}, ("axis",)),
        ({"joint": mt.Revolute(damping=-1)}, ("damping",)), ({"joint": mt.JointSpec("hinge", {})}, ("hinge", "revolute")),
        ({"at": {"xyz": 1}}, ("xyz",)),
        ({"at": {"quat": (0, 0, 0, 0)}}, ("quat",)), ({"at": {"xzy": (0, 0, 0)}}, ("xzy", "xyz")), ({"q": (1, 2, 3)}, ("q",)),
        ({"q": "x"}, ("q",)),
        ({"parent": 5}, ("parent",)), ({"at": nested(60)}, ("deep",)), ({"com": cyclic()}, ("deep",)), ({"shape": {"bx": [1, 1,
        1]}}, ("bx", "box")),
        ({"joint_name": "a*"}, ("a*",)), ({"joint": mt.Revolute(limits={"lower": 1, "upper": 0})}, ("lower",)),
    ],
)  # fmt: skip
def test_values_of_bodies(fields: dict[str, Any], words: tuple[str, ...]) -> None:
    model = mt.Model()
    good: dict[str, Any] = {"mass": 1, "inertia": 1, "joint": mt.Revolute()}
    try:
        refused(lambda: model.add("a/b", **{**good, **fields}), *words)
    except (TypeError, ZeroDivisionError, OverflowError):
        assert not words or fields.keys() & {"mass"}
    assert len(model) == 0
    model.add("a/b", **good)


@pytest.mark.parametrize("name", ["", "a\0b", "\n", "*", "a/*", "a/b/c", "ground", "a,b", 'a"b', "/", "a/", "/b", "x" * 100000,
"\u202e", "a/\u200b"])
def test_names_that_are_no_names(name: str) -> None:
    model = mt.Model()
    error = refused(lambda: model.add(name, mass=1, inertia=1, joint=mt.Revolute()))
    assert len(str(error)) < 1000000 and len(model) == 0


@pytest.mark.parametrize("name", ["ü/ß", "机器人/手臂", "🤖/💪", "a b/c d", "'/'", "%s/{0}"])
def test_names_in_any_script(name: str, tmp_path: pathlib.Path) -> None:
    model = mt.Model()
    model.add(name, mass=1, inertia=1, com=(1, 0, 0), joint=mt.Revolute(axis=(0, 1, 0)))
    sim = mt.Simulation(mt.loads(model.to_toml()).model)
    run = sim.run(0.01)
    assert sim[name].name == name and list(run.joints) == [name] and run.joints[name].q.shape == (11, 1)
    run.save(tmp_path / name.replace("/", "_"), report=True)
    assert sim.apply(mt.break_joint(name), name=name).name == name


@pytest.mark.parametrize(
    "act",
    [
        lambda s: s.step(-1), lambda s: s.step(NAN), lambda s: s.step(INF), lambda s: s.run(NAN), lambda s: s.run(INF),
        lambda s: s.run(1, record_every=-1),
        lambda s: s.run(1, record_every=NAN), lambda s: s.run("soon"), lambda s: s.run(1, observe=5), lambda s: s.at(-1),
        lambda s: s.at(NAN), lambda s: s.at(INF),
        lambda s: s.every(0), lambda s: s.every(-1), lambda s: s.every(NAN), lambda s: s.after("x", -1),
        lambda s: s.set_state(time=-1), lambda s: s.set_state(time=NAN),
        lambda s: s.set_state(v=[0, 0, 0], p=[0, 0, 0]), lambda s: s.when(5), lambda s: s.when(mt.speed("c/0")),
        lambda s: s.when(mt.speed("c/0") > "fast"),
        lambda s: s.when(mt.measured(len) > "x"), lambda s: s.when(mt.kinetic_energy("c") > -1),
        lambda s: bool(mt.speed("c/0") > 1), lambda s: s.apply(5), lambda s: s.apply(None),
        lambda s: s.at(1).then("break"), lambda s: s.apply(mt.lock("c/0", [3])), lambda s: s.apply(mt.impulse("c/0", force=(1,
        2))), lambda s: s.drive("c/0", 5),
        lambda s: s.apply(mt.set_parameters("c/0", damping=-1)), lambda s: s.force("c/0", "down"), lambda s: s.restore(5),
        lambda s: s.restore(chain(2).snapshot()),
        lambda s: s.undo(), lambda s: s.restore_state("{"), lambda s: s.set_gravity((1, 2)), lambda s: s.set_gravity((0, 0,
        INF)), lambda s: s.inverse_dynamics([1]), lambda s: s.solve_mass([1]),
        lambda s: s.jacobian("c/0", (1, 2)), lambda s: s.add("c/0", mass=1, inertia=1), lambda s: s.run(0.1).save(""),
        lambda s: s.run(0.1).joints["c/0"].reaction,
        lambda s: mt.Model(gravity="down"), lambda s: mt.Model(gravity=(1, 2)), lambda s: mt.Simulation(s.model, step=0),
        lambda s: mt.Simulation(s.model, step=NAN),
        lambda s: mt.Simulation(s.model, step="x"), lambda s: mt.Simulation(s.model, method="dopri5", rtol=-1),
        lambda s: mt.load("/no/such/file.toml"), lambda s: mt.load("/"),
        lambda s: mt.load("/dev/zero"), lambda s: mt.load("a\0b"), lambda s: mt.loads(""), lambda s: mt.loads("format = 1",
        set=5),
    ],
)  # fmt: skip
def test_impossible_calls(act: Callable[[mt.Simulation], Any]) -> None:
    sim = chain()
    sim.step()
    before, time = sim.q.tobytes(), sim.time
    refused(lambda: act(sim))
    if sim.time == time:
        assert sim.q.tobytes() == before
    sim.step()


@pytest.mark.parametrize(
    "act",
    [
        lambda: mt.Batch(chain().model, 1.5), lambda: mt.load(5), lambda: mt.loads(5),  # type: ignore[arg-type]
        lambda: chain().after(5), lambda: mt.World(), lambda: mt.Snapshot(),  # type: ignore[arg-type]
        lambda: mt.Simulation.__new__(mt.Simulation).time,  # type: ignore[arg-type]
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_wrong_types(act: Callable[[], Any]) -> None:
    with pytest.raises((mt.Error, TypeError)):
        act()


def test_attributes_that_do_not_exist_name_the_one_that_was_meant() -> None:
    sim = chain()
    batch = mt.Batch(sim.model, 2)
    model = sim.model
    for of, name, words in (
        (sim, "efforts", ("'Simulation.efforts'", "did you mean 'effort'?")),
        (sim, "gravity", ("'Simulation'", "did you mean 'set_gravity'?")),
        (sim, "time", ("'Simulation.time' can't be assigned",)),
        (sim, "torque", ("'Simulation' has no attribute 'torque'",)),
        (sim.at(1.0), "name", ("'Scheduled'", "did you mean 'named'?")),
        (batch, "efforts", ("'Batch'", "did you mean 'effort'?")),
        (batch, "gravity", ("'Batch' has no attribute 'gravity'",)),
        (model, "gravitation", ("'Model'", "did you mean 'gravity'?")),
        (mt.Revolute(), "damping", ("'JointSpec'", "damping")),
        (sim.world, "gravity", ("'World.gravity' can't be assigned",)),
        (sim.world.joints["c/1"], "q", ("'Joint.q' can't be assigned", "assign the simulation's q")),
        (sim.world.bodies["c/1"], "mass", ("'Body.mass' can't be assigned", "the model's")),
        (sim.world.bodies["c/1"], "positon", ("'Body' has no attribute 'positon'", "did you mean 'position'?")),
        (sim.snapshot(), "label", ("'Snapshot' has no attribute 'label'",)),
    ):
        with pytest.raises(AttributeError) as caught:
            setattr(of, name, 1.0)
        assert all(word in str(caught.value) for word in words), str(caught.value)
        assert not hasattr(of, "__dict__") or name not in vars(of)
    before = sim.q.tobytes()
    joint, body = sim["c/1"], sim.world.bodies["c/1"]
    for array in (joint.q, joint.v, joint.a, joint.effort, body.position, body.quaternion, body.linear, batch.q):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.3
    assert sim.q.tobytes() == before

    class Plant(mt.Simulation):
        goal: float

    plant = Plant(model)
    plant.goal = 2.0  # a subclass has attributes of its own
    plant.effort, plant._note = [1, 0, 0], "mine"
    with pytest.raises(AttributeError):
        plant.efforts = [1, 0, 0]  # type: ignore[method-assign,assignment]
    assert plant.goal == 2.0


def test_a_model_is_not_a_file() -> None:
    refused(lambda: mt.Simulation("arm.toml"), "arm.toml", "there is no such file")
    refused(lambda: mt.Batch(pathlib.Path("arm.toml"), 2), "expected a model", "momentree.load")  # type: ignore[arg-type]
    for act in (lambda: mt.Simulation(5), lambda: mt.Batch(None, 2)):  # type: ignore[arg-type]
        refused(act, "expected a model", "momentree.Model")


def test_an_inertia_is_a_matrix_too_and_text_of_models_is_recognised() -> None:
    J = np.array([[3.0, 0.2, -0.1], [0.2, 4.0, 0.3], [-0.1, 0.3, 5.0]])
    masses = []
    for inertia in (J, J.tolist(), [3, 4, 5, 0.2, -0.1, 0.3]):
        model = mt.Model()
        model.add("a", mass=1, inertia=inertia, joint=mt.Free())
        masses.append(mt.Simulation(model).mass_matrix())
    assert (masses[0][3:, 3:] == J).all()
    assert (masses[1] == masses[0]).all() and (masses[2] == masses[0]).all()
    refused(lambda: mt.Model().add("a", mass=1, inertia=np.triu(J), joint=mt.Free()), "not symmetric")
    urdf = '<?xml version="1.0"?>\n<robot name="r"><link name="a"><inertial><mass value="2"/>{}</inertial></link></robot>'
    inertial = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    (body,) = mt.loads(urdf.format(inertial)).world.bodies.values()
    assert body.name.endswith("/a") and body.mass == 2
    assert "model.urdf" in str(refused(lambda: mt.loads("<robot name='r'/>")))
    refused(lambda: mt.loads("<html/>"), "scenario.toml")


def test_times_have_units_and_runs_do_not_end_in_the_past() -> None:
    sim, other = chain(), chain()
    sim.at("0.5 ms").then(mt.lock("c/1"))
    sim.every("2 ms", "1 ms").then(mt.impulse("c/2", force=(0, 1, 0))).named("push")
    sim.after("push", "0.25 ms").then(mt.impulse("c/2", force=(0, -1, 0)))
    run = sim.run("4 ms", record_every="1 ms")
    assert [event.time for event in run.events] == pytest.approx([5e-4, 1e-3, 1.25e-3, 3e-3, 3.25e-3])
    assert run.time.tolist() == pytest.approx([0, 1e-3, 2e-3, 3e-3, 4e-3])
    other.step("1 ms")
    assert other.time == 1e-3
    for act in (
        lambda: sim.at("5 m"), lambda: sim.at("soon"), lambda: sim.step("1 kg"), lambda: sim.run("1 N"), lambda: sim.step([1]),
        lambda: sim.every("0.1"), lambda: sim.after("push", object()), lambda: sim.run(1.0, record_every="often"),
    ):  # fmt: skip
        refused(act)  # type: ignore[arg-type]
    refused(lambda: sim.run(1e-3), "past", "0.004 s")
    refused(lambda: sim.run("1 ms"), "past", "sim.time")
    assert len(sim.run(sim.time)) == 1


def test_a_world_of_a_batch_that_diverges_is_a_warning() -> None:
    model = mt.Model(gravity=(0, 0, 0))
    model.add("a", mass=1.0, com=(0.1, 0, 0), joint=mt.Revolute((0, 1, 0), damping=1e6))
    batch = mt.Batch(model, 3)
    batch.v = [[0.0], [1.0], [1.0]]
    with pytest.warns(RuntimeWarning, match="world 1 and 1 other stopped"):
        batch.run(1.0, 2000)
    assert batch.diverged.tolist() == [False, True, True]
    batch.step(0.1)  # said once


def test_an_action_that_did_nothing_is_a_warning() -> None:
    sim = chain()
    sim.at(0.01).then(mt.break_joint("c/2")).named("first")
    sim.every(0.02, 0.02).then(mt.break_joint("c/2")).named("again")
    run = sim.run(0.1)
    assert run.warnings == [
        "event 'again': break c/2 did nothing: the joint no longer exists; it is the first of 5 such actions of the event"
    ]
    assert run.summary["warnings"] == run.warnings and run.summary["events"] == len(run.events) == 6
    assert sim.run(0.11).warnings == []


def test_an_overflowed_state_is_refused_by_changes_that_need_it() -> None:
    for action in (mt.free_joint("c/1"), mt.change_joint("c/1", mt.Ball())):
        sim = chain()
        sim.p[1] = 1e308
        before = sim.p.tobytes()
        refused(lambda: sim.apply(mt.lock("c/2"), action), "c/1", "finite")  # noqa: B023
        assert sim.p.tobytes() == before and sim.world.joints["c/2"].locked == ()


def test_batches() -> None:
    model = chain().model
    for worlds in (0, -1, 10**9, 2**31 - 1):
        refused(lambda: mt.Batch(model, worlds), "world")  # noqa: B023
    refused(lambda: mt.Batch(mt.Model(), 2), "at least one body")
    refused(lambda: mt.Batch(model, 2, threads=-1), "threads")
    refused(lambda: mt.Batch(model, 2, threads=10**6), "threads")
    refused(lambda: mt.Batch(model, 2, precision="float16"), "float16", "float32")
    refused(lambda: mt.Batch(model, 2, variables="speeds"), "speeds", "velocities")
    batch = mt.Batch(model, 4)
    for step in (-1.0, NAN, INF, [1e-3] * 3, [1e-3, NAN, 0, 0], [-1e-3] * 4, "x"):
        refused(lambda: batch.step(step))  # type: ignore[arg-type]  # noqa: B023
    for worlds in (4, -1, [0, 9], [True], "all", [0.5], 2**40):
        with pytest.raises((mt.Error, TypeError)):
            batch.set_state(worlds, q=np.zeros((1, 3)))  # type: ignore[arg-type]
    for q in (np.zeros((4, 2)), np.zeros((3, 3)), np.full((4, 3), NAN), np.zeros((4, 3, 1)), [["a"] * 3] * 4, 1.0):
        refused(lambda: setattr(batch, "q", q), "q")  # noqa: B023
    with pytest.raises(ValueError):
        batch.q[0, 0] = 1.0  # a copy: writing would have no effect
    batch.apply(1, mt.break_joint("c/1"))
    refused(lambda: batch.q, "topologies", "groups")
    batch.step(1e-3)


def test_models_without_bodies() -> None:
    sim = mt.Simulation(mt.Model())
    run = sim.run(0.01, reactions=True)
    assert sim.q.shape == (0,) and sim.mass_matrix().shape == (0, 0) and sim.energy.total == 0 and sim.world.mechanisms == []
    assert len(run) == 11 and list(run.joints) == [] and sim.time == 0.01
    assert len(mt.Model().to_toml()) > 0


BAD = {
    "empty.toml": "", "syntax.toml": "format = \n", "format.toml": "format = 99\n",
    "unknown.toml": "format = 1\ngravty = [0, 0, 1]\n",
    "mass.toml": 'format = 1\n[[mechanism]]\nname = "a"\n[[mechanism.body]]\nname = "b"\nmass = -1\n', "binary.toml": "\0\1\2",
    "event.toml": 'format = 1\n[[mechanism]]\nname = "a"\n[[mechanism.body]]\nname = "b"\nmass = 1\ninertia = 1\n'
                  '[mechanism.body.joint]\nkind = "revolute"\n'
                  '[[event]]\ntime = 1\nbreak = "a/c"\n[[event]]\ntime = -1\nlock = "a/b"\n',
    "robot.urdf": "<robot><link name='a'/><joint name='j' type='revolute'/></robot>",
    "broken.urdf": "<robot",
    "robot.sdf": "<sdf/>", "robot.xml": "<mujoco><worldbody><body/></worldbody>",
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_errors_of_files_are_the_text_of_the_command(name: str, tmp_path: pathlib.Path) -> None:
    (tmp_path / name).write_text(BAD[name])
    command = subprocess.run([sys.executable, "-m", "momentree", "check", name], capture_output=True, text=True, cwd=tmp_path,
    timeout=60)
    assert command.returncode == 2
    script = "import sys, momentree\ntry: momentree.load(sys.argv[1])\nexcept momentree.Error as error: print(error)"
    package = subprocess.run([sys.executable, "-c", script, name], capture_output=True, text=True, cwd=tmp_path, timeout=60)
    assert package.stdout.strip() and package.stdout.strip() in command.stderr + command.stdout
    error = refused(lambda: mt.load(tmp_path / name))
    assert error.diagnostics and error.diagnostics[0].file.endswith(name)
    assert error.file is not None and error.file.endswith(name)
