// The page's start: its parts, the catalogue, and the state from the address.

import { get, problemsOf, takeToken } from "./core/api.js";
import { followAddress, fromAddress, keepAddress } from "./core/address.js";
import { $ } from "./core/dom.js";
import { data, setTables, wish } from "./core/state.js";
import { during } from "./core/under_way.js";
import { PANELS } from "./panels.js";
import { usePalette } from "./pictures/colours.js";
import { startDrawers } from "./screen/drawers.js";
import { startHeader } from "./screen/header.js";
import { startHeadline } from "./screen/headline.js";
import { startMap } from "./map/map_panel.js";
import { watchPreparing } from "./screen/preparing.js";
import { startScenes } from "./screen/scenes.js";
import { startSliders } from "./screen/sliders.js";
import { translate } from "./core/words.js";

const FIRST = "mini-breaker";

/** @type {Promise<any> | null} */
let server = null;
/** What the server is; its palette is taken with it. */
const about = () => (server ??= get("about").then((found) => (usePalette(found.palette), found)));

/** @param {string} address */
async function load(address) {
  const served = async () => ((await about()).case ? get("case") : null);
  const newest = wish();
  const [{ info, tables, base }] = await Promise.all([fromAddress(address, FIRST, served), about()]);
  if (!newest()) return;
  data.base = base;
  data.physical = null;
  setTables(tables, info ?? data.info);
}

/** @param {unknown} error */
function failed(error) {
  data.problems = problemsOf(error);
  data.machines = [...data.machines]; // a machine that did not come is not the one that is shown
}

async function start() {
  takeToken();
  translate(document.body);
  startHeader(PANELS, failed);
  startScenes();
  startMap($("#map-place"));
  const fetchAhead = startDrawers(PANELS);
  startHeadline();
  startSliders();
  try {
    const catalogue = get("machines");
    const case_ = load(location.hash).catch(failed); // a link may name a machine that there is not
    data.about = await about();
    watchPreparing(data.about);
    Object.assign(data, await catalogue); // machines and structures
    await case_;
  } catch (error) {
    failed(error);
  }
  keepAddress();
  followAddress((hash) => load(hash).catch(failed));
  document.documentElement.dataset.ready = "1";
  fetchAhead();
}

during("start", start());
