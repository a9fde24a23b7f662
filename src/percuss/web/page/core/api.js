// The door to the server. Every number that the page shows comes through here.

import { $, download, problem, put } from "./dom.js";
import { number } from "./format.js";
import { during } from "./under_way.js";

const TOKEN = "percuss-token";

/** The token from the address, kept for this tab and taken out of the address at once. */
export function takeToken() {
  const found = /^#token=([^&]+)&?(.*)$/.exec(location.hash);
  if (!found) return;
  sessionStorage.setItem(TOKEN, decodeURIComponent(found[1]));
  history.replaceState(null, "", `${location.pathname}#${found[2]}`);
}

/** @typedef {{ key: string, value?: any, message: string, remedy: string }} Problem */

/** A problem in words. @param {Problem} problem */
export const said = ({ message, remedy }) => [message, remedy].filter(Boolean).join(" — ");

/** One after the key that it is of. @param {Problem} problem */
export const saidOf = (problem) => [problem.key && `${problem.key}: `, said(problem)];

/** The problems that an error tells of. @param {any} error @returns {Problem[]} */
export const problemsOf = (error) =>
  error.problems ?? [{ key: "", value: null, message: String(error.message ?? error), remedy: "" }];

/** What the server refused, with the problems as it told them. */
export class Refusal extends Error {
  /** @param {number} status @param {Problem[]} problems */
  constructor(status, problems) {
    super(problems.map(said).join("\n") || `The server answered ${status}.`);
    this.status = status;
    this.problems = problems;
  }
}

/** @param {Record<string, string>} [extra] */
function headers(extra = {}) {
  const token = sessionStorage.getItem(TOKEN);
  return token ? { ...extra, Authorization: `Bearer ${token}` } : extra;
}

const pause = (/** @type {number} */ milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
const AGAIN = 2000; // ms until a server that does not answer is asked again

/** What the server answers; while it does not, as when it is started again, the page says so and goes on asking.
 * @param {string} path @param {RequestInit & { headers?: Record<string, string> }} options @returns {Promise<Response>} */
async function reached(path, options) {
  for (;;) {
    try {
      const response = await fetch(`/api/${path}`, { ...options, headers: headers(options.headers) });
      $("#away").hidden = true;
      return response;
    } catch (/** @type {any} */ error) {
      if (error.name === "AbortError") throw error;
      $("#away").hidden = false;
      await pause(AGAIN);
    }
  }
}

/** @param {string} path @param {any} options @returns {Promise<Response>} */
async function ask(path, options, tries = 4) {
  const response = await reached(path, options);
  if (response.ok) return response;
  if (response.status === 429 && tries > 0) {
    const seconds = Number(response.headers.get("Retry-After") ?? 1);
    await pause(1000 * Math.min(Math.max(seconds, 0.2), 5));
    return ask(path, options, tries - 1);
  }
  throw await refusal(response);
}

/** @param {Response} response */
async function refusal(response) {
  /** @type {Problem[]} */
  let problems = [];
  try {
    problems = (await response.json()).problems ?? [];
  } catch {
    // not JSON: a proxy's page, say; the status is all there is
  }
  const remedy = response.status === 401 ? "Open the address that percuss serve printed: it holds the token." : "";
  if (!problems.length)
    problems = [{ key: "", value: null, message: `The server answered ${response.status}.`, remedy }];
  return new Refusal(response.status, problems);
}

const posted = (/** @type {any} */ body, /** @type {AbortSignal | undefined} */ signal = undefined) => ({
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(body),
  signal,
});

/** What `taken` makes of a response; it is under way under the first word of its path, or by a `name` of its own.
 * @template T @param {string} path @param {any} options @param {(response: Response) => T | Promise<T>} taken
 * @param {string} [name] */
const answered = (path, options, taken, name = /^\w+/.exec(path)?.[0] ?? "") =>
  during(name, ask(path, options).then(taken));

/** @param {Response} response @returns {Promise<any>} */
const json = (response) => response.json();

export const get = (/** @type {string} */ path) => answered(path, {}, json);
/** @param {string} path @param {any} body @param {AbortSignal} [signal] */
export const post = (path, body, signal) => answered(path, posted(body, signal), json);

/** An answer with arrays: its header, and `arrays` by name as typed arrays with a `shape`.
 * @param {string} path @param {any} body @param {AbortSignal} [signal] @param {string} [name] @returns {Promise<any>} */
export async function postBinary(path, body, signal, name) {
  const buffer = await answered(path, posted(body, signal), (response) => response.arrayBuffer(), name);
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  /** @type {Record<string, any>} */
  const kinds = { f4: Float32Array, u1: Uint8Array, i2: Int16Array };
  /** @type {Record<string, any>} */
  const arrays = {};
  for (const { name, dtype, shape, offset } of header.arrays) {
    const length = shape.reduce((/** @type {number} */ product, /** @type {number} */ n) => product * n, 1);
    const values = new kinds[dtype](buffer, 4 + size + offset, length);
    arrays[name] = Object.assign(values, { shape });
  }
  return { ...header, arrays };
}

/** A file of the server, saved by the browser under the name that the server gives it, else this one; how that goes is
 * told in an element. @param {string} path @param {any} body @param {string} name @param {HTMLElement} place */
export async function saveFile(path, body, name, place) {
  const taken = async (/** @type {Response} */ response) => {
    const given = /filename="?([^";]+)"?/.exec(response.headers.get("Content-Disposition") ?? "")?.[1] ?? name;
    const blob = await response.blob();
    download(blob, given);
    put(place, `Saved as ${given}, ${number(blob.size / 1000, 3)} kB.`);
  };
  await answered(path, posted(body), taken).catch((error) => put(place, problem(error)));
}

export const upload = (/** @type {string} */ path, /** @type {Blob} */ file) =>
  answered(path, { method: "POST", headers: { "Content-Type": "application/octet-stream" }, body: file }, json);

/** Server-sent events over POST: `heard(event, data)` for each, until the stream ends or `signal` aborts it.
 * @param {string} path @param {any} body @param {(event: string, data: any) => void} heard @param {AbortSignal} [signal] */
export const stream = (path, body, heard, signal) =>
  answered(path, posted(body, signal), (response) => read(response, heard));

/** @param {Response} response @param {(event: string, data: any) => void} heard */
async function read(response, heard) {
  const reader = /** @type {ReadableStream} */ (response.body).pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    rest += value.replaceAll("\r\n", "\n");
    for (let end = rest.indexOf("\n\n"); end >= 0; end = rest.indexOf("\n\n")) {
      const block = rest.slice(0, end).split("\n");
      rest = rest.slice(end + 2);
      const field = (/** @type {string} */ name) =>
        block.filter((line) => line.startsWith(`${name}:`)).map((line) => line.slice(name.length + 1).trim());
      if (field("event").length) heard(field("event")[0], JSON.parse(field("data").join("\n")));
    }
  }
}
