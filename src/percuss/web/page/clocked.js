// What the panels for clocked loads say of a machine that switches itself: a sentence, and where its answer is.

import { h } from "./dom.js";
import { on, show, switchesItself } from "./state.js";

/** Put the sentence of a panel in its place when the case has no clock. */
export function tellClocked(section, words) {
  const open = () => show({ panel: "machine" });
  const note = h("div", { class: "card own", hidden: true }, h("p", {}, `${words} `, h("button", { type: "button", class: "link", onclick: open }, "Open the panel Machine")));
  section.prepend(note);
  const look = () => {
    const own = switchesItself();
    note.hidden = !own;
    section.classList.toggle("away", own);
  };
  on("tables view", look);
}
