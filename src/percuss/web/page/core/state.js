// What the page knows, in signals, and the questions that go to the server when the case changes.
// `view` is all that the address bar holds; `data` is what the server answered.

import { get, post, postBinary, problemsOf } from "./api.js";
import { afterFrame, latest, settled } from "./dom.js";
import { quantity } from "./format.js";
import { heldAt, inOwnUnit, present, unitOf, valueAt, withKey } from "./moves.js";
import { store } from "./signals.js";

/** @typedef {import("./moves.js").Tables} Tables */

/** @type {Record<string, any>} */
export const DEFAULTS = {
  panel: "", // the drawer that is open; none
  embed: 0, // 1: within another page, without what leads away
  lock: "", // parameters that stay as they are, of a link for a class
  tall: 0, // 1: the drawer is over all but the verdict
  machine: "",
  m: 1,
  orbit: 0, // 0: the one to look at first
};

export const view = store(DEFAULTS);

/** `tables`: the case as it is now; `base`: the machine that it was made from. */
export const data = store(
  /** @type {Record<string, any>} */ ({
    about: null,
    machines: [],
    structures: [],
    base: null,
    tables: null,
    physical: null, // the tables in SI, kept while the dimensionless form is shown
    info: null,
    quick: null,
    steady: null,
    machine: null, // of a case whose load the piston switches: its cycle, instead of quick and steady
    played: null, // the motion that plays: {motion: {label, summary}, change}
    problems: [],
    begin: { count: 0, state: null }, // counts the scenes of lessons; where the hammer begins, where it is not on its motion
    label: "", // the name of the motion that goes on, as the stage has it
    blows: [], // the speeds of its last blows under the present law
    experiment: null, // the last one that was followed to its end: {starts}
    blow: null, // the last blow that was followed by waves: {changed, contacts}
    ghost: null, // the motion at the point of the map that is looked at: {model, orbit}
    pinned: null, // the design that is kept as A: {tables, label, at, model, figures}
    changed: 0, // counts the changes of the case, so that late answers are known
    moved: null, // parameters of the last change when it was a move, else null
    moving: {}, // parameters on their way to the server: {name: number}
    placed: {}, // parameters moved since the case was last told in full
  }),
);

/** @param {Record<string, any>} changes */
export function show(changes) {
  Object.assign(view, changes);
  if ("m" in changes) changedCase(null);
  else if (data.quick && !enough(data.quick)) askQuick();
}

/** A painter of words, which waits while a slider is dragged, though not long; the last answer is always told. @param {() => void} paint */
export function unhurried(paint) {
  let last = 0;
  return afterFrame(() => {
    const now = performance.now();
    if (Object.keys(data.moving).length && now - last < 150) return;
    last = now;
    paint();
  });
}

/** Whether the tables are those of the last move, and not of one before it. */
export const uptodate = () => data.quick?.changed === data.changed;

/** Whether the piston switches the load of the case: it has a cycle of its own, and no steady motions of a clocked load. */
export const switchesItself = () => data.tables?.load?.kind === "valve";

/** Whether the case is a structure that something holds, in place of a free bar: it has no rigid motion. */
export const isHeld = () => Boolean(data.tables?.body);

/** What moves, in a sentence. */
export const mover = () => (isHeld() ? "structure" : "bar");

/** A number of its modes, in words. */
export const modesInWords = (/** @type {number} */ n) => (isHeld() ? `${n} modes at most` : `${n} elastic modes`);

/** The name of a file of the case, without its ending. */
export const fileName = () =>
  (data.tables?.title || "case")
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, "-")
    .replace(/^-+|-+$/g, "") || "case";

/** The case of a request. */
export const asked = () => ({ case: data.tables, periods: view.m });

/** @typedef {{ curve: number, multipliers: boolean }} Needs */

/** @type {Record<string, Needs>} */
const NEEDS = {};

/** The panels that there are: what each keeps in the address, and what it needs of the answer to a slider.
 * @param {{ name: string, defaults?: Record<string, any>, needs?: Needs }[]} panels */
export function know(panels) {
  for (const { name, defaults, needs: own } of panels) {
    Object.assign(DEFAULTS, defaults);
    if (own) NEEDS[name] = own;
  }
  Object.assign(view, DEFAULTS);
}

// What the panel in sight needs of an answer; a slider's answer has nothing else in it.
const needs = () => NEEDS[view.panel] ?? { curve: 121, multipliers: false };
const enough = (/** @type {Record<string, any>} */ quick) =>
  quick.asked.curve >= needs().curve && quick.asked.multipliers >= needs().multipliers;

let epoch = 0; // counts the cases that were set whole: a late answer to a move of the one before is dropped

/** A question about the case as it was at a change. @typedef {{ tables?: any, m?: number, count: number, epoch?: number }} Asked */

const askQuick = latest(
  async (/** @type {void} */ _) => {
    const sent = { ...data.moving };
    const values = Object.keys(sent).length ? sent : null;
    const wish = needs();
    const question = { count: data.changed, epoch, sent };
    const answer = await post("quick", { ...asked(), values, ...wish }).catch((/** @type {any} */ error) => {
      throw Object.assign(error, { question });
    });
    return { answer: Object.assign(answer, { changed: question.count, asked: wish }), question };
  },
  ({ answer, question }) => {
    if (question.epoch !== epoch) return;
    for (const [name, value] of Object.entries(question.sent))
      if (data.moving[name] === value) delete data.moving[name];
    if (answer.tables) data.tables = answer.tables;
    data.quick = answer;
    data.problems = [];
    if (!enough(answer)) askQuick(); // the panel has changed meanwhile
    refresh({ tables: data.tables, m: view.m, count: question.count });
  },
  (error) => {
    data.moving = {};
    data.placed = {};
    refused(error, error.question ?? { count: data.changed });
  },
);

/** Milliseconds without a move after which the whole answer is asked for: it would be in the way of the next move. */
export const REST = 220;

const refresh = settled((/** @type {Asked} */ question) => {
  if (question.count !== data.changed) return; // a move is on its way: its answer comes back here
  askInfo(question);
  if (!switchesItself()) return askSteady(question);
  askElastic(question);
}, REST);

const askInfo = latest(
  (/** @type {Asked} */ { tables }) => post("case", { case: tables }),
  (info, { count }) => {
    if (count !== data.changed) return;
    data.info = info;
    data.placed = { ...data.moving };
  },
  refused,
);

const askSteady = latest(
  (/** @type {Asked} */ { tables, m }) => post("steady", { case: tables, periods: [m] }),
  (steady, { count }) => {
    if (count === data.changed) data.steady = Object.assign(steady, { changed: count });
  },
  refused,
);

/** The cycle of a rigid piston, which is there at once; what takes longer comes when nothing moves. */
const askMachine = latest(
  (/** @type {Asked} */ { tables }) => postBinary("machine", { case: tables, modes: 0, points: 241, whole: false }),
  (machine, question) => {
    if (question.epoch !== epoch) return;
    takeMachine(machine, question.count);
    refresh(question);
  },
  refused,
);

const askElastic = latest(
  (/** @type {Asked} */ { tables }) => postBinary("machine", { case: tables, whole: false }),
  (machine, question) => {
    if (question.count !== data.changed) return;
    takeMachine(machine, question.count);
    asking = new AbortController();
    askMore({ ...question, signal: asking.signal });
  },
  refused,
);

let asking = new AbortController(); // of the question that takes seconds

/** Margins, what changes the figures, and the curve over the pressure, with elastic modes. */
const askMore = latest(
  (/** @type {Asked & { signal: AbortSignal }} */ { tables, signal }) =>
    postBinary("machine", { case: tables, points: 2 }, signal, "margins"), // the figures wait for none of it
  ({ answer }, { count }) => {
    if (count !== data.changed || !data.machine) return;
    data.machine = { ...data.machine, more: answer };
  },
  () => {}, // the cycle is there without it
);

/** @param {Record<string, any>} machine @param {number} count */
function takeMachine(machine, count) {
  const before = data.machine?.changed === count ? data.machine : null;
  data.machine = Object.assign(machine, { changed: count, more: before?.more ?? null });
  data.problems = [];
}

/** @param {any} error @param {Asked} question */
function refused(error, question) {
  if (question.count !== data.changed) return;
  data.problems = problemsOf(error);
  data.quick = data.steady = data.machine = null;
}

/** @param {string[] | null} names */
function changedCase(names) {
  if (!data.tables) return;
  data.changed += 1;
  data.moved = names;
  asking.abort();
  const own = switchesItself();
  if (own) data.quick = null;
  else data.machine = null;
  if (own) askMachine({ tables: data.tables, count: data.changed, epoch });
  else askQuick();
}

let wishes = 0;

/** A case is wanted that the server has to be asked for; tells later whether none was wanted, or set, since. */
export function wish() {
  const mine = ++wishes;
  return () => mine === wishes;
}

const kindOf = (/** @type {Tables} */ tables) => `${Boolean(tables?.body)} ${tables?.load?.kind === "valve"}`;

/** Another case altogether, with what the server has told of it, or one edited by hand. Nothing stays of a case of another
 * kind: what is told of a structure is not what is told of a bar.
 * @param {Tables} tables @param {Record<string, any> | null} [info] */
export function setTables(tables, info = data.info) {
  wishes += 1;
  epoch += 1;
  if (kindOf(tables) !== kindOf(data.tables)) Object.assign(data, { quick: null, steady: null, machine: null });
  Object.assign(data, { tables, info, moving: {}, placed: {} });
  changedCase(null);
}

/** What all parameters stand at: {name: number}. */
export const presentValues = () =>
  Object.fromEntries(
    (data.info?.parameters ?? []).map((/** @type {{ name: string }} */ { name }) => [
      name,
      name === "m" ? view.m : present(data, name),
    ]),
  );

/** Whether a parameter is locked. */
export const locked = (/** @type {string} */ name) =>
  view.lock
    .split(",")
    .some((/** @type {string} */ one) => one === name || (one === "R" && /^(contact\.)?restitution$/.test(name)));

/** The case with another start of its simulation; without any where nothing of it is said. @param {Record<string, any>} start */
export function setStart(start) {
  const clean = Object.fromEntries(Object.entries(start).filter(([, value]) => value !== undefined));
  const { start: _, ...rest } = data.tables;
  setTables(Object.keys(clean).length ? { ...rest, start: clean } : rest);
}

/** The same case with a value that is being dragged: answers that come meanwhile are shown. `names`: the keys that are
 * other ones, where the map may stay as it is.
 * @param {Tables} tables @param {string[] | null} [names] */
export function drag(tables, names = null) {
  wishes += 1;
  data.tables = tables;
  changedCase(names);
}

/** A key set by hand, in the unit that it has had so far. @param {string} key @param {any} value */
export function setKey(key, value) {
  const before = [data.base, data.tables]
    .map((tables) => valueAt(tables ?? {}, key))
    .find((one) => typeof one === "string" && quantity(one)?.unit);
  setTables(withKey(data.tables, key, inOwnUnit(value, before)));
}

/** Parameters moved by a slider or on the map: {name: number}, in the units that the server lists them in. A key whose
 * unit is another one since gets that unit back, for the server takes the number in the unit of the tables. @param {Record<string, number>} given */
export function move(given) {
  const values = Object.fromEntries(Object.entries(given).filter(([name]) => !locked(name)));
  for (const { name, unit, value, dimensionless } of data.info?.parameters ?? [])
    if (name in values && !dimensionless && ![undefined, unit].includes(unitOf(data.tables, name)))
      data.tables = withKey(data.tables, heldAt(data.tables, name), unit ? `${value} ${unit}` : value);
  Object.assign(data.moving, values);
  Object.assign(data.placed, values);
  changedCase(Object.keys(values));
}

/** The machine of a name, as the case. */
export const machineTables = (/** @type {string} */ name) => get(`machines/${encodeURIComponent(name)}`);

/** @param {string} name */
export async function pickMachine(name) {
  const newest = wish();
  const found = await machineTables(name);
  if (!newest()) return;
  Object.assign(view, { machine: name, orbit: 0, xr: "", yr: "" }); // ranges are of the machine before
  Object.assign(data, { base: found.tables, physical: null });
  setTables(found.tables, found);
}

/** Why an orbit is stable or not; short until the multipliers are known. @param {Chosen} orbit */
export function reasonOf({ quick, full }) {
  return (
    quick.reason ?? full?.reason ?? (quick.stable ? "stable" : quick.fold ? "unstable, beyond the fold" : "unstable")
  );
}

/** Why an orbit is not physical, as what the striking end does; "" for one that is, and until that is known. @param {Chosen} orbit */
export function obstacleOf({ quick, full }) {
  if (!full || full.admissible) return "";
  return data.about.reasons[quick.impact_velocity > 0 ? "through the wall" : "no blow"];
}

/** The full answer to what the quick one tells of, once it has come. @returns {Record<string, any> | null} */
export const fullAnswer = () => (data.steady?.changed === data.quick?.changed ? data.steady : null);

/** That of its orbits. @returns {Record<string, any>[]} */
export function fullOrbits() {
  const found = fullAnswer()?.periods[0]?.orbits ?? [];
  return found.length === data.quick?.orbits.length ? found : [];
}

/** The orbit that is looked at: number k from 1, its quick answer and, when it has come, its full answer.
 * @typedef {{ quick: Record<string, any>, full?: Record<string, any> | null }} Chosen
 * @returns {Chosen & { number: number } | null} */
export function chosen() {
  const orbits = data.quick?.orbits ?? [];
  if (!orbits.length) return null;
  const full = fullOrbits();
  let index = view.orbit >= 1 && view.orbit <= orbits.length ? view.orbit - 1 : -1;
  if (index < 0) {
    const rank = orbits.map(
      (/** @type {Record<string, any>} */ orbit, /** @type {number} */ i) =>
        (orbit.stable ? 2 : 0) + (full[i] ? Number(full[i].admissible) : 1) * 3 + i * 0.01,
    );
    index = rank.indexOf(Math.max(...rank));
  }
  return { number: index + 1, quick: orbits[index], full: full[index] };
}
