// What the players of motions and of machines share: play and pause, the slider of time, and that of the slow motion.

import { h, put } from "../core/dom.js";
import { withUnit } from "../core/format.js";
import { show } from "../core/state.js";
import { tr } from "../core/words.js";

export class Player {
  /** Of a stage: `id` begins the ids, `about` names the slider of time, `slow` is the key of the view that keeps the pace,
   * which `paced` is told of. */
  constructor(stage, { id = "", about, slow, paced }) {
    Object.assign(this, { stage, held: false, told: 0 });
    const { play, scrub, pace } = { play: `${id}play`, scrub: `${id}scrub`, pace: `${id}slow` };
    this.play = h("button", { type: "button", class: "main", id: play, "aria-label": "Play", onclick: () => this.toggle() }, "▶");
    const seek = (event) => ((this.held = true), this.stop(), stage.seek((stage.length * event.target.value) / 1000));
    this.scrub = h("input", { type: "range", id: scrub, min: 0, max: 1000, step: 1, "aria-label": about, oninput: seek });
    this.time = h("output", { class: "time", for: scrub }, "–");
    const slower = (event) => (show({ [slow]: event.target.value }), paced());
    this.slow = h("input", { type: "range", id: pace, min: 0, max: 100, step: 1, oninput: slower });
    this.slowly = h("output", { for: pace });
  }

  /** The line below the stage: play, the slider of time, the pace, and further knobs. */
  rows(...knobs) {
    const pace = h("label", { class: "pace" }, h("span", { class: "hidden-words" }, "Slow motion"), this.slow, this.slowly);
    return h("div", { class: "play" }, this.play, this.scrub, this.time, pace, knobs);
  }

  /** Play, or pause, as the user wants it; a motion that comes later stays as the one before was left. */
  toggle() {
    this.held = this.stage.playing;
    if (this.stage.playing) return this.stop();
    this.start();
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

  says(words, sign) {
    put(this.play, sign);
    this.play.setAttribute("aria-label", tr(words));
    this.play.title = tr(`${words} (space)`);
  }

  /** The pace on its slider, 0 to 1, and in words. */
  tellPace(share, words) {
    if (document.activeElement !== this.slow) this.slow.value = 100 * share;
    put(this.slowly, words);
    this.slow.setAttribute("aria-valuetext", tr(words));
  }

  /** The present moment on the slider of time and in digits. */
  tellMoment(time, units, digits = 4) {
    const { stage, scrub } = this;
    if (document.activeElement !== scrub || stage.playing) scrub.value = stage.length ? (1000 * time) / stage.length : 0;
    const now = performance.now();
    if (stage.playing && now - this.told < 100) return; // nobody reads digits that change with every frame
    this.told = now;
    const words = withUnit(time * units.time.k, units.time.name, digits);
    put(this.time, words);
    scrub.setAttribute("aria-valuetext", tr(words));
  }
}

/** The seconds that a cycle is shown for, evenly in ratios from `real` to `longest` by a share of 0 to 1; without one
 * from the view, the `usual` ones. */
export function paceOf(given, { real, usual, longest }) {
  const span = Math.log(longest / real);
  const share = given === "" ? Math.log(Math.max(usual, real) / real) / span : Number(given) / 100 || 0;
  const within = Math.min(Math.max(share, 0), 1);
  return { share: within, seconds: real * (longest / real) ** within };
}
