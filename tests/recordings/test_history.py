"""From records to loads: known waveforms are recovered, and what cannot be used is refused."""

from __future__ import annotations

import hashlib
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.case.catalogue.sample_history import write_sample_history
from percuss.errors import HistoryError, PercussError
from percuss.model.load import Load
from percuss.recordings.cycle_fit import MAX_CYCLES
from percuss.recordings.history import analyse
from percuss.recordings.recording import read_recording

TURN = 2 * math.pi


def rms(coefficients):
    return math.sqrt(0.5 * np.sum(np.abs(np.asarray(coefficients)[1:]) ** 2))


def wave(coefficients, turns):
    value = np.full(turns.shape, np.real(coefficients[0]))
    for k, c in enumerate(coefficients[1:], start=1):
        value += np.real(c * np.exp(1j * TURN * k * turns))
    return value


def record(coefficients, frequency=60.0, cycles=40.2, per_cycle=200.0, noise=0.0, jitter=0.0, drift=0.0, seed=0):
    """A record by the definition of the model: jittered cycles, white noise, a drift; the last two relative to rms."""
    rng = np.random.default_rng(seed)
    count = math.ceil(cycles) + 3
    bounds = np.concatenate([[0.0], np.cumsum(1.0 + jitter * rng.standard_normal(count))]) / frequency
    time = np.arange(round(cycles * per_cycle)) / (per_cycle * frequency)
    value = wave(coefficients, np.interp(time, bounds, np.arange(count + 1.0)))
    slow = time / time[-1] - 0.5
    return time, value + rms(coefficients) * (noise * rng.standard_normal(time.size) + drift * slow)


def distance(found, true):
    """rms difference of two loads as a fraction of the alternating part, at the best common shift."""
    n = max(len(found), len(true))
    a, b = np.pad(found, (0, n - len(found))), np.pad(true, (0, n - len(true)))
    shifts = np.linspace(-0.1, 0.1, 2001)
    turned = a[1:] * np.exp(1j * np.outer(shifts, np.arange(1, n)))
    return math.sqrt(0.5 * np.min(np.sum(np.abs(turned - b[1:]) ** 2, axis=1))) / rms(true)


def re_match(report, pattern):
    """Whether a warning says so, in the field and in the printed report."""
    return any(re.search(pattern, w) for w in report.warnings) and re.search(pattern, str(report))


DECAYING = np.array([3.0, *(np.exp(1j * k * k) / k for k in range(1, 13))])


# -- accuracy --


def test_exact_harmonics_are_recovered():
    time, values = record(DECAYING)
    found, report = analyse(time, values)
    np.testing.assert_allclose(found, DECAYING, atol=2e-4)
    assert (report.cycles, report.harmonics, report.frequency_given) == (40, 12, False)
    assert report.frequency == pytest.approx(60.0, rel=1e-6)
    assert report.sample_rate == pytest.approx(12000.0)
    assert max(report.jitter, report.scatter, report.residual) < 2e-3
    assert report.warnings == ()


coefficient = st.complex_numbers(max_magnitude=1.0)


@given(
    st.lists(coefficient, min_size=1, max_size=10),
    st.floats(-3, 3),
    st.floats(-1, 3).map(lambda x: 10**x),
    st.sampled_from([6.3, 12.0, 25.5, 60.0]),
    st.sampled_from([48.0, 150.3, 401.7]),
    st.sampled_from([0.0, 0.01, 0.1]),
    st.sampled_from([0.0, 0.003, 0.008]),
    st.integers(0, 2**32 - 1),
)
def test_random_loads_are_recovered_within_their_scatter(rest, mean, frequency, cycles, per_cycle, noise, jitter, seed):
    true = np.array([mean, 1.0, *rest])
    time, values = record(true, frequency, cycles, per_cycle, noise, jitter, 0.02, seed)
    found, report = analyse(time, values)
    several = 5.0 * (jitter / math.sqrt(cycles) + noise / (cycles * math.sqrt(time.size)))
    assert report.frequency == pytest.approx(frequency, rel=1e-3 + several)
    # noise leaves 2K/N of its variance in K harmonics; a harmonic below 3.5 standard errors or 1/1000 is left out
    several = 6.0 * noise * math.sqrt(2 * len(true) / time.size)
    assert distance(found, true) < 0.006 + several + 0.5 * jitter
    assert abs(found[0] - mean) < rms(true) * (0.01 + several)
    assert report.scatter == pytest.approx(noise, rel=0.25, abs=0.02)


@given(st.floats(-9, 9).map(lambda x: 10**x), st.floats(-1e3, 1e3), st.floats(-4, 4).map(lambda x: 10**x))
def test_units_change_nothing_but_the_scale(scale, offset, unit_of_time):
    time, values = record(DECAYING, noise=0.02, jitter=0.003, drift=0.02, cycles=12)
    one, report = analyse(time, values)
    other, again = analyse(time * unit_of_time + 7.0 * unit_of_time, scale * (values + offset))
    one[0] += offset
    np.testing.assert_allclose(other / scale, one, rtol=1e-5, atol=1e-5)
    assert again.frequency * unit_of_time == pytest.approx(report.frequency, rel=1e-8)
    assert again.harmonics == report.harmonics


def test_sampling_changes_little():
    results = [analyse(*record(DECAYING, per_cycle=p, jitter=0.003))[0] for p in (60.0, 83.7, 200.0, 833.3)]
    for other in results[1:]:
        assert distance(other[:13], results[0]) < 1e-3


def test_uneven_steps():
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(0.8, 1.2, 8000)) / 12000
    found, report = analyse(time, wave(DECAYING, 60 * (time - time[0])))
    assert distance(found, DECAYING) < 3e-3
    assert report.frequency == pytest.approx(60.0, rel=1e-4)


def test_jitter_does_not_wear_down_the_high_harmonics():
    true = np.zeros(33, complex)
    true[[0, 1, 2, 8, 16, 32]] = 1.0, 2.0, 1.0, 0.5, 0.4, 0.3
    time, values = record(true, per_cycle=833.0, noise=0.02, jitter=0.003, seed=3)
    found, report = analyse(time, values)
    for k in (8, 16, 32):
        assert abs(found[k]) == pytest.approx(abs(true[k]), rel=0.005)
    # folding at the mean period, without alignment, loses a good part of the highest
    turns = report.frequency * time
    folded = 2 * np.mean(values * np.exp(-2j * math.pi * 32 * turns))
    assert abs(folded) < 0.8 * abs(true[32])
    assert report.jitter == pytest.approx(0.003, rel=0.3)


def test_noise_is_not_taken_for_jitter():
    reports = [analyse(*record(DECAYING, per_cycle=50.0, noise=0.3, seed=s))[1] for s in range(8)]
    assert np.mean([r.jitter for r in reports]) < 0.002


@pytest.mark.parametrize("jitter", [0.002, 0.005, 0.01])
def test_jitter_is_measured(jitter):
    reports = [analyse(*record(DECAYING, noise=0.02, jitter=jitter, seed=s))[1] for s in range(8)]
    assert np.mean([r.jitter for r in reports]) == pytest.approx(jitter, rel=0.15)


def test_drift_is_reported_and_stays_out_of_the_harmonics():
    for drift in (0.0, 0.05, 1.0):
        found, report = analyse(*record(DECAYING, drift=drift, noise=0.01))
        assert report.drift == pytest.approx(drift, abs=0.02)
        assert distance(found, DECAYING) < 0.002
        assert found[0].real == pytest.approx(3.0, abs=0.01)


def test_a_long_wander_of_the_phase_is_followed():
    time = np.arange(40000) / 1e4
    turns = 100 * time + 0.8 * np.sin(3 * time) + 0.3 * np.sin(9 * time)
    found, report = analyse(time, wave([1.0, 1.0, 0.0, 0.4j], turns))
    assert np.abs(found) == pytest.approx([1.0, 1.0, 0.0, 0.4], abs=0.003)
    assert report.cycles == 399


# -- which period --


def test_missing_fundamental():
    true = [1.0, 0.0, 1.0, 0.8j]  # 120 and 180 Hz repeat at 60 Hz
    found, report = analyse(*record(true, noise=0.05, jitter=0.003))
    assert report.frequency == pytest.approx(60.0, rel=1e-3)
    assert distance(found, true) < 0.02
    assert found[1] == 0.0


@pytest.mark.parametrize("strong", [2, 3, 5, 8])
def test_a_strong_harmonic_is_not_taken_for_the_fundamental(strong):
    true = np.zeros(9, complex)
    true[:4] = 1.0, 0.1, 0.05j, 0.05
    true[strong] = 1.0
    found, report = analyse(*record(true, noise=0.02, jitter=0.002, drift=0.05))
    assert report.frequency == pytest.approx(60.0, rel=1e-3)
    assert distance(found, true) < 0.02


def test_strokes_that_alternate_are_one_period():
    true = [1.0, 0.05, 1.0, 0.03j]  # 30 Hz: every second stroke differs a little
    found, report = analyse(*record(true, frequency=30.0, noise=0.02))
    assert report.frequency == pytest.approx(30.0, rel=1e-3)
    assert distance(found, true) < 0.02


def test_a_plain_sine_is_the_first_harmonic():
    for cycles in (2.0, 2.7, 40.5):
        found, report = analyse(*record([2.0, 1.0], cycles=cycles, noise=0.01))
        assert report.harmonics == 1
        assert report.frequency == pytest.approx(60.0, rel=0.005)
        assert abs(found[1]) == pytest.approx(1.0, rel=0.02)


def test_few_samples_in_a_cycle():
    found, report = analyse(*record([0.0, 1.0, 0.3], per_cycle=8.0, cycles=100))
    np.testing.assert_allclose(np.abs(found), [0.0, 1.0, 0.3], atol=1e-3)
    assert report.frequency == pytest.approx(60.0, rel=1e-5)


def test_more_cycles_than_are_needed():
    found, report = analyse(*record(DECAYING[:4], cycles=1500, per_cycle=30, jitter=0.003, noise=0.02))
    assert report.cycles == MAX_CYCLES
    assert "only the first 400 cycles are used" in str(report)
    assert distance(found, DECAYING[:4]) < 0.01


def test_frequency_given():
    time, values = record(DECAYING, noise=0.02, jitter=0.003)
    found, report = analyse(time, values, frequency=60.0)
    assert (report.frequency, report.frequency_given, report.warnings) == (60.0, True, ())
    assert distance(found, DECAYING) < 0.01
    found, report = analyse(time, values, frequency=62.0)
    assert report.frequency == 62.0
    assert report.frequency_found == pytest.approx(60.0, rel=2e-3)
    assert re_match(report, r"repeats at (59\.9|60)[.\d]* Hz, 3\.\d % from the 62 Hz given")
    assert distance(found, DECAYING) < 0.01  # the cycles are aligned as they are


def test_frequency_given_that_is_a_fraction_of_the_true_one():
    time, values = record(DECAYING)
    found, report = analyse(time, values, frequency=30.0)
    assert re_match(report, "repeats 2 times in each period, at 60 Hz")
    assert distance(found[::2], DECAYING) < 1e-3
    assert not np.any(found[1::2])


def test_frequency_given_at_which_the_strokes_alternate():
    _, report = analyse(*record([1.0, 0.05, 1.0, 0.03j], frequency=30.0, noise=0.005), frequency=60.0)
    assert re_match(report, "successive cycles differ: the record repeats at 30")


# -- which harmonics --


def test_harmonics_asked_for():
    time, values = record(DECAYING, noise=0.05)
    for k in (1, 5, 30):
        found, report = analyse(time, values, harmonics=k)
        assert (found.size, report.harmonics) == (k + 1, k)
        assert np.all(found != 0)
    true_rest = rms(np.concatenate([[0], DECAYING[6:]])) / rms(DECAYING)
    assert analyse(time, values, harmonics=5)[1].residual == pytest.approx(true_rest, rel=0.05)


def test_noise_is_not_kept_as_harmonics():
    kept = [analyse(*record([1.0, 1.0, 0.0, 0.2], noise=0.5, seed=s))[1].harmonics for s in range(20)]
    assert kept == [3] * 20


def test_a_square_wave_keeps_64_harmonics():
    time = np.arange(20000) / 1e4
    found, report = analyse(time, np.sign(np.sin(TURN * 7.013 * time)))
    assert report.harmonics in (63, 64)
    np.testing.assert_allclose(np.abs(found[1:20:2]), 4 / math.pi / np.arange(1, 20, 2), rtol=0.02)


# -- what is refused --

T = np.arange(4000) / 1e4
RNG = np.random.default_rng(1)


def sine(f):
    return 3 + np.cos(TURN * f * T) + 0.3 * np.cos(2 * TURN * f * T + 1)


@pytest.mark.parametrize(
    ("time", "values", "options", "parts"),
    [
        (T, RNG.standard_normal(T.size), {}, ["no repetition found", "at least two whole cycles"]),
        (T, RNG.standard_normal(T.size), {"frequency": 50.0}, ["no repetition found"]),
        (T, np.cumsum(RNG.standard_normal(T.size)), {}, ["no repetition found"]),
        (T, T, {}, ["no repetition found"]),
        (T, sine(2.5), {}, ["no repetition found"]),  # one cycle
        (T, sine(4.6), {}, ["two whole cycles"]),  # 1.84
        (T, sine(3.75), {"frequency": 3.75}, ["holds 1.5 cycles of 3.75 Hz", "unit of time"]),
        (T, sine(50), {"frequency": 1e-9}, ["two whole cycles are needed"]),
        (T, sine(50), {"frequency": 1e9}, ["samples in a cycle", "at least 8"]),
        (T, sine(2500), {}, ["4 samples in a cycle of 2500 Hz, at least 8", "sample faster"]),
        (T, sine(42), {"frequency": 60.0}, ["does not repeat at the 60 Hz given, but at 42"]),
        (T, sine(50), {"frequency": 100.0}, ["does not repeat at the 100 Hz given, but at 50 Hz"]),
        (T, sine(50), {"frequency": math.nan}, ["frequency = nan"]),
        (T, sine(50), {"frequency": -50.0}, ["greater than 0"]),
        (T, sine(50), {"harmonics": 0}, ["0 harmonics", "at least 1"]),
        (T, sine(50), {"harmonics": 200}, ["200 harmonics of 50 Hz from 200 samples", "harmonics = 90 or fewer"]),
        (T, np.full(T.size, 2.0), {}, ["constant (2)"]),
        (T, 1e9 + 1e-6 * sine(50), {}, ["constant"]),
        (T, 1e305 * sine(50), {}, ["1e300"]),
        (np.delete(T, slice(900, 1200)), np.delete(sine(50), slice(900, 1200)), {}, ["gap from 0.0899 s to 0.12 s"]),
        (T[:10], T[:10], {}, ["only 10 samples"]),
        ([], [], {}, ["only 0 samples"]),
        (T, sine(50)[:-1], {}, ["(4000,)", "(3999,)"]),
        (T.reshape(2, -1), sine(50).reshape(2, -1), {}, ["(2, 2000)"]),
        (T, np.where(T[5] == T, np.nan, sine(50)), {}, ["values[5] is nan"]),
        (np.where(T[5] == T, np.inf, T), sine(50), {}, ["time[5] is inf"]),
        (np.where(T[5] == T, T[4], T), sine(50), {}, ["time[5] = 0.0004 does not follow 0.0004"]),
    ],
)
def test_refused(time, values, options, parts):
    with pytest.raises(HistoryError) as caught:
        analyse(time, values, **options)
    message = str(caught.value)
    assert " — " in message
    assert all(part in message for part in parts), message


def test_low_passed_noise_is_no_load():
    accepted = 0
    for seed in range(30):
        noise = np.convolve(np.random.default_rng(seed).standard_normal(4400), np.hanning(200), "valid")
        try:
            _, report = analyse(np.arange(noise.size) / 1e4, noise)
            accepted += not report.warnings
        except HistoryError:
            pass
    assert accepted <= 1


@given(st.lists(st.floats(-1e6, 1e6), min_size=16, max_size=200), st.sampled_from([None, 10.0, 300.0]))
def test_any_numbers_give_a_finite_load_or_a_message(values, frequency):
    try:
        found, report = analyse(np.arange(len(values)) / 1e3, values, frequency=frequency)
        assert np.all(np.isfinite(found))
        assert str(report)
        assert found[0].imag == 0.0
        assert found.size >= 2
    except PercussError as error:
        assert str(error)


def test_cycles_that_hardly_repeat_give_a_warning():
    time, values = record(DECAYING)
    values[777] += 300.0
    _, report = analyse(time, values)
    assert re_match(report, "hardly resemble each other")


def test_a_record_that_does_not_run_evenly_gives_a_warning():
    _, report = analyse(*record(DECAYING, drift=3.14, noise=0.01))
    assert re_match(report, r"the mean drifts by 31\d % .*from, to")
    _, report = analyse(*record(DECAYING, jitter=0.06, noise=0.01, seed=3))
    assert re_match(report, r"the period varies by \d\.?\d* %")
    for good in ({}, {"drift": 0.05, "jitter": 0.01}):
        assert analyse(*record(DECAYING, noise=0.02, **good))[1].warnings == ()


CLIPPED = {"above": (-np.inf, 3.9, "highest"), "below": (2.2, np.inf, "lowest"), "both": (2.2, 3.9, "lowest.*highest")}


@pytest.mark.parametrize("steps", [0.0, 1e-3, 0.02])
@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("name", CLIPPED)
def test_clipping_gives_a_warning(name, noise, steps):
    low, high, words = CLIPPED[name]
    time, values = record(DECAYING, noise=noise)
    assert np.min(values) < 1.8 and np.max(values) > 4.3
    values = np.round(values / steps) * steps if steps else values
    _, report = analyse(time, np.clip(values, low, high))
    assert re.search(words, " ".join(report.warnings))
    assert ("lowest" in str(report)) == (name != "above") and ("highest" in str(report)) == (name != "below")


@pytest.mark.parametrize("steps", [0.0, 1e-3, 0.02, 0.1])
@pytest.mark.parametrize("wave_of", [DECAYING, np.array([0.0, 1.0]), np.array([0.0, 1.0, 0.0, 0.1j])])
def test_rounded_peaks_and_square_waves_are_not_taken_for_clipped(wave_of, steps):
    for noise in (0.0, 0.01):
        time, values = record(wave_of, noise=noise)
        values = np.round(values / steps) * steps if steps else values
        assert "reached its limit" not in str(analyse(time, values)[1])
    time, values = record(np.array([0.0, 1.0]))
    assert "reached its limit" not in str(analyse(time, np.where(values > 0.3, 1.0, -1.0))[1])


# -- the report, the load, the sample --


def test_the_report_reads_well():
    _, report = analyse(*record(DECAYING, noise=0.02, jitter=0.003, drift=0.02))
    lines = str(report).splitlines()
    assert lines[0].startswith("40 cycles at 60.0")
    assert "(found)" in lines[0]
    assert all(word in str(report) for word in ("standard deviation", "drift of the mean", "harmonics up to 12 kept"))


def test_load_history_keeps_the_report_and_takes_an_area():
    time, values = record(DECAYING)
    force, pressure = Load.history(time, values), Load.history(time, values, area=6.5e-4)
    np.testing.assert_allclose(pressure.coefficients, 6.5e-4 * force.coefficients)
    assert force.report is not None
    assert force.report.cycles == 40
    assert force.frequency == force.report.frequency


PRESSURE = [6.2e6, 14.7e6, 2.8e6 * np.exp(0.8j), 1.5e6 * np.exp(2.6j), 0.0, 0.6e6j]


def test_the_sample_history_is_recovered_to_a_percent(tmp_path):
    path = tmp_path / "sample.csv"
    write_sample_history(path, pressure_coefficients=PRESSURE, frequency=60.0)
    recording = read_recording(path)
    assert recording.notes == ()
    assert recording.values.size == 33333
    found, report = analyse(recording.time, recording.values)
    assert found.size == len(PRESSURE)
    np.testing.assert_allclose(found[:4], PRESSURE[:4], rtol=0.01)
    np.testing.assert_allclose(found, PRESSURE, atol=0.01 * abs(PRESSURE[1]))
    assert report.frequency == pytest.approx(60.0, rel=1e-4)
    assert report.cycles == 40
    assert report.scatter == pytest.approx(0.02, rel=0.1)
    assert report.drift == pytest.approx(0.02, abs=0.006)
    assert 0.0015 < report.jitter < 0.0045
    assert report.warnings == ()


def test_the_sample_history_is_the_same_everywhere_and_says_what_it_is(tmp_path):
    files = [tmp_path / name for name in "abc"]
    for path, seed in zip(files, (1977, 1977, 1978), strict=True):
        write_sample_history(path, pressure_coefficients=PRESSURE, frequency=60.0, seed=seed)
    one, same, other = (path.read_bytes() for path in files)
    assert one == same != other
    assert one.startswith(b"# Synthetic history of chamber pressure: computed, not measured on any machine\n")
    assert one.splitlines()[2] == b"time [s],pressure [MPa]"
    plain = [line.split(b",") for line in one.splitlines()[3:]]
    assert len(plain) == 33333
    # the first numbers do not hang on a library's way of making random numbers
    digest = hashlib.sha256(b"".join(t for t, _ in plain)).hexdigest()
    assert digest == hashlib.sha256(b"".join(b"%.5f" % (i / 50e3) for i in range(33333))).hexdigest()
