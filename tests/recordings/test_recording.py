"""Reading recordings: every way of writing a table that is understood, and every file that is refused."""

from __future__ import annotations

import builtins
import os
import re
import sys
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.errors import HistoryError, MissingExtraError, PercussError, UnitError
from percuss.recordings.recording import MAX_BYTES, Recording, read_recording

N = 40
TIME = np.arange(N) / 1e3
BAR = np.round(10 + np.sin(TIME * 300), 4)


def rows(delimiter=",", decimal=".", end="\n", time=TIME, values=BAR):
    lines = [f"{t:.4f}{delimiter}{v:.4f}".replace(".", decimal) for t, v in zip(time, values, strict=True)]
    return end.join(lines) + end


@pytest.fixture
def write(tmp_path):
    def make(content, name="record.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return make


def check(recording: Recording, *, scale=1e5, time=TIME, quantity="pressure"):
    np.testing.assert_allclose(recording.time, time, rtol=1e-12)
    np.testing.assert_allclose(recording.values, scale * BAR, rtol=1e-12)
    assert recording.quantity == quantity


# -- what is understood --


@pytest.mark.parametrize(
    "content",
    [
        "time [s],pressure [bar]\n" + rows(),
        "time [s],pressure [bar]\n" + rows(end="\r\n"),
        "time [s],pressure [bar]\n" + rows(end="\r"),
        "time [s], pressure [bar]\n" + rows(", "),
        "t_s,p_bar\n" + rows().rstrip("\n"),
        "Zeit [s];Druck [bar]\n" + rows(";", ","),
        "Zeit [s];Druck [bar]\n" + rows(";"),
        "Time (s)\tPressure (bar)\n" + rows("\t"),
        "Time (s)\tPressure (bar)\n" + rows("\t", ","),
        "time [s] pressure [bar]\n" + rows("   "),
        "time[s] pressure[bar]\n" + rows(" ", ","),
        "# time [s], pressure [bar]\n" + rows(),
        "% made by a logger\n# time [s]  pressure [bar]\n" + rows(" "),
        "Time,Pressure\ns,bar\n" + rows(),
        "Time,Pressure\n[s],[bar]\n" + rows(),
        "Sample rate,1000\nDevice,xyz\n\nTime,Pressure\n(s),(bar)\n" + rows(),
        '"Time [s]","Pressure, chamber [bar]"\n' + "".join(f'"{t}","{v}"\n' for t, v in zip(TIME, BAR, strict=True)),
        '"Time [s]";"Pressure [bar]"\n'
        + "".join(f'"{t}";"{v}"\n'.replace(".", ",") for t, v in zip(TIME, BAR, strict=True)),
        "time [s],pressure [bar],\n" + rows().replace("\n", ",\n"),
        "stamp,time [s],pressure [bar],state\n"
        + "".join(f"12:00,{t},{v},ok\n" for t, v in zip(TIME, BAR, strict=True)),
        "time [s],T [degC],pressure [bar]\n" + "".join(f"{t},20,{v}\n" for t, v in zip(TIME, BAR, strict=True)),
        "pressure [bar],time [s]\n" + "".join(f"{v},{t}\n" for t, v in zip(TIME, BAR, strict=True)),
        "\ufeff" + "time [s],pressure [bar]\n" + rows(),
        ("time [s],pressure [bar]\n" + rows()).encode("utf-16"),
        "time [s],pressure [bar]\n\n" + rows().replace("0.0200", "# a remark\n\n0.0200"),
        "time [s],pressure [bar]\n" + "".join(f"{t:e},{v:E}\n" for t, v in zip(TIME, BAR, strict=True)),
    ],
)
def test_ways_of_writing_the_same_table(write, content):
    recording = read_recording(write(content))
    check(recording)
    assert recording.notes == ()


@pytest.mark.parametrize(
    ("heading", "scale", "quantity"),
    [
        ("p [MPa]", 1e6, "pressure"),
        ("chamber/psi", 6894.757293168361, "pressure"),
        ("Kraft [kN]", 1e3, "force"),
        ("F_N", 1.0, "force"),
        ("whatever (lbf)", 4.4482216152605, "force"),
        ("p [inHg]", 3386.389, "pressure"),  # pint
    ],
)
def test_units_of_the_heading(write, heading, scale, quantity):
    recording = read_recording(write(f"t [s],{heading}\n{rows()}"))
    np.testing.assert_allclose(recording.values, scale * BAR, rtol=1e-6)
    assert recording.quantity == quantity


def test_milliseconds_and_an_old_character_set(write):
    check(read_recording(write("t [µs],p [bar]\n".encode("cp1252") + rows().encode())), time=1e-6 * TIME)
    check(read_recording(write("t [ms],p [bar]\n" + rows())), time=1e-3 * TIME)


def test_time_without_a_unit_is_in_seconds_and_says_so(write):
    recording = read_recording(write("Time,p [bar]\n" + rows()))
    check(recording)
    assert recording.notes == ('the time in "Time" has no unit and is taken to be in seconds',)


def test_two_columns_without_headings(write):
    recording = read_recording(write(rows()), unit="bar")
    check(recording)
    assert "first of two columns" in recording.notes[0]
    check(read_recording(write(rows()), unit="bar", column=2, time_column=1))


def test_sample_rate_instead_of_time(write):
    one = "p [bar]\n" + "".join(f"{v}\n" for v in BAR)
    check(read_recording(write(one), sample_rate=1000.0))
    check(read_recording(write(one), sample_rate="1 kHz"))
    check(read_recording(write("t [s],p [bar]\n" + rows()), sample_rate="2 kHz"), time=TIME / 2)  # it wins over a time
    check(read_recording(write("".join(f"{v}\n" for v in BAR)), sample_rate=1e3, unit="bar"))


def test_unit_overrides_the_heading_and_may_be_a_sensors_scale(write):
    path = write("t [s],p [bar]\n" + rows())
    check(read_recording(path, unit="MPa"), scale=1e6)
    check(read_recording(path, unit="12 MPa"), scale=12e6)
    check(read_recording(path, unit="2.5 kN"), scale=2500.0, quantity="force")


def test_choosing_a_column(write):
    path = write("t [s],p1 [bar],p2 [MPa]\n" + "".join(f"{t},{v},{-v}\n" for t, v in zip(TIME, BAR, strict=True)))
    check(read_recording(path, column="p1"))
    check(read_recording(path, column="P1 [bar]"))
    check(read_recording(path, column=2))
    check(read_recording(path, column="2"))
    check(read_recording(path, column="p2"), scale=-1e6)


@given(
    st.sampled_from([",", ";", "\t", " ", "  ;  "]),
    st.sampled_from([".", ","]),
    st.sampled_from(["\n", "\r\n"]),
    st.sampled_from([("MPa", 1e6), ("bar", 1e5), ("kN", 1e3), ("psi", 6894.757293168361)]),
    st.sampled_from([("s", 1.0), ("ms", 1e-3), ("min", 60.0)]),
    st.lists(st.floats(-1e6, 1e6).map(lambda x: round(x, 4)), min_size=16, max_size=30),
    st.integers(0, 3),
)
def test_any_delimiter_decimal_and_unit_give_the_same_numbers(
    tmp_path_factory, delimiter, decimal, end, unit, clock, values, remarks
):
    decimal = "." if delimiter == "," else decimal
    time = np.arange(len(values)) * 0.25
    text = "# remark\n" * remarks + f"time [{clock[0]}]{delimiter}load [{unit[0]}]{end}"
    path = tmp_path_factory.mktemp("r") / "x.txt"
    path.write_bytes((text + rows(delimiter, decimal, end, time, values)).encode())
    recording = read_recording(path)
    np.testing.assert_allclose(recording.time, clock[1] * time, rtol=1e-12)
    np.testing.assert_allclose(recording.values, unit[1] * np.array(values), rtol=1e-12)


# -- what differs from the file is said --


def test_a_unit_that_differs_from_the_heading_is_said(write):
    path = write("t [s],p [bar]\n" + rows())
    assert read_recording(path, unit="bar").notes == ()
    assert read_recording(path, unit="100 kPa").notes == ()
    (note,) = read_recording(path, unit="MPa").notes
    assert 'unit = "MPa" is used for "p" [bar]' in note and "10 times the unit in the heading" in note
    (note,) = read_recording(path, unit="kN").notes
    assert "not the quantity in the heading" in note
    assert read_recording(write("t [s],p [V]\n" + rows()), unit="2 MPa").notes == ()  # nothing to compare


def test_a_sample_rate_that_differs_from_the_time_is_said(write):
    path = write("t [s],p [bar]\n" + rows())
    assert read_recording(path, sample_rate=1000.0).notes == ()
    (note,) = read_recording(path, sample_rate="50 kHz").notes
    assert 'sample_rate = "50 kHz" is used; the time in "t" [s] says "1 kHz"' in note


def test_remedies_propose_the_rate_of_this_record(write):
    text = "t [s],p [bar]\n" + rows(time=np.arange(N) / 1e4).replace("0.0020,", "0.0018,")
    with pytest.raises(HistoryError, match=r'sample_rate = "10 kHz"'):
        read_recording(write(text))
    stamps = "".join(f"12:00:0{i // 20},{v}\n" for i, v in enumerate(BAR))  # a clock of whole seconds
    with pytest.raises(HistoryError, match=r'sample_rate = "39 Hz", if that is right'):
        read_recording(write("Time,p [bar]\n" + stamps))


# -- gaps, parts, two faces, dates --


@pytest.mark.parametrize("word", ["", "nan", "NaN", "#N/A", "--"])
def test_gaps_are_left_out_and_said(write, word):
    lines = [
        f"{t:.4f},{word if 10 <= i < 13 or i == 20 else v}" for i, (t, v) in enumerate(zip(TIME, BAR, strict=True))
    ]
    there = np.ones(N, dtype=bool)
    there[[10, 11, 12, 20]] = False
    for options in ({}, {"sample_rate": 1e3}):
        recording = read_recording(write("t [s],p [bar]\n" + "\n".join(lines)), **options)
        np.testing.assert_allclose(recording.time, TIME[there], rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(recording.values, 1e5 * BAR[there], rtol=1e-12)
        (note,) = recording.notes
        assert "4 of 40 samples have no value, in 2 gaps of at most 4 ms" in note


def test_a_record_that_begins_with_a_gap(write):
    lines = [f"{t:.4f},{v if i > 2 else ''}" for i, (t, v) in enumerate(zip(TIME, BAR, strict=True))]
    recording = read_recording(write("t [s],p [bar]\n" + "\n".join(lines)))
    np.testing.assert_allclose(recording.time, TIME[3:], rtol=1e-12)


def test_a_part_of_the_record(write):
    path = write("t [s],p [bar]\n" + rows(time=5.0 + TIME))
    recording = read_recording(path, start="5.01 s", end=5.03)
    np.testing.assert_allclose(recording.time, 5.0 + TIME[10:31], rtol=1e-12)
    assert read_recording(path, sample_rate=1e3, end="29.5 ms").time[-1] == pytest.approx(0.029)
    for options in ({"start": 6.0}, {"start": 5.03, "end": 5.01}):
        with pytest.raises(HistoryError, match=r"nothing lies between .* goes from 5 s to 5.039 s"):
            read_recording(path, **options)
    with pytest.raises(HistoryError, match="only 11 samples"):
        read_recording(path, end=5.01)
    with pytest.raises(UnitError, match="from"):
        read_recording(path, start="5 bar")


def test_two_faces(write):
    path = write(
        "t [s],p1 [bar],p2 [MPa]\n" + "".join(f"{t},{v},{0.5 - 0.01 * v}\n" for t, v in zip(TIME, BAR, strict=True))
    )
    recording = read_recording(path, column="p1", opposing_column="p2")
    check(recording)
    np.testing.assert_allclose(recording.opposing, 1e6 * (0.5 - 0.01 * BAR), rtol=1e-12)
    for key, part in (
        ("p1", "both opposing_column and column"),
        ("t", "both opposing_column and time_column"),
        ("q", "no column"),
    ):
        with pytest.raises(HistoryError, match=part):
            read_recording(path, column="p1", opposing_column=key)
    path = write("t [s],p1 [bar],F [kN]\n" + "".join(f"{t},{v},{v}\n" for t, v in zip(TIME, BAR, strict=True)))
    with pytest.raises(HistoryError, match=r'"p1" .bar. is a pressure, "F" .kN. a force'):
        read_recording(path, column="p1", opposing_column="F")


@pytest.mark.parametrize(
    "stamp",
    [
        "12:59:59.{:03d}",
        "2026-03-01 12:59:59.{:03d}",
        "2026-03-01T12:59:59.{:03d}Z",
        "2026-03-01T12:59:59.{:03d}000+01:00",
        "01.03.2026 12:59:59.{:03d}",
        "3/1/2026 12:59:59.{:03d} PM",
    ],
)
@pytest.mark.parametrize("heading", ["Time", "Stamp"])
def test_dates_and_times_of_day(write, heading, stamp):
    later = stamp.replace("12:59:59", "01:00:00" if "PM" in stamp else "13:00:00")
    stamps = [stamp.format(980 + i) if i < 20 else later.format(i - 20) for i in range(N)]
    lines = [f"{at},{v}" for at, v in zip(stamps, BAR, strict=True)]
    recording = read_recording(write(f"{heading},p [bar]\n" + "\n".join(lines)))
    np.testing.assert_allclose(recording.time, TIME, rtol=0, atol=1e-9)
    np.testing.assert_allclose(recording.values, 1e5 * BAR, rtol=1e-12)


def test_stamps_over_midnight(write):
    def record(day, next_day):
        stamps = [f"{day}23:59:59.{980 + i}" if i < 20 else f"{next_day}00:00:00.{i - 20:03d}" for i in range(N)]
        return write("Time,p [bar]\n" + "".join(f"{s},{v}\n" for s, v in zip(stamps, BAR, strict=True)))

    for days in (("", ""), ("2025-12-31 ", "2026-01-01 "), ("31.12.2025 ", "01.01.2026 "), ("3/4/2026 ", "3/4/2026 ")):
        np.testing.assert_allclose(read_recording(record(*days)).time, TIME, rtol=0, atol=1e-9)
    with pytest.raises(HistoryError, match='line 2: the date "3/4/2026" can be read in more than one way'):
        read_recording(record("3/4/2026 ", "3/5/2026 "))


# -- what is refused --

GOOD = rows().splitlines()


def damaged(line, at=10):
    return "t [s],p [bar]\n" + "\n".join([*GOOD[:at], line, *GOOD[at + 1 :]])


def two(names):
    return f"{names}\n" + "".join(f"{t},{v},{v}\n" for t, v in zip(TIME, BAR, strict=True))


@pytest.mark.parametrize(
    ("content", "options", "parts"),
    [
        ("", {}, ["is empty"]),
        ("\n\n  \n# only a remark\n", {}, ["holds no data"]),
        ("t [s],p [bar]\n", {}, ["no column of numbers"]),
        ("hello world\nthis is text\n" * 20, {}, ["no column of numbers", '"hello world"', "expected rows"]),
        ("t [s],p [bar]\n1,2\n2,3\n", {}, ["only 2 samples", "at least 16"]),
        (damaged("0.01"), {}, ["line 12 has 1 cells, the others 2"]),
        (damaged("0.01,1,2"), {}, ["line 12 has 3 cells, the others 2"]),
        (damaged("0.01,abc"), {}, ['line 12: "abc" is not a number', "fix or delete"]),
        (damaged("0.0,abc", 0), {}, ['line 2: "abc" is not a number']),
        (damaged("0.01,1_0"), {}, ['"1_0" is not a number']),
        ("t [s],p [bar]\n" + "".join(f"{t},\n" for t in TIME[:6] - 1) + rows(), {}, ["6 of 46", "at most 10 %"]),
        (rows(values=np.where(TIME < 0.005, np.nan, BAR)), {"unit": "bar"}, ["5 of 40", "at 0 s"]),
        (damaged("0.01,-inf"), {}, ["line 12", "-inf"]),
        (damaged("inf,1"), {}, ["line 12", '"t"', "inf"]),
        (damaged("0.0085,1"), {}, ["line 12: the time does not increase (0.009 s, then 0.0085 s)", "sample_rate"]),
        (damaged("0.009,1"), {}, ["line 12: the time does not increase"]),
        (b"PK\x03\x04\x00\x00" * 300, {}, ["is not text", ".mat, .h5, .tdms and .wav"]),
        (bytes(range(128, 256)) * 50, {}, ["is not text"]),
        (b"t [s],p [bar]\n" + rows().encode() + b"\0", {}, ["is not text"]),
        (b"\xff\xfea", {}, ["is not text"]),
        ("t [s],p [bar]\n" + rows().replace(".", ","), {}, ["line 2", "decimal commas stand between commas", "points"]),
        (two("t [s],p1 [bar],p2 [bar]"), {}, ["more than one column", '"p1" [bar], "p2" [bar]', 'column = "p1"']),
        (two("t [s],p [bar],p [bar]"), {}, ["more than one column", "column = 2"]),
        (two("t [s],p [bar],p [bar]"), {"column": "p"}, ["fits more than one column", "column = 2"]),
        (two("start [s],end [s],p [bar]"), {}, ["more than one column could be the time", 'time_column = "start"']),
        (two("t [s],a,b"), {}, ["no column is a force or pressure", '"a", "b"', 'column = "b"']),
        (two("t [s],a [mm],b [V]"), {"unit": "bar"}, ["more than one column", '"a" [mm], "b" [V]']),
        ("t [s],p\n" + rows(), {}, ['no unit of force or pressure for "p"', 'unit = "bar"', '"pressure [bar]"']),
        ("t [s],a\n" + rows(), {}, ['no unit of force or pressure for "a"']),
        ("t [s],p [barg]\n" + rows(), {}, ['"barg" is not a unit of force or pressure', 'did you mean "bar"']),
        ("t [s],p [mm]\n" + rows(), {}, ["no unit of force or pressure", "[mm]"]),
        ("t [s],p [mm]\n" + rows(), {"column": "p"}, ['"mm" is not a unit of force or pressure', "unit of length"]),
        ("t [fortnite],p [bar]\n" + rows(), {"time_column": "t"}, ['"fortnite" is not a unit of time']),
        (rows(), {}, ["no headings", "column 1, column 2", "column = 2", 'unit = "bar"']),
        (rows(), {"column": 2}, ["no unit of force or pressure for column 2"]),
        ("p [bar]\n" + "1\n2\n" * 10, {}, ["no column of time", 'sample_rate = "… kHz"']),
        ("Time,p [bar]\n" + "12:00:01,3\n" * 20, {}, ["does not increase", "sample_rate"]),
        ("t [s],p [bar]\n" + rows(), {"column": "q"}, ["no column 'q'", '"t" [s], "p" [bar]']),
        ("Time,p [bar]\n" + "noon,3\n" * 20, {}, ["neither as numbers nor as times of day", "sample_rate"]),
        ("t [s],pressure [bar]\n" + rows(), {"column": "presure"}, ['did you mean "pressure"?']),
        ("t [s],p [bar]\n" + rows(), {"column": 3}, ["no column 3", "from 1 to 2"]),
        ("t [s],p [bar]\n" + rows(), {"column": 0}, ["no column 0"]),
        ("t [s],p [bar]\n" + rows(), {"column": True}, ["no column True"]),
        ("t [s],p [bar]\n" + rows(), {"column": "9" * 50}, ["no column"]),
        ("t [s],p [bar]\n" + rows(), {"column": "p", "time_column": "p"}, ["both column and time_column"]),
        ("t [s],p [bar],m\n" + rows().replace("\n", ",ok\n"), {"column": "m"}, ["does not hold numbers"]),
    ],
)
def test_refused(write, content, options, parts):
    path = write(content)
    with pytest.raises(HistoryError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert " — " in message
    assert all(part in message for part in parts), message
    assert len(message) - len(str(path)) < 400


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        ({"unit": "mm"}, ["unit = 'mm'", "force", "pressure"]),
        ({"unit": "Bar"}, ["unit = 'Bar'"]),
        ({"sample_rate": "50 kN"}, ["sample_rate", '"kN" is a unit of force']),
        ({"sample_rate": "50"}, ["sample_rate"]),
        ({"sample_rate": 0.0}, ["greater than 0"]),
        ({"sample_rate": "-5 Hz"}, ["greater than 0"]),
        ({"sample_rate": float("nan")}, ["sample_rate = nan"]),
    ],
)
def test_options_with_wrong_units(write, options, parts):
    with pytest.raises(UnitError) as caught:
        read_recording(write("t [s],p [bar]\n" + rows()), **options)
    assert all(part in str(caught.value) for part in parts), caught.value


def test_files_that_are_none(tmp_path):
    for path, part in [
        (tmp_path, "is a directory"),
        (tmp_path / "none.csv", "no such file"),
        ("x" * 5000, "x"),
        ("a\0b", "no such file"),
        ("/dev/zero", "not a regular file"),
    ]:
        if part == "not a regular file" and not os.path.exists(path):
            continue
        with pytest.raises(HistoryError, match=part):
            read_recording(path)
    (tmp_path / "pressure.csv").touch()
    with pytest.raises(HistoryError, match=r'did you mean "pressure\.csv"\?'):
        read_recording(tmp_path / "presure.csv")


@pytest.mark.parametrize("suffix", [".csv", ".mat", ".wav"])
def test_a_file_of_200_megabytes_is_refused_at_once(tmp_path, suffix):
    path = tmp_path / f"huge{suffix}"
    with open(path, "wb") as file:
        file.truncate(200 * 2**20)  # sparse
    start = time.perf_counter()
    with pytest.raises(HistoryError, match=f"has 200 MB; at most {MAX_BYTES // 2**20} MB are read — cut"):
        read_recording(path)
    assert time.perf_counter() - start < 1.0


@given(st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("b") / "x.csv"
    path.write_bytes(content)
    try:
        recording = read_recording(path)
        assert np.all(np.isfinite(recording.values))
    except PercussError as error:
        assert str(error)


@given(st.text(alphabet='0123456789.,;\t \n"#tp[]ba-e', max_size=200))
def test_any_table_like_text_is_read_or_refused(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("b") / "x.csv"
    path.write_text(text * 20)
    try:
        recording = read_recording(path, unit="bar", sample_rate=1e3)
        assert np.all(np.isfinite(recording.values))
    except PercussError as error:
        assert str(error)


# -- the formats of [io] --


def test_mat(tmp_path):
    io = pytest.importorskip("scipy.io")
    path = tmp_path / "r.mat"
    io.savemat(path, {"time_s": TIME, "p_bar": BAR[:, None], "note": "x"})
    check(read_recording(path))
    io.savemat(path, {"fs": 1000.0, "p_bar": BAR})
    check(read_recording(path))
    io.savemat(path, {"t": TIME, "data": np.column_stack([BAR, -BAR])})
    check(read_recording(path, column="data:1", unit="bar"))
    with pytest.raises(HistoryError, match='"data:1", "data:2"'):
        read_recording(path, unit="bar")
    io.savemat(path, {"time_s": TIME[:-3], "p_bar": BAR})
    with pytest.raises(HistoryError, match=r'"p" .bar. has 40 samples and "time" .s. 37'):
        read_recording(path)
    for content in ({"text": "only"}, {"record": {"t": TIME, "p": BAR}}):
        io.savemat(path, content)
        with pytest.raises(HistoryError, match=r"holds no array of numbers — .*not in a struct"):
            read_recording(path)
    path.rename(path.with_suffix(".xlsx"))
    with pytest.raises(HistoryError, match="save the sheet as CSV"):
        read_recording(path.with_suffix(".xlsx"))
    bad = BAR.copy()
    bad[7] = np.inf
    io.savemat(path, {"time_s": TIME, "p_bar": bad})
    with pytest.raises(HistoryError, match="sample 8"):
        read_recording(path)


def test_mat_of_version_73_and_h5(tmp_path):
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("scipy.io")
    path = tmp_path / "r.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["time_s"] = TIME[None, :]
        file["p_bar"] = BAR[None, :]
    with open(path, "r+b") as file:  # MATLAB's own head
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + b"\0" * 8 + b"\x00\x02IM")
    check(read_recording(path))
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as file:
        file["run/time"] = TIME
        file["run/time"].attrs["unit"] = "s"
        file["run/pressure"] = BAR.astype("f4")
        file["run/pressure"].attrs["units"] = b"bar"
    np.testing.assert_allclose(read_recording(path).values, 1e5 * BAR, rtol=1e-6)
    with h5py.File(path, "w") as file:
        file["p_bar"] = BAR
        file["p_bar"].attrs["sample_rate"] = 1000.0
    check(read_recording(path))


def test_wav_is_a_fraction_of_full_scale(tmp_path):
    wavfile = pytest.importorskip("scipy.io.wavfile")
    wave = 0.5 * np.sin(2 * np.pi * 50 * np.arange(2000) / 8000)
    for data, tolerance in [
        ((wave * 2**15).astype(np.int16), 2**-15),
        ((wave * 2**31).astype(np.int32), 2**-30),
        ((wave * 128 + 128).astype(np.uint8), 2**-7),
        (wave.astype(np.float32), 1e-7),
    ]:
        path = tmp_path / "r.wav"
        wavfile.write(path, 8000, data)
        recording = read_recording(path, unit="12 MPa")
        assert recording.quantity == "pressure"
        np.testing.assert_allclose(recording.values, 12e6 * wave, atol=12e6 * tolerance)
        np.testing.assert_allclose(recording.time, np.arange(2000) / 8000)
        for unit in (None, "MPa"):
            with pytest.raises(HistoryError, match=r'full scale.* — say what full scale is: unit = "12 MPa"'):
                read_recording(path, unit=unit)
    wavfile.write(path, 8000, np.column_stack([data, data]))
    with pytest.raises(HistoryError, match="more than one column"):
        read_recording(path, unit="12 MPa")
    assert read_recording(path, unit="12 MPa", column=2).values.size == 2000


def test_tdms(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "r.tdms"
    pressure = nptdms.ChannelObject("log", "pressure", BAR, properties={"unit_string": "bar", "wf_increment": 1e-3})
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([pressure])
    check(read_recording(path))
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([nptdms.ChannelObject("log", "time", TIME), nptdms.ChannelObject("log", "p_bar", BAR)])
    check(read_recording(path))


@pytest.mark.parametrize("name", ["r.mat", "r.h5", "r.hdf5", "r.wav", "r.tdms"])
def test_damaged_files_of_other_formats(write, name):
    for module in ("scipy", "h5py", "nptdms"):
        pytest.importorskip(module)
    with pytest.raises(HistoryError, match=r"is not a readable \w+ file .* — save it again or export it as CSV"):
        read_recording(write(b"garbage" * 100, name))


@pytest.mark.parametrize(
    ("name", "package"), [("r.mat", "scipy"), ("r.h5", "h5py"), ("r.wav", "scipy"), ("r.tdms", "npTDMS")]
)
def test_a_missing_extra_says_how_to_get_it(write, monkeypatch, name, package):
    real = builtins.__import__

    def without(module, *rest, **more):
        if module.split(".")[0] == package.lower():
            raise ImportError(module)
        return real(module, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setitem(sys.modules, package.lower(), None)
    with pytest.raises(MissingExtraError, match=re.escape(f"'{package}'")) as caught:
        read_recording(write(b"x" * 100, name))
    assert "pip install 'percuss[io]'" in str(caught.value)


# -- what a strain gauge saw


@pytest.mark.parametrize(
    ("heading", "factor", "quantity"),
    [
        ("strain [µm/m]", 1e-6, "strain"),
        ("DMS 1 [µε]", 1e-6, "strain"),
        ("gauge (microstrain)", 1e-6, "strain"),
        ("eps [1e-6]", 1e-6, "strain"),
        ("eps [10^-6]", 1e-6, "strain"),
        ("Dehnung [%]", 1e-2, "strain"),
        ("strain [m/m]", 1.0, "strain"),
        ("stress [MPa]", 1e6, "pressure"),
        ("force [kN]", 1e3, "force"),
    ],
)
def test_a_gauge_gives_strain_stress_or_force(tmp_path, heading, factor, quantity):
    file = tmp_path / "gauge.csv"
    file.write_text(f"t [µs],{heading}\n" + "".join(f"{i},{i % 7 - 3}\n" for i in range(40)), encoding="utf-8")
    found = read_recording(file, sensor="gauge")
    assert found.quantity == quantity
    assert found.values == pytest.approx(factor * (np.arange(40) % 7 - 3), rel=1e-15)


def test_a_strain_is_read_only_where_a_gauge_is_asked_for(tmp_path):
    file = tmp_path / "gauge.csv"
    file.write_text("t [s],strain [µm/m]\n" + rows(), encoding="utf-8")
    with pytest.raises(HistoryError, match="no unit of force or pressure"):
        read_recording(file)
    file.write_text("t [s],a,b\n" + "".join(f"{i / 100},{i % 10},{i % 3}\n" for i in range(40)), encoding="utf-8")
    with pytest.raises(HistoryError, match="no column is a strain, stress or force by its name and unit") as caught:
        read_recording(file, sensor="gauge")
    assert 'unit = "µm/m"' in caught.value.remedy
