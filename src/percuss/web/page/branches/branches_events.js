// What happens on the branches, each with its sentence and a way there; and the orbits that a search has found.

import { h, put } from "../core/dom.js";
import { angle, number, withUnit } from "../core/format.js";
import { EVENTS } from "./branches_picture.js";
import { switchesItself } from "../core/state.js";

/** The table of what happens on the branches that were followed, and on request on the others; `go` leads to a point. */
export function eventTable(card, { followed, others }, axis, go) {
  if (!followed.length && !others.length) return put(card);
  const open = card.querySelector("details")?.open;
  const main = followed.length ? [h("h2", {}, "What happens on the way"), events(followed, 0, axis, go)] : [];
  put(card, main, others.length ? more(others, followed.length, axis, go, open) : "");
}

/** The table of the others, which is made when it is opened: there can be hundreds of rows. */
function more(others, first, axis, go, open) {
  const many = others.reduce((total, { points }) => total + points.length, 0);
  const box = h("details", { id: "branches-more", open }, h("summary", {}, `What happens on the other ${others.length === 1 ? "branch" : `${others.length} branches`}: ${many} points`));
  const fill = () => box.open && box.children.length === 1 && box.append(events(others, first, axis, go));
  box.addEventListener("toggle", fill);
  return box;
}

function events(branches, first, { label, unit, name }, go) {
  const rows = branches.flatMap((branch, i) =>
    branch.points.map((point) => {
      const words = EVENTS[point.type]?.words ?? point.type;
      const place = withUnit(point.value, unit, 7);
      const open = { type: "button", "aria-label": `Go to ${words} of ${branch.label} at ${place}`, onclick: () => go(first + i, point) };
      const cells = [h("button", open, place), branch.label, words, sentence(point.beyond, name, label)];
      return h("tr", { "data-event": point.type }, cells.map((cell) => h("td", {}, cell)));
    }),
  );
  return table([label, "Motion", "Event", "Beyond it"], rows);
}

/** The server's sentence with the parameter as the page calls it. */
const sentence = (text, name, label) => text.replaceAll(`${name} =`, `${label} =`).replaceAll(`smaller ${name}`, `smaller ${label}`).replaceAll(`greater ${name}`, `greater ${label}`);

const table = (heads, rows) =>
  h("table", {}, h("thead", {}, h("tr", {}, heads.map((head) => h("th", { scope: "col" }, head)))), h("tbody", {}, rows));

/** The orbits of a label; `begin` is told which is to be followed. */
export function orbitList(card, found, begin) {
  const label = found.label.replace("z=", "");
  const rest = found.label === label; // chatter/n or rest/n
  const few = (list) => list.slice(0, 4).join(", ") + (list.length > 4 ? ", …" : "");
  const rows = found.orbits.map((orbit, i) => {
    const name = `${label}:${i + 1}`;
    const cells = [
      h("button", { type: "button", "aria-label": `Follow ${found.label}, number ${i + 1}`, onclick: () => begin(name) }, "Follow"),
      few(orbit.impacts.map(({ phase, time }) => (phase === undefined || orbit.impacts.length > 1 ? number(phase ?? time) : angle(phase)))),
      few(orbit.impacts.map(({ speed }) => number(speed))),
      ...(rest ? [number(orbit.rest_phase), number(orbit.release_phase)] : []),
      orbit.stable ? "stable" : "unstable",
    ];
    return h("tr", {}, cells.map((cell) => h("td", {}, cell)));
  });
  const missing = found.complete ? "These are all." : `${found.tries} tries; the share that a search of this size may miss: ${number(100 * found.unseen, 2)} %, at most ${number(100 * found.unseen_bound, 2)} %.`;
  put(
    card,
    h("h2", {}, `Motions ${found.label}`),
    rows.length ? table(["", switchesItself() ? "Blows in the cycle" : "Impact phases [rad]", switchesItself() ? "Striking speeds" : "Striking speeds, dimensionless", ...(rest ? ["At rest from [rad]", "Let go at [rad]"] : []), "Verdict"], rows) : h("p", {}, "None was found."),
    h("p", { class: "small muted" }, missing),
  );
}
