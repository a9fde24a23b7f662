// A part of a picture that the server tells while it finds it, of the diagram or of a map. One is told at a time, so that the sliders keep their share
// of the machine; what is no longer wanted ends at once.

import { Refusal, stream } from "../core/api.js";
import { h, put } from "../core/dom.js";
import { during } from "../core/under_way.js";

let turn = Promise.resolve(); // until the part before has ended

export class Part {
  #key = "";
  #running = null; // the abort controller of the question under way

  /** `id` of its elements, `begun` what is said at first, `told(found, done)` is called with each answer, null for none. */
  constructor({ id, path = "diagram", begun, told }) {
    Object.assign(this, { path, begun, told });
    this.bar = h("progress", { max: 1, value: 0, id: `${id}-progress`, "aria-label": begun });
    this.words = h("span", { class: "small muted", id, role: "status" });
    this.bar.hidden = true;
  }

  /** Ask, unless that is under way or there; `key` tells questions apart, and is empty when nothing is wanted. */
  want(key, question) {
    if (key === this.#key) return;
    this.stop();
    this.#key = key;
    this.bar.hidden = true;
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

  async #ask(question) {
    const own = (this.#running = new AbortController());
    const before = turn;
    let end;
    turn = new Promise((resolve) => (end = resolve));
    this.bar.hidden = false;
    this.bar.value = 0;
    put(this.words, this.begun);
    try {
      await during(this.path, before);
      if (own !== this.#running) return;
      await stream(this.path, question, (event, found) => own === this.#running && this.#take(event, found), own.signal);
      if (own === this.#running && !this.bar.hidden) throw ended();
    } catch (error) {
      if (error.name === "AbortError" || own !== this.#running) return;
      this.bar.hidden = true;
      put(this.words, h("span", { class: "problem", role: "alert" }, error.message));
    } finally {
      end();
      if (own === this.#running) this.#running = null;
    }
  }

  #take(event, found) {
    if (event === "error") throw new Refusal(422, found.problems);
    const done = event === "done";
    this.bar.value = found.done;
    this.bar.hidden = done;
    this.told(found, done);
  }
}

const ended = () => new Refusal(0, [{ key: "", value: null, message: "The server ended the search.", remedy: "" }]);
