// What a test of a module says: the one argument of each function that a `*.test.js` exports.

/** What a test holds, as it stands in the message: objects by what they hold, numbers to the last digit.
 * @param {unknown} value @returns {string} */
const told = (value) =>
  JSON.stringify(value, (_, one) => (typeof one === "number" && !Number.isFinite(one) ? String(one) : one)) ??
  String(value);

/** @param {unknown} found @param {string} [about] */
export function ok(found, about = "") {
  if (!found) throw new Error(`${about || "it"}: ${told(found)}`);
}

/** The same, objects and lists by what they hold.
 * @param {unknown} found @param {unknown} wanted @param {string} [about] */
export function equal(found, wanted, about = "") {
  if (told(found) !== told(wanted)) throw new Error(`${about} is ${told(found)}, not ${told(wanted)}`);
}

/** Two numbers that are the same but for rounding.
 * @param {number} found @param {number} wanted @param {number} [relative] @param {string} [about] */
export function close(found, wanted, relative = 1e-12, about = "") {
  const least = relative * Math.max(Math.abs(wanted), Number.MIN_VALUE);
  if (!(Math.abs(found - wanted) <= least)) throw new Error(`${about} is ${found}, not ${wanted}`);
}
