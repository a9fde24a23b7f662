// The page in other languages. Its words are written in English where they are used; the catalogue (words.json) has them
// in German and Swedish, with `#` for a number and `{}` for what is filled in and has words of its own. What goes into the
// page (core/dom.js) or onto a canvas passes through `tr`, which also gives numbers the language's decimal comma.

import { kindOf } from "./units.js";

/** The languages that there are, by their codes. @type {Record<string, string>} */
export const LANGUAGES = { en: "English", de: "Deutsch", sv: "Svenska" };

const kept = localStorage.getItem("percuss-language") ?? "";
const preferred = navigator.languages.map((one) => one.slice(0, 2)).find((one) => one in LANGUAGES);

/** The language of the page: the one that was chosen here, else the browser's. */
export const language = kept in LANGUAGES ? kept : (preferred ?? "en");

/** Another one, for the whole page. @param {string} name */
export function useLanguage(name) {
  localStorage.setItem("percuss-language", name);
  location.reload();
}

/** A key of a case, "load.ports[0].delay". */
const KEY = /^[\w[\]]+(\.[\w[\]]+)+$/;
const NUMBER = /(?:−|(?<![^\s(=[])-)?(?<![\w.])\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*\.\d)(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?/g;
const FILLED = /#(\d?)|\{(\d?)\}/g;

/** Texts that the catalogue does not have; a test of the page finds none. @type {Set<string>} */
export const missed = new Set();

/** @typedef {{ pattern: RegExp, target: string, kinds: string[] }} Template */

/** @type {Map<string, string> | null} */
let phrases = null;
/** What has words filled in, that with most words of its own first. @type {Template[]} */
let templates = [];
/** @type {Map<string, string>} */
const done = new Map();

if (language !== "en") {
  const catalogue = await fetch("/static/core/words.json").then(
    (answer) => answer.json(),
    () => ({}),
  ); // else in English
  const column = Object.keys(LANGUAGES).indexOf(language) - 1;
  phrases = new Map(Object.entries(catalogue).map(([key, targets]) => [key, targets[column]]));
  const filled = [...phrases].filter(([key]) => key.includes("{}"));
  templates = filled
    .sort(([a], [b]) => bare(b).length - bare(a).length)
    .map(([key, target]) => templateOf(key, target));
  document.documentElement.lang = language;
}

/** @param {string} key */
function bare(key) {
  return key.replace(/[#{}\s]/g, "");
}

/** @param {string} key @param {string} target @returns {Template} */
function templateOf(key, target) {
  const pattern = key
    .replace(/[.*+?^$()|[\]\\]/g, "\\$&")
    .replaceAll("#", `(${NUMBER.source})`)
    .replaceAll("{}", "(.+?)");
  return { pattern: new RegExp(`^${pattern}$`, "s"), target, kinds: key.match(/#|\{\}/g) ?? [] };
}

/** A text in the language of the page. @template {string | null | undefined} T @param {T} text @returns {T} */
export function tr(text) {
  if (!phrases || !text) return text;
  const found = done.get(text) ?? translated(text);
  if (done.size > 5000) done.clear();
  done.set(text, found);
  return /** @type {T} */ (found);
}

// What stands between texts that are translated each for itself: sentences, clauses; what ends one; what a list has.
const SENTENCES = [/((?<=[.!?])\s+)/, /((?<=;)\s+)/, /( — | · | \/ )/, /(: )/];
const END = /([.;:…▸▾?]+$)/;
const MARK = /(^[▴●○✓]\s?|^\d+ (?=\p{Lu}))/u;
const PARTS = /(, | = | \((?=[\w.[\]]*\.[\w.[\]]*\)$)| \[(?=[^[\]]*\]$)|[)\]]$)/;

/** The translation of a text, and a note of what there is none of. @param {string} text @returns {string} */
function translated(text) {
  const found = known(text);
  if (found !== null) return found;
  for (const marks of SENTENCES) {
    const parts = text.split(marks);
    if (parts.length > 1) return parts.map((part, i) => (i % 2 || !part ? part : translated(part))).join("");
  }
  missed.add(text);
  return text;
}

/** The translation of a text by the catalogue: as a whole, with its first letter small, or part by part where all are
 * known; null where there is none. @param {string} text @returns {string | null} */
function known(text) {
  const ended = phrase(text) ?? inParts(text, END) ?? template(text);
  const whole = ended ?? (isWordless(text) ? withCommas(text) : null);
  if (whole !== null) return whole;
  const small = text[0].toLowerCase() + text.slice(1);
  const uncapped = small === text ? null : (phrase(small) ?? template(small));
  if (uncapped !== null) return uncapped[0].toUpperCase() + uncapped.slice(1);
  for (const marks of [/(^\s+|\s+$)/, ...SENTENCES, MARK, PARTS]) {
    const found = inParts(text, marks);
    if (found !== null) return found;
  }
  return null;
}

/** The same of a text with such marks in it, where all that stands between them is known.
 * @param {string} text @param {RegExp} marks @returns {string | null} */
function inParts(text, marks) {
  const parts = text.split(marks);
  if (parts.length === 1) return null;
  const found = parts.map((part, i) => (i % 2 || !part ? part : known(part)));
  return found.every((part) => part !== null) ? found.join("") : null;
}

/** @param {string} text */
function phrase(text) {
  /** @type {string[]} */
  const numbers = [];
  const key = text.replace(NUMBER, (number) => (numbers.push(withCommas(number)), "#"));
  const target = phrases?.get(key);
  return target === undefined ? null : filledIn(target, numbers, []);
}

/** @param {string} text */
function template(text) {
  for (const { pattern, target, kinds } of templates) {
    const found = pattern.exec(text);
    if (!found) continue;
    const pieces = found.slice(1);
    const numbers = pieces.filter((_, i) => kinds[i] === "#").map(withCommas);
    const words = pieces.filter((_, i) => kinds[i] !== "#").map((piece) => translated(piece));
    return filledIn(target, numbers, words);
  }
  return null;
}

/** A target with its numbers and words in their places: in order, or by number as `#2`, `{1}`.
 * @param {string} target @param {string[]} numbers @param {string[]} words */
function filledIn(target, numbers, words) {
  const [number, word] = [numbers.values(), words.values()];
  return target.replace(FILLED, (mark, n, w) =>
    mark[0] === "#" ? (n ? numbers[n - 1] : (number.next().value ?? "")) : w ? words[w - 1] : (word.next().value ?? ""),
  );
}

/** @param {string} text */
const withCommas = (text) => text.replace(NUMBER, (number) => number.replace(".", ",").replace(/^-/, "−"));

/** Whether a text has nothing to translate: numbers, units and symbols. @param {string} text */
const isWordless = (text) =>
  KEY.test(text) ||
  text.split(/[\s\u202f=/:;,()[\]…–]+/).every((one) => !/\p{L}{2}/u.test(one) || kindOf(one) !== "" || KEY.test(one));

/** The static parts of the page in its language. @param {Element} root */
export function translate(root) {
  if (!phrases) return;
  const walk = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
  while (walk.nextNode())
    if (!walk.currentNode.parentElement?.closest("noscript, h1"))
      walk.currentNode.nodeValue = tr(walk.currentNode.nodeValue);
  for (const one of root.querySelectorAll("[aria-label]"))
    one.setAttribute("aria-label", tr(one.getAttribute("aria-label")) ?? "");
}
