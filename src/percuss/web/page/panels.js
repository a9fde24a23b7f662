// The drawers in the order of their buttons, and the places of the head. A new one is a file and a line here. Each file
// exports its `panel`: the `name` in the address, the `title`, `start`, which fills its section, and, where it has them,
// the `defaults` of what it keeps in the address, what it `needs` of the answer to a slider, and whether it is of `clocked`
// loads or of `free` bars only.

import { panel as blow } from "./blow/blow_panel.js";
import { panel as branches } from "./branches/branches_panel.js";
import { panel as casePanel } from "./case/case_panel.js";
import { panel as experiment } from "./drawers/experiment_panel.js";
import { panel as hammer } from "./drawers/hammer_panel.js";
import { panel as lessons } from "./lessons/lessons_panel.js";
import { panel as orbits } from "./orbits/orbits_panel.js";
import { panel as report } from "./drawers/report_panel.js";

export const PANELS = [orbits, branches, blow, experiment, hammer, casePanel, lessons, report];
