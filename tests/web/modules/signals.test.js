import { effect, flush, signal, store, whenever } from "/static/core/signals.js";

/** @typedef {typeof import("./checks.js")} Checks */

/** @param {Checks} t */
export function an_effect_runs_once_for_all_that_has_changed(t) {
  const data = store({ a: 1, b: 2, c: 3 });
  /** @type {number[]} */
  const seen = [];
  effect(() => void seen.push(data.a + data.b));
  Object.assign(data, { a: 10, b: 20, c: 30 });
  flush();
  data.c = 31;
  flush();
  t.equal(seen, [3, 30]);
}

/** @param {Checks} t */
export function an_effect_that_is_put_off_runs_when_it_is_called(t) {
  const value = signal(1);
  /** @type {number[]} */
  const seen = [];
  /** @type {(() => void)[]} */
  const waiting = [];
  const again = effect(
    () => void seen.push(value.value),
    (run) => () => void waiting.push(run),
  );
  value.value = 2;
  value.value = 3;
  flush();
  t.equal(seen, [1]);
  waiting.splice(0).forEach((run) => run());
  t.equal(seen, [1, 3, 3]);
  again();
  t.equal(waiting.length, 1);
}

/** @param {Checks} t */
export function what_is_done_for_a_key_depends_on_nothing_else(t) {
  const [key, other] = [signal(/** @type {any} */ (null)), signal(1)];
  /** @type {any[]} */
  const seen = [];
  whenever(
    () => key.value,
    () => seen.push([...key.value, other.value]),
  );
  for (const now of [["a"], ["a"], null, ["a"], ["b"]]) {
    key.value = now;
    other.value += 1;
    flush();
  }
  t.equal(seen, [
    ["a", 2],
    ["b", 6],
  ]);
}
