"""The answer to "what do blows that follow each other do?", each beginning with the waves of those before it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from percuss.case.answers.blows.blow_answer import own_speed
from percuss.case.answers.blows.drilling_answer import warned
from percuss.case.answers.facts import (
    BAD,
    GOOD,
    PLAIN,
    Fact,
    Grid,
    Report,
    ReportSection,
    Teller,
    counted,
    figures,
    grid_of,
    number,
    percent,
    plain,
    plain_of,
    quantity,
    rows_of,
)
from percuss.case.case import checked_case
from percuss.errors import CaseError, extra_package
from percuss.model.body import SizedBody
from percuss.model.checks import callback, count, positive
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.blow import Drilling, Rod
    from percuss.blow.periods import BlowInTrain, RepeatedBlows
    from percuss.case.case import Case
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.simulate import Progress


@dataclass(frozen=True)
class RepeatedAnswer(ShortRepr):
    """Blows that follow each other, and what they come to; in SI.

    Attributes
    ----------
    name, title, notes
        The case as it was named, its title, and what was assumed, one sentence each.
    train
        The blows.
    speed
        Where the speed of the striker is from.
    drilling
        What they are worth in advance; None without a table [drilling].
    machine_force
        The feed force of the machine, where the case gives that; the tool has less.
    """

    name: str
    title: str
    train: RepeatedBlows
    speed: str
    drilling: Drilling | None = None
    machine_force: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def tell(self) -> Teller:
        """Says its values with their units."""
        return Teller(None, True)

    @property
    def rate(self) -> float:
        """Blows per second."""
        return 1.0 / self.train.period

    @property
    def feed_force(self) -> float | None:
        """F on the tool; None where nothing feeds it."""
        feed = self.train.target.feed
        return None if feed is None else feed.force

    @property
    def recoil_force(self) -> float:
        """f J over the régime: what blows push the machine back with."""
        return self.rate * self.train.mean("impulse")

    @property
    def shares(self) -> dict[str, float]:
        """Where the energy of a blow and of the feed goes over the régime, over the energy of the striker."""
        mean = self.train.mean
        before = mean("energy_before")
        change = mean("tool_energy_before") - mean("tool_energy_after") - mean("joint_energy")
        found = {
            "rock": mean("rock_work"),
            "returned": mean("returned_energy"),
            "ringing": mean("vibration_energy"),
            "recoil_damper": mean("recoil_damper_loss") - mean("recoil_spring_work"),
            "steel": mean("steel_loss"),
            "joints": mean("joint_loss"),
            "out_of_the_end": mean("energy_out"),
            "into_the_feed": -mean("feed_force_work"),
            "kept_by_the_tool": -change,
        }
        return {key: value / before for key, value in found.items()}

    @property
    def named_shares(self) -> tuple[tuple[str, float], ...]:
        """Those of `shares` that are not next to nothing, by the names that reports and pictures have."""
        told = self.shares
        return tuple((name, told[key]) for key, name in _NAMES.items() if abs(told[key]) > 5e-5)

    @property
    def advance_per_blow(self) -> float | None:
        """Of the hole over the régime, by crater factor or specific energy; None without either."""
        own, train = self.drilling, self.train
        if own is None or train.target.rock is None:
            return None
        deeper = train.mean("residual_penetration" if train.blows_per_crater == 1 else "advance")
        return own.advance(deeper, train.mean("rock_dissipated"))

    @property
    def rate_of_penetration(self) -> float | None:
        """In m/s."""
        return None if self.advance_per_blow is None else self.rate * self.advance_per_blow

    @property
    def specific_energy_rock(self) -> float | None:
        """What stays in the rock per volume drilled, J/m³."""
        return self._per_volume("rock_dissipated")

    @property
    def specific_energy_blow(self) -> float | None:
        """Energy of the striker per volume drilled, J/m³."""
        return self._per_volume("energy_before")

    def _per_volume(self, name: str) -> float | None:
        advance = self.advance_per_blow
        if self.drilling is None or advance is None or not advance > 0.0:
            return None
        return self.train.mean(name) / (self.drilling.area * advance)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        train, found = self.train, []
        if train.target.feed is None:
            found.append("no feed force: nothing brings the tool back to the rock; describe it in [feed]")
        if not any(train.target.attenuation):
            found.append("undamped steel: what a blow leaves in the tool only rock, recoil damper and joints can take")
        if train.regime.kind == "no periodic régime" and train.blows_per_crater == 1:
            told = f"greatest penetrations scatter by {percent(train.regime.scatter)} of their mean"
            found.append(f"no periodic régime: {told}; a recoil damper or more attenuation gives one")
        found += warned(train.target.rock is None or train.stands, train.bound)
        if train.error is not None and train.error > 1e-3 and train.regime.kind != "no periodic régime":
            found.append(f"half the cells change penetrations by {percent(train.error)}: give more cells")
        return tuple(found)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, in SI, as `percuss blow --json` prints it."""
        train = self.train
        return plain(
            {
                "case": self.name,
                "title": self.title,
                "units": "SI",
                "notes": list(self.notes),
                "warnings": list(self.warnings),
                "velocity": list(train.velocity),
                "velocity_from": self.speed,
                **plain_of(self, REPEATED),
                "shares": self.shares,
                "blows": [
                    plain_of(one, IN_TRAIN)
                    | {
                        "contacts": [[c.start, c.end, c.impulse, c.peak_force] for c in one.contacts],
                        "bit_contacts": [[c.start, c.end, c.impulse, c.peak_force] for c in one.bit_contacts],
                    }
                    for one in train.blows
                ],
            }
        )


REPEATED: tuple[Fact[RepeatedAnswer], ...] = (
    Fact("number", "blows", "blows that follow each other", "", lambda one: len(one.train.blows),
         lambda one, _: f"{len(one.train.blows)}, {number(one.rate)} in a second"),
    Fact("rate", "", "of them in a second", "rate", "rate"),
    Fact("blows_per_crater", "", "after which the rock is new; 0 for never", "", "train.blows_per_crater"),
    Fact("regime", "régime", '`"fixed point"`, `"2-cycle"`, `"no periodic régime"` or `"too few blows"`', "",
         "train.regime.kind", lambda one, _: _regime(one)),
    Fact("multiplier", "", "by which the distance from a fixed point shrinks in a blow, with its sign, read from the "
         "greatest penetrations; null where it cannot be read", "", "train.regime.multiplier"),
    Fact("scatter", "", "(max − min)/mean of the greatest penetrations in the régime", "", "train.regime.scatter"),
    Fact("feed_force", "feed force", "on the tool; null without", "force", "feed_force",
         lambda one, tell: "none" if one.feed_force is None else tell(one.feed_force, "force")
         if one.machine_force is None else f"{tell(one.feed_force, 'force')} on the tool, "
         f"{tell(one.machine_force, 'force')} on the machine"),
    Fact("recoil_force", "recoil", "$f J$, with which blows push the machine back", "force", "recoil_force"),
    Fact("mean_rock_force", "mean rock force", "over the régime", "force", "train.mean_rock_force"),
    Fact("stands", "bit", "whether the bit is on the rock at every blow of the régime", "", "train.stands",
         lambda one, _: None if one.train.target.rock is None else
         "on the rock at every blow" if one.train.stands else "off the rock at a blow"),
    Fact("energy_left", "left in the tool", "departure from the static state when the next blow comes", "energy",
         lambda one: one.train.mean("energy_left"),
         lambda one, tell: tell(one.train.mean("energy_left"), "energy") + ("" if one.train.bound is None else
         f", which may change a penetration by {percent(one.train.bound)}")),
    Fact("bound", "", r"$\sqrt{E_{left}/W_{load}}$, by which that may change a penetration at most", "", "train.bound"),
    Fact("rock_dissipated", "into the rock", "what stays in the rock of a blow over the régime", "energy",
         lambda one: one.train.mean("rock_dissipated"), lambda one, tell: None if one.train.target.rock is None else
         f"{tell(one.train.mean('rock_dissipated'), 'energy')} of a blow of "
         f"{tell(one.train.mean('energy_before'), 'energy')}"),
    Fact("greatest_penetration", "penetration", "u_m, mean over the régime", "length",
         lambda one: one.train.mean("greatest_penetration")),
    Fact("advance_per_blow", "advance per blow", "of the hole in a blow; null without `[drilling]`", "length",
         "advance_per_blow"),
    Fact("rate_of_penetration", "rate of penetration", "of the hole, m/s", "speed", "rate_of_penetration",
         lambda one, _: None if one.rate_of_penetration is None else
         f"{number(60.0 * one.rate_of_penetration)} m/min"),
    Fact("specific_energy_rock", "specific energy", "what stays in the rock per volume drilled, J/m³", "",
         "specific_energy_rock", lambda one, _: None if one.specific_energy_rock is None else
         f"{number(1e-6 * one.specific_energy_rock)} MJ/m³ in the rock, "
         f"{number(1e-6 * (one.specific_energy_blow or 0.0))} MJ/m³ of the striker"),
    Fact("specific_energy_blow", "", "energy of the striker per volume drilled, J/m³", "", "specific_energy_blow"),
    Fact("tension", "tension", "the greatest in each section of the tool over the régime, N", "",
         lambda one: _worst(one, "tension"), lambda one, tell: _by_section(one, "tension", tell)),
    Fact("compression", "compression", "likewise", "", lambda one: _worst(one, "compression"),
         lambda one, tell: _by_section(one, "compression", tell)),
    Fact("openings", "joints", "of each step of the tool: how often a contact joint opened in all blows, when first, "
         "when it shut again, in s, and the widest gap in m", "", lambda one: [list(row) for row in one.train.openings],
         lambda one, _: _joints(one)),
    Fact("cells", "waves", "of each section of striker and tool on a lattice; null where waves are exact", "",
         lambda one: None if one.train.lattice is None else list(one.train.lattice.cells),
         lambda one, _: "exact but for rounding" if one.train.lattice is None else
         f"on a lattice of {one.train.lattice.cells[0]} cells in the striker's first section"
         + ("" if one.train.error is None else f"; half of them change penetrations by {percent(one.train.error)}")),
    Fact("error", "", "by which half the cells change penetrations, relative; null if not asked for, or exact", "",
         "train.error"),
)  # fmt: skip
"""What blows that follow each other come to."""


IN_TRAIN: tuple[Fact[BlowInTrain], ...] = (
    Fact("greatest_penetration", "penetration", "$u_m$ of this blow's rock", "length", "greatest_penetration"),
    Fact("advance", "deeper at rest", "penetration at rest after it, less that at its start", "length", "advance"),
    Fact("rock_work", "rock", r"$\int F\,v\,dt$", "energy", "rock_work"),
    Fact("returned_energy", "returned", r"$\frac12MV_1^2$ of the striker", "energy", "returned_energy"),
    Fact("recoil_damper_loss", "damper", r"$c_d\int v^2dt$ while it acts", "energy", "recoil_damper_loss"),
    Fact("steel_loss", "steel", "taken by attenuation; less than 0 where relaxed tension gives preload energy back",
         "energy", "steel_loss"),
    Fact("energy_left", "left", "departure from the static state when the next blow comes", "energy", "energy_left"),
    Fact("impulse", "", "of all contacts of the striker", "momentum", "impulse"),
    Fact("stands", "bit", "whether it is on the rock when the next blow comes", "", "stands",
         lambda one, _: "on" if one.stands else "off"),
    *figures(r"""
energy_before | of the striker
vibration_energy | ringing in it after the blow
mean_velocity_after | of the striker; negative: goes back
tool_energy_before | kinetic and strain energy of the tool, with the bit, without joints
tool_energy_after | the same at the end
joint_energy | its rise in springs and masses of joints
feed_work | $\int Q\,v\,dt$
feed_force_work | of the constant force
recoil_spring_work | of the recoil damper's spring
feed_impulse | $\int Q\,dt$
joint_loss | in the dashpots of joints
energy_out | through the end of an endless rod
rock_dissipated | what stays in the rock
rock_impulse | $\int F\,dt$
greatest_rock_force | the greatest F
residual_penetration | $(1-\gamma)u_m$
penetration_after | at the end
energy_error | by how much the balance does not close, over the striker's energy
"""),
)  # fmt: skip
"""What each of them is."""


def repeated_answer(
    case: Case,
    velocity: float | None = None,
    *,
    cells: int | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> RepeatedAnswer:
    """Blows that follow each other as the table [blow] of a case asks for them, with `between = "waves"`.

    Parameters
    ----------
    velocity
        Of the striker in m/s, instead of that of the case.
    cells
        Of the striker, at least, on a lattice. None: exact waves, where they have few pieces.
    progress
        Called now and then with a `percuss.simulate.Progress`; the blows end when it returns something true.

    Raises
    ------
    CaseError
        For a dimensionless case, a wall, a case without a rate of blows, one that has no speed, and a feed force of a
        machine that its blows push back.
    """
    from percuss.blow import Rod
    from percuss.blow.periods import strike_repeatedly

    checked_case(case)
    velocity = None if velocity is None else positive("velocity", velocity)
    if cells is not None:
        count("cells", cells)
    callback("progress", progress)
    question = case.blow_question()
    if not isinstance(question.striker, SizedBody) or not isinstance(question.target, Rod):
        remedy = "describe bar and tool by their sizes, in [bar] and [tool]"
        raise CaseError(case.file, "blow.between", question.between, '"static" of this case', remedy)
    if question.rate is None:
        remedy = 'for example rate = "60 Hz"'
        raise CaseError(case.file, "blow.rate", None, 'a rate of the blows beside between = "waves"', remedy)
    for key in ("until", "load"):
        if getattr(question, key):
            accepted = f'no {key} beside between = "waves"'
            raise CaseError(case.file, f"blow.{key}", None, accepted, "each blow lasts until the next one")
    speed, given = "as the case says", question.velocity
    if velocity is not None:
        speed, given = "as asked for", velocity
    elif given is None:
        speed, given = "that of the hammer's own motion just before its impact", own_speed(case)
    striker, period = question.striker, 1.0 / question.rate
    same = 1 if question.crater == "new" else question.blows_per_crater

    def struck(rod: Rod, estimate: bool) -> RepeatedBlows:
        return strike_repeatedly(
            striker, rod, given, period, question.number,
            blows_per_crater=same, cells=cells, estimate=estimate, progress=progress,
        )  # fmt: skip

    rod, force = question.target, None
    if question.feed_of == "machine" and rod.feed is not None:
        force = rod.feed.force
        rod = _fed_by_machine(case, rod, question, lambda one: struck(one, False))
    return RepeatedAnswer(case.file, case.title, struck(rod, True), speed, question.drilling, force)


_TURNS = 4
_AGREE = 1e-4  # of the machine's force


def _fed_by_machine(case: Case, rod: Rod, question: BlowQuestion, struck: Callable[[Rod], RepeatedBlows]) -> Rod:
    """The rod under F − f J(F): f dJ/dF is some hundredths, so that a few turns do."""
    assert rod.feed is not None and question.rate is not None
    whole = left = rod.feed.force
    for _ in range(_TURNS):
        recoil = question.rate * struck(replace(rod, feed=replace(rod.feed, force=left))).mean("impulse")
        before, left = left, whole - recoil
        if left <= 0.0:
            accepted = f"a force above rate × impulse, {quantity(recoil, 'N')}, with which blows push the machine back"
            raise CaseError(case.file, "feed.force", whole, accepted, "more feed, or fewer blows in a second")
        if abs(left - before) <= _AGREE * whole:
            break
    return replace(rod, feed=replace(rod.feed, force=left))


def repeated_dataset(answer: RepeatedAnswer) -> Dataset:
    """The figures of every blow, in SI, for files."""
    xarray = extra_package("xarray", "io")
    told = [plain_of(blow, IN_TRAIN) for blow in answer.train.blows]
    kinds = {fact.keys: fact.meaning for fact in IN_TRAIN}
    variables: dict[str, Any] = {
        name: ("blow", [one[name] for one in told], {"long_name": kinds.get(name, name)}) for name in told[0]
    }
    blows = list(range(1, len(told) + 1))
    made: Dataset = xarray.Dataset(variables, {"blow": ("blow", blows)}, {"title": answer.title, "units": "SI"})
    return made


# ---- The report


_SHOWN = 12  # blows that are listed one by one


def repeated_report(answer: RepeatedAnswer) -> Report:
    """The régime, where the energy goes, and the last blows."""
    train = answer.train
    rows = [("case", answer.name), ("striker", str(train.striker)), *_spoken(answer)]
    shares = tuple((name, percent(share)) for name, share in answer.named_shares)
    sections: list[ReportSection | Grid] = [
        ReportSection("Blows that follow each other", (*rows, *rows_of(answer, REPEATED, answer.tell))),
        ReportSection("Where the energy of the striker goes", shares),
    ]
    if answer.warnings:
        sections.append(ReportSection("Mind", tuple(("", text) for text in answer.warnings), BAD))
    shown = train.blows[-_SHOWN:]
    heading = f"The last {len(shown)} blows" if len(shown) < len(train.blows) else counted(len(shown), "blow")
    sections.append(grid_of(heading, shown, IN_TRAIN, answer.tell))
    settled = train.regime.kind in ("fixed point", "2-cycle")
    told = _regime(answer)
    return Report(answer.title, f"{told[0].upper()}{told[1:]}.", GOOD if settled else PLAIN, tuple(sections))


_NAMES = {
    "rock": "rock", "returned": "with the striker", "ringing": "ringing in it", "recoil_damper": "recoil damper",
    "steel": "steel", "joints": "joints", "out_of_the_end": "out of the end", "into_the_feed": "into the feed",
    "kept_by_the_tool": "kept by the tool",
}  # fmt: skip


def _spoken(answer: RepeatedAnswer) -> list[tuple[str, str]]:
    speed = answer.tell(answer.train.velocity[0], "speed")
    return [("speed", f"{speed}, {answer.speed}"), *(("note", note) for note in answer.notes)]


def _regime(answer: RepeatedAnswer) -> str:
    regime = answer.train.regime
    if regime.kind == "fixed point":
        text = "every blow is like the one before (a fixed point)"
        told = regime.multiplier
        return text if told is None else f"{text}; a disturbance is multiplied by {number(told, 3)} in each"
    if regime.kind == "2-cycle":
        return f"two kinds of blows in turn (a 2-cycle), whose penetrations differ by {percent(regime.scatter)}"
    if regime.kind == "too few blows":
        return f"{counted(len(answer.train.blows), 'blow')}: too few to see what they come to"
    return f"no periodic régime; penetrations of the later half scatter by {percent(regime.scatter)}"


def _worst(answer: RepeatedAnswer, name: str) -> list[float]:
    return [float(max(each)) for each in zip(*(getattr(one, name) for one in answer.train.settled), strict=True)]


def _by_section(answer: RepeatedAnswer, name: str, tell: Teller) -> str:
    texts = []
    for force, piece in zip(_worst(answer, name), answer.train.target.pieces, strict=True):
        texts.append(f"{tell(force, 'force')} ({tell(force / piece.area, 'stress')})")
    return ", ".join(texts)


def _joints(answer: RepeatedAnswer) -> str | None:
    opened = [
        f"step {i} opens {counted(row[0], 'time')}, by up to {quantity(row[3], 'm')}"
        for i, row in enumerate(answer.train.openings, 1)
        if row[0]
    ]
    return "; ".join(opened) or None
