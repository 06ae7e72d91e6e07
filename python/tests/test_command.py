"""``python -m momentree`` is the command: the same output, exit codes and signals."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

import momentree

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODULE = [sys.executable, "-m", "momentree"]
PROGRAM = os.environ.get("MOMENTREE_PROGRAM", "")
needs_program = pytest.mark.skipif(not PROGRAM, reason="MOMENTREE_PROGRAM does not name the program; ctest sets it")


def run(*words: str, **options: object) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(words, capture_output=True, timeout=120, **options)  # type: ignore[call-overload, no-any-return]


@needs_program
@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--version"], 0),
        (["help", "run"], 0),
        (["check", "scenarios/pendulum.toml"], 0),
        (["check", "scenarios/models/ur5/ur5_robot.urdf"], 0),
        (["run", "no_such_file.toml"], 2),
        (["runn"], 2),
        ([], 2),
    ],
)
def test_same_as_the_program(arguments: list[str], code: int) -> None:
    program = run(PROGRAM, *arguments, cwd=ROOT)
    module = run(*MODULE, *arguments, cwd=ROOT)
    assert module.returncode == program.returncode == code
    assert module.stdout == program.stdout
    assert module.stderr == program.stderr


def test_version() -> None:
    assert run(*MODULE, "--version").stdout.split()[:2] == [b"momentree", momentree.__version__.encode()]


def test_a_name_that_is_not_text(tmp_path: pathlib.Path) -> None:
    name = os.fsencode(tmp_path) + b"/pendulum \xff.toml"
    pathlib.Path(os.fsdecode(name)).write_bytes((ROOT / "scenarios/pendulum.toml").read_bytes())
    assert run(*MODULE, "check", os.fsdecode(name)).returncode == 0


def test_bench_measures_a_model() -> None:
    done = run(*MODULE, "bench", "scenarios/pendulum.toml", cwd=ROOT)
    assert done.returncode == 0
    assert b"Your models" in done.stdout


@pytest.mark.parametrize("command", [MODULE, pytest.param([PROGRAM], marks=needs_program)], ids=["module", "program"])
def test_interrupted_run_keeps_its_results(command: list[str], tmp_path: pathlib.Path) -> None:
    out = tmp_path / "out"
    scenario = str(ROOT / "scenarios/breaking_chain.toml")
    process = subprocess.Popen([*command, "run", scenario, "--until", "1e6", "--out", str(out)], stderr=subprocess.PIPE)
    while not list(tmp_path.rglob("joints.csv*")):  # the run has begun, and handles the signal
        assert process.poll() is None
        time.sleep(0.01)
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 3
    assert (tmp_path / "out.partial" / "joints.csv").exists()


def test_interrupt_ends_other_commands_as_a_signal_does() -> None:
    process = subprocess.Popen([*MODULE, "check", "-"], stdin=subprocess.PIPE)
    status = pathlib.Path(f"/proc/{process.pid}/wchan")
    for _ in range(500):  # until it waits for standard input
        if "pipe" in status.read_text():
            break
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == -signal.SIGINT


def test_a_closed_pipe_ends_it_silently() -> None:
    module = subprocess.Popen([*MODULE, "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert module.stdout is not None and module.stderr is not None
    module.stdout.close()
    error = module.stderr.read()
    assert module.wait(timeout=60) == -signal.SIGPIPE
    assert error == b""


def test_handlers_of_python_come_back(tmp_path: pathlib.Path) -> None:
    before = signal.getsignal(signal.SIGINT)
    code = momentree._core.main([b"momentree", b"check", os.fsencode(ROOT / "scenarios/pendulum.toml")])
    assert code == 0
    assert signal.getsignal(signal.SIGINT) is before
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
