// What leaves the page: the link, the same as a command or as Python, and the page within another one.

import { writeAddress } from "../core/address.js";
import { post } from "../core/api.js";
import { button, div, h } from "../core/dom.js";
import { valueAt } from "../core/moves.js";
import { data, fileName, switchesItself, view } from "../core/state.js";
import { changed, toast } from "./header.js";

/** The menu of the head. */
export function shareMenu() {
  /** @param {string} id @param {string} words @param {() => string | Promise<string>} text */
  const copy = (id, words, text) => button(words, () => copied(words, text), { id });
  const embedded = () =>
    `<iframe src="${link().replace("#", "#embed=1&")}" width="960" height="600" title="percuss"></iframe>`;
  const menu = h(
    "details",
    { class: "menu", id: "share" },
    h("summary", { title: "Copy a link, a command, Python" }, "Share"),
    div(
      "sheet column",
      copy("share-link", "Copy link", link),
      copy("share-command", "Copy as command", command),
      copy("share-python", "Copy as Python", python),
      copy("share-embed", "Copy to embed", embedded),
      h(
        "p",
        { class: "small muted" },
        "For a class: add lock=restitution,load_factor to a link, and these stay as they are.",
      ),
    ),
  );
  addEventListener("pointerdown", (event) => {
    for (const one of document.querySelectorAll("details.menu[open]"))
      if (!one.contains(/** @type {Node} */ (event.target))) /** @type {HTMLDetailsElement} */ (one).open = false;
  });
  return menu;
}

/** @param {string} words @param {() => string | Promise<string>} text */
async function copied(words, text) {
  const menu = /** @type {HTMLDetailsElement} */ (document.getElementById("share"));
  menu.open = false;
  try {
    await navigator.clipboard.writeText(await text());
    toast(`${words.replace("Copy", "Copied")}.`);
  } catch (error) {
    toast(`Not copied: ${/** @type {Error} */ (error).message}`);
  }
}

function link() {
  writeAddress();
  return location.href;
}

const verb = () => (switchesItself() ? "machine" : "steady");

/** The answer of the page as a command of the shell. */
async function command() {
  if (view.machine && !changed().length) return `percuss ${verb()} ${view.machine}`;
  const { toml } = await post("case", { case: data.tables });
  return `percuss ${verb()} - <<'CASE'\n${toml.trimEnd()}\nCASE\n`;
}

/** The same in Python. */
async function python() {
  const answer = `${verb()}_answer`;
  if (!view.machine) {
    const { toml } = await post("case", { case: data.tables });
    const file = `${fileName()}.toml`;
    return `from pathlib import Path\n\nfrom percuss.case import Case, ${answer}\n\nPath("${file}").write_text('''\\\n${toml.replaceAll("\\", "\\\\")}''')\nprint(${answer}(Case.read("${file}")).to_json_dict())\n`;
  }
  const values = changed().map(([key]) => `    "${key}": ${literal(valueAt(data.tables, key))},\n`);
  const varied = values.length ? `.varied({\n${values.join("")}})` : "";
  return `from percuss.case import load_case, ${answer}\n\ncase = load_case("${view.machine}")${varied}\nprint(${answer}(case).to_json_dict())\n`;
}

/** @param {any} value */
const literal = (value) =>
  value === undefined
    ? "None"
    : JSON.stringify(value).replaceAll("true", "True").replaceAll("false", "False").replaceAll("null", "None");
