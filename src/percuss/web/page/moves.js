// Edits of a case's tables by hand, and what parameters stand at. What a slider or the map moves is moved by the
// server, which knows how a parameter is written in a case. Tables are never changed in place.

import { quantity } from "./format.js";

/** The tables with one dotted key set, or taken out when the value is undefined. */
export function withKey(tables, key, value) {
  const [table, name] = key.includes(".") ? key.split(".") : ["", key];
  const inside = table ? { ...(tables[table] ?? {}) } : { ...tables };
  if (value === undefined) delete inside[name];
  else inside[name] = value;
  if (!table) return inside;
  const found = { ...tables, [table]: inside };
  if (!Object.keys(inside).length && (table === "start" || table === "simulation")) delete found[table];
  return found;
}

export function valueAt(tables, key) {
  const [table, name] = key.includes(".") ? key.split(".") : ["", key];
  return table ? tables[table]?.[name] : tables[name];
}

/** The number that a parameter stands at now; undefined when it has none. */
export function present(data, name) {
  if (name in data.placed) return data.placed[name];
  const known = data.info?.parameters.find((p) => p.name === name);
  if (known?.dimensionless) return data.quick?.[name] ?? data.tables.system?.[name] ?? known.value ?? undefined;
  const written = quantity(valueAt(data.tables, name));
  // in another unit, or in none that fits, only the server can tell
  return written && written.unit === known?.unit ? written.value : (known?.value ?? undefined);
}
