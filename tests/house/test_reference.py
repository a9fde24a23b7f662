"""The generated and the written reference say what the program does: commands, keys of the case file, JSON."""

import contextlib
import importlib
import io
import json
import re
import sys
from pathlib import Path

import pytest

from case_texts import plain_case, si_case
from percuss import Stop, run
from percuss.case import Case, blow_answer, load_case
from percuss.case.file_format import plain_form, schema
from percuss.cli import main
from percuss.errors import CaseError

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS / "_ext"))
reference = importlib.import_module("reference")
cells = importlib.import_module("cells")


def page(name: str) -> str:
    return reference.expanded((DOCS / name).read_text(encoding="utf-8"))


def help_of(*words: str) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.suppress(SystemExit):
        main([*words, "--help"])
    return out.getvalue()


# -- commands --

COMMANDS = re.findall(r"^  (\w+)  ", help_of().partition("commands:")[2].partition("\n\n")[0], re.MULTILINE)


def test_the_reference_has_every_command():
    assert len(COMMANDS) > 8
    assert re.findall(r"^## `percuss (\w+)`$", page("commands.md"), re.MULTILINE) == COMMANDS


# -- the case file --

TABLES = {
    "BarTable": ("si", "bar"),
    "BodyTable": ("si", "body"),
    "SectionTable": ("si", "bar.sections"),
    "DampingTable": ("si", "bar.damping"),
    "ContactTable": ("si", "contact"),
    "HarmonicLoad": ("si", "load"),
    "SquareLoad": ("si", "load"),
    "StepsLoad": ("si", "load"),
    "FourierLoad": ("si", "load"),
    "HistoryLoad": ("si", "load"),
    "ValveLoad": ("si", "load"),
    "PortTable": ("si", "load.ports"),
    "ChamberTable": ("si", "load.chamber"),
    "CushionTable": ("si", "load.cushion"),
    "SupplyTable": ("si", "load.supply"),
    "AreasTable": ("si", "load.states"),
    "OilChamberTable": ("si", "load.chambers"),
    "OrificeTable": ("si", "load.orifices"),
    "PassageTable": ("si", "load.orifices.in"),
    "WaysTable": ("si", "load.passage"),
    "OilTable": ("si", "load.oil"),
    "FlowAtTable": ("si", "load.supply.leakage"),
    "ReliefTable": ("si", "load.supply.relief"),
    "GasAccumulatorTable": ("si", "load.supply.accumulator"),
    "SystemTable": ("plain", "system"),
    "PlainHarmonicLoad": ("plain", "load"),
    "PlainSquareLoad": ("plain", "load"),
    "PlainStepsLoad": ("plain", "load"),
    "PlainFourierLoad": ("plain", "load"),
    "PlainHistoryLoad": ("plain", "load"),
    "PlainValveLoad": ("plain", "load"),
    "StartTable": ("plain", "start"),
    "SimulationTable": ("plain", "simulation"),
    "ToolTable": ("si", "tool"),
    "ToolSectionTable": ("si", "tool.sections"),
    "JointTable": ("si", "tool.joints"),
    "FeedTable": ("si", "feed"),
    "RockTable": ("si", "rock"),
    "DrillingTable": ("si", "drilling"),
    "SteelTable": ("si", "steel"),
    "ToolSteelTable": ("si", "steel.tool"),
    "BlowTable": ("si", "blow"),
    "PlainTool": ("plain", "tool"),
    "PlainBlow": ("plain", "blow"),
}
"""The tables that the page shows, with the form of case and the name that they have there."""


def rows(table: str) -> dict[str, list[str]]:
    """The generated table: for each key its other columns."""
    lines = reference.keys(table).splitlines()[2:]
    cut = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    return {row[0].strip("` "): row[1:] for row in cut}


@pytest.mark.parametrize(
    ("form", "kind"),
    [
        (form, kind)
        for form in (schema.PhysicalCase, plain_form.PlainCase)
        for kind in ("harmonic", "square", "fourier", "steps", "valve")
    ]
    + [(schema.PhysicalCase, "history"), (plain_form.PlainCase, "history")],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_the_page_has_every_key_of_a_case(form, kind):
    text = (DOCS / "case-file.md").read_text(encoding="utf-8")
    shown = re.findall(r"<!-- percuss: keys (\w+) -->", text)
    assert shown == sorted(set(shown), key=shown.index) and set(shown) == TABLES.keys()
    found = {"": {"title", *(name for _, name in TABLES.values())}}
    for table in shown:
        found.setdefault(TABLES[table][1], set()).update(rows(table))
    found["system.damping"] = found["bar.damping"]
    found["tool.sections"] |= found["bar.sections"]
    found["steel"] |= found["steel.tool"]
    found["load.supply.slip"] = found["load.supply.leakage"]
    found["load.passage"] |= found["load.orifices.in"]
    found["load.orifices"] |= found["load.passage"]  # an orifice is a passage
    found["load.opposing_passage"] = found["load.passage"]
    for one in ("load.orifices", "load.passage", "load.opposing_passage"):
        found[f"{one}.in"] = found[f"{one}.out"] = found["load.orifices.in"]
    for table, keys in schema.table_fields(form, kind).items():
        assert set(keys) <= found[table]


CASES = {
    "si": {
        "bar": {"length": '"341 mm"', "diameter": '"49 mm"'},
        "load": {"kind": '"harmonic"', "mean": '"4 kN"', "amplitude": '"9 kN"', "frequency": '"60 Hz"'},
        "contact": {"restitution": "0.2"},
    },
    "plain": {
        "system": {"s": "20.0", "d": "0.01", "restitution": "0.6"},
        "load": {"kind": '"harmonic"', "mean": "0.9", "amplitude": "1.0"},
    },
}
VALVE = {
    "kind": '"valve"',
    "states": '{return = "-4 kN", power = "9 kN"}',
    "ports": '[{behind = "0.5 mm", side = "back", to = "power"}, {on = "impact", to = "return"}]',
}
LOADS = {
    "SquareLoad": {"kind": '"square"', "amplitude": '"9 kN"', "kappa": "1.3", "frequency": '"60 Hz"'},
    "FourierLoad": {"kind": '"fourier"', "coefficients": "[[4, 0], [9, 0]]", "unit": '"kN"', "frequency": '"60 Hz"'},
    "StepsLoad": {"kind": '"steps"', "breaks": "[0, 2]", "values": "[4, -9]", "unit": '"kN"', "frequency": '"60 Hz"'},
    "ValveLoad": dict(VALVE),
    "PlainValveLoad": {
        "kind": '"valve"',
        "states": "{return = -0.4, power = 1.8}",
        "ports": '[{behind = 0.5, side = "back", to = "power"}, {on = "impact", to = "return"}]',
    },
    "PlainSquareLoad": {"kind": '"square"', "amplitude": "1.0", "kappa": "1.3"},
    "PlainStepsLoad": {"kind": '"steps"', "breaks": "[0, 2]", "values": "[0.4, -1.0]"},
    "PlainFourierLoad": {"kind": '"fourier"', "coefficients": "[[0.9, 0], [1, 0]]"},
}
STRUCK = {
    "si": {
        "tool": {"sections": '[{length = "1 m", diameter = "38 mm"}]'},
        "feed": {"force": '"1 kN"'},
        "rock": {"stiffness": '"400 kN/mm"'},
        "blow": {},
        "drilling": {"bit_diameter": '"64 mm"', "crater_factor": "0.3"},
    },
    "plain": {"tool": {"impedance": "3.0"}, "blow": {}},
}
"""What a case has besides where a key of one of these tables is looked at."""

BODY = {"kind": '"mounted"', "spring": '"20 kN/m"', "mass": '"2 kg"'}
SECTION = {"length": '"120 mm"', "diameter": '"52 mm"'}
BESIDE = {
    ("SectionTable", "area"): {"diameter": None},
    ("BarTable", "area"): {"diameter": None},
    ("ToolSectionTable", "area"): {"diameter": None},
    ("PortTable", "speed"): {"behind": None},
    ("ContactTable", "advance"): {"law": '"b77-tau"'},
    ("SystemTable", "advance"): {"law": '"b77-tau"'},
    ("ContactTable", "receiving_area"): {"restitution": None},
    ("HarmonicLoad", "area"): {"mean": '"4 bar"', "amplitude": '"9 bar"'},
    ("SquareLoad", "area"): {"amplitude": '"9 bar"'},
    ("FourierLoad", "area"): {"unit": '"bar"'},
    ("StepsLoad", "area"): {"unit": '"bar"'},
    **{
        ("SupplyTable", key): {"flow": '"133 l/min"', "accumulator": '"2.5 cm^3/bar"'}
        for key in ("flow", "accumulator", "start", "quickening", "power", "slip", "leakage", "relief")
    },
    ("SupplyTable", "line"): {
        "flow": '"133 l/min"',
        "accumulator": '{precharge = "80 bar", volume = "0.4 l"}',
    },
    ("ValveLoad", "spool"): {
        "pressure": '"160 bar"',
        "states": '{return = {front = "8.2 cm^2"}, power = {front = "8.2 cm^2", rear = "16 cm^2"}}',
    },
    ("PlainValveLoad", "spool"): {
        "chambers": '{front = {area = 0.4, side = "front"}, rear = {area = 2.2, side = "rear"}}',
        "states": '{return = {front = "supply"}, power = {front = "supply", rear = "supply"}}',
    },
    **{(table, "area"): {"drop": None, "at": None} for table in ("OrificeTable", "PassageTable", "WaysTable")},
    **{
        (table, "discharge"): {"drop": None, "at": None, "area": '"1 cm^2"'}
        for table in ("OrificeTable", "PassageTable", "WaysTable")
    },
    **{
        ("ChamberTable", key): {"force": '"9 kN"', "area": '"60 cm^2"', "volume": '"3.7 l"', "exponent": "1.3"}
        for key in ("area", "volume", "exponent")
    },
    ("JointTable", "stiffness"): {"kind": '"elastic"', "mass": None},
    ("JointTable", "damping"): {"kind": '"elastic"', "mass": None, "stiffness": '"1 N/m"'},
    ("JointTable", "slack"): {"kind": '"contact"', "mass": None},
    ("RockTable", "blows_per_crater"): {"crater": '"same"'},
    ("DrillingTable", "specific_energy"): {"crater_factor": None},
    ("ToolSteelTable", "fatigue_limit"): {"ultimate": '"2 GPa"'},
    ("StartTable", "modal_displacement"): {"modal_velocity": "[0.1]"},
    ("StartTable", "modal_velocity"): {"modal_displacement": "[-1.0]"},
    ("StartTable", "periods"): {"orbit": "1"},
    ("StartTable", "seed"): {"random": '"rigid"'},
}
"""What a case needs, or must not have, beside a key."""

UNITS = {
    "length": "mm",
    "area": "mm^2",
    "pressure": "GPa",
    "density": "kg/m^3",
    "frequency": "Hz",
    "damping": "N*s/m^2",
    "mass": "kg",
    "stiffness": "N/m",
    "dashpot": "N*s/m",
    "time": "ms",
    "velocity": "m/s",
    "force": "kN",
    "force or pressure": "kN",
    "flow": "l/min",
    "compliance": "cm^3/bar",
    "attenuation": "1/m",
    "specific energy": "MJ/m^3",
    "volume": "l",
    "power": "kW",
}


JOINED = '{return = {front = "supply", rear = "tank"}, power = {front = "supply", rear = "supply"}}'
OIL_LOAD = {
    "chambers": '{front = {area = "8.2 cm^2", side = "front"}, rear = {area = "16 cm^2", side = "rear"}}',
    "supply": '{flow = "133 l/min", accumulator = "2.5 cm^3/bar"}',
}
PASSAGE = {"chamber": '"rear"', "to": '"tank"', "drop": '"5 bar"', "at": '"100 l/min"'}
FED = {"load.supply": {"flow": '"133 l/min"', "accumulator": '"2.5 cm^3/bar"'}}
OIL = {
    "OilChamberTable": {
        "load.chambers.front": {"area": '"8.2 cm^2"', "side": '"front"'},
        "load.chambers.rear": {"area": '"16 cm^2"', "side": '"rear"'},
    },
    "OrificeTable": {"load.orifices": PASSAGE},
    "PassageTable": {"load.orifices": PASSAGE, "load.orifices.in": {"drop": '"4 bar"', "at": '"100 l/min"'}},
    "OilTable": {"load.orifices": {"chamber": '"rear"', "to": '"tank"', "area": '"1 cm^2"'}, "load.oil": {}},
    "FlowAtTable": {**FED, "load.supply.leakage": {"flow": '"8 l/min"', "at": '"160 bar"'}},
    "ReliefTable": {
        **FED, "load.supply.relief": {"opens": '"200 bar"', "flow": '"20 l/min"', "over": '"10 bar"'}
    },
    "GasAccumulatorTable": {
        "load.supply": {"flow": '"133 l/min"'},
        "load.supply.accumulator": {"precharge": '"80 bar"', "volume": '"0.4 l"'},
    },
}  # fmt: skip
"""The tables of oil that flows, the one that is looked at last."""


def case_with(table: str, key: str, value: str | None) -> Case:
    form, name = TABLES[table]
    tables = {part: dict(keys) for part, keys in CASES[form].items()}
    if table in LOADS:
        tables["load"] = dict(LOADS[table])
    if table == "SectionTable":
        tables |= {"bar": {}, name: dict(SECTION)}
    if table == "ToolSectionTable":
        tables |= {"tool": {"end": '"free"'}, name: dict(SECTION)}
    elif name in STRUCK[form]:
        tables |= {part: dict(keys) for part, keys in STRUCK[form].items()}
    if table == "JointTable":
        tables["tool"] = {"sections": '[{length = "1 m", diameter = "38 mm"}, {length = "1 m", diameter = "38 mm"}]'}
        tables |= {"rock": dict(STRUCK[form]["rock"]), name: {"at": "1", "mass": '"1 kg"'}}
    if table == "BodyTable":
        tables = {name: dict(BODY), **{part: tables[part] for part in ("load", "contact")}}
    if name.startswith("load."):
        tables["load"] = {part: held for part, held in VALVE.items() if part != name.removeprefix("load.")}
    if table == "PortTable":
        tables[name] = {"behind": '"0.5 mm"', "side": '"back"', "to": '"power"'}
    if table == "WaysTable":
        tables["load"] = {"kind": '"history"', "file": '"line.csv"', "area": '"4 cm^2"'}
        tables[name] = {"drop": '"5 bar"', "at": '"100 l/min"'}
    if table == "AreasTable":
        tables["load"] |= {"pressure": '"160 bar"'}
        tables["load.states"] = {"power": '"9 kN"'}
        name = "load.states.return"
    if table in OIL:
        tables["load"] |= {"pressure": '"160 bar"', "states": JOINED, **OIL_LOAD}
        tables["load"] = {part: held for part, held in tables["load"].items() if part != name.split(".")[1]}
        for place, content in OIL[table].items():
            tables[place] = dict(content)
        name = list(OIL[table])[-1]
    if table == "SupplyTable":
        areas = '{return = {front = "8.2 cm^2"}, power = {front = "8.2 cm^2", rear = "16 cm^2"}}'
        tables["load"] |= {"pressure": '"160 bar"', "states": areas}
    keys = tables.setdefault(name, {})
    keys |= {**BESIDE.get((table, key), {}), key: value}
    lines = []
    for part, content in tables.items():
        lines += [
            f"[[{part}]]" if part.endswith((".sections", ".ports", ".joints", ".orifices")) else f"[{part}]",
            *(f"{k} = {v}" for k, v in content.items() if v is not None),
        ]
    return Case.from_text("\n".join(lines))


def computed(table: str, case: Case) -> object:
    """What the tables of a case come to, in a form that can be compared."""
    if table not in ("StartTable", "SimulationTable"):
        moved = case.machine() if case.is_machine else (case.system(), case.timed_law())
        return moved, case.room(), None if case.tables.body is not None else case.blow_question()
    simulation = case.simulation()
    motion = run(case.system(), case.start(4), modes=4, stop=Stop(impacts=5))
    return simulation, motion.begin_time, [(event.time, event.impact_velocity) for event in motion.events]


STATED = [
    (table, key, columns[1].strip("`"))
    for table in TABLES
    for key, columns in (rows(table).items() if "History" not in table else ())
    if re.match(r"^`?[-−]?[\d.]|steady|.*`\"|true", columns[1])
]


@pytest.mark.parametrize(("table", "key", "stated"), STATED)
def test_what_holds_without_a_key_is_what_the_reference_says(table, key, stated):
    value = re.sub(r"^steel, `?|`|,.*", "", stated.replace("−", "-"))
    value = f"[{value}]" if key.startswith("modal") else value
    assert computed(table, case_with(table, key, value)) == computed(table, case_with(table, key, None))


def limits(text: str) -> tuple[list[float], list[float]]:
    """Numbers that a range in words allows and refuses, at its ends."""
    number = r"([\d.e+-]+)"
    small = 1e-6
    if found := re.search(rf"between {number} and {number}", text):
        low, high = map(float, found.groups())
        return [low + small, high - small], [low, high]
    if found := re.search(rf", {number} to {number}", text):
        low, high = map(float, found.groups())
        whole = "whole" in text
        step = 1.0 if whole else small * low or small
        return [low, high], [low - step, high * (1 + small) + whole]
    if found := re.search(rf"greater than {number}", text):
        return [1.0], [float(found[1]), -1.0]
    if found := re.search(rf", {number} or greater", text):
        return [float(found[1])], [float(found[1]) - 1.0]
    if re.search(r"0 \(on the wall\) or less", text):
        return [0.0, -1.0], [small]
    return [], []


RANGES = [
    (table, key, columns[0])
    for table in TABLES
    for key, columns in (rows(table).items() if "History" not in table else ())
    if limits(columns[0])[1] and "pairs" not in columns[0]
]


@pytest.mark.parametrize(("table", "key", "said"), RANGES)
def test_the_allowed_range_is_what_the_reference_says(table, key, said):
    def text(value: float) -> str:
        plain = str(int(value)) if said.startswith("whole") else repr(value)
        unit = UNITS.get(said.partition(",")[0])
        return f'"{plain} {unit}"' if unit else plain

    good, bad = limits(said)
    for value in good:
        case_with(table, key, text(value))
    for value in bad:
        with pytest.raises(CaseError) as caught:
            case_with(table, key, text(value))
        assert key in caught.value.key, caught.value


@pytest.mark.parametrize("table", [table for table in TABLES if "History" not in table])
def test_a_misspelt_key_is_told_with_the_right_one(table):
    for key in rows(table):
        if len(key) > 4:
            with pytest.raises(CaseError, match=f"did you mean '{key}'"):
                case_with(table, f"{key}{key[-1]}", "1")


# -- JSON --


ANSWERS = {
    "machine": (
        "machine valve-breaker --modes 1",
        "machine stalling.toml",
        "machine fed.toml --modes 0",
        "machine valve-drifter --modes 0",
        "machine oil-breaker --modes 0",
    ),
    "machine --blow": ("machine switching.toml --modes 1", "machine line.toml --modes 0"),
    "steady": (
        "steady hydraulic-drifter --periods 1..9 --starts 4",
        "steady square.toml",
        "steady tau.toml",
        "steady pneumatic-jackleg --reach-of load_factor --modes 0",
    ),
    "compare": ("compare mini-breaker valve-breaker --modes 0 --set pressure=150bar",),
    "tolerance": ("tolerance valve-breaker --modes 0 --samples 64",),
    "identify": ("identify valve-breaker --blows blows.csv --modes 0 --given bar.length=±1%",),
    "design": ("design valve-drifter --vary ports[0].behind=20:24mm --want blow_rate=1..90Hz --modes 0 --hammers 20",),
    "blow": (
        "blow laboratory-striker --fatigue",
        "blow struck.toml",
        "blow craters.toml",
        "blow laboratory-striker --gauge 0.6m --measured gauge.csv",
    ),
    "blow --best": ("blow laboratory-striker --best efficiency --vary length=100:300mm --blows 20",),
    "simulate": ("simulate hydraulic-drifter --events last:3",),
    "simulate --contact waves": (
        "simulate hydraulic-drifter --contact waves --cells 16 --impacts 3 --full",
        "simulate heavy-drifter --contact waves --cells 16 --events last:3",
    ),
    "sweep": (
        "sweep hydraulic-drifter --x restitution=0:0.8:3 --y load_factor=0.1:1:3 --curves -o map.zarr --workers 1",
    ),
    "orbits": (
        "orbits pneumatic-jackleg --label 2/1 --modes 0 --tries 40",
        "orbits laboratory-striker --label chatter/1 --modes 0",
        "orbits valve-breaker --label 1/1 --modes 0 --tries 4 --motions 0",
    ),
    "follow": (
        "follow pneumatic-jackleg --orbit 1/1:2 --along load_factor=0.28:0.9 --modes 0 --switch 1"
        " --curve flip --over restitution=0.145:0.155",
        "follow laboratory-striker --orbit chatter/1 --along load_factor=0.54:0.61 --modes 0"
        " --curve onset --over restitution=0.33:0.36",
        "follow pneumatic-jackleg --orbit 1/1 --along load_factor=0.40:0.41 --modes 0",
    ),
    "simulate --contact waves valve": ("simulate valve-breaker --contact waves --cells 16 --impacts 4",),
    "identify --energy": ("identify valve-drifter --pressure 175bar --rate 68Hz --energy 277J --flow 2.05e-3m^3/s",),
    "diagram": (
        "diagram pneumatic-jackleg --along load_factor=0.35:0.45:3 --label 1/1 --searched 1 --switch 0 --starts 1 "
        "--runs 0 --modes 0 --workers 1",
    ),
    "experiment": (
        "experiment hydraulic-drifter --starts 8 --modes 0 --workers 1",
        "experiment valve-drifter --starts 4 --modes 0 --workers 1",
    ),
    "basins": (
        "basins hydraulic-drifter --x time=0:6:2 --y velocity=-6:-1:2 --modes 0 --workers 1",
        "basins valve-drifter --x position=-20:-5mm:2 --y velocity=-6:-1:2 --at state=power --modes 0 --workers 1",
    ),
    "show": ("show map.zarr",),
}
"""For each command that prints JSON questions whose answers have every key that there can be."""

OIL_PARTS = (
    "machine.supply.relief", "machine.supply.gas", "machine.oil", "machine.oil.chambers[]", "machine.oil.joins[][][]"
)  # fmt: skip
"""Objects of oil that flows alone."""

FREE = {
    "at",
    "dropped",
    "sources",
    "sessions[].versions",
    "ask",
    "best_case",
    "machine.states",
    "losses",
    "oil.losses",
    "oil.loss_energies",
    "oil.chambers",
    "uncertainty.figures[].shares",
}
"""Objects whose keys are names of axes, packages and whatever the question holds."""

VALVE_SWITCHED = (
    'kind = "valve"\nstates = {return = %s, power = 1.8}\nports = [{behind = 1.0, side = "back", to = "power"}%s]'
)
TEXTS = {
    # strikes as its load jumps: κ(2 − κ)(1 + R) = 2(κ − 1)(1 − R), theory §6
    "square": plain_case("d = 0.0", kind=f'kind = "square"\namplitude = 1.0\nkappa = {2.0**0.5!r}', restitution=0.0),
    # a clock does not keep it going, a valve does
    "switching": si_case(kind='kind = "square"\namplitude = "5 kN"\nkappa = 1.2\nfrequency = "60 Hz"'),
    "tau": plain_case('d = "0.0048 ± 0.001"\nlaw = "b77-tau"'),
    "fed": plain_case(
        "d = 0.0", 'supply = {flow = "0.7 ± 0.01", accumulator = 15.0}', restitution=0.2,
        kind=VALVE_SWITCHED % (-0.4, ', {to = "return", on = "impact"}'),
    ),
    "stalling": plain_case("d = 0.0", kind=VALVE_SWITCHED % (0.4, ""), restitution=0.2),
    "craters": si_case().partition("[load]")[0] + '[tool]\nsections = [{length = "1 m", diameter = "38 mm"}]\n'
    '[rock]\nstiffness = "400 kN/mm"\nunloading_ratio = 0.3\ncrater = "same"\nblows_per_crater = 2\n'
    '[blow]\nvelocity = "9 m/s"\n',
    "struck": plain_case("d = 0.0").partition("[load]")[0] + "[tool]\nimpedance = 80.0\n[blow]\nvelocity = 0.1\n",
}  # fmt: skip


def documented() -> dict[str, dict[str, set[str]]]:
    """For each command of json.md and each object in its answer, by its path, the keys."""
    text = page("json.md")
    found: dict[str, dict[str, set[str]]] = {}
    for title, body in re.findall(
        r"^## `percuss (\w+(?: --contact waves valve| --contact waves| --best| --blow| --energy)?)`\n(.*?)(?=^## |\Z)",
        text,
        re.MULTILINE | re.DOTALL,
    ):
        tables = re.findall(r"^(?:`([^`\n]+)`\n\n)?\| key \|.*\n.*\n((?:\|.*\n)+)", body, re.MULTILINE)
        found[title] = {
            re.sub(r"\[\w\]", "[]", path): {
                key for row in table.splitlines() for key in re.findall(r"`(\w+)`", row.split(" | ")[0])
            }
            for path, table in tables
        }
    return found


def objects(value: object, path: str = "") -> list[tuple[str, set[str]]]:
    """All objects of an answer with their paths; those under a free name as NAME."""
    if isinstance(value, list):
        return [found for item in value for found in objects(item, f"{path}[]")]
    if not isinstance(value, dict) or path in FREE:
        return []
    named = path in ("quantities", "columns", "figures")
    inner = [objects(item, f"{path}.{'NAME' if named else key}".lstrip(".")) for key, item in value.items()]
    return [*([] if named else [(path, set(value))]), *(found for part in inner for found in part)]


def test_every_object_of_the_json_is_documented_key_by_key(tmp_path, monkeypatch):
    """Both ways: every key of an answer is in the table of its object, every key of a table is in some answer."""
    monkeypatch.chdir(tmp_path)
    for name, text in TEXTS.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    waves = blow_answer(load_case("laboratory-striker"), gauge=0.6).waves
    assert waves is not None
    record = [(k * 1e-6, waves.incident.at(k * 1e-6) + waves.reflected.at(k * 1e-6)) for k in range(500)]
    lines = "".join(f"{time},{force}\n" for time, force in record)
    (tmp_path / "gauge.csv").write_text(f"time [s],force [N]\n{lines}", encoding="utf-8")
    line = si_case().partition("[load]")[0] + '[load]\nkind = "history"\nfile = "line.csv"\narea = "4 cm^2"\n'
    line += 'passage = {drop = "5 bar", at = "100 l/min"}\n[contact]\nrestitution = 0.2\n'
    (tmp_path / "line.toml").write_text(line, encoding="utf-8")
    lines = "".join(f"{1e-4 * i:.4f},{100.0 if i % 200 < 90 else 1.0}\n" for i in range(2000))
    (tmp_path / "line.csv").write_text(f"time [s],line [bar]\n{lines}", encoding="utf-8")
    lines = "".join(f"{0.1 * i + 1e-4 * (i % 3)},{1.4 + 0.01 * (i % 4)}\n" for i in range(40))
    (tmp_path / "blows.csv").write_text(f"time [s],rebound [m/s]\n{lines}", encoding="utf-8")
    described = documented()
    assert described.keys() == ANSWERS.keys()
    for command, questions in ANSWERS.items():
        found: dict[str, set[str]] = {}
        for question in questions:
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                cells.command(f"percuss {question} --json")
            for path, keys in objects(json.loads(out.getvalue())):
                path = re.sub(r"(\.other_side)+$", "", path)
                if path == "switched[]":
                    assert keys == {"label", "points", "branch"}
                    continue
                path = path.removeprefix("switched[].")
                found.setdefault(path, set()).update(keys)
        wanted = described[command]
        if command.startswith("simulate") and not command.endswith(
            "valve"
        ):  # these are the same as in the answer of steady
            wanted = {
                **wanted,
                **{path: described["steady"][path] for path in ("system", "body", "contact", "history")},
            }
            if "orbit" in found:  # that is told as in a list of orbits
                told = described["orbits"].items()
                others = {"release_phase", "rest_phase", "period", "ports", "pressure", "time"}  # of other hammers
                own = {path.replace("orbits[]", "orbit"): keys - others for path, keys in told if path}
                wanted |= {path: keys for path, keys in own.items() if not path.endswith("ports[]")}
        if command == "machine --blow":  # the answer of machine for one that runs, and more
            wanted = {
                **described["machine"],
                **wanted,
                "": (described["machine"][""] | wanted[""]) - {"transfer", "uncertainty", "oil"},
            }
            for path in ("failed_condition", "supply", "machine.supply", "oil", "oil.si", *OIL_PARTS):
                del wanted[path]
            none = ("transfer", "uncertainty")  # it has no tool, and no number within ±
            wanted = {path: keys - set(none) for path, keys in wanted.items() if not path.startswith(none)}
        assert found == wanted, command


def test_every_command_that_prints_json_is_in_json_md():
    printing = {name for name in COMMANDS if "--json" in help_of(name)}
    assert printing - {"machines"} == {title.partition(" ")[0] for title in documented()}


def test_keys_are_printed_as_the_reference_has_them(capsys):
    """Every table that a page shows has a name, and every key of it is told with its values and its meaning."""
    from percuss.case.file_format.key_tables import TABLES, rows_of
    from percuss.cli import main

    shown = set(re.findall(r"<!-- percuss: keys (\w+) -->", (DOCS / "case-file.md").read_text(encoding="utf-8")))
    assert shown == {table.__name__ for table in TABLES.values()}
    assert main(["keys"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed] == list(TABLES) and all(len(line.split()) > 2 for line in listed)
    for name, table in TABLES.items():
        assert main(["keys", f"[{name}]"]) == 0
        out = " ".join(capsys.readouterr().out.split())
        for row in rows_of(table):
            assert f"{row.key} = " in out
            assert " ".join(re.sub(r"[`*$]", "", row.meaning).split()) in out
            assert f"| `{row.key}` | {row.value} |" in reference.keys(table.__name__)
    assert main(["keys", "tol"]) == 2
    assert "one of bar, " in capsys.readouterr().err
