"""Records made from a blow, with a clock of their own, noise, a zero, a sign and units: all of it must come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.blow.gauges import fitted_record
from percuss.case import BlowAnswer, Case, blow_answer, measured_gauge
from percuss.errors import HistoryError, ParameterError

AREA, MODULUS, LATER = 1.2e-3, 2.06e11, 1.8e-3
CASE = f"""
[bar]
length = "400 mm"
area = "20 cm^2"
youngs_modulus = "206 GPa"
density = "7850 kg/m^3"
[tool]
sections = [
  {{length = "1.5 m", area = "{AREA} m^2", youngs_modulus = "206 GPa", density = "7850 kg/m^3"}},
  {{length = "0.5 m", area = "{LATER} m^2", youngs_modulus = "206 GPa", density = "7850 kg/m^3"}},
]
end = "free"
[blow]
velocity = "9 m/s"
until = "1.2 ms"
"""
WALL = CASE[: CASE.index("[tool]")] + CASE[CASE.index("[blow]") :]
STEP, EARLY = 5e-7, 2e-4


@pytest.fixture(scope="module")
def answer() -> BlowAnswer:
    return blow_answer(Case.from_text(CASE), gauge=0.8)


def force_of(answer: BlowAnswer, time: np.ndarray) -> np.ndarray:
    """The force at the gauge, at rest before the blow, through the low pass of an amplifier."""
    waves = answer.waves
    fine = np.arange(-4, 5) * (STEP / 9.0)
    times = time[:, None] + fine
    return np.where(times >= 0.0, waves.incident.at(times) + waves.reflected.at(times), 0.0).mean(axis=1)


def record_of(answer: BlowAnswer, *, noise: float = 0.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Times on the clock of the blow and forces, from before the blow to the end of the window."""
    time = np.arange(-EARLY, answer.blow.until, STEP) + 0.3 * STEP
    force = force_of(answer, time)
    return time, force + noise * abs(force).max() * np.random.default_rng(seed).standard_normal(time.size)


def written(folder: Path, heading: str, time: np.ndarray, values: np.ndarray, comma: bool = False) -> Path:
    file = folder / "gauge.csv"
    lines = [heading] + [f"{t:.10g};{v:.9g}" for t, v in zip(time, values, strict=True)]
    text = "\n".join(lines) + "\n"
    file.write_text(text.replace(".", ",") if comma else text.replace(";", ","), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("heading", "of_force", "quantity"),
    [
        ("strain [µm/m]", 1e6 / (AREA * MODULUS), "strain"),
        ("strain [1e-6]", 1e6 / (AREA * MODULUS), "strain"),
        ("Dehnung [%]", 1e2 / (AREA * MODULUS), "strain"),
        ("stress [MPa]", 1e-6 / AREA, "stress"),
        ("force [kN]", 1e-3, "force"),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_clock_scale_zero_sign_and_unit_come_back(
    answer: BlowAnswer, tmp_path: Path, heading: str, of_force: float, quantity: str, sign: int
) -> None:
    time, force = record_of(answer, noise=0.01)
    zero = 4e3
    values = of_force * (sign * 1.07 * force + zero)
    found = measured_gauge(
        answer, written(tmp_path, f"t [ms];{heading}".replace(";", ","), 1e3 * (time + 3.217e-3), values)
    )
    assert (found.quantity, found.sign) == (quantity, sign)
    assert found.shift == pytest.approx(-3.217e-3, abs=0.1 * STEP)
    assert found.scale == pytest.approx(1.07, abs=2e-3)
    assert found.zero == pytest.approx(zero, abs=1e-3 * force.max())
    assert found.residual_scaled == pytest.approx(0.0107, rel=0.15)  # the noise, and the rounded jumps
    inside = time >= 0.0
    expected = np.hypot(0.07 * np.sqrt(np.mean(force[inside] ** 2)) / force.max(), found.residual_scaled)
    assert found.residual == pytest.approx(expected, rel=0.1)
    assert found.overlap == pytest.approx(1.0, abs=2e-3)
    assert found.force == pytest.approx(1.07 * force, abs=1e-3 * force.max())
    assert any("fits better" in note for note in found.notes)


def test_a_decimal_comma_and_a_given_rate(answer: BlowAnswer, tmp_path: Path) -> None:
    time, force = record_of(answer)
    strain = 1e6 * force / (AREA * MODULUS)
    file = written(tmp_path, "Zeit [s];Dehnung [µm/m]", time + 0.5, strain, comma=True)
    found = measured_gauge(answer, file)
    assert found.shift == pytest.approx(-0.5, abs=0.1 * STEP)
    assert found.scale == pytest.approx(1.0, abs=1e-3) and found.residual < 5e-3
    bare = tmp_path / "bare.csv"
    bare.write_text("\n".join(f"{x:.9g}" for x in strain), encoding="utf-8")
    found = measured_gauge(answer, bare, unit="µm/m", sample_rate="2 MHz")
    assert found.shift == pytest.approx(time[0], abs=0.1 * STEP)


def test_a_gauge_on_a_later_section_has_its_area(tmp_path: Path) -> None:
    answer = blow_answer(Case.from_text(CASE), gauge=1.6)
    time, force = record_of(answer)
    found = measured_gauge(answer, written(tmp_path, "t [s],strain [m/m]", time, force / (LATER * MODULUS)))
    assert found.scale == pytest.approx(1.0, abs=1e-3)


def test_a_given_sign_is_kept_to(answer: BlowAnswer, tmp_path: Path) -> None:
    time, force = record_of(answer)
    file = written(tmp_path, "t [s],force [N]", time, -force)
    found = measured_gauge(answer, file, sign="negative")
    assert found.sign == -1 and not found.notes
    try:  # the other way up it lies elsewhere, and worse
        wrong = measured_gauge(answer, file, sign="positive")
    except HistoryError:
        return
    assert wrong.sign == 1 and wrong.residual_scaled > 10.0 * found.residual_scaled


@settings(max_examples=25, deadline=None)
@given(
    st.floats(-1.0, 1.0), st.floats(0.5, 2.0), st.floats(-0.5, 0.5), st.sampled_from([1, -1]),
    st.floats(0.2, 8.0), st.integers(0, 400), st.floats(0.55, 1.0),
)  # fmt: skip
def test_any_clock_factor_zero_rate_and_length_come_back(
    answer: BlowAnswer, shift: float, scale: float, zero: float, sign: int, step: float, early: int, last: float
) -> None:
    step *= 1e-6
    time = np.arange(-1e-6 * early, last * answer.blow.until, step)
    force = force_of(answer, time)
    top = force.max()
    fit = fitted_record(answer.waves, answer.blow.until, time - shift, sign * scale * force + zero * top)
    assert fit.sign == sign
    assert fit.shift == pytest.approx(shift, abs=max(0.6 * step, 1e-7))
    assert fit.scale == pytest.approx(scale, rel=0.05)
    assert fit.overlap == pytest.approx(last, abs=step / answer.blow.until + 2e-3)
    assert fit.residual_scaled < 0.1 * scale


def test_the_residual_is_that_of_the_best_factor(answer: BlowAnswer) -> None:
    time, force = record_of(answer, noise=0.05)
    fit = fitted_record(answer.waves, answer.blow.until, time, force)
    for wrong in (0.9, 1.1):
        other = fitted_record(answer.waves, answer.blow.until, time, wrong * force)
        assert other.residual > fit.residual
        assert other.scale == pytest.approx(wrong * fit.scale, rel=1e-9)
        assert other.residual_scaled == pytest.approx(wrong * fit.residual_scaled, rel=1e-9)


def test_the_second_blow_of_a_record_does_not_mislead(answer: BlowAnswer) -> None:
    time, force = record_of(answer, noise=0.02)
    later = 0.02 + np.concatenate([time, time + 0.025])
    fit = fitted_record(answer.waves, answer.blow.until, later, np.concatenate([0.4 * force, force]))
    assert fit.shift == pytest.approx(-0.045, abs=STEP)
    assert fit.scale == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (lambda force: np.full_like(force, 3.0), "a record that is not constant"),
        (lambda force: np.random.default_rng(3).standard_normal(force.size), "nothing in it resembles"),
        (lambda force: force[:10], "10 samples"),
    ],
)
def test_records_of_nothing_are_refused(answer: BlowAnswer, tmp_path: Path, values: object, said: str) -> None:
    time, force = record_of(answer)
    seen = values(force)
    with pytest.raises(HistoryError, match=said) as caught:
        measured_gauge(answer, written(tmp_path, "t [s],force [N]", time[: seen.size], seen))
    assert caught.value.remedy


def test_a_slow_recorder_is_told_of_or_refused(answer: BlowAnswer, tmp_path: Path) -> None:
    time = np.arange(-EARLY, answer.blow.until, 3e-5)
    found = measured_gauge(answer, written(tmp_path, "t [s],force [N]", time, force_of(answer, time)))
    assert any("only 5.2 samples" in note for note in found.notes)
    time = np.arange(-20.0 * EARLY, answer.blow.until, 2e-4)
    with pytest.raises(HistoryError) as caught:
        measured_gauge(answer, written(tmp_path, "t [s],force [N]", time, force_of(answer, time)))
    assert "sample faster" in caught.value.remedy


def test_walls_and_bars_without_sizes_have_no_gauge(tmp_path: Path) -> None:
    file = written(tmp_path, "t [s],force [N]", np.arange(40) * 1e-6, np.arange(40.0))
    wall = blow_answer(Case.from_text(WALL + '[tool]\nkind = "wall"\n'))
    with pytest.raises(ParameterError, match="a blow on a rod"):
        measured_gauge(wall, file)
    text = '[system]\ns = 20.0\nd = 0.0\nrestitution = 0.5\n[load]\nkind = "harmonic"\nmean = 0.9\namplitude = 1.0\n'
    bare = blow_answer(Case.from_text(text + "[tool]\nimpedance = 3.0\n"), 1.0)
    with pytest.raises(ParameterError, match="the case is dimensionless"):
        measured_gauge(bare, file)
