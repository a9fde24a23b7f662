// What is known, and what follows from it: signals, and effects that run when one they have
// read is another. Effects run together, in a microtask, after all that changes at once has changed; each once; or they
// are put off, to the next frame or until nothing changes any more.

/** @typedef {{ sources: Set<Source>, again: () => void }} Reader */
/** @typedef {{ readers: Set<Reader> }} Source */
/** @template T @typedef {{ value: T, peek: () => T }} Signal */
/** How effects are put off: makes of what runs one what asks for a run. @typedef {(run: () => void) => () => void} Later */

/** @type {Reader | null} */
let reading = null;
/** @type {Set<Effect>} */
const due = new Set();

/** @param {Source} source */
function read(source) {
  if (!reading) return;
  source.readers.add(reading);
  reading.sources.add(source);
}

/** @param {Reader} reader */
function forget(reader) {
  for (const source of reader.sources) source.readers.delete(reader);
  reader.sources.clear();
}

/** @template T @param {Reader | null} reader @param {() => T} action */
function within(reader, action) {
  const before = reading;
  reading = reader;
  try {
    return action();
  } finally {
    reading = before;
  }
}

/** What an action reads is not what the effect that it is in waits for. @param {() => void} action */
export const untracked = (action) => within(null, action);

/** A value that tells who has read it when it is another. @template T @param {T} initial @returns {Signal<T>} */
export function signal(initial) {
  let value = initial;
  /** @type {Source} */
  const source = { readers: new Set() };
  return {
    get value() {
      read(source);
      return value;
    },
    set value(next) {
      if (Object.is(next, value)) return;
      value = next;
      for (const reader of [...source.readers]) reader.again();
    },
    peek: () => value,
  };
}

class Effect {
  /** @param {() => void} action @param {Later} [later] */
  constructor(action, later = () => () => soon(this)) {
    this.action = action;
    /** @type {Set<Source>} */
    this.sources = new Set();
    this.again = later(() => this.run());
  }

  run() {
    forget(this);
    try {
      within(this, this.action);
    } catch (error) {
      reportError(error); // one that fails is reported, and the others run all the same
    }
  }
}

/** @param {Effect} effect */
function soon(effect) {
  if (!due.size) queueMicrotask(flush);
  due.add(effect);
}

/** Run what is due now, and what that makes due; an endless round is an error. */
export function flush() {
  for (let rounds = 0; due.size; rounds++) {
    if (rounds > 100) throw (due.clear(), new Error("effects that go round in a circle"));
    const now = [...due];
    due.clear();
    for (const effect of now) effect.run();
  }
}

/** Run an action now, and again whenever a signal it has read is another, and when what is returned is called.
 * @param {() => void} action @param {Later} [later] */
export function effect(action, later) {
  const own = new Effect(action, later);
  own.run();
  return own.again;
}

/** Run an action now, and again when its key has another content: an effect of the key alone, whatever the action reads.
 * Nothing happens while the key is false or null.
 * @template K @param {() => K} key @param {(now: NonNullable<K>) => void} action @param {Later} [later] */
export function whenever(key, action, later) {
  let before = "";
  return effect(() => {
    const now = key();
    if (!now || JSON.stringify(now) === before) return;
    before = JSON.stringify(now);
    untracked(() => action(now));
  }, later);
}

/** An object whose properties are signals. @template {Record<string, any>} T @param {T} initial @returns {T} */
export function store(initial) {
  /** @type {Map<string | symbol, Signal<any>>} */
  const signals = new Map();
  const of = (/** @type {any} */ target, /** @type {string | symbol} */ name) =>
    signals.get(name) ?? (signals.set(name, signal(target[name])), /** @type {Signal<any>} */ (signals.get(name)));
  return new Proxy(/** @type {any} */ ({ ...initial }), {
    get: (target, name) => of(target, name).value,
    set(target, name, value) {
      target[name] = value;
      of(target, name).value = value;
      return true;
    },
  });
}
