"""``percuss machines``: the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from percuss.cli.arguments import Parser

_DESCRIPTION = """\
The catalogue of sample cases: hammers, with sizes and figures of public data sheets and synthetic force histories, and
structures that strike a stop."""

_EXAMPLES = """\
  percuss machines
  percuss steady mini-breaker
  percuss machine valve-breaker
  percuss new mini-breaker -o breaker.toml"""


def run(arguments: Sequence[str]) -> int:
    """List the machines; returns the exit code."""
    parser = Parser("machines", _DESCRIPTION, _EXAMPLES)
    parser.add_argument("--json", action="store_true", help="print the list as JSON (kg, Hz, J)")
    options = parser.parsed(arguments)

    from percuss.case.answers.numerals import quantity
    from percuss.case.catalogue.sample_cases import MACHINES, STRUCTURES

    if options.json:
        import json

        none = dict.fromkeys(("mass", "blow_rate", "blow_energy"))
        rows = [asdict(machine) | {"structure": False} for machine in MACHINES]
        rows += [asdict(one) | none | {"valve": False, "structure": True} for one in STRUCTURES]
        print(json.dumps(rows, indent=1))
        return 0
    print(f"{'machine':<20}{'mass':>9}{'blow rate':>11}{'blow energy':>13}   what it is")
    for m in MACHINES:
        figures = f"{f'{m.mass:g} kg':>9}{f'{m.blow_rate:g} Hz':>11}{quantity(m.blow_energy, 'J', 3):>13}"
        started = f"; a simulation from rest ends in {m.from_rest}" if m.from_rest else ""
        print(f"{m.name:<20}{figures}   {m.title}{started}")
    for structure in STRUCTURES:
        print(f"{structure.name:<53}   {structure.title}")
    print("\nRun one with 'percuss steady MACHINE', start from one with 'percuss new MACHINE -o FILE'.")
    valves = ", ".join(f"'percuss machine {m.name}'" for m in MACHINES if m.valve)
    print(f"Those that switch their own valve have a command of their own: {valves}.")
    return 0
