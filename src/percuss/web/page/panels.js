// The drawers in the order of their buttons, and the places of the head: the name in the address, the title, what is kept
// in the address, what it `needs` of the answer to a slider, whether it is of `clocked` loads or of `free` bars only. What
// fills its section is the `start` of a module, when it is opened; an `early` one starts when the page has nothing else to
// do, as files can be dropped anywhere.

/** @type {import("./screen/drawers.js").Panel[]} */
export const PANELS = [
  {
    name: "orbits",
    title: "All motions",
    needs: { curve: 361, multipliers: true },
    load: () => import("./orbits/orbits_panel.js"),
  },
  {
    name: "branches",
    title: "Branches",
    defaults: {
      along: "load_factor",
      alongr: "", // the range "from:to", empty for the server's
      up: "phase",
      begin: "", // "2/1:3"; empty for the motion of the head
      depth: 1, // how often to go on at flips
      bmodes: 8,
      every: "", // "3/3": with all branches up to this label
      settled: 0, // 1: with what simulations settle on
      spot: "", // the place that is looked at: "value,phase of its first impact"
      branchSlow: "",
    },
    load: () => import("./branches/branches_panel.js"),
  },
  {
    name: "blow",
    title: "One blow by waves",
    defaults: {
      blowShow: "start",
      blowSlow: 12, // seconds that all that is shown takes
    },
    free: true,
    load: () => import("./blow/blow_panel.js"),
  },
  {
    name: "experiment",
    title: "Random starts",
    defaults: { starts: 300, distribution: "wall", seed: 1, emodes: 0 },
    load: () => import("./drawers/experiment_panel.js"),
  },
  {
    name: "hammer",
    title: "Design and tolerance",
    defaults: { ask: "design" },
    load: () => import("./drawers/hammer_panel.js"),
  },
  { name: "case", title: "Case as a form", early: true, load: () => import("./case/case_panel.js") },
  {
    name: "lessons",
    title: "Lessons",
    place: "head",
    defaults: {
      lesson: 0,
      scene: 0, // of the lesson, from 1
      projector: 0, // 1: only verdict, stage, map and the sentence, in large type
    },
    load: () => import("./lessons/lessons_panel.js"),
  },
  { name: "report", title: "Report", place: "head", load: () => import("./drawers/report_panel.js") },
];
