// What the players share: play and pause, the slider of time, and that of the slow motion.

import { button, div, h, movesByItself, put } from "../core/dom.js";
import { number, withUnit } from "../core/format.js";
import { show } from "../core/state.js";
import { tr } from "../core/words.js";

/** What can be played: for `length` of its own time; `there` when there is something to play.
 * @typedef {{ length: number, playing: boolean, there: boolean, play: () => void, pause: () => void,
 *   seek: (time: number) => void }} Playable */
/** A factor and the unit that it leads to. @typedef {{ k: number, name: string }} Unit */

export class Player {
  /** `id` begins the ids, `about` names the slider of time, `slow` is the key of the view that keeps the pace, between
   * `least` and `most`; `moved` is told when that is another one.
   * @param {any} stage
   * @param {{ id?: string, about: string, slow: string, moved: () => void, least?: number, most?: number }} about */
  constructor(stage, { id = "", about, slow, moved, least = 0, most = 100 }) {
    this.stage = /** @type {Playable} */ (stage);
    this.held = false; // by the user
    this.told = 0;
    const [scrub, pace] = [`${id}scrub`, `${id}slow`];
    this.play = button("▶", () => this.toggle(), { class: "main", id: `${id}play`, "aria-label": "Play" });
    const oninput = (/** @type {any} */ { target }) => this.seek((stage.length * target.value) / target.max);
    this.scrub = h("input", { type: "range", id: scrub, min: 0, max: 1000, step: 1, "aria-label": about, oninput });
    this.time = h("output", { class: "time", for: scrub }, "–");
    const slower = (/** @type {any} */ { target }) => (show({ [slow]: target.value }), moved());
    this.slow = h("input", { type: "range", id: pace, min: least, max: most, step: 1, oninput: slower });
    this.slowly = h("output", { for: pace });
    document.addEventListener("visibilitychange", () => document.hidden && this.stop());
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

  /** A motion has come: it plays by itself unless the user has paused, or wants nothing to move. */
  begin() {
    if (movesByItself() && !this.held && !this.stage.playing) this.start();
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

  /** The seconds that a cycle is shown for, evenly in ratios from `real` to `longest` by a share of 0 to 100; without one
   * from the view, the `usual` ones. They are told beside real time, or, where none is known, by the name of what they show.
   * @param {string | number} given @param {{ real: number, usual: number, longest: number }} span @param {string} cycle */
  paced(given, { real, usual, longest }, cycle) {
    const span = Math.log(longest / real);
    const wish = given === "" ? Math.log(Math.max(usual, real) / real) / span : Number(given) / 100 || 0;
    const share = Math.min(Math.max(wish, 0), 1);
    const seconds = real * (longest / real) ** share;
    const slower = seconds / real < 1.01 ? "real time" : `1/${number(seconds / real, 2)} speed`;
    this.tellPace(share, cycle ? `${number(seconds, 2)} s a ${cycle}` : slower);
    return seconds;
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
