// The panels in the order of their tabs; the first one is shown at first. A new panel is a file and a line here. Each file
// exports its `panel`: the `name` in the address, the `title` of its tab, `start`, which fills its section, and, where it
// has them, the `defaults` of what it keeps in the address, what it `needs` of the answer to a slider, and what it says of
// cases that are not its own: of a machine without a clock (`clocked`), of a structure that is held (`held`).

import { panel as blow } from "./blow_panel.js";
import { panel as branches } from "./branches_panel.js";
import { panel as casePanel } from "./case_panel.js";
import { panel as experiment } from "./experiment_panel.js";
import { panel as hammer } from "./hammer_panel.js";
import { panel as lessons } from "./lessons_panel.js";
import { panel as machine } from "./machine_panel.js";
import { panel as map } from "./map_panel.js";
import { panel as motion } from "./motion_panel.js";
import { panel as orbits } from "./orbits_panel.js";
import { panel as report } from "./report_panel.js";

export const PANELS = [casePanel, map, orbits, branches, motion, machine, blow, hammer, report, experiment, lessons];
