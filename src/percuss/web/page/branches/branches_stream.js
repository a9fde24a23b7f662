// A part of a picture that the server tells while it finds it, of the diagram or of a map. One is told at a time, so that
// the sliders keep their share of the machine; what is no longer wanted ends at once.

import { Refusal, stream } from "../core/api.js";
import { h, problem, put } from "../core/dom.js";
import { during } from "../core/under_way.js";

let turn = Promise.resolve(); // until the part before has ended

export class Part {
  #key = "";
  /** The question under way. @type {AbortController | null} */
  #running = null;

  /** `id` of its elements, `begun` what is said at first, `told` is called with each answer, null for none.
   * @param {{ id: string, path?: string, begun: string, told: (found: any, done: boolean) => void }} about */
  constructor({ id, path = "diagram", begun, told }) {
    this.path = path;
    this.begun = begun;
    this.told = told;
    this.bar = h("progress", { max: 1, value: 0, id: `${id}-progress`, "aria-label": begun, hidden: true });
    this.words = h("span", { class: "small muted", id, role: "status" });
  }

  /** Ask, unless that is under way or there; `key` tells questions apart, and is empty when nothing is wanted.
   * @param {string} key @param {any} question */
  want(key, question) {
    if (key === this.#key) return;
    this.stop();
    this.#key = key;
    put(this.words, "");
    this.told(null, false);
    if (key) this.#ask(question);
  }

  /** What is under way ends; what has been told stays, and is asked for anew when it is wanted again. */
  stop() {
    if (!this.#running) return;
    this.#running.abort();
    this.#running = null;
    this.#key = "stopped";
    this.bar.hidden = true;
  }

  /** @param {any} question */
  async #ask(question) {
    const own = (this.#running = new AbortController());
    const before = turn;
    let end = () => {};
    turn = new Promise((resolve) => (end = resolve));
    this.bar.hidden = false;
    this.bar.value = 0;
    put(this.words, this.begun);
    const heard = (/** @type {string} */ event, /** @type {any} */ found) =>
      own === this.#running && this.#take(event, found);
    try {
      await during(this.path, before);
      if (own !== this.#running) return;
      await stream(this.path, question, heard, own.signal);
      if (own === this.#running && !this.bar.hidden) throw ended();
    } catch (/** @type {any} */ error) {
      if (error.name === "AbortError" || own !== this.#running) return;
      this.bar.hidden = true;
      put(this.words, problem(error));
    } finally {
      end();
      if (own === this.#running) this.#running = null;
    }
  }

  /** @param {string} event @param {any} found */
  #take(event, found) {
    if (event === "error") throw new Refusal(422, found.problems);
    this.bar.value = found.done;
    this.bar.hidden = event === "done";
    this.told(found, event === "done");
  }
}

const ended = () => new Refusal(0, [{ key: "", value: null, message: "The server ended the search.", remedy: "" }]);
