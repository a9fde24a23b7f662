// What is struck in a blow: the wall or the rod that [contact] stands for, or a tool of its own, as a choice.

import { select } from "../core/dom.js";
import { data, setTables } from "../core/state.js";

/** @type {[string, string][]} */
const STRUCK = [
  ["none", "as [contact] says"],
  ["wall", "a rigid wall"],
  ["infinite", "an endless rod"],
  ["free", "a rod with a free end"],
  ["rock", "a rod on rock"],
];

/** What is struck, by its word in `STRUCK`. @param {import("../core/moves.js").Tables} tables @returns {string} */
export function struckNow({ tool, rock }) {
  if (!tool) return "none";
  if (tool.kind === "wall") return "wall";
  return tool.end ?? (rock ? "rock" : "infinite");
}

/** The choice of it; `id` is that of its control. @param {string} id */
export function whatIsStruck(id) {
  const options = data.tables?.bar ? STRUCK : STRUCK.slice(0, 3);
  const now = struckNow(data.tables ?? {});
  const isKnown = options.some(([name]) => name === now);
  return select("What is struck", isKnown ? options : [...options, [now, now]], now, strikeAt, { id });
}

/** The case with another thing struck; a rod keeps its sections, else it has those of the machine, else it is as thick
 * as the striking end. Only rock bears a feed, and is drilled. @param {string} wish */
function strikeAt(wish) {
  const { tool, rock, feed, drilling, ...tables } = data.tables;
  const own = data.base?.tool;
  if (wish === "none") return setTables(tables);
  if (wish === "wall") return setTables({ ...tables, tool: { kind: "wall" } });
  if (!tables.bar) return setTables({ ...tables, tool: { impedance: tool?.impedance ?? 1 } });
  const { diameter, area, bore } = tables.bar.sections?.at(-1) ?? tables.bar;
  const size = Object.fromEntries(Object.entries({ diameter, area, bore }).filter(([, value]) => value !== undefined));
  const rod = [tool, own].find((one) => one?.sections) ?? { sections: [{ length: "1 m", ...size }] };
  if (wish === "infinite") {
    const { length, ...last } = rod.sections.at(-1);
    return setTables({ ...tables, tool: { sections: [...rod.sections.slice(0, -1), last], end: "infinite" } });
  }
  const sections = rod.sections.map((/** @type {any} */ section, /** @type {number} */ i) => ({
    length: own?.sections?.[i]?.length ?? "1 m",
    ...section,
  }));
  /** @type {Record<string, any>} */
  const ground = { rock: { stiffness: "100 kN/mm", unloading_ratio: 0.3 } };
  for (const [name, value] of Object.entries({ rock, feed, drilling }))
    if (value ?? data.base?.[name]) ground[name] = value ?? data.base[name];
  setTables({ ...tables, tool: { ...rod, sections, end: wish }, ...(wish === "rock" && ground) });
}
