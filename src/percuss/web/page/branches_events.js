// What happens on the branches, each with its sentence and a way there; and the orbits that a search has found.

import { h, put } from "./dom.js";
import { angle, number, withUnit } from "./format.js";
import { EVENTS } from "./branches_picture.js";

/** The table of what happens; `go` is told the branch and the point. */
export function eventTable(card, branches, { label, unit, name }, go) {
  const rows = branches.flatMap((branch, i) =>
    branch.points.map((point) => {
      const words = EVENTS[point.type]?.words ?? point.type;
      const place = withUnit(point.value, unit, 7);
      const open = { type: "button", "aria-label": `Go to ${words} of ${branch.label} at ${place}`, onclick: () => go(i, point) };
      const cells = [h("button", open, place), branch.label, words, sentence(point.beyond, name, label)];
      return h("tr", { "data-event": point.type }, cells.map((cell) => h("td", {}, cell)));
    }),
  );
  put(card, h("h2", {}, "What happens on the way"), table([label, "Motion", "Event", "Beyond it"], rows));
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
      few(orbit.impacts.map(({ phase }) => (orbit.impacts.length > 1 ? number(phase) : angle(phase)))),
      few(orbit.impacts.map(({ speed }) => number(speed))),
      ...(rest ? [number(orbit.rest_phase), number(orbit.release_phase)] : []),
      orbit.stable ? "stable" : "unstable",
    ];
    return h("tr", {}, cells.map((cell) => h("td", {}, cell)));
  });
  const missing = found.complete ? "These are all." : `${found.tries} tries; the share that a search of this size may miss: ${number(100 * found.unseen, 2)} %.`;
  put(
    card,
    h("h2", {}, `Motions ${found.label}`),
    rows.length ? table(["", "Impact phases [rad]", "Striking speeds, dimensionless", ...(rest ? ["At rest from [rad]", "Let go at [rad]"] : []), "Verdict"], rows) : h("p", {}, "None was found."),
    h("p", { class: "small muted" }, missing),
  );
}
