"""Contacts of a case whose numbers come from one blow, resolved by waves: known blows, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.blow import Rod, strike
from percuss.blow import striking as effective
from percuss.case import Case, load_case
from percuss.case.case import case_of
from percuss.case.file_format.contact import blow_of
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.description import plain_tables
from percuss.errors import CaseError
from percuss.model import Kept, Reversed
from percuss.model.contact import Timed
from percuss.steady import self_excited_motion, steady_states

LOAD: dict[str, Any] = {"kind": "harmonic", "mean": "81 N", "amplitude": "134 N", "frequency": "20 Hz"}
FROM_BLOW = {"restitution": "from the blow"}


def si_case(tool: dict[str, Any] | None, contact: dict[str, Any], **tables: Any) -> Case:
    bar = tables.pop("bar", {"length": "200 mm", "diameter": "22 mm"})
    struck = {} if tool is None else {"tool": tool}
    return case_of({"bar": bar, "load": LOAD, "contact": contact, **struck, **tables}, "case.toml")


def refusal(case: Case, ask: str = "system") -> str:
    with pytest.raises(CaseError) as caught:
        getattr(case, ask)()
    assert "\n" not in str(caught.value)
    return str(caught.value)


# -- known blows --


@settings(max_examples=30)
@given(own=st.floats(5.0, 80.0), ratio=st.floats(1.0, 20.0), length=st.floats(0.05, 3.0))
def test_a_uniform_bar_on_an_endless_rod_rebounds_as_b77_says(own: float, ratio: float, length: float) -> None:
    """B77's R of the areas, the contact of one round trip and the advance: b77-blow is b77-tau (St Venant 1867)."""
    bar = {"length": f"{length!r} m", "area": f"{own!r} cm^2"}
    rod = f"{own * ratio!r} cm^2"
    by_area = si_case(None, {"receiving_area": rod}, bar=bar).system()
    case = si_case({"sections": [{"area": rod}]}, {"law": "b77-blow"}, bar=bar)
    assert case.system().restitution == pytest.approx(by_area.restitution, abs=1e-12)
    assert isinstance(case.system().contact, Reversed)
    law, closed = case.timed_law(), Timed.of_uniform_bar(by_area.s, by_area.restitution)
    assert law is not None and law.contacts == 1 and law.ringing_share < 1e-12
    for name in ("duration", "force_centroid", "advance_per_impulse"):
        assert getattr(law, name) == pytest.approx(getattr(closed, name), rel=1e-11)
    said = si_case(None, {"receiving_area": rod, "law": "b77-blow"}, bar=bar).timed_law()
    assert said is not None and said.duration == pytest.approx(law.duration, rel=1e-13)


@pytest.mark.parametrize("ratio", [1.0, 3.0])
def test_a_dimensionless_bar_on_an_endless_rod(ratio: float) -> None:
    tables = {
        "system": {"s": 20.0, "d": 0.0, "restitution": "from the blow", "law": "b77-blow"},
        "tool": {"impedance": ratio},
        "load": {"kind": "harmonic", "mean": 0.5, "amplitude": 1.0},
    }
    case = case_of(tables)
    r = (ratio - 1.0) / (ratio + 1.0)
    assert isinstance(case.system().contact, Kept) and case.system().restitution == pytest.approx(r, abs=1e-14)
    law = case.timed_law()
    assert law is not None
    closed = Timed.of_uniform_bar(20.0, r)
    assert law.duration == pytest.approx(closed.duration, rel=1e-13)
    assert law.advance_per_impulse == pytest.approx(1.0 / (20.0 * ratio), rel=1e-13)
    back = case_of({**tables, "system": {**tables["system"], "advance": "pushed back"}}).timed_law()
    assert back is not None and back.advance_per_impulse == 0.0


def test_two_sections_of_equal_transit_time_on_a_wall() -> None:
    """R = 1 − 2ρ² in a contact of 4 τ, with the forces 1 and 1 + 2ρ; 4ρ²(1 − ρ²) of the energy rings on."""
    bar = {"sections": [{"length": "0.25 m", "area": "10 cm^2"}, {"length": "0.25 m", "area": "12 cm^2"}]}
    case = si_case({"kind": "wall"}, {"law": "b77-blow"}, bar=bar)
    rho, tau = -1.0 / 11.0, 0.25 / math.sqrt(210e9 / 7850.0)
    law, omega = case.timed_law(), 2.0 * math.pi * 20.0
    assert law is not None
    assert law.restitution == case.system().restitution == pytest.approx(1.0 - 2.0 * rho**2, abs=1e-13)
    assert law.duration == pytest.approx(4.0 * tau * omega, rel=1e-12)
    assert law.force_centroid == pytest.approx(
        tau * (1.0 + 3.0 * (1.0 + 2.0 * rho)) / (2.0 + 2.0 * rho) * omega, rel=1e-12
    )
    assert law.ringing_share == pytest.approx(4.0 * rho**2 * (1.0 - rho**2), abs=1e-12)
    assert law.advance_per_impulse == 0.0


def test_the_drifter_piston_of_three_sections_on_a_thick_rod() -> None:
    """Figures of two independent programs: exact waves with 30 digits, and a fine lattice."""
    tables = {
        "system": {
            "s": 40.0,
            "d": 0.0,
            "restitution": "from the blow",
            "law": "b77-blow",
            "impedances": [1.2566, 1.9635, 0.9503],
            "transit_times": [0.0731, 0.2187, 0.1493],
        },
        "tool": {"impedance": 4.0},
        "load": {"kind": "fourier", "coefficients": [[0.66, 0.0], [1.0, 0.0]]},
    }
    law = case_of(tables).timed_law()
    assert law is not None
    assert law.restitution == pytest.approx(0.41528390670042886, abs=1e-9)
    assert law.duration == pytest.approx(0.066923600090682378, abs=1e-9)
    assert law.force_centroid == pytest.approx(0.02807555306396961, abs=1e-9)
    assert 1.0 / law.advance_per_impulse == pytest.approx(101.13533508847935, rel=1e-9)


def test_the_advance_on_rock_is_the_penetration_that_stays() -> None:
    """At any speed: impulse and residual penetration are in proportion."""
    case = load_case("dth-6-inch").varied({"contact.restitution": None, "contact.law": "b77-blow"})
    law, system, question = case.timed_law(), case.system(), case.blow_question()
    assert law is not None and isinstance(question.target, Rod)
    blow = strike(question.striker, question.target, 7.3)
    assert blow.residual_penetration is not None and blow.residual_penetration > 1e-4
    impulse = blow.impulse / (system.force_scale * system.time_scale)
    assert law.advance_per_impulse * impulse * system.length_scale == pytest.approx(
        blow.residual_penetration, rel=1e-11
    )
    assert law.restitution == pytest.approx(blow.effective_restitution, rel=1e-11)
    assert 0.0 < law.ringing_share < 0.2 and law.contacts == len(blow.contacts)
    back = case.varied({"contact.advance": "pushed back"}).timed_law()
    assert back is not None and back.advance_per_impulse == 0.0


# -- how it is used --


def test_the_restitution_of_the_blow_is_that_of_the_motion() -> None:
    case = load_case("heavy-breaker").varied({"contact.restitution": "from the blow"})
    found = blow_of(case.blow_question())
    assert case.is_from_blow and case.system().restitution == found.restitution
    number = case.varied({"contact.restitution": found.restitution})
    assert number.system() == case.system() and not number.is_from_blow
    (note,) = case.notes
    assert note.startswith(f"R = {found.restitution:.4g} is that of the blow on the tool") and "3 contacts" in note
    assert number.notes == ()
    assert case_of(plain_tables(case)).system().restitution == found.restitution


def test_a_blow_is_computed_once_for_a_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def counted(*arguments: Any, **named: Any) -> Any:
        asked.append(arguments)
        return strike(*arguments, **named)

    monkeypatch.setattr(effective, "strike", counted)
    effective._known.cache_clear()
    case = load_case("heavy-breaker").varied({"contact.restitution": "from the blow"})
    family = CaseFamily(case, {"frequency": "Hz", "rock.stiffness": "kN/mm"})
    for frequency in (5.0, 6.0, 7.0):
        assert family.system({"frequency": frequency}).restitution == case.system().restitution
    assert len(asked) == 1
    softer = family.system({"rock.stiffness": 500.0})
    assert softer.restitution < case.system().restitution and len(asked) == 2


# -- what is refused --


def test_a_bar_that_is_thicker_than_the_rod_stops_in_steps() -> None:
    """Its momentum passes on in a staircase: R = 0, and no contact that ends."""
    tool = {"sections": [{"diameter": "20 mm"}]}
    assert si_case(tool, FROM_BLOW).system().restitution == 0.0
    case = si_case(tool, {"law": "b77-blow"})
    assert "contact.law = 'b77-blow': expected a contact that ends" in refusal(case, "timed_law")


def test_a_bar_that_goes_on_after_the_blow_has_no_restitution() -> None:
    """A heavy bar drives a short free rod in front of it."""
    tool = {"sections": [{"length": "20 mm", "diameter": "20 mm"}], "end": "free"}
    found = refusal(si_case(tool, FROM_BLOW))
    assert "contact.restitution = 'from the blow': expected a blow with a restitution from 0 to 1" in found
    assert "has R = -0." in found


def test_a_load_that_does_not_push_gives_no_speed() -> None:
    case = load_case("mini-breaker").varied({"contact.restitution": "from the blow", "rock.gap": "1 mm"})
    assert "expected a load that pushes toward the tool" in refusal(case.varied({"load.mean": "0 N"}))


def test_a_blow_that_is_not_over_has_no_restitution() -> None:
    tool = {"sections": [{"diameter": "32 mm"}]}
    found = refusal(si_case(tool, FROM_BLOW, blow={"until": "20 us"}))
    assert "expected a blow that is over; the window ended while the faces were in contact" in found
    assert "until in [blow]" in found


@pytest.mark.parametrize(
    ("tool", "advance", "part"),
    [
        ({"sections": [{"diameter": "32 mm"}]}, "residual penetration", '"kept" or "pushed back" of an endless rod'),
        ({"kind": "wall"}, "kept", '"pushed back" of a wall'),
        ({"sections": [{"length": "1 m", "diameter": "32 mm"}], "end": "fixed"}, "kept", '"pushed back" of a rod'),
    ],
)
def test_an_advance_that_the_tool_does_not_have(tool: dict[str, Any], advance: str, part: str) -> None:
    found = refusal(si_case(tool, {"law": "b77-blow", "advance": advance}), "timed_law")
    assert f"contact.advance = '{advance}': expected {part}" in found


# -- a gap in front of the rock: the blow depends on its speed, and the speed on the restitution --

PUMP = {"load.supply": {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}}


@pytest.mark.parametrize(
    ("name", "gap", "more", "slope"),
    [
        ("mini-breaker", "1 mm", {}, -1.07),
        ("valve-drifter", "0.3 mm", {}, 0.0),
        ("valve-breaker", "2 mm", PUMP, -0.108),
    ],
)
def test_the_restitution_is_that_of_the_cycles_own_blow(
    name: str, gap: str, more: dict[str, Any], slope: float
) -> None:
    """The cycle is solved anew, its blow followed at its speed: the same R, whatever [blow] says of a speed."""
    asked = {"contact.restitution": "from the blow", "rock.gap": gap, "blow.velocity": "3 m/s", **more}
    case = load_case(name).varied(asked)
    hammer, question = case.hammer, case.blow_question()
    r = hammer.contact.restitution

    def blown(restitution: float) -> float:
        other = case.varied({"contact.restitution": restitution})
        if case.is_machine:
            cycle = self_excited_motion(other.machine(), modes=0, room=other.room()).cycle
            assert cycle is not None
            speed = cycle.blow_speed
        else:
            speed = steady_states(other.system()).orbits[0].rigid_velocity
        blow = strike(question.striker, question.target, speed * hammer.speed_scale)
        assert blow.effective_restitution is not None
        return blow.effective_restitution

    assert blown(r) == pytest.approx(r, abs=1e-10)
    assert (blown(r + 1e-4) - blown(r - 1e-4)) / 2e-4 == pytest.approx(slope, abs=6e-3)
    note = case.notes[-1]
    assert "the gap in front of the rock makes it depend on the speed" in note
    assert ("slope" in note) == (slope != 0.0)
    closed = case.varied({"blow.velocity": None, "contact.restitution": "from the blow"})
    assert closed.hammer.contact.restitution == r


def test_without_a_gap_one_blow_serves_all_speeds() -> None:
    """To the bit that of a unit speed, and nothing is said of a speed."""
    for name in ("valve-drifter", "hydraulic-drifter"):
        case = load_case(name).varied({"contact.restitution": "from the blow"})
        question = case.blow_question()
        one = strike(question.striker, question.target, 1.0)
        assert case.hammer.contact.restitution == one.effective_restitution
        assert not any("depend on the speed" in note for note in case.notes)


def test_the_law_of_a_blow_is_that_of_its_own_speed() -> None:
    """The advance is that of the blow at the speed of the cycle."""
    case = load_case("mini-breaker").varied(
        {"contact.restitution": None, "contact.law": "b77-blow", "rock.gap": "1 mm", "blow.velocity": "1 m/s"}
    )
    law, system, question = case.timed_law(), case.system(), case.blow_question()
    speed = steady_states(system).orbits[0].rigid_velocity * system.speed_scale
    blow = strike(question.striker, question.target, speed)
    assert law is not None and blow.contact_duration is not None
    assert law.restitution == pytest.approx(system.restitution, abs=1e-10)
    assert law.duration == pytest.approx(blow.contact_duration / system.time_scale, rel=1e-9)
