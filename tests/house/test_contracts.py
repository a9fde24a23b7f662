"""What the package promises about itself: its floors, its public names, what it does not load at start-up."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import percuss

ROOT = Path(__file__).resolve().parents[2]

PUBLIC = [
    "Bar",
    "Case",
    "Contact",
    "Ensemble",
    "Kept",
    "Load",
    "Orbit",
    "PercussError",
    "Reversed",
    "Stability",
    "Start",
    "Starts",
    "SteadyStates",
    "Stop",
    "System",
    "Timed",
    "Trajectory",
    "__version__",
    "rest_on_wall",
    "run",
    "si_report",
    "simulate_many",
    "stability_of",
    "steady_states",
    "timed_stability",
    "timed_states",
]

HEAVY = {"h5py", "matplotlib", "nptdms", "numba", "numpy", "pint", "pydantic", "rich", "scipy"}


def run(code: str) -> str:
    """The standard output of a fresh interpreter that runs `code`."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def loaded_after(code: str) -> set[str]:
    """The heavy packages in sys.modules after `code`, whatever it prints and even if it exits."""
    out = run(
        f"import json, sys\ntry:\n    {code}\nexcept SystemExit:\n    pass\n"
        "print()\nprint(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})))"
    )
    return HEAVY & set(json.loads(out.splitlines()[-1]))


def test_imports_point_down():
    code = "from importlinter.cli import lint_imports as f; raise SystemExit(f(no_cache=True, no_logo=True))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_public_names_are_pinned():
    assert sorted(percuss.__all__) == PUBLIC
    assert set(PUBLIC) <= set(dir(percuss))
    with pytest.raises(AttributeError, match="orbits"):
        _ = percuss.orbits


@pytest.mark.parametrize(
    "first", ["pass", "import percuss.case.answers.steady_answer", "import percuss.stability, percuss.steady"]
)
def test_public_names_mean_the_same_whatever_was_imported_before(first):
    """A function and a room of one name would take each other's place."""
    kinds = run(f"import percuss\n{first}\nfor name in percuss.__all__: print(name, type(getattr(percuss, name)))")
    assert "class 'module'" not in kinds


@pytest.mark.parametrize(
    "code",
    [
        "import percuss",
        "import percuss.cli",
        "import percuss.case",
        "import percuss.plot",
    ],
)
def test_nothing_heavy_is_loaded_at_start_up(code):
    assert loaded_after(code) == set()


def test_the_physics_loads_numpy_alone():
    """Doors load nothing; names behind them no more than numpy."""
    assert loaded_after("import percuss.model, percuss.steady, percuss.stability, percuss.simulate") == set()
    code = "from percuss import Load, Start, System, stability_of, steady_states"
    assert loaded_after(code) == {"numpy"}


def test_a_saved_motion_is_read_without_the_engine(tmp_path):
    path = str(tmp_path / "run.nc")
    run(
        "from percuss import Load, Start, Stop, System, run\n"
        "system = System(s=5.0, d=0.01, restitution=0.5, load=Load.square(1.0, 1.4))\n"
        f"run(system, Start.rigid(), modes=3, stop=Stop(impacts=7)).save({path!r})"
    )
    code = (
        f"from percuss import Trajectory; m = Trajectory.load({path!r}); assert m.impacts == 7;"
        " assert m.gap(m.end_time).size == 1 and m.energy_balance().input > 0.0 and m.summary.blow_rate"
    )
    assert "numba" not in loaded_after(code)


def test_a_json_answer_loads_neither_scipy_nor_a_terminal_nor_pint(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(
        '[bar]\nlength = "341 mm"\ndiameter = "49 mm"\n'
        '[load]\nkind = "harmonic"\nmean = "5 kN"\namplitude = "6 kN"\nfrequency = "60 Hz"\n'
        "[contact]\nrestitution = 0.6\n"
    )
    code = f"from percuss.cli import main; main(['steady', {str(case)!r}, '--json'])"
    assert loaded_after(code) <= {"numpy", "pydantic"}


def test_the_version_is_written_once():
    assert percuss.__version__ == run("from percuss._version import __version__ as v; print(v)").strip()
    assert f"version: {percuss.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## [{percuss.__version__}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
