// A question whose answer takes its time: the buttons that ask it and give it up, how far it is, and what went wrong.

import { Refusal, stream } from "../core/api.js";
import { button, h, put } from "../core/dom.js";

export class LongQuestion {
  /** @param {string} name of its elements
   * @param {string} ask the words of its button @param {string} first what is said
   * at first @param {(told: string) => string} [inWords] what the server says, as it is said here */
  constructor(name, ask, first, inWords = (told) => told) {
    this.inWords = inWords;
    /** @type {AbortController | null} */
    this.running = null;
    this.go = h("button", { type: "submit", class: "main", id: `${name}-run` }, ask);
    this.cancel = button("Cancel", () => this.running?.abort(), { id: `${name}-cancel`, ".disabled": true });
    this.bar = h("progress", { max: 1, value: 0, "aria-label": "Progress", id: `${name}-progress` });
    this.status = h("p", { role: "status", id: `${name}-status` }, first);
    this.problem = h("p", { class: "problem", role: "alert", id: `${name}-problem` });
  }

  /** Ask, hear what comes meanwhile and at last, and tell how it has ended.
   * @param {string} path @param {any} body @param {(event: string, found: any) => void} heard
   * @returns {Promise<"answered" | "cancelled" | "refused" | "ended early">} */
  async ask(path, body, heard) {
    this.running = new AbortController();
    this.busy();
    put(this.problem);
    this.bar.value = 0;
    put(this.status, "Starting …");
    /** @type {"answered" | "cancelled" | "refused" | "ended early"} */
    let how = "ended early";
    const refused = (/** @type {string} */ message) => (put(this.problem, this.inWords(message)), (how = "refused"));
    const each = (/** @type {string} */ event, /** @type {any} */ found) => {
      if (event === "error") return refused(new Refusal(0, found.problems).message);
      if (event === "done") how = "answered";
      this.bar.value = event === "done" ? 1 : (found.fraction ?? found.done / (found.size ?? 1));
      heard(event, found);
    };
    try {
      await stream(path, body, each, this.running.signal);
    } catch (/** @type {any} */ error) {
      if (error.name === "AbortError") how = "cancelled";
      else refused(error.message);
    }
    this.running = null;
    this.busy();
    return how;
  }

  busy() {
    this.go.disabled = Boolean(this.running);
    this.cancel.disabled = !this.running;
  }
}
