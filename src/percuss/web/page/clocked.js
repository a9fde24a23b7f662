// What panels say of cases that are not theirs: of a machine that switches itself, and of a structure that is held.

import { h } from "./dom.js";
import { isHeld, on, show, switchesItself } from "./state.js";

/** Put the sentences of a panel in its place when the case has no clock (`clocked`), or no free bar (`held`). */
export function tellOthers(section, { clocked, held }) {
  const notes = [];
  if (clocked) notes.push([switchesItself, noteOf(clocked, "machine", "Machine")]);
  if (held) notes.push([isHeld, noteOf(held, "branches", "Branches")]);
  if (!notes.length) return;
  section.prepend(...notes.map(([, note]) => note));
  const look = () => {
    for (const [is, note] of notes) note.hidden = !is();
    section.classList.toggle("away", notes.some(([is]) => is()));
  };
  on("tables view", look);
}

function noteOf(words, name, title) {
  const open = h("button", { type: "button", class: "link", onclick: () => show({ panel: name }) }, `Open the panel ${title}`);
  return h("div", { class: "card own", hidden: true }, h("p", {}, `${words} `, open));
}
