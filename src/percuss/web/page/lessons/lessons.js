// Nine lessons. A scene sets a case and a view and says one sentence; the learner predicts, looks and reaches a target,
// which is judged from what the page knows. A lesson ends with one question. The numbers are always the server's.

/** What a target is judged from: the steady motions and the one looked at, what a parameter stands at, the machine's
 * answer, the name of the live motion and the speeds of its blows under the present law, and answers of the drawers.
 * @typedef {{ orbits: { stable: boolean }[], number: number, stable: boolean, reason: string, m: number, machine: any,
 *   value: (name: string) => number, label: string, blows: number[], experiment: any, blow: any }} Now */
/** A question as the lessons have it, "words | choice | *the right one | why", and its parts.
 * @typedef {{ words: string, choices: string[], right: number, why: string }} Question */
/** What a scene says, asks and wants. @typedef {{ say: string, predict: string, target: string,
 *   reached: (now: Now) => boolean }} Words */
/** @typedef {{ show: string, view: Record<string, any>, case?: any, machine?: string, begin?: any } & Words} Scene */
/** @typedef {{ title: string, goal: string, scenes: Scene[], question: string }} Lesson */

const PLAIN = {};
const SECOND = { orbit: 2 };
const CONTACT = { contact: 1 };
const ENDS = { panel: "experiment", starts: 300, distribution: "wall", seed: 1, emodes: 0 };
const MAP = { x: "restitution", y: "load_factor", q: "verdict" };

/** @param {string} alongr @param {number} depth */
const branches = (alongr, depth) => ({ panel: "branches", along: "load_factor", alongr, depth, bmodes: 0 });

const blow = (/** @type {string} */ blowShow) => ({ panel: "blow", blowShow });
const machine = (/** @type {string} */ name) => ({ machine: name });

/** @param {string} show @param {Record<string, any>} setting @param {Record<string, any>} view @param {Words} words @returns {Scene} */
const scene = (show, setting, view, words) => ({ show, view, ...setting, ...words });

/** @param {number} factor @param {number} restitution @param {any} [begin] */
const pneumatic = (factor, restitution, begin) => ({
  case: {
    title: "Pneumatic hammer",
    system: { s: 20, d: 0.005, restitution },
    load: { kind: "harmonic", mean: factor, amplitude: 1.0 },
  },
  begin,
});

const REBOUND = { gap: 0, velocity: -2.4, phase: 2.85 }; // near that of the steady motion

/** @param {string} strain @param {number} kappa */
const square = (strain, kappa) => ({
  case: {
    title: "Square wave, by the clock",
    system: { s: 200, d: 0.0, restitution: 0.4, ...(strain && { strain }) },
    load: { kind: "square", amplitude: 1.0, kappa },
  },
});

/** The forces of the square wave, switched by the piston in the same rhythm. @param {number} [delay] */
const valve = (delay) => ({
  case: {
    title: "The same forces, switched by the piston",
    system: square("reversed", 1).case.system,
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

/** A piston of 200 mm at 10 m/s on an endless rod of 32 mm, or on another tool. @param {string} diameter @param {any} [more] */
const blown = (diameter, more = { tool: { sections: [{ diameter: "32 mm" }], end: "infinite" } }) => ({
  case: {
    title: "Piston on a rod",
    bar: { length: "200 mm", diameter, damping_ratio: 1e-3 },
    load: { kind: "harmonic", mean: "81.3 N", amplitude: "134 N", frequency: "20 Hz" },
    contact: { restitution: 0.3 },
    ...more,
    blow: { velocity: "10 m/s" },
  },
});
const ON_ROCK = {
  tool: { sections: [{ length: "1200 mm", diameter: "32 mm" }], end: "rock" },
  rock: { stiffness: "100 kN/mm", unloading_ratio: 0.3 },
};

/** After how many blows the last ones repeat, to 1 % of their speed; 0 for after none up to eight. @param {number[]} blows */
export function repeats(blows) {
  for (let p = 1; p <= 8 && blows.length >= Math.max(2 * p, 6); p++) {
    const last = blows.slice(-Math.max(2 * p, 6));
    const most = Math.max(...last);
    if (last.every((speed, i) => i < p || Math.abs(speed - last[i - p]) < 0.01 * most)) return p;
  }
  return 0;
}

/** @param {string} text @returns {Question} */
export function questionOf(text) {
  const [words, ...choices] = text.split(" | ");
  const why = choices.pop() ?? "";
  const right = choices.findIndex((choice) => choice.startsWith("*"));
  return { words, choices: choices.map((choice) => choice.replace("*", "")), right, why };
}

/** @param {Now} now */
const none = (now) => now.orbits.length > 0 && now.orbits.every(({ stable }) => !stable);

/** @type {Lesson[]} */
export const LESSONS = [
  {
    title: "Does it strike at all? The fold",
    goal: "A steady motion exists only while the load can give the speed that its mean requires. Raise the mean, and the two motions meet and vanish.",
    scenes: [
      scene("Two motions", pneumatic(0.6, 0.4), PLAIN, {
        say: "Below the map: the load over a period, and the moments at which the hammer can strike again and again, one for each of its two steady motions.",
        predict:
          "Raise the load factor. The two moments … | drift apart | *meet and vanish | At 0.734 they meet: the fold. A greater mean requires more speed at the blow than the alternating load can give.",
        target: "Cross the fold: make the verdict say that no steady motion is left.",
        reached: (now) => !now.orbits.length,
      }),
      scene("On the map", pneumatic(0.73, 0.4), MAP, {
        say: "On the map the fold is the solid curve: above it there is no steady motion.",
        predict:
          "A bar that rebounds better (a greater R) bears … | *a greater mean load | a smaller mean load | A blow takes the momentum (1 + R)v, so that less alternating speed is needed: the fold is near (1 + R)/(π(1 − R)).",
        target: "Find a steady motion at a load factor above 1.",
        reached: (now) => now.orbits.length > 0 && now.value("load_factor") > 1,
      }),
    ],
    question:
      "What vanishes at the fold? | the unstable motion | *both motions at once | the sound | The two are one motion there, with one moment of impact. Beyond it there is none.",
  },
  {
    title: "Does it stay? The flip",
    goal: "Of the two motions, one falls apart at once. The other is stable while the load at the impact stays in its band.",
    scenes: [
      scene("A stable motion", pneumatic(0.65, 0.4), SECOND, {
        say: "Below the map: the filled disc is stable, the ring is not. A stable blow falls into the green band of the load.",
        predict:
          "Both motions exist. How many of them can last? | *one | both | Where the load is above its mean, a late blow is a faster one, and the next comes later still: the least disturbance grows.",
        target: "Put the hammer on the other motion (1 in the verdict), and see it leave.",
        reached: (now) => now.number === 1 && !now.stable,
      }),
      scene("Across the flip", pneumatic(0.58, 0.4), SECOND, {
        say: "Still stable, but only just: the blow is near the lower edge of the band.",
        predict:
          "Lower the load factor. The motion … | becomes safer | vanishes | *becomes unstable | At 0.551 the blow leaves the band and a multiplier passes −1: the flip. The motion exists, but every second blow differs.",
        target: "Cross the flip: make the verdict say that the motion is unstable.",
        reached: (now) => now.number === 2 && !now.stable && now.value("load_factor") < 0.56,
      }),
      scene("The strip", pneumatic(0.6, 0.4), MAP, {
        say: "On the map, stable hammers lie between the dashed curve (flip) and the solid one (fold).",
        predict:
          "For smaller restitutions the strip … | widens | *narrows | From 0.55–0.73 at R = 0.4 to 0.39–0.47 at R = 0.2: a blow that loses much is hard to tune.",
        target: "Find a stable motion with R below 0.25.",
        reached: (now) => now.stable && now.value("restitution") < 0.25,
      }),
    ],
    question:
      "A multiplier is −1.57. A disturbance … | dies out | *grows, first late, then early | grows to one side | It is multiplied by −1.57 at every blow: it grows, and changes its sign.",
  },
  {
    title: "Hear period doubling",
    goal: "Below the flip the blows alternate, strong and weak; then four take turns; then they never repeat. Turn the sound on (♪).",
    scenes: [
      scene("One blow", pneumatic(1.0, 0.8), PLAIN, {
        say: "Play, turn on the sound (♪), and hear the even beat. Then lower the load factor below 0.926; the motion goes on.",
        predict:
          "Below the flip the blows … | cease | *take turns, strong and weak | come twice as fast | The motion repeats after two blows in two periods: z=2/2, two dots in the corner of the map.",
        target: "Hear strong, weak, strong, weak: two blows that take turns.",
        reached: (now) => none(now) && repeats(now.blows) === 2,
      }),
      scene("Two by two", pneumatic(0.86, 0.8), PLAIN, {
        say: "Go on, slowly: lower the load factor in steps of 1 % (arrow keys). Lost in another rhythm? Press this scene again.",
        predict:
          "What comes after two by two? | three by three | *four by four | no repetition | The motion of two blows flips as well, at 0.813: four unequal blows, z=4/4, four dots.",
        target: "Make four different blows take turns.",
        reached: (now) => none(now) && repeats(now.blows) === 4,
      }),
      scene("Four by four", pneumatic(0.805, 0.8, REBOUND), PLAIN, {
        say: "Four blows take turns. The next flips follow sooner and sooner: all of them lie above 0.794.",
        predict:
          "Below all of them the blows … | repeat after a hundred | *never repeat | No two blows are alike, and yet each follows from the one before: the dots fill a curve.",
        target: "Make it never repeat: 16 blows without a pattern.",
        reached: (now) => now.value("load_factor") < 0.794 && now.blows.length >= 16 && !repeats(now.blows),
      }),
    ],
    question:
      "Is the last motion random? | yes | *no | Every blow is computed from the one before. But a hair's breadth grows, so that nobody can foretell it for long.",
  },
  {
    title: "The same hammer, other motions",
    goal: "Several motions live side by side. How you start the hammer decides which one you get.",
    scenes: [
      scene("Half as often", pneumatic(0.945, 0.8), PLAIN, {
        say: "One blow in every period is stable here. Under “more” the sliders have m, the load periods per blow.",
        predict:
          "One blow in two periods has … the energy. | the same | twice | *four times | The mean load gives twice the momentum in two periods, so that the speed is twice as great: stable as well.",
        target: "Find a stable motion with one blow in two periods, m = 2.",
        reached: (now) => now.m === 2 && now.stable,
      }),
      scene("Count the ends", pneumatic(0.945, 0.8), ENDS, {
        say: "Follow the same hammer from 300 random starts.",
        predict:
          "Where do most of them end? | *in chatter | one blow in one period | one blow in two | About half end in chatter, and only some 4 in 100 find the motion of twice the power.",
        target: "Press Start, and count all 300.",
        reached: (now) => now.experiment?.starts >= 300,
      }),
    ],
    question:
      "Which of the two steady motions has the greater power? | one blow in one period | *one blow in two | neither | Four times the energy, half as often: twice the power.",
  },
  {
    title: "Chatter and rest",
    goal: "While the load pushes, ever smaller bounces end in a finite time. The bar rests until the load pulls.",
    scenes: [
      scene("Chatter", pneumatic(0.9, 0.2), CONTACT, {
        say: "Play. The inset magnifies the contact: each bounce lasts R times as long as the one before; then the bar lies still until the load pulls.",
        predict:
          "How many bounces are there before it lies still? | seven | *infinitely many | Infinitely many in a finite time, 2w/((1 − R)P): a geometric series. Above a load factor of 1 the load never pulls.",
        target: "Make it lie still for good: raise the load factor until the load never pulls.",
        reached: (now) => now.label === "rest",
      }),
      scene("Rest for good", pneumatic(1.1, 0.5), CONTACT, {
        say: "The mean is greater than the amplitude: the load always pushes, and the bar rests.",
        predict:
          "Below which load factor does it leave the wall? | *1 | 0.734 | 0 | 0.9 + cos t, say, pulls for a while: there the bar leaves, and its blows end in chatter again.",
        target: "Make it leave again and again: chatter once a period.",
        reached: (now) => now.label === "chatter/1",
      }),
    ],
    question:
      "Why is every cycle with a rest the same? | the load is periodic | *it always leaves from the same state | It leaves undeformed, at rest, at the phase at which the load turns: a rest forgets all that was before.",
  },
  {
    title: "Why the hydraulic hammer of 1977 cannot settle",
    goal: "A square wave is always at full push or full pull at the impact: outside the band. A real pressure falls gently.",
    scenes: [
      scene("The square wave", square("", 1.3), PLAIN, {
        say: "A square load on a stiff bar. Below the map: both blows lie outside the green band, on the edges of the wave.",
        predict:
          "Is there a κ with a stable motion? | yes | *no | The load is ±1/(κ − 1) of its mean, with κ below 2: above 1 or below −1, and the band lies between.",
        target: "Try: move κ by at least 0.2. Both motions stay unstable.",
        reached: (now) => none(now) && Math.abs(now.value("kappa") - 1.3) >= 0.199,
      }),
      scene("A real drifter", machine("hydraulic-drifter"), PLAIN, {
        say: "A drifter as it is built: its pressure rises and falls smoothly, and it settles.",
        predict:
          "Where does its blow fall? | at full push | at full pull | *where the load is small | At 0.25 of the mean, in the band. A greater R narrows the band from below: near 0.35 the blow is outside.",
        target: "Break it: raise the restitution until the motion is unstable.",
        reached: none,
      }),
    ],
    question:
      "What makes the drifter stable? | its greater power | *a valve that opens gradually | its longer bar | The load passes through all values between push and pull, so that the blow can fall into the band.",
  },
  {
    title: "Why a thick piston strikes twice",
    goal: "A piston stops in one contact only where it has the impedance of the rod. A thicker one pushes on, in steps.",
    scenes: [
      scene("As thick as the rod", blown("32 mm"), blow("start"), {
        say: "Play. One rectangular wave, twice as long as the piston, runs into the rod, and the piston stands still.",
        predict:
          "A thicker piston makes the wave … | *longer, in steps that grow smaller | shorter | bounce back | Each time its own wave comes back it still has speed, and it pushes again, more weakly.",
        target: "Make the striker at least 48 mm thick, and see the steps.",
        reached: (now) => now.value("bar.diameter") >= 48 && now.blow,
      }),
      scene("A rod with an end", blown("50 mm", ON_ROCK), blow("window"), {
        say: "A rod of 1.2 m stands on rock. What the rock does not take comes back, and meets the piston that has followed: further contacts.",
        predict:
          "How does one get a single contact? | with a thicker striker | *with a thinner striker | A thin striker has rebounded before the wave comes back.",
        target: "Leave one contact: change the diameter of the striker.",
        reached: (now) => now.blow?.contacts === 1,
      }),
    ],
    question:
      "A piston gives all its energy in one contact when it has the rod's … | *impedance | length | mass | Equal impedances reflect nothing at the contact: when its wave has come back once, the piston is at rest.",
  },
  {
    title: "Why yours settles: the valve",
    goal: "A clock does not listen: a blow that comes late stays late. A valve waits for the piston, and no phase can go wrong.",
    scenes: [
      scene("The clock", square("reversed", 1.659), SECOND, {
        say: "A load that pulls with the force 1, then pushes with the force 1, by the clock.",
        predict:
          "How many of its two motions are stable? | *none | one | Where the load jumps, the least delay of a blow grows with the next one.",
        target: "Look at the other motion, too (1 in the verdict).",
        reached: (now) => now.number === 1 && !now.stable,
      }),
      scene("A valve", valve(), PLAIN, {
        say: "The same piston, forces, period and speed; but the piston switches: a port 1.839 lengths behind the wall orders the push, the blow orders the pull.",
        predict:
          "What decides how fast it settles? | the forces | the places of the ports | *the restitution | Of a disturbance no more than R is left after a blow: 0.2³ is below 1 %.",
        target: "Make it settle in 3 cycles.",
        reached: (now) => now.machine?.runs && now.machine.modes && / [123] cycles?/.test(now.machine.settles ?? ""),
      }),
      scene("A late valve", valve(1.2), PLAIN, {
        say: "The pull comes 1.2 after the blow, and the machine still runs.",
        predict:
          "What if it comes still later? | it stops | *it strikes twice | From 1.86 on the piston has fallen back to the wall before the pull comes.",
        target: "Make it strike twice: raise the delay of the blow's order.",
        reached: (now) => now.machine?.answer.outcome === "double blow",
      }),
      scene("A breaker", machine("valve-breaker"), PLAIN, {
        say: "A hydraulic breaker of the 20 t class, at 160 bar.",
        predict:
          "With half the pressure it … | strikes half as hard | *stops | Its gas no longer lets it reach the port that switches: the verdict says what would be needed.",
        target: "Lower the pressure until it stops.",
        reached: (now) => now.machine?.answer.outcome === "stalls",
      }),
    ],
    question:
      "Why does the valve cure the square wave? | its forces are smaller | *it waits for the piston | There is no clock to be late for: a disturbance only decays.",
  },
  {
    title: "Down the cascade",
    goal: "At a flip the motion goes on, unstable, and one of twice the period begins beside it; that one flips, too, sooner and sooner.",
    scenes: [
      scene("One branch", pneumatic(0.95, 0.8), branches("0.78:1", 0), {
        say: "The line is the motion with one blow a period, solid where it is stable; at the triangle, 0.926, it flips.",
        predict:
          "Below the flip this motion … | *goes on, unstable | ends | The dashed part: it is there, but every disturbance grows. No simulation shows it.",
        target: "Go there: bring the load factor below 0.926, onto the dashed line.",
        reached: (now) => none(now) && now.value("load_factor") < 0.926,
      }),
      scene("Strong and weak", pneumatic(0.9, 0.8), branches("0.78:1", 1), {
        say: "Two lines leave the flip: one motion, whose two blows take turns. Where they turn dashed, it flips as well.",
        predict:
          "Going down, the two lines … | come together again | *drift apart and flip again | Strong and weak differ more and more, until this motion flips at 0.813 and four blows take turns.",
        target: "Bring the load factor to the second flip, to within 0.003.",
        reached: (now) => Math.abs(now.value("load_factor") - 0.8133) < 0.003,
      }),
      scene("The cascade", pneumatic(0.9, 0.8), branches("0.785:0.95", 4), {
        say: "Flips at 0.9262, 0.8133, 0.7972, 0.7945, 0.7940: divide each interval by the next one.",
        predict:
          "The ratios 7.0, 5.9, 4.8 … tend to | 1 | *4.669 | 0 | Feigenbaum's number, whatever it is that doubles: a hammer, a circuit, a dripping tap.",
        target: "Go below all of them: a load factor under 0.794.",
        reached: (now) => now.value("load_factor") < 0.794,
      }),
    ],
    question:
      "Where are the motions of the cascade below its end? | gone | *still there, unstable | The motion that never repeats comes near one of them after another.",
  },
];
