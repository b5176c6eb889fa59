// Arrays of numbers, of which some may be no number.

/** Return values times a factor; the same ones if that is 1. */
export const scaled = (values, factor) => (factor === 1 ? values : values.map((each) => each * factor));

/** Return the smallest and the largest value, or wider limits that are given. */
export function extremes(values, [low, high] = [Infinity, -Infinity]) {
  for (const each of values) {
    if (each < low) low = each;
    if (each > high) high = each;
  }
  return [low, high];
}

/** Return the place of the value that lies nearest to another one. */
export function nearestIn(values, value) {
  let best = 0, least = Infinity;
  values.forEach((each, place) => {
    const away = Math.abs(each - value);
    if (away < least) [best, least] = [place, away];
  });
  return best;
}
