"""The examples run, their claims hold, and they are notebooks, too."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parent.parent / "examples"
NUMBER = r"([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)"


def numbers(text: str, pattern: str) -> list[float]:
    """The numbers at each ``#`` of a pattern in what an example prints."""
    found = re.search(re.escape(pattern).replace(r"\#", NUMBER), text)
    assert found, f"no '{pattern}' in:\n{text}"
    return [float(each) for each in found.groups()]


def breaking_chain(text: str) -> None:
    gravity, off = numbers(text, "falls with # m/s², off its parabola by at most # m")
    lost, momentum = numbers(text, "took # J; momentum changed by # N s")
    assert gravity == pytest.approx(9.81, abs=1e-6)
    assert off < 1e-9
    assert abs(lost) < 1e-12
    assert momentum < 1e-12


def capture_and_release(text: str) -> None:
    (change,) = numbers(text, "momenta changed by at most # of their size")
    _, lost, before, stiffening = numbers(text, "the grasp at # s took # J of # J; stiffening took # J")
    assert change < 1e-11
    assert 0 < lost < before
    assert stiffening > 0


def chimney(text: str) -> None:
    (share,) = numbers(text, "largest at # of the height")
    (deviation,) = numbers(text, "differs from the theory by at most # of its largest")
    _, broken = numbers(text, "first break at # s, # m above the ground")
    assert share == pytest.approx(1 / 3, abs=1e-4)
    assert deviation < 1e-9
    assert broken == pytest.approx(10.0)


def jammed_joint_monte_carlo(text: str) -> None:
    mean, most = numbers(text, "mean loss # J, 95 % of the jams take less than # J")
    (difference,) = numbers(text, "differ by at most # J")
    assert 0 < mean < most
    assert difference < 1e-9


def energy_against_step(text: str) -> None:
    assert numbers(text, "damped: order #")[0] == pytest.approx(3, abs=0.25)
    assert numbers(text, "midpoint: order #")[0] == pytest.approx(2, abs=0.1)
    assert numbers(text, "rk4: order #")[0] > 3.9


def lost_joint_controller(text: str) -> None:
    assert numbers(text, "freedom: # before the jam, # after")[:2] == [4, 3]
    before, after = numbers(text, "tracking error: # mm before, # mm a second after")
    assert before < 1
    assert after < 2


def batch_of_10000(text: str) -> None:
    flipped, impossible = numbers(text, "#% flip within 10 s; of those without the energy for it, #")
    assert 40 < flipped < 90
    assert impossible == 0
    assert numbers(text, "median energy error # J")[0] < 1e-3


def learn_after_failure(text: str) -> None:
    before, after, _ = numbers(text, "mean return # before, # after # generations")
    reached_before, reached_after = numbers(text, "per episode: # before, # after")
    assert after > before + 8
    assert reached_after > reached_before + 2


CLAIMS: dict[str, Callable[[str], None]] = {
    each.__name__: each
    for each in (
        breaking_chain,
        capture_and_release,
        chimney,
        jammed_joint_monte_carlo,
        energy_against_step,
        lost_joint_controller,
        batch_of_10000,
        learn_after_failure,
    )
}
NEEDS = {"learn_after_failure": ("matplotlib", "gymnasium", "cma")}
ELSEWHERE = {"bridge_mujoco"}  # examples with tests of their own


def require(name: str) -> None:
    for package in NEEDS.get(name, ("matplotlib",)):
        pytest.importorskip(package)


def environment(folder: Path) -> dict[str, str]:
    return {**os.environ, "MPLBACKEND": "agg", "MPLCONFIGDIR": str(folder / "matplotlib"), "PYTHONDONTWRITEBYTECODE": "1"}


def test_every_example_has_its_claims() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} - ELSEWHERE == set(CLAIMS)


@pytest.mark.parametrize("name", CLAIMS)
def test_an_example_runs_and_its_claim_holds(name: str, tmp_path: Path) -> None:
    require(name)
    out = tmp_path / "pictures"
    command = [sys.executable, str(FOLDER / f"{name}.py"), "--quick", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment(tmp_path), cwd=tmp_path, timeout=300)
    assert done.returncode == 0, done.stderr
    CLAIMS[name](done.stdout)
    picture = importlib.import_module("matplotlib.image").imread(out / f"{name}.png")
    assert picture.shape[0] > 300
    assert picture.shape[1] > 500
    drawn = (picture[:, :, :3].min(axis=2) < 0.9).mean()
    assert drawn > 0.01, "the picture is all but empty"
    assert len(np.unique((picture[:, :, :3] * 15).astype(int).reshape(-1, 3), axis=0)) > 10
    assert [path.name for path in out.iterdir()] == [f"{name}.png"]


def cells(path: Path) -> list[str]:
    """The cells of a script: what stands between lines that begin with ``# %%``, and what stands before the first."""
    return [cell for cell in re.split(r"(?m)^# %%", path.read_text(encoding="utf-8")) if cell.strip()]


@pytest.mark.parametrize("name", CLAIMS)
def test_an_example_is_a_notebook(name: str, tmp_path: Path) -> None:
    require(name)
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    new = nbformat.v4
    begin = f"import sys; sys.argv = ['ipykernel', '-f', 'kernel.json', '--quick', '--out', {str(tmp_path)!r}]"
    code = [begin, *(cell if k == 0 else "#" + cell for k, cell in enumerate(cells(FOLDER / f"{name}.py")))]
    notebook = new.new_notebook(cells=[new.new_code_cell(each) for each in code])
    assert len(notebook.cells) > 5
    client = nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute(env=environment(tmp_path))
    text = "".join(o.text for cell in notebook.cells for o in cell.get("outputs", []) if o.get("name") == "stdout")
    CLAIMS[name](text)
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize("guide", ["python-gallery", "python-learning"])
def test_the_guides_are_right(guide: str, tmp_path: Path) -> None:
    """Their Python blocks run, and their pictures and links to examples exist."""
    pytest.importorskip("gymnasium")
    docs = FOLDER.parent.parent / "docs"
    if not docs.exists():
        pytest.skip("the documentation is not here")
    text = (docs / f"{guide}.md").read_text(encoding="utf-8")
    for link in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        assert (docs / link).exists(), link
    for block in re.findall(r"(?ms)^```python\n(.*?)^```", text):
        done = subprocess.run(
            [sys.executable, "-c", block], capture_output=True, text=True, env=environment(tmp_path), timeout=300
        )
        assert done.returncode == 0, done.stderr
    if guide == "python-gallery":
        assert {name for name in CLAIMS if f"examples/{name}.py" in text} == set(CLAIMS)
