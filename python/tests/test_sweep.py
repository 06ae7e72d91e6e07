"""Sweeps: the results of the command to the bit, closed forms, errors, interrupts, and sweeps of Python functions."""

from __future__ import annotations

import csv
import json
import math
import multiprocessing
import os
import pickle
import re
import signal
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import momentree as mt

PROGRAM = os.environ.get("MOMENTREE_PROGRAM", "")

BALL = """format = 1
[world]
gravity = [0, -10, 0]
[[mechanism]]
name = "m"
root = "free"
state = { velocity = { linear = [2, 4, 0] } }
[[mechanism.body]]
name = "ball"
mass = 2
inertia = 1
[[event]]
name = "low"
when = { height = { of = "m/ball", below = -1 } }
impulse = { body = "m/ball", force = [1, 0, 0] }
[integrate]
step = 0.01
until = 1
[output]
every = 0.1
"""
SWEEP = """format = 1
scenario = "ball.toml"
worlds = 12
seed = 3
[vary]
"mechanism.m.state.velocity.linear" = { uniform = [[1, 3, -1], [2, 6, 1]] }
"integrate.method" = ["rk4", "midpoint"]
[measure]
x = { final = "m/ball.x" }
y = { final = "m/ball.y" }
mass_moved = { mean = "m/ball.x" }
"""


def folder_of(tmp_path: Path, sweep: str = SWEEP) -> Path:
    (tmp_path / "ball.toml").write_text(BALL.replace(BALL[BALL.index("[[event]]") : BALL.index("[integrate]")], ""))
    path = tmp_path / "throws.toml"
    path.write_text(sweep)
    return path


def test_a_sweep_says_what_it_varies(tmp_path: Path) -> None:
    sweep = mt.Sweep(folder_of(tmp_path))
    velocity = "mechanism.m.state.velocity.linear"
    assert sweep.worlds == len(sweep) == 12 and sweep.seed == 3 and sweep.name == "throws" and sweep.warnings == []
    assert sweep.parameters == (f"{velocity}.0", f"{velocity}.1", f"{velocity}.2", "integrate.method")
    assert sweep.measures == ("x", "y", "mass_moved")
    values = sweep.values(7)
    assert 1 <= float(values[f"{velocity}.0"]) <= 2 and 3 <= float(values[f"{velocity}.1"]) <= 6
    assert values["integrate.method"] in ("rk4", "midpoint")
    given = dict(each.split("=", 1) for each in sweep.overrides(7))
    assert json.loads(given[velocity]) == [values[f"{velocity}.{k}"] for k in range(3)]


def test_measures_have_their_closed_forms(tmp_path: Path) -> None:
    """A thrown ball; both methods are exact for it."""
    results = mt.Sweep(folder_of(tmp_path)).run()
    v = [results[f"mechanism.m.state.velocity.linear.{k}"] for k in range(2)]
    assert results["x"] == pytest.approx(v[0], rel=1e-13)
    assert results["y"] == pytest.approx(v[1] - 5, rel=1e-12, abs=1e-12)
    assert results.status == ["done"] * 12 and not results.failed.any()
    assert list(results.world) == list(range(12))


def test_any_number_of_jobs_and_any_order_give_the_same_bits(tmp_path: Path) -> None:
    sweep = mt.Sweep(folder_of(tmp_path))
    one, many = sweep.run(jobs=1), sweep.run(jobs=5)
    some = sweep.run(jobs=2, worlds=[9, 3, np.int64(4)])
    for name in (*sweep.parameters, *sweep.measures):
        assert one[name].tobytes() == many[name].tobytes()
        assert list(some[name]) == [one[name][k] for k in (9, 3, 4)]
    assert one.summary() == many.summary()


def test_a_world_is_the_simulation_of_its_row(tmp_path: Path) -> None:
    sweep = mt.Sweep(folder_of(tmp_path))
    results = sweep.run()
    for k in (0, 5, 11):
        simulation = sweep.world(k)
        simulation.run(progress=False)
        assert simulation.world.bodies["m/ball"].position[:2] == pytest.approx([results["x"][k], results["y"][k]], rel=1e-12)
        assert pickle.loads(pickle.dumps(sweep.world(k))).time == 0


FAILING = SWEEP.replace('"integrate.method" = ["rk4", "midpoint"]', '"integrate.until" = ["0.05 s", "1 s"]') + (
    "[stop]\nsteps = 50\n"
)


def rows_of_command(path: Path, out: Path) -> list[dict[str, str]]:
    command = [PROGRAM, "sweep", str(path), "--out", str(out), "--quiet", "--jobs", "1"]
    assert subprocess.run(command, check=False, capture_output=True, timeout=120).returncode == 0
    with open(out / "worlds.csv", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.skipif(not PROGRAM, reason="MOMENTREE_PROGRAM does not name the command")
@pytest.mark.parametrize("text", [SWEEP, FAILING], ids=["all", "some fail"])
def test_results_are_those_of_the_command(text: str, tmp_path: Path) -> None:
    path = folder_of(tmp_path, text)
    sweep = mt.Sweep(path)
    rows = rows_of_command(path, tmp_path / "out")
    for jobs in (1, 3):
        results = sweep.run(jobs=jobs)
        assert results.status == [row["status"] for row in rows]
        assert list(results.failed) == [row["status"] != "done" for row in rows]
        for name in (*sweep.parameters, *sweep.measures):
            for value, row in zip(results[name], rows, strict=True):
                if isinstance(value, str):
                    assert value == row[name]
                else:
                    assert (math.isnan(value) and row[name] == "") or value == float(row[name])
        assert results.summary() == json.loads((tmp_path / "out" / "sweep.json").read_text())
    assert (text is FAILING) == any(results.failed)


@pytest.mark.skipif(not PROGRAM, reason="MOMENTREE_PROGRAM does not name the command")
def test_flags_and_absent_numbers(tmp_path: Path) -> None:
    """The crane's rope parts in some worlds only."""
    path = Path(__file__).parents[2] / "scenarios/sweeps/rope_strength.toml"
    text = path.read_text().replace("../crane.toml", str(path.parents[1] / "crane.toml"))
    (tmp_path / "rope.toml").write_text(re.sub(r"(?m)^worlds *=.*", "worlds = 16", text))
    rows = rows_of_command(tmp_path / "rope.toml", tmp_path / "out")
    results = mt.Sweep(tmp_path / "rope.toml").run(jobs=2)
    assert results["parted"].dtype == float
    parted = results["parted"] == 1
    assert list(parted) == [row["parted"] == "true" for row in rows]
    assert 0 < parted.sum() < len(results) == 16
    assert (np.isnan(results["when"]) == ~parted).all()
    when = [float(row["when"]) for row in rows if row["when"]]
    assert list(results["when"][parted]) == when
    share = results.share("parted")
    column = next(each for each in results.summary()["columns"] if each["name"] == "parted")
    assert share.worlds == 16 and share.value == column["share"] == np.nanmean(results["parted"])
    assert (share.lowest, share.highest) == pytest.approx(column["interval"], rel=1e-12)
    with pytest.raises(mt.Error, match="'when' is no flag"):
        results.share("when")
    assert results.summary() == json.loads((tmp_path / "out" / "sweep.json").read_text())


def test_tables(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    results = mt.Sweep(folder_of(tmp_path, FAILING)).run()
    table = results.to_pandas()
    assert list(table.columns) == [*results.parameters, *results.measures, "status"]
    assert table.index.name == "world" and list(table.index) == list(range(12))
    assert (table["status"] == "done").sum() == len(results) - results.failed.sum()
    try:
        import pyarrow  # type: ignore[import-not-found,unused-ignore] # noqa: F401
    except ImportError:
        with pytest.raises(mt.Error, match="pyarrow"):
            results.to_parquet(tmp_path / "table.parquet")
        return
    results.to_parquet(tmp_path / "table.parquet")
    pandas.testing.assert_frame_equal(pandas.read_parquet(tmp_path / "table.parquet"), table)


def test_mistakes_are_errors(tmp_path: Path) -> None:
    path = folder_of(tmp_path, SWEEP.replace("final", "finale", 1))
    with pytest.raises(mt.Error, match="finale") as wrong:
        mt.Sweep(path)
    assert wrong.value.file == str(path) and wrong.value.line == 9 and wrong.value.column
    assert wrong.value.diagnostics[0].severity == "error"
    with pytest.raises(mt.Error, match=r"absent\.toml"):
        mt.Sweep(tmp_path / "absent.toml")
    with pytest.raises(mt.Error, match="scenario of one world"):
        mt.Sweep(tmp_path / "ball.toml")
    sweep = mt.Sweep(folder_of(tmp_path))
    uses: list[Callable[[Any], Any]] = [sweep.values, sweep.overrides, sweep.world, lambda world: sweep.run(worlds=[0, world])]
    for use in uses:
        for world in (12, -1):
            with pytest.raises(mt.Error, match=f"no world {world}: the sweep has 12"):
                use(world)
        with pytest.raises(mt.Error, match="expected an integer, found 'a'"):
            use("a")
    with pytest.raises(mt.Error, match="jobs"):
        sweep.run(jobs=-1)
    results = sweep.run(worlds=[0])
    with pytest.raises(mt.Error, match="no column 'z'"):
        results["z"]
    assert "x" in results and "z" not in results
    assert len(sweep.run(worlds=[])) == 0
    with pytest.raises(mt.Error, match="not enough memory"):
        mt.Sweep(folder_of(tmp_path, SWEEP.replace("worlds = 12", f"worlds = {2**47}"))).run()


def test_ctrl_c_ends_it_and_other_threads_run(tmp_path: Path) -> None:
    sweep = mt.Sweep(folder_of(tmp_path, SWEEP.replace("worlds = 12", "worlds = 1_000_000")))
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=count)
    thread.start()
    threading.Timer(0.5, stop.set).start()
    with pytest.raises(KeyboardInterrupt) as ended:
        sweep.run(jobs=2)
    thread.join()
    assert counted[0] > 0
    kept = ended.value.results  # type: ignore[attr-defined]
    assert 0 < len(kept) < 1_000_000
    some = kept.world[:: max(1, len(kept) // 20)]
    again = sweep.run(worlds=some)
    for name in sweep.parameters + sweep.measures:
        np.testing.assert_array_equal(kept[name][np.isin(kept.world, some)], again[name])


@pytest.mark.parametrize("sweeps_functions", [True, False])
def test_progress_is_shown_as_worlds(tmp_path: Path, capsys: pytest.CaptureFixture[str], sweeps_functions: bool) -> None:
    if sweeps_functions:
        mt.sweep(double_of, {"seed": range(300)}, progress=True)
    else:
        mt.Sweep(folder_of(tmp_path, SWEEP.replace("worlds = 12", "worlds = 3000"))).run(progress=True)
    assert "worlds" in capsys.readouterr().err


# Functions of the worlds; processes import them from this file.


def range_of_throw(speed: float, angle: float) -> dict[str, float]:
    v = (speed * math.cos(angle), 0, speed * math.sin(angle), 0, 0, 0)
    model = mt.Model(gravity=(0, 0, -10))
    model.add("ball", mass=1, inertia=1, joint=mt.Free(), v=v)
    simulation = mt.Simulation(model, step=0.01)
    simulation.run(2 * speed * math.sin(angle) / 10, progress=False)
    return {"reach": float(simulation.world.bodies["ball"].position[0]), "height": float(simulation.world.bodies["ball"].position[2])}


def fails_above_two(x: float) -> dict[str, Any]:
    if x > 2:
        raise ZeroDivisionError("too much")
    return {"x2": x * x, "big": x > 1, "even": None if x % 2 else 1.0}


def double_of(seed: int) -> float:
    return 2.0 * seed


def columns_of(results: mt.SweepResults) -> dict[str, bytes]:
    return {name: results[name].tobytes() for name in (*results.parameters, *results.measures)}


def test_functions_have_their_closed_forms() -> None:
    results = mt.sweep(range_of_throw, {"speed": [3, 4], "angle": np.linspace(0.3, 1.2, 4)})
    assert list(results["speed"]) == [3] * 4 + [4] * 4
    assert list(results["angle"]) == list(np.linspace(0.3, 1.2, 4)) * 2
    assert results["reach"] == pytest.approx(results["speed"] ** 2 * np.sin(2 * results["angle"]) / 10, rel=1e-11)
    assert results["height"] == pytest.approx(0, abs=1e-12)


def test_executors_give_the_same_results() -> None:
    parameters = {"speed": [3.0, 4.0], "angle": [0.3, 0.6, 0.9]}
    one = columns_of(mt.sweep(range_of_throw, parameters))
    assert columns_of(mt.sweep(range_of_throw, parameters, jobs=3)) == one
    assert columns_of(mt.sweep(range_of_throw, parameters, jobs=0)) == one
    with ThreadPoolExecutor(2) as threads:
        assert columns_of(mt.sweep(range_of_throw, parameters, executor=threads)) == one
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as processes:
        assert columns_of(mt.sweep(range_of_throw, parameters, executor=processes)) == one


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_exception_is_the_status_of_its_world(jobs: int) -> None:
    results = mt.sweep(fails_above_two, [{"x": k % 4} for k in range(2500)], jobs=jobs)
    assert results.status[:4] == ["done", "done", "done", "failed: ZeroDivisionError: too much"]
    assert list(results.failed) == [k % 4 == 3 for k in range(2500)]
    assert list(results["big"][:3]) == [0, 0, 1] and math.isnan(results["big"][3])
    share = results.share("big")
    assert share.worlds == 1875 and share.value == np.nanmean(results["big"]) == 1 / 3
    assert 0.31 < share.lowest < 1 / 3 < share.highest < 0.36
    assert list(results["x2"][:3]) == [0, 1, 4] and math.isnan(results["x2"][3])
    assert results["even"][0] == 1 and math.isnan(results["even"][1])
    with pytest.raises(mt.Error, match="summary"):
        results.summary()


def test_seeds_differ_between_worlds_and_depend_on_the_seed_alone() -> None:
    results = mt.sweep(double_of, 1000, seed=7)
    assert len(set(results["seed"])) == 1000
    assert list(results["value"]) == list(2 * results["seed"])
    assert list(mt.sweep(double_of, 10, seed=7, jobs=2)["seed"]) == list(results["seed"][:10])
    assert not set(mt.sweep(double_of, 10, seed=8)["seed"]) & set(results["seed"])


DISTRIBUTIONS = [  # with mean and standard deviation
    (mt.uniform(2, 5), 3.5, 3 / math.sqrt(12)),
    (mt.normal(4, 0.5), 4, 0.5),
    (mt.normal(0, 1, within=(0, 50)), math.sqrt(2 / math.pi), math.sqrt(1 - 2 / math.pi)),
    (mt.lognormal(0.5, 0.2), math.exp(0.52), math.exp(0.52) * math.sqrt(math.expm1(0.04))),
    (mt.exponential(3), 3, 3),
    (mt.weibull(2, 2), math.sqrt(math.pi), math.sqrt(4 - math.pi)),
    (mt.triangular(0, 1, 2), 1, math.sqrt(1 / 6)),
]


@pytest.mark.parametrize(("distribution", "mean", "deviation"), DISTRIBUTIONS)
def test_distributions_have_their_moments(distribution: mt.Distribution, mean: float, deviation: float) -> None:
    results = mt.sweep(lambda x: x, {"x": distribution}, worlds=20_000, sampling="latin", seed=5)
    assert (results["x"] == results["value"]).all()
    assert results["x"].mean() == pytest.approx(mean, rel=1e-3)
    assert results["x"].std() == pytest.approx(deviation, rel=0.02)


def test_draws_depend_on_the_seed_and_lists_are_drawn_evenly() -> None:
    def draw(seed: int, sampling: str = "random") -> mt.SweepResults:
        parameters: dict[str, Any] = {"x": mt.uniform(0, 1), "kind": ["a", "b"]}
        return mt.sweep(lambda x, kind: x, parameters, worlds=4096, seed=seed, sampling=sampling)

    assert columns_of(draw(1)) == columns_of(draw(1)) != columns_of(draw(2))
    assert abs((draw(1)["kind"] == "a").sum() - 2048) < 5 * 32
    assert (np.bincount((draw(1, "sobol")["x"] * 64).astype(int)) == 64).all()
    wrong_draws: list[dict[str, Any]] = [{}, {"worlds": 0}, {"worlds": 5, "sampling": "best"}, {"worlds": 5, "seed": -1}]
    for wrong in wrong_draws:
        with pytest.raises(mt.Error, match="worlds|sampling|seed"):
            mt.sweep(lambda x: x, {"x": mt.uniform(0, 1)}, **wrong)
    with pytest.raises(mt.Error, match="uniform"):
        mt.sweep(lambda x: x, {"x": mt.uniform(1, 0)}, worlds=5)
    with pytest.raises(mt.Error, match="worlds"):
        mt.sweep(double_of, 5, worlds=5)


def test_wrong_parameters_and_results() -> None:
    wrong: list[tuple[Any, str]] = [({"x": 1}, "sequence of values"), ("x", "expected parameters"), ([1], "world 0"), (-1, "negative")]
    for parameters, problem in wrong:
        with pytest.raises(mt.Error, match=problem):
            mt.sweep(fails_above_two, parameters)
    with pytest.raises(mt.Error, match="expected a function"):
        mt.sweep(3, 1)  # type: ignore[arg-type]
    with pytest.raises(mt.Error, match="jobs"):
        mt.sweep(double_of, 1, jobs=-1)
    with pytest.raises(mt.Error, match="which is a parameter"):
        mt.sweep(lambda seed: {"seed": 1}, 2)
    assert list(mt.sweep(lambda x: x, {"x": [True, 2.0, False]})["value"]) == [1, 2, 0]
    results = mt.sweep(lambda x: x, {"x": ["a", "b"]})
    assert results.status[1] == "failed: TypeError: the function returned 'b' as 'value', which is no number"
    assert list(results["x"]) == ["a", "b"]


def test_a_name_that_clashes_is_found_in_the_first_world() -> None:
    called: list[int] = []

    def function(x: int) -> dict[str, int]:
        called.append(x)
        return {"x": 1}

    with pytest.raises(mt.Error, match="which is a parameter"):
        mt.sweep(function, {"x": range(100)}, jobs=1)
    assert called == [0]
    late = mt.sweep(lambda x: {"y" if x < 3 else "x": x}, {"x": [1, 2, 3]})
    assert late.status == ["done", "done", "failed: the function returned 'x', which is a parameter"]
    assert list(late["y"][:2]) == [1, 2]


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_finished_is_kept_when_a_sweep_is_interrupted(jobs: int) -> None:
    later = threading.Event()

    def function(x: int) -> int:
        if x == 5:
            later.wait(0.2)
            raise KeyboardInterrupt
        return 2 * x

    with pytest.raises(KeyboardInterrupt) as ended:
        mt.sweep(function, {"x": range(100)}, jobs=jobs)
    results = ended.value.results  # type: ignore[attr-defined]
    assert set(range(5)) <= set(results.world) and 5 not in results.world
    assert list(results["value"]) == list(2 * results["x"]) == [2 * k for k in results.world]
    assert not results.failed.any()


def dies_in_world_7(x: int) -> int:
    if x == 7:
        os._exit(1)
    return 2 * x


def test_worlds_of_a_broken_executor_fail_and_the_others_are_kept() -> None:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as processes:
        results = mt.sweep(dies_in_world_7, {"x": range(20)}, executor=processes)
    assert len(results) == 20 and list(results["value"][:5]) == [0, 2, 4, 6, 8]
    assert results.status[7].startswith("failed: BrokenProcessPool: ")
    assert list(results["value"][~results.failed]) == list(2 * results["x"][~results.failed])
