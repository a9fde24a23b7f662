import { quantity } from "/static/core/format.js";

/** @typedef {typeof import("./checks.js")} Checks */

/** @param {Checks} t */
export function a_quantity_is_a_number_and_a_unit(t) {
  t.equal(quantity("341 mm"), { value: 341, unit: "mm" });
}
