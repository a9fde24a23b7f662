"""Case files: both forms, writing back, and every way in which a file can be wrong."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from case_texts import PLAIN, SI, STEPPED, STEPS, VALVE, plain_case, refusal, si_case
from percuss.case import Case, CaseErrors, steady_answer
from percuss.case.case import case_of, json_tables, without_files
from percuss.case.catalogue.sample_cases import machine_text
from percuss.case.file_format.reading import toml_text
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.description import plain_tables
from percuss.errors import CaseError, ResonanceError
from percuss.model import Ratio, Reversed
from percuss.model.described import describe_system, system_from


def test_si_form() -> None:
    system = Case.from_text(SI).system()
    assert system.bar is not None
    assert system.bar.length == 0.341
    assert system.bar.area == pytest.approx(math.pi / 4 * 0.049**2, rel=1e-15)
    assert system.frequency == 60.0
    assert system.restitution == 0.2
    assert system.load.mean * system.force_scale == pytest.approx(4000.0, rel=1e-14)
    assert system.body.damping == Ratio(1e-3)
    assert system.contact == Reversed(0.2)
    assert (
        Case.from_text(SI.replace("damping_ratio = 1e-3\n", "")).system() == system
    )  # what holds when nothing is known


def test_plain_form() -> None:
    case = Case.from_text(PLAIN)
    system = case.system()
    assert case.title == "B77 scale"
    assert (system.s, system.d, system.restitution, system.is_si) == (20.0, 0.0048, 0.6, False)
    assert system.load.coefficients.tolist() == [0.9, 1.0]
    assert case.history_report is None


def test_pressure_with_area_is_force() -> None:
    force = Case.from_text(SI).system()
    pressures = SI.replace('"4 kN"', '"40 bar"').replace('"9 kN"', '"9 MPa"')
    with_area = pressures.replace("[contact]", 'area = "10 cm^2"\n[contact]')
    assert Case.from_text(with_area).system().load.coefficients == pytest.approx(force.load.coefficients, rel=1e-14)
    with pytest.raises(CaseError, match=r"load\.mean = '40 bar'.*needs the area"):
        Case.from_text(pressures)


def test_si_square_and_fourier() -> None:
    square = SI.replace('"harmonic"', '"square"').replace('mean = "4 kN"', "kappa = 1.2")
    load = Case.from_text(square).system().load
    assert load.is_piecewise
    assert load.load_factor > 0.0
    fourier = SI.replace('"harmonic"', '"fourier"').replace('mean = "4 kN"', "coefficients = [[4, 0], [9, 0.0]]")
    fourier = fourier.replace('amplitude = "9 kN"', 'unit = "kN"')
    same = Case.from_text(SI).system().load
    assert Case.from_text(fourier).system().load.coefficients == pytest.approx(same.coefficients, rel=1e-14)


def test_receiving_area() -> None:
    text = SI.replace("restitution = 0.2", 'receiving_area = "24 cm^2"')
    own = math.pi / 4 * 4.9**2
    assert Case.from_text(text).system().restitution == pytest.approx((24 - own) / (24 + own), rel=1e-14)


TEXTS = [
    SI,
    PLAIN,
    SI.replace("restitution = 0.2", 'receiving_area = "24 cm^2"'),
    si_case('damping = {kind = "kelvin_voigt", value = "10 ns"}', contact='strain = "reversed"'),
    si_case('drag = "40 N*s/m^2"'),
    si_case('damping = {kind = "table", value = [1.0, 20]}', "at = 0"),
    plain_case('damping = {kind = "ratio", value = 2e-3}\nstrain = "reversed"'),
    plain_case(kind=STEPS),
    si_case(load="at = 1", contact='strain = "kept"', sizes=STEPPED),
    plain_case("impedances = [2, 1]\ntransit_times = [1, 2]"),
    machine_text("valve-breaker"),
    plain_case(kind=VALVE),
]


@pytest.mark.parametrize("text", TEXTS)
def test_a_case_is_written_back_and_has_its_dimensionless_form(text: str) -> None:
    case = Case.from_text(text)
    again = Case.from_text(case.to_toml())
    assert again == case and (case.is_machine or hash(again) == hash(case))
    hammer = case.machine() if case.is_machine else case.system()
    assert (again.machine() if case.is_machine else again.system()) == hammer
    assert case_of(json.loads(json.dumps(json_tables(case)))) == case
    assert without_files(case) is case
    form = case_of(json.loads(json.dumps(plain_tables(case))))
    if case.is_machine:
        assert form.machine().valve == hammer.valve
        return
    plain = form.system()
    assert plain.contact.restitution == hammer.contact.restitution and type(plain.contact) is type(hammer.contact)
    assert plain.body == hammer.body or len(hammer.body.places) > 1
    assert plain.body.frequencies(9) == pytest.approx(hammer.body.frequencies(9), rel=1e-13)
    assert plain.load.coefficients == pytest.approx(hammer.load.coefficients, rel=1e-14, abs=1e-14)
    assert (plain.load.values, plain.load.at) == (hammer.load.values, hammer.load.at)
    assert system_from(json.loads(json.dumps(describe_system(hammer)))) == hammer


# A case file is ASCII-safe text, but a title may hold anything, and numbers must survive to the last bit.
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=30)
numbers = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**53), 2**53)


@given(title=texts, s=st.floats(1e-6, 1e9), pairs=st.lists(st.tuples(numbers, numbers), min_size=1, max_size=4))
def test_toml_text_reads_back(title: str, s: float, pairs: list[tuple[float, float]]) -> None:
    import tomllib

    tables = {"title": title, "system": {"s": s, "flag": True}, "load": {"coefficients": pairs}}
    back = tomllib.loads(toml_text(tables))
    assert back == {**tables, "load": {"coefficients": [list(pair) for pair in pairs]}}


# -- what is wrong, beside `test_refused_cases.py` --------------------------------------------------------------------


@pytest.mark.parametrize("kappa", [0.0, 2.0, -1.0, 2.5])
def test_kappa_between_0_and_2(kappa: float) -> None:
    square = PLAIN[: PLAIN.index("kind")] + f'kind = "square"\namplitude = 1.0\nkappa = {kappa}\n'
    assert f"load.kappa = {kappa}: expected a number greater than 0 and less than 2" in refusal(square)


def test_all_problems_together() -> None:
    text = SI.replace("length =", "lenght =").replace('"4 kN"', "4").replace("[contact]", "[contakt]")
    with pytest.raises(CaseErrors) as caught:
        Case.from_text(text)
    keys = [problem.key for problem in caught.value.problems]
    assert sorted(keys) == ["bar.lenght", "contakt", "load.mean"]
    sizes = SI.replace("341", "-341").replace("restitution = 0.2", "restitution = 7")
    with pytest.raises(CaseErrors) as caught:
        Case.from_text(sizes)
    assert [problem.key for problem in caught.value.problems] == ["bar.length", "contact.restitution"]


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "bar: missing"),
        ("a = = 1", "line 1"),
        ("[bar]\nlength = 341 mm\n", "needs quotes"),
        ("[bar]\n[bar]\n", "line 2"),
        ("x = " + "[" * 5000, "nested too deeply"),
        ("x = " + "9" * 5000, "not valid TOML"),
        ("bar = 3\n[load]\nkind = 'harmonic'", "bar = 3: expected a table"),
        ("load = 3\n[system]\ns = 1.0", "load = 3"),
    ],
)
def test_not_a_case(text: str, part: str) -> None:
    with pytest.raises(CaseError) as caught:
        Case.from_text(text)
    assert part in str(caught.value)


def test_files_that_are_none(tmp_path: Path) -> None:
    def reason(path: Path) -> str:
        with pytest.raises(CaseError) as caught:
            Case.read(path)
        assert str(caught.value).startswith(str(path))
        return str(caught.value)

    assert "no such file" in reason(tmp_path / "none.toml")
    assert "is a directory" in reason(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\x89PNG\0\0\1")
    assert "is a binary file" in reason(binary)
    latin = tmp_path / "latin.toml"
    latin.write_bytes('title = "x"\ntitle2 = "Hammarbyhöjden"'.encode("latin-1"))
    assert "is not UTF-8 text (line 2)" in reason(latin)
    large = tmp_path / "large.toml"
    with large.open("wb") as file:
        file.truncate(200_000_000)  # a hole: takes no room on the disk
    assert "too large" in reason(large)
    if os.geteuid() != 0:
        latin.chmod(0)
        assert "cannot be read" in reason(latin)


def test_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + SI.replace("\n", "\r\n").encode())
    assert Case.read(path) == Case.from_text(SI)


# -- histories ------------------------------------------------------------------------------------------------------


def history_case(tmp_path: Path, table: str, header: str = "time [s],pressure [bar]", cycles: int = 12) -> Case:
    t = np.arange(cycles * 200) / 12_000.0  # 60 Hz, 200 samples a cycle
    p = 60.0 + 140.0 * np.cos(2.0 * math.pi * 60.0 * t) + 20.0 * np.sin(4.0 * math.pi * 60.0 * t)
    rows = "\n".join(f"{a:.9g},{b:.9g}" for a, b in zip(t, p, strict=True))
    (tmp_path / "pressure.csv").write_text(f"{header}\n{rows}\n", encoding="utf-8")
    text = SI[: SI.index("kind")] + f'kind = "history"\n{table}\n' + SI[SI.index("[contact]") :]
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    return Case.read(path)


def test_history_beside_the_case(tmp_path: Path) -> None:
    case = history_case(tmp_path, 'file = "pressure.csv"\narea = "6.5 cm^2"')
    system = case.system()
    assert system.load.mean * system.force_scale == pytest.approx(60e5 * 6.5e-4, rel=1e-3)
    assert system.frequency == pytest.approx(60.0, rel=1e-4)
    report = case.history_report
    assert report is not None
    assert report.cycles >= 10
    assert Case.from_text(case.to_toml(), folder=tmp_path) == case


@pytest.mark.parametrize(
    ("table", "part"),
    [
        ('file = "pressur.csv"\narea = "6.5 cm^2"', "did you mean 'pressure.csv'?"),
        ('file = "."\narea = "6.5 cm^2"', "is a directory"),
        ('file = "pressure.csv"', "load.area: a recorded pressure needs the area"),
        ('file = "pressure.csv"\narea = "-1 cm^2"', "load.area = '-1 cm^2'"),
        ('file = "pressure.csv"\narea = "6.5 cm^2"\nunit = "kN"', "load.area = '6.5 cm^2': the recorded values are"),
        ('file = "pressure.csv"\narea = "6.5 cm^2"\nunit = "kB"', "kB"),
        ('file = "pressure.csv"\narea = "6.5 cm^2"\ncolumn = "force"', "force"),
        ('file = "pressure.csv"\narea = "6.5 cm^2"\nharmonics = 0', "load.harmonics = 0"),
    ],
)
def test_wrong_history_table(tmp_path: Path, table: str, part: str) -> None:
    with pytest.raises(CaseError) as caught:
        history_case(tmp_path, table).system()
    assert part in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_history_of_a_plain_system(tmp_path: Path) -> None:
    si = history_case(tmp_path, 'file = "pressure.csv"\narea = "6.5 cm^2"').system()
    text = PLAIN[: PLAIN.index("kind")] + (
        'kind = "history"\nfile = "pressure.csv"\narea = "6.5 cm^2"\n' + f'force_scale = "{si.force_scale!r} N"\n'
    )
    case = Case.from_text(text, folder=tmp_path)
    assert case.system().load.coefficients == pytest.approx(si.load.coefficients, rel=1e-12)
    assert case.history_report is not None
    assert not case.system().is_si


def two_faces_case(tmp_path: Path, table: str, header: str = "time [s],p1 [bar],p2 [MPa]") -> Case:
    """A record from 100 s on: 60 + 140 cos bar on one face, 4 − 2 cos MPa on the other, nothing useful after 0.5 s."""
    case = history_case(tmp_path, table)
    t = np.arange(40 * 200) / 12_000.0
    c = np.where(t < 0.5, np.cos(2.0 * math.pi * 60.0 * t), 0.0)
    rows = "\n".join(f"{100 + a:.9g},{60 + 140 * b:.9g},{4 - 2 * b:.9g}" for a, b in zip(t, c, strict=True))
    (tmp_path / "pressure.csv").write_text(f"{header}\n{rows}\n", encoding="utf-8")
    return case


TWO_FACES = """file = "pressure.csv"
column = "p1"
area = "6.5 cm^2"
opposing_column = "p2"
opposing_area = "4 cm^2"
from = "100 s"
to = "100.5 s"
"""


def test_two_faces_of_a_part_of_a_record(tmp_path: Path) -> None:
    case = two_faces_case(tmp_path, TWO_FACES)
    load = case.load()
    assert load.report is not None and load.report.cycles == 30
    assert load.mean == pytest.approx(60e5 * 6.5e-4 - 4e6 * 4e-4, rel=1e-4)
    assert abs(load.coefficients[1]) == pytest.approx(140e5 * 6.5e-4 + 2e6 * 4e-4, rel=1e-4)
    again = Case.from_text(case.to_toml(), folder=tmp_path)
    assert again == case and 'from = "100 s"' in case.to_toml()
    assert not {"load.area", "load.opposing_area", "load.from", "load.to"} & set(CaseFamily(case, {}).keys)


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ('opposing_area = "4 cm^2"\n', "", "load.opposing_area: a recorded pressure needs the area"),
        ('opposing_column = "p2"\n', "", "load.opposing_area = '4 cm^2': there is no opposing pressure"),
        ('"100.5 s"', '"99 s"', "nothing lies between 100 s and 99 s"),
        ('"100.5 s"', '"0.5 bar"', "load.to = '0.5 bar'"),
        ("from =", "form =", "unknown key"),
        ('"p2"', '"p3"', "no column 'p3'"),
    ],
)
def test_wrong_two_faces(tmp_path: Path, old: str, new: str, part: str) -> None:
    with pytest.raises(CaseError) as caught:
        two_faces_case(tmp_path, TWO_FACES.replace(old, new)).system()
    assert part in str(caught.value), caught.value


@pytest.mark.parametrize(
    ("rows", "what"),
    [
        ("", "empty"),
        ("time [s],pressure [bar]\n", "header only"),
        ("time [s],pressure [bar]\n0,1\n1,2,3\n2,1\n", "ragged"),
        ("time [s],pressure [bar]\n0,1\n2,2\n1,3\n3,1\n", "not monotonic"),
        ("time [s],pressure [bar]\n" + "".join(f"{i / 100},{math.cos(i / 16)}\n" for i in range(100)), "one cycle"),
        ("time [s],pressure [bar]\n" + "".join(f"{i},nan\n" for i in range(100)), "not finite"),
    ],
)
def test_wrong_recordings(tmp_path: Path, rows: str, what: str) -> None:
    case = history_case(tmp_path, 'file = "pressure.csv"\narea = "6.5 cm^2"')
    (tmp_path / "pressure.csv").write_text(rows, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        case.system()
    assert "pressure.csv" in str(caught.value), what


# -- answers --------------------------------------------------------------------------------------------------------


def test_resonance_is_named() -> None:
    text = PLAIN.replace("s = 20.0", f"s = {1.0 / (2.0 * math.pi)!r}").replace("d = 0.0048", "d = 0.0")
    with pytest.raises(ResonanceError) as caught:
        steady_answer(Case.from_text(text))
    assert (caught.value.harmonic, caught.value.mode) == (1, 2)


def test_answer_of_an_unanswerable_question() -> None:
    answer = steady_answer(Case.from_text(PLAIN.replace("0.9, 0.0", "5.0, 0.0")))
    period = answer.to_json_dict()["periods"][0]
    assert period["exists"] is False
    assert period["orbits"] == []
    assert period["nearest"]["load_factor"] == pytest.approx(1.6 / (math.pi * 0.4), rel=2e-2)  # B77 (38)
    assert answer.chosen is None
    assert answer.running == ()
