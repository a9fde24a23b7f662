"""The figures of B77: their tables against closed forms, their pictures, and the command that makes them."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import naive
from percuss import Load, System, stability_of, steady_states
from percuss.cli import main
from percuss.errors import ParameterError, PercussError
from percuss.explore.boundary_curves.boundary import boundaries
from percuss.explore.parameters import vary
from percuss.paper import figures, write_figures
from percuss.paper.figure import DAMPING, RESTITUTIONS, PaperFigure, hydraulic, pneumatic
from percuss.plot.canvas import segments
from percuss.stability import stability_plane

COLUMNS = {
    "fig2": ["phase", "measured", "approximation"],
    "fig3": ["phase", "load", "series_3", "series_10", "series_40"],
    "fig4": ["restitution", "load_factor", "phase", "stable", "admissible"],
    "fig5": ["restitution", "lower", "upper", "lower_damped", "upper_damped"],
    "fig6": ["restitution", "upper", "lower", "lower_10_1", "lower_10_01"],
    "fig7": ["restitution", "kappa", "phase", "stable", "admissible"],
    "fig8": ["restitution", "kappa", "kappa_damped"],
    "elastic": ["s", "upper", "lower_reduced", "flip", "neimark_sacker"],
    "elastic_multipliers": ["s", "reduced", "exact_8", "exact_16"],
    "elastic_instability": ["s", "reduced", "exact_8", "exact_16"],
}
LONG = ("fig7", "fig8", "elastic")
DRAWN = [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in COLUMNS]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the figures are written, each when it is first looked at."""
    pytest.importorskip("matplotlib")
    return tmp_path_factory.mktemp("paper") / "made" / "here"


def written(folder: Path, name: str, suffix: str) -> Path:
    """One file of a figure, which is made when it is not there yet."""
    if not (folder / f"{name}.csv").exists():
        group = name.partition("_")[0]
        paths = list(write_figures([group], folder))
        assert all(path.is_file() for path in paths)
        assert len(paths) == 3 * sum(other.startswith(group) for other in COLUMNS)
    return folder / f"{name}{suffix}"


def table(folder: Path, name: str) -> dict[str, np.ndarray]:
    """A CSV as columns: numbers, or truth values."""
    with written(folder, name, ".csv").open(encoding="utf-8", newline="") as file:
        head, *rows = list(csv.reader(file))
    assert head == COLUMNS[name]
    columns = dict(zip(head, zip(*rows, strict=True), strict=True))
    words = {"true": True, "false": False}
    return {
        key: np.array([words[x] for x in column]) if column[0] in words else np.array([float(x) for x in column])
        for key, column in columns.items()
    }


def near(found: object, expected: object, to: float = 1e-12) -> bool:
    return bool(np.max(np.abs(np.asarray(found) - np.asarray(expected))) < to)


# ---------------------------------------------------------------- every figure


@pytest.mark.parametrize("name", DRAWN)
def test_tables_have_their_columns(folder, name):
    columns = table(folder, name)
    assert {column.size for column in columns.values()} != {0}
    if name in ("fig5", "fig6", "fig8"):
        assert near(columns["restitution"], np.linspace(0.0, 0.99, 100), 1e-15)
        assert all(np.isfinite(column).all() for column in columns.values())
    if name in ("fig4", "fig7"):
        assert near(np.unique(columns["restitution"]), np.arange(10) / 10, 1e-15)


@pytest.mark.parametrize("name", DRAWN)
def test_pictures_show_something(folder, name):
    from matplotlib.image import imread

    picture = imread(written(folder, name, ".png"))[:, :, :3]
    inked = np.mean(np.abs(picture - 1.0).max(axis=2) > 0.1)
    assert 0.01 < inked < 0.6
    assert min(picture.shape[:2]) > 400
    colours = np.unique((picture[::3, ::3] * 15).astype(int).reshape(-1, 3) @ [256, 16, 1])
    assert len(colours) > 4
    text = written(folder, name, ".svg").read_text(encoding="utf-8")
    assert text.startswith("<?xml") and "</svg>" in text


def test_same_figure_same_bytes(folder, tmp_path):
    for path in write_figures(("fig2", "fig3"), tmp_path):
        assert path.read_bytes() == written(folder, path.stem, path.suffix).read_bytes()
    (other,) = figures("fig2", seed=5)
    assert not np.array_equal(other.columns["measured"], table(folder, "fig2")["measured"])


# ---------------------------------------------------------------- one by one


def test_fig2_approximation_is_a_mean_and_one_harmonic(folder):
    c = table(folder, "fig2")
    cycle = slice(0, 360)
    assert near(np.exp(1j * c["phase"][360:]), np.exp(1j * c["phase"][:-360]), 1e-9)
    for wave, expected in (
        (np.ones(360), 0.62),
        (2 * np.cos(c["phase"][cycle]), 1.0),
        (np.sin(c["phase"][cycle]), 0.0),
    ):
        assert np.mean(c["measured"][cycle] * wave) == pytest.approx(expected, abs=0.01)
        assert np.mean(c["approximation"][cycle] * wave) == pytest.approx(expected, abs=0.01)


def test_fig3_is_the_square_wave(folder):
    c = table(folder, "fig3")
    inside = np.abs(np.sin(c["phase"] / 2)) * np.abs(np.sin((c["phase"] - 1.3 * np.pi) / 2)) > 1e-6
    turned = np.mod(c["phase"], 2 * np.pi) < 1.3 * np.pi
    assert near(c["load"][inside], np.where(turned, 1.0, -1.0)[inside])
    k = np.arange(1, 11)
    p = 2 / (np.pi * k) * (np.sin(k * 1.3 * np.pi) + 1j * (np.cos(k * 1.3 * np.pi) - 1))  # B77 (34)
    assert near(c["series_10"], 0.3 + (np.exp(1j * np.outer(c["phase"], k)) @ p).real)
    far = np.abs(np.sin(c["phase"])) > 0.9
    assert (
        np.abs(c["series_40"] - c["load"])[far & inside].max() < np.abs(c["series_3"] - c["load"])[far & inside].max()
    )


def test_fig4_against_closed_forms(folder):
    c = table(folder, "fig4")
    r, factor, phase = c["restitution"], c["load_factor"], c["phase"]
    assert near(np.sin(phase), np.pi * factor * (1 - r) / (1 + r))
    cosine = np.cos(phase)
    stable = (cosine < 0) & ((1 + r) ** 2 / factor * np.abs(cosine) < 2 * (1 + r**2))  # B77 (36) with σ = 0
    assert np.array_equal(c["stable"], stable)
    for value in np.unique(r):
        here = phase[r == value]
        assert np.count_nonzero(here < np.pi / 2) == np.count_nonzero(here > np.pi / 2) == 180
        assert factor[r == value].max() == pytest.approx((1 + value) / (np.pi * (1 - value)), rel=1e-4)


def test_fig4_possible_motions_one_by_one(folder):
    c = table(folder, "fig4")
    for i in np.random.default_rng(3).choice(c["phase"].size, 60, replace=False):
        system = vary(
            pneumatic(), {"restitution": float(c["restitution"][i]), "load_factor": float(c["load_factor"][i])}
        )
        orbits = steady_states(system, modes=0).orbits
        orbit = min(orbits, key=lambda o: abs(o.phase - c["phase"][i]))
        assert orbit.phase == pytest.approx(c["phase"][i], abs=1e-7)
        assert orbit.admissible == c["admissible"][i]


def test_fig4_stable_motions_that_cannot_be(folder):
    """R = 0 between p_0/p_1 = 1/sqrt(1 + π²) and 1/π: stable by B77 (36), but the load still pushes at the impact."""
    c = table(folder, "fig4")
    wrong = c["stable"] & ~c["admissible"]
    assert wrong.any() and set(c["restitution"][wrong]) == {0.0}
    assert c["load_factor"][wrong].min() > 1 / math.sqrt(1 + math.pi**2)
    assert np.all(c["load_factor"][wrong] + np.cos(c["phase"][wrong]) > 0.0)


def test_fig5_against_closed_forms_and_the_stability_plane(folder):
    c = table(folder, "fig5")
    r = c["restitution"]
    assert near(c["upper"], (1 + r) / (np.pi * (1 - r)))
    assert near(c["lower"], (1 + r) ** 2 / np.sqrt(4 * (1 + r**2) ** 2 + np.pi**2 * (1 - r**2) ** 2))
    for ending, d in (("", 0.0), ("_damped", DAMPING)):
        lower, upper = c[f"lower{ending}"], c[f"upper{ending}"]
        for factor, stable in (
            (lower - 1e-9, False),
            (lower + 1e-9, True),
            (upper - 1e-9, True),
            (upper + 1e-9, False),
        ):
            plane = stability_plane(pneumatic(d=d), r, factor)
            assert np.array_equal(plane.stable.any(axis=0), np.full(r.size, stable))
    assert np.all(c["upper_damped"] < c["upper"]) and np.all(c["lower_damped"] < c["lower"])


def test_fig6_against_closed_forms(folder):
    c = table(folder, "fig6")
    r, m = c["restitution"], 10
    assert near(c["upper"], (1 + r) / (np.pi * m * (1 - r)))
    for name, s in (("lower", math.inf), ("lower_10_1", 10.1 / 10 / math.pi), ("lower_10_01", 10.01 / 10 / math.pi)):
        sigma = (1 - r) / (1 + r) * 0.5 * ((1 / s) / math.sin(1 / s) - 1 if math.isfinite(s) else 0.0)
        below = 4 * (1 + r**2 + (1 - r**2) * sigma) ** 2 + (np.pi * m) ** 2 * (1 - r**2) ** 2
        assert near(c[name], (1 + r) ** 2 / np.sqrt(below))
    assert np.all(c["lower_10_01"] < c["lower_10_1"]) and np.all(c["lower_10_1"] < c["lower"])


def test_fig6_in_the_scaling_of_b77():
    """s, d and the forces change from one scaling to the other; p_0 over the amplitude does not (theory §1)."""
    m, s, r = 10, 1.01 / math.pi, 0.4
    ours = System(s=s, d=0.0, restitution=r, load=Load.harmonic(0.05, 1.0))
    theirs = System(s=m * s, d=0.0, restitution=r, load=Load.harmonic(0.05 * m**2, 1.0 * m**2, m))
    one = boundaries(ours, ("restitution", [r]), ("load_factor", 0.0, 1.0), m, kinds=("fold", "flip"))
    two = boundaries(theirs, ("restitution", [r]), ("load_factor", 0.0, 1.0), 1, kinds=("fold", "flip"))
    assert two.greatest("fold")[0] == pytest.approx(one.greatest("fold")[0], rel=1e-12)
    assert two.greatest("flip")[0] == pytest.approx(one.greatest("flip")[0], rel=1e-9)


def test_fig7_against_closed_forms(folder):
    c = table(folder, "fig7")
    r, kappa, phase = c["restitution"], c["kappa"], c["phase"]
    rising = phase < kappa * np.pi
    half = 0.5 * np.pi * kappa * (2 - kappa)  # v_f goes from −half to half while the load pushes
    v = np.where(rising, -half + (2 - kappa) * phase, half - kappa * (phase - kappa * np.pi))
    assert near(v, np.pi * (kappa - 1) * (1 - r) / (1 + r), 1e-10)
    assert not c["stable"].any()
    assert c["admissible"].any() and not c["admissible"].all()
    for value in np.unique(r):
        rho = (1 - value) / (1 + value)
        assert kappa[r == value].max() == pytest.approx(1 - rho + math.sqrt(1 + rho**2), abs=1e-3)
        assert np.count_nonzero(rising[r == value]) == np.count_nonzero(~rising[r == value])
    for i in np.random.default_rng(4).choice(phase.size, 12, replace=False):
        system = vary(hydraulic(), {"restitution": float(r[i]), "kappa": float(kappa[i])})
        orbit = min(steady_states(system, modes=0).orbits, key=lambda o: abs(o.phase - phase[i]))
        assert orbit.admissible == c["admissible"][i]
        assert not stability_of(orbit, modes=0).stable


def test_fig8_against_closed_form_and_roots_in_many_digits(folder):
    c = table(folder, "fig8")
    rho = (1 - c["restitution"]) / (1 + c["restitution"])
    assert near(c["kappa"], 1 - rho + np.sqrt(1 + rho**2))
    for i in (0, 37, 90):

        def excess(k, r=float(c["restitution"][i])):
            case = naive.Case.of(naive.Square.of(1, k), 1, DAMPING, r, 1)
            return naive.v_f(case, k * naive.PI) - naive.level(case)

        found = naive.mp.mpf(float(c["kappa_damped"][i]))
        assert excess(found - 1e-11) > 0 > excess(found + 1e-11)


def test_the_limit_of_stiff_bars_is_one():
    """s = 10⁶ … 10⁸ give the same curves to rounding, and σ is nothing beside 1."""
    plane = ("restitution", RESTITUTIONS[::10]), ("load_factor", 0.0, 10.0)
    curves = [boundaries(pneumatic(s, DAMPING), *plane, kinds=("flip",)).greatest("flip") for s in (1e6, 1e7, 1e8)]
    assert near(curves[0], curves[1], 1e-11) and near(curves[2], curves[1], 1e-13)


def test_elastic_boundaries_and_instabilities(folder):
    c = table(folder, "elastic")
    assert c["s"][0] == pytest.approx(0.4) and c["s"][-1] == pytest.approx(100.0)
    stiff = c["s"] > 40.0
    assert near(c["flip"][stiff], c["lower_reduced"][stiff], 2e-3)
    assert not near(
        c["flip"][~stiff & np.isfinite(c["flip"])], c["lower_reduced"][~stiff & np.isfinite(c["flip"])], 0.05
    )
    assert np.isfinite(c["neimark_sacker"]).any()
    for name in ("elastic_multipliers", "elastic_instability"):
        grown = table(folder, name)
        assert np.all(grown["reduced"] < 1.0) and (grown["exact_8"] > 1.0).any()
    theirs = table(folder, "elastic_instability")
    at = int(np.argmin(np.abs(theirs["s"] - 5.0)))
    assert theirs["exact_8"][at] == pytest.approx(1.000147, abs=5e-7)  # theory §5


# ---------------------------------------------------------------- the parts


def test_runs_of_a_curve_leave_no_gap():
    truth = np.array([True, False, False, True])
    assert segments(truth) == [(slice(0, 2), True), (slice(1, 4), False), (slice(3, 4), True)]


def test_a_table_is_csv(tmp_path):
    columns = {"x": np.array([0.1, math.nan]), "good": np.array([True, False]), "word": np.array(["a", "b"])}
    figure = PaperFigure("one", "One", columns, lambda figure, picture: None)
    assert figure.csv() == "x,good,word\n0.1,true,a\nnan,false,b\n"
    assert figure.write_csv(tmp_path / "one.csv").read_bytes() == figure.csv().encode()
    with pytest.raises(PercussError, match="cannot be written"):
        figure.write_csv(tmp_path / "none" / "one.csv")
    with pytest.raises(ParameterError, match="fig2, fig3"):
        figures("fig9")


# ---------------------------------------------------------------- the command


def test_command_writes_and_says_what(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    target = tmp_path / "new" / "figures"
    assert main(["paper", "fig5", "fig3", "-o", str(target)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said == [str(target / f"{name}.{kind}") for name in ("fig3", "fig5") for kind in ("csv", "svg", "png")]
    assert sorted(path.name for path in target.iterdir()) == sorted(Path(line).name for line in said)
