"""The package as it was built."""

import subprocess
import sys

from momentree import _core


def test_the_extension_exports_its_init_function_alone() -> None:
    extension = str(_core.__file__)
    lines = subprocess.run(["nm", "-D", "--defined-only", extension], check=True, capture_output=True, text=True).stdout.splitlines()
    assert [line.split()[-1] for line in lines] == ["PyInit__core"]


def test_importing_brings_only_numpy() -> None:
    code = "import sys; import momentree; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    others = {"matplotlib", "pandas", "gymnasium", "mujoco", "pydrake", "torch", "scipy", "cma"}
    assert "momentree" in loaded
    assert not others & set(loaded)


def test_without_gymnasium_the_package_can_be_inspected() -> None:
    program = """
import inspect, pydoc, sys
sys.modules["gymnasium"] = None  # as if it was not installed
import momentree
assert not hasattr(momentree, "envs")
assert "Simulation" in dict(inspect.getmembers(momentree))
assert "class Simulation" in pydoc.render_doc(momentree, renderer=pydoc.plaintext)
for statement in ("import momentree.envs", "from momentree import envs"):
    try:
        exec(statement)
    except ImportError as error:
        assert "pip install gymnasium" in str(error)
    else:
        raise AssertionError(statement)
try:
    momentree.envs
except AttributeError as error:
    assert "pip install gymnasium" in str(error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
