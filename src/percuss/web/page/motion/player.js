// What the players share: play and pause, the slider of time, and that of the slow motion.

import { button, div, h, put } from "../core/dom.js";
import { withUnit } from "../core/format.js";
import { show } from "../core/state.js";
import { tr } from "../core/words.js";

/** What can be played: for `length` of its own time; `there` when there is something to play.
 * @typedef {{ length: number, playing: boolean, there: boolean, play: () => void, pause: () => void,
 *   seek: (time: number) => void }} Playable */
/** A factor and the unit that it leads to. @typedef {{ k: number, name: string }} Unit */

export class Player {
  /** `id` begins the ids, `about` names the slider of time, `slow` is the key of the view that keeps the pace, between
   * `least` and `most`, which `paced` is told of.
   * @param {any} stage
   * @param {{ id?: string, about: string, slow: string, paced: () => void, least?: number, most?: number }} about */
  constructor(stage, { id = "", about, slow, paced, least = 0, most = 100 }) {
    this.stage = /** @type {Playable} */ (stage);
    this.held = false; // by the user
    this.told = 0;
    const [scrub, pace] = [`${id}scrub`, `${id}slow`];
    this.play = button("▶", () => this.toggle(), { class: "main", id: `${id}play`, "aria-label": "Play" });
    const oninput = (/** @type {any} */ { target }) => this.seek((stage.length * target.value) / target.max);
    this.scrub = h("input", { type: "range", id: scrub, min: 0, max: 1000, step: 1, "aria-label": about, oninput });
    this.time = h("output", { class: "time", for: scrub }, "–");
    const slower = (/** @type {any} */ { target }) => (show({ [slow]: target.value }), paced());
    this.slow = h("input", { type: "range", id: pace, min: least, max: most, step: 1, oninput: slower });
    this.slowly = h("output", { for: pace });
  }

  /** The line below the stage: play, the slider of time, the pace, and further knobs. @param {Node[]} knobs */
  rows(...knobs) {
    const name = h("span", { class: "hidden-words" }, "Slow motion");
    const pace = h("label", { class: "pace" }, name, this.slow, this.slowly);
    return div("play", this.play, this.scrub, this.time, pace, knobs);
  }

  /** Another moment, as the user wants it: it stays. @param {number} time */
  seek(time) {
    this.held = true;
    this.stop();
    this.stage.seek(time);
  }

  /** Play, or pause, as the user wants it; a motion that comes later stays as the one before was left. */
  toggle() {
    this.held = this.stage.playing;
    if (this.held) this.stop();
    else this.start();
  }

  /** A motion has come: it plays by itself unless the user has paused. */
  begin() {
    if (!this.held && !this.stage.playing) this.start();
  }

  start() {
    if (!this.stage.there) return;
    this.stage.play();
    this.says("Pause", "▮▮");
  }

  stop() {
    if (this.stage.playing) this.stage.pause();
    this.says("Play", "▶");
  }

  /** @param {string} words @param {string} sign */
  says(words, sign) {
    put(this.play, sign);
    this.play.setAttribute("aria-label", tr(words));
    this.play.title = tr(`${words} (space)`);
  }

  /** The pace on its slider, of 0 to 1, and in words. @param {number} share @param {string} words */
  tellPace(share, words) {
    if (document.activeElement !== this.slow) this.slow.value = String(100 * share);
    put(this.slowly, words);
    this.slow.setAttribute("aria-valuetext", tr(words));
  }

  /** The present moment in digits, and on the slider of time, where it is at `place`.
   * @param {number} time @param {{ time: Unit }} units @param {number} [digits] @param {number} [place] */
  tellMoment(time, units, digits = 4, place = time) {
    const { stage, scrub } = this;
    if (document.activeElement !== scrub || stage.playing)
      scrub.value = String(stage.length ? (Number(scrub.max) * place) / stage.length : 0);
    const now = performance.now();
    if (stage.playing && now - this.told < 100) return; // nobody reads digits that change with every frame
    this.told = now;
    const words = withUnit(time * units.time.k, units.time.name, digits);
    put(this.time, words);
    scrub.setAttribute("aria-valuetext", tr(words));
  }
}

/** The seconds that a cycle is shown for, evenly in ratios from `real` to `longest` by a share of 0 to 1; without one
 * from the view, the `usual` ones.
 * @param {string | number} given @param {{ real: number, usual: number, longest: number }} span */
export function paceOf(given, { real, usual, longest }) {
  const span = Math.log(longest / real);
  const share = given === "" ? Math.log(Math.max(usual, real) / real) / span : Number(given) / 100 || 0;
  const within = Math.min(Math.max(share, 0), 1);
  return { share: within, seconds: real * (longest / real) ** within };
}
