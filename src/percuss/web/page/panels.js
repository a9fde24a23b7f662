// The panels in the order of their tabs; the first one is shown at first. A new panel is a file and a line here. Each file
// exports its `panel`: the `name` in the address, the `title` of its tab, `start`, which fills its section, and, where it
// has them, the `defaults` of what it keeps in the address, what it `needs` of the answer to a slider, and what it says of
// cases that are not its own: of a machine without a clock (`clocked`), of a structure that is held (`held`).

import { panel as blow } from "./blow/blow_panel.js";
import { panel as branches } from "./branches/branches_panel.js";
import { panel as casePanel } from "./case/case_panel.js";
import { panel as experiment } from "./drawers/experiment_panel.js";
import { panel as hammer } from "./drawers/hammer_panel.js";
import { panel as lessons } from "./lessons/lessons_panel.js";
import { panel as machine } from "./machine/machine_panel.js";
import { panel as map } from "./map/map_panel.js";
import { panel as motion } from "./motion/motion_panel.js";
import { panel as orbits } from "./orbits/orbits_panel.js";
import { panel as report } from "./drawers/report_panel.js";

export const PANELS = [casePanel, map, orbits, branches, motion, machine, blow, hammer, report, experiment, lessons];
