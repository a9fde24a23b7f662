// @ts-check
import { quantity } from "./format.js";
/** @param {string} text @param {string} unit @returns {any} */
export function read(text, unit) {
  const found = quantity(text.replaceAll("\u202f", " ").replace("−", "-").replace(",", "."));
  if (!found) return { error: "not a number", remedy: "" };
  return { value: found.value, unit };
}
