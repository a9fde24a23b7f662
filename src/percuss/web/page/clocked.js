// What panels say of cases that are not theirs: of a machine that switches itself, and of a structure that is held.

import { h, put } from "./core/dom.js";
import { isHeld, on, show, switchesItself } from "./core/state.js";

/** Whether a panel has nothing of the case but that sentence. */
export const isElsewhere = ({ clocked, held }) => Boolean((clocked && switchesItself()) || (held && isHeld()));

/** Put the sentence of a panel in its place when the case has no clock (`clocked`), or no free bar (`held`). */
export function tellOthers(section, { clocked, held }) {
  if (!clocked && !held) return;
  const words = h("p", {});
  const note = h("div", { class: "card own", hidden: true }, words);
  section.prepend(note);
  const look = () => {
    const own = clocked && switchesItself();
    const away = isElsewhere({ clocked, held });
    note.hidden = !away;
    section.classList.toggle("away", away);
    if (away) put(words, own ? [`${clocked} `, opener("machine", "Machine")] : [`${held} `, opener("branches", "Branches")]);
  };
  on("tables view", look);
}

const opener = (panel, title) => h("button", { type: "button", class: "link", onclick: () => show({ panel }) }, `Open the panel ${title}`);
