import { converted, kindOf, number, printed, read, shown } from "/static/core/units.js";

/** @typedef {typeof import("./checks.js")} Checks */

/** @param {Checks} t */
export function what_is_typed_is_read_in_the_unit_of_the_field(t) {
  const rows = /** @type {[string, string, number][]} */ ([
    ["0,36", "", 0.36],
    ["0.36", "", 0.36],
    [".5", "", 0.5],
    ["36 %", "", 0.36],
    ["36", "%", 36],
    ["32 cm", "mm", 320],
    ["320", "mm", 320],
    ["341 mm", "m", 0.341],
    ["1 050 1/min", "1/min", 1050],
    ["1\u202f050\u202f1/min", "Hz", 17.5],
    ["1'050,5", "bar", 1050.5],
    ["1,050.5", "bar", 1050.5],
    ["1.050,5", "bar", 1050.5],
    ["1,050,000", "Pa", 1050000],
    ["1.2e3", "N", 1200],
    ["1,2·10³ N", "kN", 1.2],
    ["1.2 × 10^-3 m", "mm", 1.2],
    ["−3 mm", "mm", -3],
    ["– 3", "mm", -3],
    ["12e3mm", "m", 12],
    ['12"', "mm", 304.8],
    ["40 Hz", "blows/min", 2400],
    ["2400 rpm", "Hz", 40],
    ["10 N·s/m²", "N*s/m^2", 10],
    ["3 kN/(m/s)", "N*s/m", 3000],
    ["10 L/min", "l/min", 10],
    ["90°", "rad", 1.5707963267949],
    ["2 N m", "J", 2],
  ]);
  for (const [text, unit, value] of rows) t.equal(read(text, unit), { value, unit }, text);
}

/** @param {Checks} t */
export function a_mark_that_may_mean_two_things_is_asked_back(t) {
  t.equal(read("1,050", "mm").remedy, "write 1050 or 1.050");
  t.equal(read("1.050", "mm", "de").remedy, "write 1050 or 1,050");
  t.equal(read("1,050", "mm", "de"), { value: 1.05, unit: "mm" });
  t.equal(read("1,050", "mm", "sv"), { value: 1.05, unit: "mm" });
  t.equal(read("0,341", "m"), { value: 0.341, unit: "m" });
}

/** @param {Checks} t */
export function a_unit_of_another_kind_is_refused_with_an_example(t) {
  const found = read("5 bar", "mm");
  t.equal(found.error, "“5 bar” is a pressure, and a length is needed");
  t.equal(found.remedy, "write a length, such as 320\u202fmm or 0.32\u202fm");
  t.equal(read("5 bar", "mm", "sv").remedy, "write a length, such as 320\u202fmm or 0,32\u202fm");
  t.equal(read("5 mm", "").error, "“5 mm” is a length, and a plain number is needed");
  t.equal(read("5 mPa", "bar").remedy, "did you mean MPa?", "a factor of 1e9");
  for (const text of [
    "",
    "five",
    "5 foo",
    "5e",
    "1e999",
    "5 m/",
    "5 (m",
    "5 m)",
    "5 /m",
    "5 m//s",
    "5 ^2",
    "5 m^",
    "5 1 2",
    "5 constructor",
  ])
    t.ok(read(text, "mm").error, text);
}

/** @param {Checks} t */
export function an_example_is_read_again(t) {
  for (const unit of ["mm", "bar", "l/min", "1/min", "kN*s/m", "J/m^3", "°", "%", "", "um/m"]) {
    const words = read("?", unit, "de").remedy ?? "";
    for (const text of words.replace(/^.*such as /, "").split(" or "))
      t.ok(read(text, unit, "de").value, `${unit}: ${text}`);
  }
}

/** @param {Checks} t */
export function quantities_are_shown_in_three_systems(t) {
  for (const system of /** @type {const} */ (["SI", "practical", "US"]))
    for (const unit of ["mm", "bar", "MPa", "l/min", "1/min", "J", "kN", "m/s", "kN/mm", "cm^3/bar", "rad"]) {
      const found = shown(12.34567, unit, system);
      t.close(converted(found.value, found.unit, unit), 12.34567, 1e-14, `${unit} in ${system} and back`);
    }
}

/** @param {Checks} t */
export function numbers_have_a_real_minus_and_as_many_digits_as_can_be_read(t) {
  t.equal(number(-0.012345, 3), "−0.0123");
  t.equal(number(1049.6), "1050");
  t.equal(number(123456, 6), "123456");
  t.equal(number(999.96), "1000");
  t.equal(number(1.234e-7), "1.23·10⁻⁷");
  t.equal(number(0), "0");
  t.equal(number(Number.NaN), "–");
  t.equal(printed("kN*s/m^2"), "kN·s/m²");
  t.equal(printed("um"), "µm");
  t.equal(kindOf("1/min"), "blow rate");
  for (const value of [1.5, -2e-9, 123456, 7.25e8, 0.001]) t.equal(read(number(value, 6), "").value, value);
}
