"""Contact in models that are built in Python."""

import copy
import pickle

import momentree as mt
import numpy as np
import pytest


def box_above_floor(height=0.5, **law):
    model = mt.Model()
    model.add("box/box", mass=2, inertia=[0.03, 0.04, 0.05], joint=mt.Free(), q=[0, 0, 0.1 + height, 1, 0, 0, 0],
              shape={"box": [0.4, 0.3, 0.2]}, collision="shape")
    model.add_floor(friction={"static": 0.5, "kinetic": 0.4}, restitution=0.2)
    if law:
        model.add_contact(("box/*", "ground"), **law)
    return model


def test_a_box_lands_and_is_carried():
    for method in ("dop853", "stepping"):
        sim = mt.Simulation(box_above_floor(), method=method)
        sim.run(2)
        contacts = sim.world.contacts
        assert len(contacts) == 4
        assert {(c.one, c.other) for c in contacts} == {("box/box", "ground")}
        np.testing.assert_allclose(sum(c.force for c in contacts), [0, 0, 2 * 9.81], atol=1e-5)
        np.testing.assert_allclose([c.normal for c in contacts], [[0, 0, 1]] * 4, atol=1e-9)
        assert not any(c.slips for c in contacts)
        # A model that is copied has the same contacts.
        other = mt.Simulation(copy.copy(box_above_floor()), method=method)
        other.run(2)
        np.testing.assert_array_equal(other.q, sim.q)


def test_conditions():
    lands = np.sqrt(2 * 0.5 / 9.81)
    for condition, time in ((mt.touch("box/box", "ground"), lands), (mt.gap("ground", "box/box") < 0.2, np.sqrt(2 * 0.3 / 9.81)),
                            (mt.touch("box", "floor"), lands), (mt.contact_impulse("box", "floor") > 1, lands),
                            (mt.contact_impulse("box/box", "ground") > 1, lands), (mt.contact_force("box/box", "ground") > 30, None)):
        sim = mt.Simulation(box_above_floor(restitution=0), method="dop853")
        sim.when(condition).then(mt.impulse("box/box", force=(0, 0, 0))).named("now")
        sim.run(1)
        assert [event.time for event in sim.events if event.name == "now"] == ([] if time is None else [pytest.approx(time, abs=1e-9)])
    sim = mt.Simulation(box_above_floor(0))
    sim.at(0.2).then(mt.impulse("box/box", force=(1, 0, 0)))
    sim.when(mt.slip("box", "floor")).named("once")
    sim.when(mt.slip("box", "floor").begins().repeated()).named("each")
    sim.run(0.5)
    for name in ("once", "each"):
        assert [event.time for event in sim.events if event.name == name] == [pytest.approx(0.2)]
    assert repr(mt.touch("a", "b")) == "<momentree.Condition touch(['a', 'b'])>"


def test_pickles_touch_as_the_model_does_and_impacts_have_their_impulse():
    model = box_above_floor(restitution=0.3)
    model.add("ball/ball", mass=1, inertia=0.004, joint=mt.Free(), q=[0.05, 0, 1.2, 1, 0, 0, 0], collision=[{"sphere": 0.1}])
    run = mt.Simulation(model).run(0.6)
    again = mt.Simulation(pickle.loads(pickle.dumps(model))).run(0.6)
    assert [(e.name, e.time) for e in again.events] == [(e.name, e.time) for e in run.events]
    assert np.array_equal(again.bodies["ball/ball"].position, run.bodies["ball/ball"].position)
    hit = run.events[0].contact
    assert (hit.one, hit.other, hit.scaled, hit.in_turn) == ("box/box", "ground", 1, False)
    np.testing.assert_allclose(hit.impulse, [0, 0, 2 * 1.3 * np.sqrt(2 * 0.5 * 9.81)], atol=1e-7)


def test_a_model_that_is_written_touches_as_before():
    model = box_above_floor()
    for name, x, shape in (("ball", 1, {"sphere": 0.1}), ("rod", 2, {"capsule": {"radius": 0.1, "length": 0.5}}),
                           ("drum", 3, {"cylinder": {"radius": 0.2, "length": 0.3}, "at": {"rpy": [0.1, 0.2, 0.3]}}),
                           ("egg", 4, {"ellipsoid": [0.2, 0.15, 0.1], "at": {"rpy": [0.1, 0.2, 0.3]}})):  # fmt: skip
        model.add(f"{name}/{name}", mass=1, inertia=0.01, joint=mt.Free(), q=[x, 0, 1, 1, 0, 0, 0], collision=shape)
    model.add_contact(("ball", "floor"), name="bounce", restitution=0.5, friction={"static": 0.6, "kinetic": 0.4})
    model.add_contact(("rod", "drum"), off=True)
    text = model.to_toml()
    run, again = mt.Simulation(model).run(0.6), mt.Simulation(mt.loads(text).model).run(0.6)
    assert [e.name for e in again.events][:8] == [e.name for e in run.events][:8]
    assert "impact bounce" in [e.name for e in again.events]
    for name in ("box/box", "ball/ball", "rod/rod", "drum/drum"):
        assert np.allclose(again.bodies[name].position[-1], run.bodies[name].position[-1], atol=1e-4)


def test_overlaps_at_the_start():
    sim = mt.Simulation(box_above_floor(-0.005), resolve=True)
    np.testing.assert_allclose(sim.q[:3], [0, 0, 0.1], atol=1e-14)
    sim.run(0.1)
    with pytest.raises(mt.Error, match="overlap by 0.005 m"):
        mt.Simulation(box_above_floor(-0.005)).run(0.1)


def test_mistakes():
    model = box_above_floor()
    with pytest.raises(mt.Error, match="restitution: at most 1"):
        model.add_contact(restitution=2)
    with pytest.raises(mt.Error, match="no body or mechanism 'crate'"):
        model.add_contact(("crate", "ground"))
    with pytest.raises(mt.Error, match="normal: must not be zero"):
        model.add_floor(normal=(0, 0, 0))
    with pytest.raises(mt.Error, match="collision"):
        model.add("b", mass=1, inertia=1, joint=mt.Free(), collision="shape")
    model.add("thing/b", mass=1, inertia=1, joint=mt.Free(), q=[3, 0, 1, 1, 0, 0, 0])
    sim = mt.Simulation(model)
    with pytest.raises(mt.Error, match="a quantity without a threshold"):
        sim.when(mt.gap("box", "floor"))
    with pytest.raises(mt.Error, match="'box' and 'box/box' are the same body"):
        sim.when(mt.touch("box", "box/box"))
    with pytest.raises(mt.Error, match="'thing/b' touches nothing"):
        sim.when(mt.gap("box/box", "thing/b") < 1)
    with pytest.raises(mt.Error, match="takes no threshold"):
        sim.when(mt.Quantity("touch", ["box/box", "ground"]) > 1)


def test_a_body_that_is_added_moves_as_one_that_was_there():
    ball = dict(mass=1, inertia=0.004, joint=mt.Free(), collision={"sphere": 0.1})
    start = dict(q=[0.05, 0, 1, 1, 0, 0, 0], v=[0.1, 0, -1, 0, 0, 0])
    for method in ("rk4", "dop853", "stepping"):
        model = box_above_floor(0.1, restitution=0.3)
        sim = mt.Simulation(model, method=method, step=1e-3)
        sim.run(0.2)
        q, v = list(sim.q), list(sim.v)
        handle = sim.add("ball/ball", **ball, **start)
        model.add("ball/ball", **ball, **start)
        other = mt.Simulation(model, method=method, step=1e-3)
        other.set_state(q=q + start["q"], v=v + start["v"], time=0.2)
        branch = sim.branch()
        for each in (sim, other, branch):
            each.run(0.5)
            assert any("ball/ball" in (e.contact.one, e.contact.other) for e in each.events if e.name == "impact") == (method != "stepping")
        np.testing.assert_allclose(other.q, sim.q, atol=1e-12)
        np.testing.assert_array_equal(branch.q, sim.q)
        sim.run(3)
        assert {c.one for c in sim.world.contacts if c.other == "ground"} >= {"box/box"}
        assert abs(sim.energy_balance["error"]) < 1e-6
        sim.remove(handle)
        sim.run(4)
        assert {(c.one, c.other) for c in sim.world.contacts} == {("box/box", "ground")}
        np.testing.assert_allclose(sum(c.force for c in sim.world.contacts), [0, 0, 2 * 9.81], atol=1e-5)


def test_what_a_body_that_is_added_overlaps():
    box = dict(mass=1, inertia=0.01, joint=mt.Free(), shape={"box": [0.2, 0.2, 0.2]}, collision="shape")
    for resolve in (None, True):
        sim = mt.Simulation(box_above_floor(0), resolve=resolve)
        sim.run(0.1)
        if resolve:
            sim.add("new/new", q=[2, 0, 0.095, 1, 0, 0, 0], **box)
            assert sim.world.bodies["new/new"].position[2] == pytest.approx(0.1, abs=1e-12)
            assert sim.events[-2].name == "add" and sim.events[-2].work == pytest.approx(0.1 * 9.81)
        else:
            with pytest.raises(mt.Error, match="'new/new' and 'ground' overlap by 0.00"):
                sim.add("new/new", q=[2, 0, 0.095, 1, 0, 0, 0], **box)
            assert "new/new" not in sim.world.bodies
        sim.run(0.3)
        assert abs(sim.energy_balance["error"]) < 1e-9
    sim = mt.Simulation(mt.Model(), method="midpoint")
    with pytest.raises(mt.Error, match="does not support contact"):
        sim.add("new/new", q=[2, 0, 0.095, 1, 0, 0, 0], **box)


def test_contact_rules_stand_for_bodies_that_are_added_by_their_names():
    sim = mt.Simulation(pickle.loads(pickle.dumps(box_above_floor(0, friction=0))), method="dop853")
    for name, x in (("box/2", 0.3), ("crate/1", 1 / (2 * 0.4 * 9.81))):  # the rule for box/*, and that of the floor
        y = len(sim.world.bodies)
        sim.add(name, mass=1, inertia=0.01, joint=mt.Free(), q=[0, y, 0.1, 1, 0, 0, 0], v=[1, 0, 0, 0, 0, 0],
                collision={"box": [0.2, 0.2, 0.2]})  # fmt: skip
        end = sim.time + 0.3
        sim.run(end)
        assert sim.world.bodies[name].position[0] == pytest.approx(x, rel=1e-9)


def test_rules_are_written_as_they_were_given():
    model = box_above_floor(0, friction=0.1, name="box")
    model.add_contact(friction=0.7)
    model.add_contact(("box", "box/*"), off=True)
    text = model.to_toml()
    assert text.count("friction = ") == 4
    for written in ('["box/*", "ground"]', '["box", "box/*"]'):
        assert f"between = {written}" in text
    again = mt.loads(text).model
    assert again.to_toml() == text
    sim = mt.Simulation(again, method="dop853")
    sim.add("box/2", mass=1, inertia=0.01, joint=mt.Free(), q=[0, 0, 0.2, 1, 0, 0, 0], collision={"box": [0.2, 0.2, 0.2]})
    sim.run(0.2)  # through the other box
    assert sim.world.bodies["box/2"].position[2] == pytest.approx(0.1)


def test_meshes_are_written_by_their_files(tmp_path):
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.2]]) - 0.05
    faces = [[corners[i] for i in face] for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))]
    facets = ["facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in face) + "endloop\nendfacet\n"
              for face in faces]  # fmt: skip
    (tmp_path / "wedge.stl").write_text("solid wedge\n" + "".join(facets) + "endsolid wedge\n")
    (tmp_path / "wedges.toml").write_text("""
format = 1
world = { floor = { restitution = 0.3 } }
[[mechanism]]
name = "one"
root = "free"
pose = { xyz = [0, 0, 0.5] }
body = [{ name = "one", mass = 1, inertia = 0.01, collision = { mesh = "wedge.stl" } }]
[[mechanism]]
name = "two"
root = "free"
pose = { xyz = [1, 0, 0.5] }
[[mechanism.body]]
name = "two"
mass = 1
inertia = 0.01
collision = [{ sphere = 0.05 }, { mesh = "wedge.stl", scale = 0.5, at = { xyz = [0, 0.1, 0], rpy = [0.3, 0.2, 0.1] } }]
""")
    model = mt.load(tmp_path / "wedges.toml").model
    text = model.to_toml()
    assert text.count("wedge.stl") == 2
    (tmp_path / "again.toml").write_text(text)
    models = [mt.load(tmp_path / "again.toml").model, pickle.loads(pickle.dumps(model)), copy.copy(model)]
    expected = mt.Simulation(model).run(0.6)
    assert any(e.name == "impact" for e in expected.events)
    for other in models:
        assert other.to_toml() == text
        run = mt.Simulation(other).run(0.6)
        for name in model.body_names:
            np.testing.assert_allclose(run.bodies[name].position[-1], expected.bodies[name].position[-1], atol=1e-9)


def test_pickles_go_on_with_closed_contacts() -> None:
    model = mt.Model()
    turned = [-np.cos(0.3), 0, 0, -np.sin(0.3)]  # documents have the opposite quaternion
    model.add("box/box", mass=2, inertia=0.02, joint=mt.Free(), q=[0, 0, 0.1, *turned], v=[1, 0, 0, 0, 0, 2],
              collision={"box": [0.4, 0.4, 0.2]})
    model.add_floor(friction=0.2)
    for method in ("rk4", "dopri5", "stepping"):
        sim = mt.Simulation(model, method=method)
        sim.run(0.1)
        again = pickle.loads(pickle.dumps(sim))
        assert sim.q[3] < 0
        np.testing.assert_array_equal(again.q, sim.q)
        assert len(again.world.contacts) == len(sim.world.contacts) == 4
        sim.run(0.2)
        again.run(0.2)
        np.testing.assert_array_equal(again.q, sim.q)
        assert [(event.time, event.name) for event in again.events] == [(event.time, event.name) for event in sim.events]


@pytest.mark.parametrize("method", ["dop853", "stepping"])
def test_belts(method: str) -> None:
    belt = {"axis": [0, 1, 0], "speed": 1.5}
    box = dict(mass=2, inertia=0.02, joint=mt.Free(), collision={"box": [0.4, 0.4, 0.2]})
    bed, floor = mt.Model(), mt.Model()
    bed.add("bed", mass=1, at=[0, 0, -0.5], collision={"box": [40, 2, 1]}, belt=belt)
    bed.add_contact(friction=0.4)
    floor.add_floor(friction=0.4, belt=belt)
    for model in (bed, floor):
        model.add("load/box", q=[0, 0, 0.1, 1, 0, 0, 0], **box)
        for each in (model, pickle.loads(pickle.dumps(model))):
            sim = mt.Simulation(each, method=method)
            sim.add("load/other", q=[0, 0.7, 0.1, 1, 0, 0, 0], **box)
            sim.run(1)
            for name in ("load/box", "load/other"):
                np.testing.assert_allclose(sim.world.bodies[name].linear, [1.5, 0, 0], atol=1e-6)
    sim = mt.Simulation(bed)
    sim.add("tracked", q=[0, 0.7, 0.1, 1, 0, 0, 0], belt={"axis": [0, 1, 0], "speed": 2}, **box)
    sim.run(2)
    np.testing.assert_allclose(sim.world.bodies["tracked"].linear, [3.5, 0, 0], atol=1e-6)


@pytest.mark.parametrize("method", ["dop853", "stepping"])
def test_contacts_after_a_state_is_written(method: str) -> None:
    model = mt.Model()
    model.add("box/box", mass=2, inertia=0.02, joint=mt.Free(), q=[0, 0, 0.1, 1, 0, 0, 0], collision={"box": [0.4, 0.4, 0.2]})
    model.add_floor(friction=0.5)
    sim = mt.Simulation(model, method=method)
    assert len(sim.world.contacts) == 4
    sim.run(0.1)
    again = mt.Simulation(model, method=method)
    again.restore_state(sim.state_json())
    assert len(again.world.contacts) == 4
    np.testing.assert_allclose(again.world.bodies["box/box"].linear_acceleration, [0, 0, 0], atol=1e-6)
    for v, a in (([0, 0, 0, 0, 0, 0], 0.0), ([3, 0, 0, 0, 0, 0], -0.5 * 9.81)):
        sim.v = v
        assert len(sim.world.contacts) == 4
        np.testing.assert_allclose(sim.world.bodies["box/box"].linear_acceleration, [a, 0, 0], atol=1e-9)
    sim.v = [0, 0, 1, 0, 0, 0]
    assert not sim.world.contacts
    np.testing.assert_allclose(sim.world.bodies["box/box"].linear_acceleration, [0, 0, -9.81], atol=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_pickled_models_fall_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = mt.Model()
    for k in range(5):
        turned = rng.normal(size=4)
        round_shape = {"radius": 0.1, "length": 0.2}
        shapes = ({"box": rng.uniform(0.1, 0.4, 3)}, {"cylinder": round_shape}, {"capsule": round_shape})
        model.add(f"{k}/body", mass=rng.uniform(0.5, 3), inertia=0.02, joint=mt.Free(), collision=shapes[rng.integers(3)],
                  q=[*rng.uniform(-0.2, 0.2, 2), 0.3 + 0.5 * k, *(turned / np.linalg.norm(turned))])
    model.add_floor(friction=0.5)
    sim, again = (mt.Simulation(each, method="stepping", step=2e-3) for each in (model, pickle.loads(pickle.dumps(model))))
    sim.run(1.5)
    again.run(1.5)
    np.testing.assert_array_equal(again.q, sim.q)


def test_the_ground_has_planes_solids_and_height_fields():
    def model_on(*ground):
        model = mt.Model()
        model.add("ball", mass=1, inertia=0.004, joint=mt.Free(), q=[0.1, 0, 0.5, 1, 0, 0, 0], collision={"sphere": 0.1})
        for each in ground:
            model.add_ground(each)
        return model

    slope = {"plane": [-1, 0, 3], "at": {"xyz": [0, 0, 0.1]}}
    heights = {"heightmap": np.array([[-1, 1.0], [-1, 1.0]]) + 0.3, "size": [6, 6, 1]}
    ends = {}
    for name, model in {
        "plane": model_on(slope),
        "field": model_on({**heights, "at": {"xyz": [0, 0, -0.2]}}),
        "pickled": pickle.loads(pickle.dumps(model_on({**heights, "at": {"xyz": [0, 0, -0.2]}}))),
        "list": model_on([slope, {"box": [0.1, 9, 9], "at": {"xyz": [3, 0, 0]}}]),
    }.items():
        sim = mt.Simulation(model, method="dop853")
        sim.run(0.8)
        ends[name] = sim.q
        assert any(event.name == "impact" for event in sim.events)
    for end in ends.values():
        np.testing.assert_allclose(end, ends["plane"], atol=1e-9)
    assert "heightmap" in model_on(heights).to_toml()
    with pytest.raises(mt.Error, match=r"Model.add_ground.*its normal must not be zero"):
        model_on({"plane": [0, 0, 0]})
    with pytest.raises(mt.Error, match="row 2 has 1 numbers"):
        model_on({"heightmap": [[0, 1], [0]], "size": [1, 1, 1]})


@pytest.mark.parametrize("method", ["rk4", "dop853", "stepping"])
def test_contacts_follow_what_changes_between_runs(method: str) -> None:
    model = mt.Model()
    box = model.add("box/box", mass=2, inertia=0.02, joint=mt.Free(), q=[0, 0, 0.1, 1, 0, 0, 0], collision={"box": [0.4, 0.4, 0.2]})
    model.add_floor(friction=0.5)
    sim = mt.Simulation(model, method=method)
    sim.run(0.1)

    def force():
        return sum((contact.force for contact in sim.world.contacts), np.zeros(3))

    sim.effort[2] = 5
    np.testing.assert_allclose(force(), [0, 0, 2 * 9.81 - 5], atol=1e-3)
    sim.effort[2] = 30
    np.testing.assert_allclose(force(), 0, atol=1e-9)
    np.testing.assert_allclose(sim.world.bodies["box/box"].linear_acceleration, [0, 0, 15 - 9.81], atol=1e-6)
    sim.effort[2] = 0
    sim.set_gravity([0, 0, -1.62])
    np.testing.assert_allclose(force(), [0, 0, 2 * 1.62], atol=1e-3)
    other = sim.branch()
    sim.run(0.2)
    other.run(0.2)
    np.testing.assert_array_equal(other.q, sim.q)
    assert len(mt.Batch(model, worlds=2, threads=1).contact_forces(box)) == 2


@pytest.mark.parametrize("method", ["rk4", "stepping"])
def test_an_action_by_which_bodies_overlap_changes_nothing(method: str) -> None:
    model = mt.Model()
    shape = {"box": [0.4, 0.4, 0.2]}
    model.add("a", mass=2, inertia=0.02, joint=mt.Free(), q=[0, 0, 0.5, 1, 0, 0, 0], collision=shape)
    model.add("b", parent="a", mass=0.1, inertia=1e-3, joint=mt.Weld(), at=[0, 0, 0.1])
    model.add("c", parent="b", mass=2, inertia=0.02, joint=mt.Weld(), at=[0, 0, 0.05], collision=shape)
    model.add_floor()
    sim = mt.Simulation(model, method=method)
    sim.run(0.1)
    before = sim.state_json()
    for _ in range(2):
        with pytest.raises(mt.Error, match="'a' and 'c' overlap by 0.05 m"):
            sim.apply(mt.break_joint("c"))
    assert sim.state_json() == before
    assert not sim.events
    sim.run(0.2)


def test_a_state_in_which_bodies_overlap_is_refused_by_stepping_too() -> None:
    sim = mt.Simulation(box_above_floor(0), method="stepping")
    sim.q[2] = 0.02
    with pytest.raises(mt.RunError, match="'box/box' and 'ground' overlap by 0.08 m"):
        sim.run(0.1)
    sim.q[2] = 0.3
    sim.run(0.1)


def test_what_falls_through_the_floor_for_lack_of_a_collision_is_a_warning() -> None:
    model = mt.Model()
    model.add("box/box", density=1000, shape={"box": [0.2, 0.2, 0.2]}, joint=mt.Free(), q=[0, 0, 1, 1, 0, 0, 0])
    model.add_floor()
    (warning,) = mt.Simulation(model).run(1).warnings
    assert "'box/box' has no collision and is 3.9" in warning and 'collision = "shape"' in warning
    assert mt.Simulation(model).run(0.1).warnings == []
