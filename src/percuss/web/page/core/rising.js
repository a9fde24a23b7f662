// Values of lists over others that rise, as the frames of a motion have them over its times.

/** A place between two of a list: the first of them, and the share of the way to the next. @typedef {[number, number]} Place */

/** Where a value is among those that rise. @param {ArrayLike<number>} rising @param {number} value @returns {Place} */
export function placeIn(rising, value) {
  let [low, high] = [0, rising.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rising[middle] <= value) low = middle;
    else high = middle;
  }
  const reach = rising[high] - rising[low];
  return [low, reach > 0 ? Math.min(Math.max((value - rising[low]) / reach, 0), 1) : 0];
}

/** What a list has at a place. @param {ArrayLike<number>} list @param {Place} place */
export const valueIn = (list, [i, share]) => (share ? list[i] + share * (list[i + 1] - list[i]) : list[i]);
