// What is under way: questions to the server, timers and frames to come. The root of the page names it in `data-busy` until
// all that is shown is of the present state; the headline is `aria-busy` while its figures may be of an earlier one.

const FIGURES = ["start", "machines", "case", "quick", "steady", "machine", "motion", "rest", "frame"];
/** @type {Map<string, number>} */
const counts = new Map();

/** Something begins; what is returned ends it, once what it brought has been painted. @param {string} name */
export function begun(name) {
  count(name, 1);
  return () => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(() => count(name, -1))));
}

/** The answer of a promise, which is under way until then. @template T @param {string} name @param {Promise<T>} promise */
export async function during(name, promise) {
  const end = begun(name);
  try {
    return await promise;
  } finally {
    end();
  }
}

/** @param {string} name @param {number} by */
function count(name, by) {
  const left = (counts.get(name) ?? 0) + by;
  if (left) counts.set(name, left);
  else counts.delete(name);
  if (left > 1 || (left === 1 && by < 0)) return; // it was named before
  const root = document.documentElement;
  if (counts.size) root.dataset.busy = [...counts.keys()].join(" ");
  else delete root.dataset.busy;
  document.getElementById("headline")?.setAttribute("aria-busy", String(FIGURES.some((one) => counts.has(one))));
}
