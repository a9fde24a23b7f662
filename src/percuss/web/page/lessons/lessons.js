// Nine guided lessons. Each sets a scene (a case and a view) and says what to try; the numbers are always the server's.

const ORBITS = { panel: "orbits", m: 1 };
const MAP = { panel: "map", x: "restitution", y: "load_factor", q: "verdict" };
const heard = (cycles) => ({ panel: "motion", source: "start", window: "settled", cycles });

const branches = (range, depth) => ({ panel: "branches", along: "load_factor", alongr: range, depth, bmodes: 0 });

/** A scene: its button, its view, its setting ({case, start?} or {machine}), what is said. */
const scene = (show, view, setting, say) => ({ show, view, say, ...setting });

const pneumatic = (factor, restitution, start) => ({
  case: {
    title: "Pneumatic hammer",
    system: { s: 20, d: 0.005, restitution },
    load: { kind: "harmonic", mean: factor, amplitude: 1.0 },
  },
  start,
});

const square = (start) => ({
  case: {
    title: "Hydraulic hammer, square wave",
    system: { s: 200, d: 0.0, restitution: 0.4 },
    load: { kind: "square", amplitude: 1.0, kappa: 1.3 },
  },
  start,
});

// starts: let go half a bar length off the wall, and near the rebound of the steady motion
const FALL = { position: -0.5, velocity: 0, time: 0.3 };
const REBOUND = { position: 0, velocity: -2.4, time: 2.85 };

const ROCK = { stiffness: "100 kN/mm", unloading_ratio: 0.3 };

/** A piston of 200 mm at 10 m/s on an endless rod of 32 mm, or on another tool. */
const blown = (diameter, tool = { sections: [{ diameter: "32 mm" }], end: "infinite" }, rock) => ({
  case: {
    title: "Piston on a rod",
    bar: { length: "200 mm", diameter, damping_ratio: 1e-3 },
    load: { kind: "harmonic", mean: "81.3 N", amplitude: "134 N", frequency: "20 Hz" },
    contact: { restitution: 0.3 },
    tool,
    ...(rock && { rock }),
    blow: { velocity: "10 m/s" },
  },
});

/** A square wave that keeps time by itself; and the same two forces, switched by the piston in the same rhythm. */
const CLOCK = {
  case: {
    title: "Square wave, clocked",
    system: { s: 200, d: 0.0, restitution: 0.4, strain: "reversed" },
    load: { kind: "square", amplitude: 1.0, kappa: 1.659 },
  },
};
const valve = (delay) => ({
  case: {
    title: "The same forces, switched by the piston",
    system: CLOCK.case.system,
    load: {
      kind: "valve",
      states: { return: -1.0, power: 1.0 },
      ports: [
        { behind: 1.839, side: "back", to: "power" },
        { on: "impact", to: "return", ...(delay && { delay }) },
      ],
    },
  },
});

export const LESSONS = [
  {
    title: "Does it strike at all? Existence and the fold",
    goal: "A steady motion exists where the curve v_f reaches the level. Raise the mean load, and the two motions meet and vanish.",
    scenes: [
      scene(
        "Set the scene",
        ORBITS,
        pneumatic(0.6, 0.4),
        "The curve is the speed that the load alone would give the bar; the dashed level is the speed that the mean load requires at each blow. They cross twice: two steady motions.",
      ),
      scene(
        "Just before the fold",
        ORBITS,
        pneumatic(0.73, 0.4),
        "Now move the load factor to the right. The level rises and the two crossings come together: that is the fold. Beyond it no steady motion is left, and the headline says so.",
      ),
      scene(
        "See it on the map",
        MAP,
        pneumatic(0.73, 0.4),
        "On the map the fold is the solid curve. Above the curve there is no steady motion; drag the point across it.",
      ),
    ],
  },
  {
    title: "Does it stay? Stability and the flip",
    goal: "Of the two motions, one falls apart at once. The other is stable only while the load at the moment of impact stays within its band.",
    scenes: [
      scene(
        "A stable motion",
        { ...ORBITS, orbit: 2 },
        pneumatic(0.65, 0.4),
        "The filled disc is stable, the ring is not. In the load chart, the blow must fall in the green band. Disturbances whose multipliers lie inside the unit circle die out.",
      ),
      scene(
        "Across the flip",
        { ...ORBITS, orbit: 2 },
        pneumatic(0.58, 0.4),
        "Still stable, but only just. Lower the load factor: at about 0.55 the moment of impact slides down out of the band, and one multiplier passes −1: the flip. Beyond it every second blow differs.",
      ),
      scene(
        "The strip on the map",
        MAP,
        pneumatic(0.6, 0.4),
        "Between the dashed curve (flip) and the solid one (fold) lies the strip of stable hammers. It narrows for small restitutions and widens for large ones.",
      ),
    ],
  },
  {
    title: "Hear period doubling",
    goal: "Below the flip the blows alternate, strong and weak; further down they take four periods to repeat, then they never repeat. Turn the sound on.",
    scenes: [
      scene(
        "One blow, always the same",
        heard(8),
        pneumatic(1.0, 0.8, REBOUND),
        "Stable: every blow is the same. Turn on the sound above, and listen to the even beat.",
      ),
      scene(
        "Two by two",
        heard(8),
        pneumatic(0.86, 0.8, REBOUND),
        "The load factor is a little smaller. Strong, weak, strong, weak: the motion repeats after two blows, the impact chart shows two points, and the motion is called z=2/2.",
      ),
      scene(
        "Four by four",
        heard(8),
        pneumatic(0.805, 0.8, REBOUND),
        "Smaller still: the motion repeats after four blows.",
      ),
      scene(
        "Never the same",
        heard(32),
        pneumatic(0.788, 0.8, REBOUND),
        "Now the motion never repeats: the points in the impact chart fill a curve. Find what lies in between with the load factor slider.",
      ),
    ],
  },
  {
    title: "The same hammer, other motions",
    goal: "Several motions live side by side. How you start the hammer decides which one you get.",
    scenes: [
      scene(
        "One blow in one period",
        ORBITS,
        pneumatic(0.945, 0.8),
        "A hard contact, R = 0.8: one blow every load period is stable.",
      ),
      scene(
        "One blow in two",
        { panel: "orbits", m: 2 },
        pneumatic(0.945, 0.8),
        "The same case with one blow in two load periods, harder and half as often. It is stable as well.",
      ),
      scene(
        "Count the ends",
        { panel: "experiment", m: 1, starts: 300, distribution: "wall", seed: 1, emodes: 0 },
        pneumatic(0.945, 0.8),
        "Follow the hammer from 300 random starts and count where they end: press Start. Some end in chatter, and some in a motion of three unequal blows.",
      ),
    ],
  },
  {
    title: "Chatter and rest",
    goal: "While the load pushes, ever smaller bounces accumulate in a finite time. The bar comes to rest on the wall and leaves when the load pulls.",
    scenes: [
      scene(
        "Chatter, rest, release",
        heard(4),
        pneumatic(0.9, 0.2, FALL),
        "Watch the striking end: the bounces grow smaller and closer until it lies still; then the load reverses and pulls it away.",
      ),
      scene(
        "Rest for good",
        { panel: "motion", source: "start", window: "start", cycles: 8 },
        pneumatic(1.1, 0.5, FALL),
        "Here the mean is greater than the amplitude: the load never pulls, and the bar rests for good.",
      ),
      scene(
        "In the report",
        { panel: "report" },
        pneumatic(1.1, 0.5),
        "The report says whether the bar can lie at rest, and gives the least force that holds it there.",
      ),
    ],
  },
  {
    title: "Why the hydraulic hammer of 1977 cannot settle, and a real one does",
    goal: "A square wave is always at full push or full pull at the moment of impact: outside the band, however it is tuned. A real pressure falls gently.",
    scenes: [
      scene(
        "The square wave",
        ORBITS,
        square(),
        "A square load, κ = 1.3, on a stiff bar without damping. Both motions lie outside the green band, on the edges of the wave.",
      ),
      scene(
        "See what it does",
        heard(16),
        square(FALL),
        "The blows are not equal: many different ones follow, some of them chatter, before anything repeats. Look at the impact chart and at the name of the motion.",
      ),
      scene(
        "A real drifter",
        ORBITS,
        { machine: "hydraulic-drifter" },
        "A drifter as it is built: its pressure rises and falls smoothly, and the blow comes where the pressure is low, inside the band. The hammer settles.",
      ),
    ],
  },
  {
    title: "Why a thick piston strikes twice",
    goal: "A piston stops in one contact only where it has the impedance of the rod. A thicker one keeps part of its speed and pushes on, in steps that grow smaller.",
    scenes: [
      scene(
        "As thick as the rod",
        { panel: "blow", blowShow: "start" },
        blown("32 mm"),
        "Press Play. One rectangular wave runs into the rod. It is twice as long as the piston, and the piston has nothing left: it stands still.",
      ),
      scene(
        "Thicker",
        { panel: "blow", blowShow: "start" },
        blown("50 mm"),
        "Now the wave goes down in steps. The head of the piston is heavier than the wave can stop, so that each time its own wave comes back it pushes again, more weakly. The rod carries it all away.",
      ),
      scene(
        "A rod with an end",
        { panel: "blow", blowShow: "window" },
        blown("50 mm", { sections: [{ length: "1200 mm", diameter: "32 mm" }], end: "rock" }, ROCK),
        "The rod is 1.2 m long and stands on rock. What the rock does not take comes back as a wave and meets the piston, which has followed the rod: further contacts. Draw the diameter of the striker down to 24 mm: it has rebounded by then, and one contact is left.",
      ),
    ],
  },
  {
    title: "Why the hammer of 1977 could not settle, and yours does: the valve",
    goal: "A clock does not listen: a blow that comes late stays late. A valve waits for the piston, so that no phase is left to go wrong.",
    scenes: [
      scene(
        "The clock",
        ORBITS,
        CLOCK,
        "A load that pulls with the force 1, then pushes with the force 1, in its own rhythm. It has two steady motions, and neither is stable: where the load jumps, the least delay of a blow grows with the next one.",
      ),
      scene(
        "See what it does",
        heard(16),
        { ...CLOCK, start: FALL },
        "From a start the hammer does not settle on equal blows.",
      ),
      scene(
        "The same machine with a valve",
        { panel: "machine" },
        valve(0),
        "The same piston, the same two forces, the same period of 2π, the same speed. Now the piston switches them: a port 1.839 bar lengths behind the wall orders the push, the blow orders the pull. It runs: of a disturbance no more than R, 40 %, is left after each blow; of its rhythm R², 16 %, whatever the ports and the forces are. Move every slider: it settles at once.",
      ),
      scene(
        "A valve that is late",
        { panel: "machine" },
        valve(1.2),
        "The pull comes 1.2 after the blow, and the machine still runs. Move the delay of the blow to the right: at 1.86 the piston has fallen back to the wall before the pull comes, and it strikes twice.",
      ),
      scene(
        "A breaker of today",
        { panel: "machine" },
        { machine: "valve-breaker" },
        "A hydraulic breaker of the 20 t class. Lower the pressure until it stops, and read what would be needed; add gas, and see that it may run and still not start from rest.",
      ),
    ],
  },
  {
    title: "Down the cascade",
    goal: "At a flip the motion does not end: it goes on unstable, and beside it one of twice the period begins. That one flips, too, and so on, sooner and sooner.",
    scenes: [
      scene(
        "One branch",
        branches("0.78:1", 0),
        pneumatic(0.95, 0.8),
        "The line is the motion with one blow in every load period, at every load factor. It is solid where it is stable; at the triangle, 0.926, it flips. No simulation shows the dashed part, for every disturbance grows there. Click on it: the motion is there all the same. Turn on the sound, and listen to the even beat.",
      ),
      scene(
        "Strong and weak",
        branches("0.78:1", 1),
        pneumatic(0.9, 0.8),
        "Two lines leave the flip: one motion, whose two blows take turns. Click close to the triangle and drag down along the line: strong and weak drift apart, until this motion flips as well, at 0.813.",
      ),
      scene(
        "Down the cascade",
        branches("0.785:0.95", 4),
        pneumatic(0.9, 0.8),
        "Four blows, eight, sixteen. Read the flips in the table: 0.9262, 0.8133, 0.7972, 0.7945, 0.7940. Divide each interval by the next one: 7.0, 5.9, 4.8. The ratios tend to 4.669, as in every such cascade, whatever it is that doubles. Click on z=4/4, and listen.",
      ),
      scene(
        "At its end",
        heard(32),
        pneumatic(0.788, 0.8, REBOUND),
        "Below all flips nothing is left of the cascade that is stable: the blows never repeat. The motions of the cascade are all still there, unstable, and this one comes near one of them after another.",
      ),
    ],
  },
];
