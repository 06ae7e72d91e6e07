"""The commands that the sweep runs, and the folders that they start from."""
import os
import resource
import subprocess
from dataclasses import dataclass, field
from functools import partial
from typing import Callable

import laws

SCENARIO = '''format = 1
title = "Two links"
[world]
gravity = [0, 0, -9.81]
[[mechanism]]
name = "arm"
[[mechanism.body]]
name = "a"
mass = 1
inertia = 0.1
com = [0.5, 0, 0]
[mechanism.body.joint]
kind = "revolute"
axis = [0, 1, 0]
[[mechanism.body]]
name = "b"
mass = 1
inertia = 0.1
[mechanism.body.joint]
name = "pin"
kind = "revolute"
axis = [0, 1, 0]
parent = "a"
at = { xyz = [1, 0, 0] }
[[event]]
name = "snap"
at = 0.05
break = "arm/pin"
[integrate]
until = 0.1
[output]
every = 0.01
'''


@dataclass
class Case:
    name: str
    arguments: list
    law: Callable
    before: dict = field(default_factory=dict)  # the file tree before the run
    environment: dict = field(default_factory=dict)
    kills: bool = True  # whether there is data to lose


def bounded():
    """No slip in a test fills the disk."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 25, 1 << 25))
    resource.setrlimit(resource.RLIMIT_CPU, (60, 60))


def cases(program, shim, folder):
    """All of them; `folder` is for making the results that some of them start from."""
    def made(*arguments, fails=False):
        environment = os.environ | ({"LD_PRELOAD": shim, "FAULTS_DISK": "20000"} if fails else {})
        done = subprocess.run([program, *arguments], cwd=folder, env=environment, capture_output=True, check=False, timeout=60,
                              preexec_fn=bounded)
        if done.returncode != (1 if fails else 0):
            raise SystemExit(f"{arguments}: exit {done.returncode}: {done.stderr.decode()}")

    with open(os.path.join(folder, "s.toml"), "w", encoding="utf-8") as file:
        file.write(SCENARIO)
    made("run", "s.toml", "--quiet", "--out", "r", "--until", "0.07")  # an earlier result, and a failed one
    made("run", "s.toml", "--quiet", "--out", "f", "--until", "1", fails=True)
    made("convert", "s.toml", "-o", "m.urdf")
    tree = laws.read_tree(folder)
    result = {"r/" + name: text for name, text in laws.below(tree, "r").items()}
    failed = {"r.partial/" + name: text for name, text in laws.below(tree, "f.partial").items()}
    if not failed:
        raise SystemExit("the run that should fail left nothing")
    scenario = {"s.toml": SCENARIO.encode()}
    notes = {"r/notes/page.txt": b"mine", "r/picture.svg": b"mine, too"}
    more = {"r.partial/why.txt": b"my thoughts about it"}
    neighbours = {"r.former": b"precious", "r.partial.txt": b"mine", "summary.json": b"{}"}
    from_state = {"t.toml": SCENARIO.replace("format = 1", 'format = 1\nstate = "f.json"', 1).encode(),
                  "f.json": result["r/final.json"]}
    run = ["run", "s.toml", "--out", "r"]
    urdf = {"m.urdf": tree["m.urdf"]}
    return [
        Case("run", run, laws.run_law, scenario | neighbours),
        Case("run --report over a result", run + ["--report", "--reactions"], laws.run_law,
             scenario | result | notes | neighbours),
        Case("run --checkpoint", run + ["--quiet", "--checkpoint", "1us", "--set", "integrate.step=0.03"], laws.run_law,
             scenario | result | neighbours),
        Case("run over a failed one", run + ["--quiet"], laws.run_law, scenario | result | notes | failed | more),
        Case("run without exchange", run + ["--json"], laws.run_law, scenario | result | notes | failed | more,
             {"FAULTS_NO_EXCHANGE": "1"}),
        Case("run from a state", ["run", "t.toml", "--out", "r"], laws.run_law, from_state),
        Case("run of a model", ["run", "m.urdf", "--until", "0.02", "--out", "deep/er/r"],
             partial(laws.run_law, out="deep/er/r"), urdf, kills=False),
        Case("convert", ["convert", "s.toml", "-o", "out.toml"], laws.file_law, scenario),
        Case("convert over a file", ["convert", "s.toml", "-o", "out.urdf"], laws.file_law, scenario | {"out.urdf": b"older"}),
        Case("convert to output", ["convert", "m.urdf", "-o", "-"], laws.text_law, urdf, kills=False),
        Case("compile", ["compile", "s.toml", "-o", "out.cpp"], laws.file_law, scenario | {"out.cpp": b"older"}),
        Case("evaluate --state", ["evaluate", "s.toml", "--state", "r/final.json", "--json"], laws.text_law, scenario | result,
             kills=False),
        Case("check --json", ["check", "s.toml", "m.urdf", "--json"], laws.text_law, scenario | urdf, kills=False),
        Case("explain", ["explain", "s.toml"], laws.text_law, scenario, kills=False),
        Case("view of a result", ["view", "r", "--svg", "out.svg"], laws.file_law, scenario | result),
        Case("export as glTF", ["view", "r", "--export", "out.glb"], laws.file_law, scenario | result | {"out.glb": b"older"}),
        Case("export as MCAP", ["view", "r", "--export", "out.mcap"], laws.file_law, scenario | result),
        Case("view of a scenario", ["view", "s.toml", "--svg", "out.svg"], laws.file_law, scenario, kills=False),
    ]
