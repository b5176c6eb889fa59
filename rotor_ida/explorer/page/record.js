// A measured record: columns of numbers from text, the angle of the rotor, and orders and spectra.
// The definitions are those of rotor_ida.signals, so that both come to the same numbers.

const TURN = 2 * Math.PI;
// Lines before the numbers in which instruments tell about themselves.
const MOST_HEAD = 200;
const FEWEST_SAMPLES = 16;
// A step that is so much longer than the usual one is a gap; times are equally spaced to so much of a step.
const GAP = 1.5, UNEQUAL = 0.01;
// Nearer to one line, the sine of the angle between, two probes tell of one direction only.
const NEARLY_ALONG = 1e-3;
// Samples that stay at the largest or smallest reading.
const CLIPPED = 4;
// Of a window: a sample at its edge belongs to it, whatever rounding did to its angle.
const EDGE = 1e-9, SLACK = 1e-9;
const BESIDE = 3;
// Pulses: how many there must be, and which intervals have lost or gained one.
const FEWEST_PULSES = 3, LONGER = 1.5, SHORTER = 0.6, ALIKE = 1.15;
const LOW = 0.4, HIGH = 0.6;
// A speed that changes by less than that is one speed.
const STEADY = 1e-3;
// Samples of a spectrum, and how many spectra are kept.
const FEWEST = 128, MOST = 4096, MOST_ROWS = 240;
const OVERLAP = 0.5;
const FURTHEST = 2.5, ORDERS = 5;
const FLAT_TOP = [0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368];
const HANN = [0.5, 0.5];

const GUESSES = {
  t: ["t", "time", "times", "zeit", "seconds"],
  x: ["x", "probe x", "x probe", "probe_x", "probe 1", "probe1", "horizontal", "ch1", "1"],
  y: ["y", "probe y", "y probe", "probe_y", "probe 2", "probe2", "vertical", "ch2", "2"],
  keyphasor: ["keyphasor", "key", "kph", "kp", "tacho", "tachometer", "trigger", "pulses", "3"],
  angle: ["angle", "theta", "phase", "shaft angle", "shaft_angle"],
};
const TIMES = { s: 1, sec: 1, ms: 1e-3, us: 1e-6, "µs": 1e-6, min: 60 };
const ANGLES = { rad: 1, radian: 1, deg: Math.PI / 180, "°": Math.PI / 180, degree: Math.PI / 180, rev: TURN };
const LENGTHS = ["m", "mm", "um", "nm", "in", "mil", "V", "mV"];
const ALIASES = { "µm": "um", "μm": "um", mils: "mil", "": "1" };
const KNOWN = new Set([...Object.keys(TIMES), ...Object.keys(ANGLES), ...LENGTHS, ...Object.keys(ALIASES), "1"]);

/** What is wrong with a file, in one line. */
export class Refusal extends Error {}
const refuse = (text) => {
  throw new Refusal(text);
};
const shown = (text) => `"${text.length > 40 ? `${text.slice(0, 39)}…` : text}"`;
const short = (value) => String(Number(value.toPrecision(6)));

// columns

/** Return the columns of text with commas, semicolons, tabs or blanks between the numbers. */
export function columnsOf(text) {
  const { separator, begin, head, width, decimal } = beginningOf(text);
  const { names, units } = namesOf(head, width);
  const columns = names.map(() => []);
  let row = 0;
  forEachLine(text, begin, (line) => {
    const cells = split(line, separator);
    row += 1;
    if (cells.length !== width) refuse(`row ${row} of the numbers must have ${width} columns, got ${shown(line.trim())}`);
    for (let i = 0; i < width; i++) {
      const value = numberOf(decimal ? cells[i].replace(",", ".") : cells[i]);
      if (!Number.isFinite(value)) refuse(`row ${row} of the numbers must hold finite numbers, got ${shown(cells[i].trim())} in column ${shown(names[i])}`);
      columns[i].push(value);
    }
    return true;
  });
  return { names, units, columns: columns.map((each) => Float64Array.from(each)) };
}

const isComment = (line) => !line.trim() || line.trimStart().startsWith("#");

/** Call `take` with each line that is no comment, from a place on, until it returns false. */
function forEachLine(text, begin, take) {
  for (let from = begin; from < text.length; ) {
    let to = text.indexOf("\n", from);
    if (to < 0) to = text.length;
    const line = text.slice(from, text[to - 1] === "\r" ? to - 1 : to);
    if (!isComment(line) && !take(line, from)) return;
    from = to + 1;
  }
}

function split(line, separator) {
  if (separator === " ") return line.trim().split(/\s+/);
  return line.split(separator);
}

const clean = (cell) => cell.trim().replace(/^"+|"+$/g, "");

function numberOf(cell) {
  const value = Number(cell);
  if (!Number.isNaN(value) && cell.trim() !== "") return value;
  const plain = clean(cell);
  return plain === "" || !/^[+-]?(\d|\.\d)/.test(plain) ? NaN : Number(plain);
}

/** Return what separates the columns, where the numbers begin, and what stands before them. */
function beginningOf(text) {
  const head = [];
  let found = null;
  forEachLine(text, text.charCodeAt(0) === 0xfeff ? 1 : 0, (line, from) => {
    for (const separator of [";", "\t", ",", " "]) {
      const cells = split(line, separator);
      if (cells.length < 2) continue;
      const comma = (separator === ";" || separator === "\t") && cells.some((cell) => cell.includes(","));
      if (cells.every((cell) => Number.isFinite(numberOf(comma ? cell.replace(",", ".") : cell)))) {
        found = { separator, begin: from, width: cells.length, decimal: separator === ";" || comma };
        return false;
      }
    }
    head.push(line);
    return head.length < MOST_HEAD;
  });
  if (!found) refuse("the file must hold lines of two numbers or more, got none");
  return { ...found, head: head.map((line) => split(line, found.separator).map(clean)) };
}

/** Return names and units of the columns; without a line of names they are numbered from 1. */
function namesOf(head, width) {
  const fitting = head.filter((cells) => cells.length === width);
  let units = new Array(width).fill("");
  const bare = (cell) => cell.replace(/^[[\]() ]+|[[\]() ]+$/g, "");
  if (fitting.length > 1 && fitting.at(-1) === head.at(-1) && fitting.at(-2) === head.at(-2) && fitting.at(-1).every((cell) => KNOWN.has(bare(cell)))) {
    units = fitting.pop().map(bare);
  }
  const names = fitting.length ? [...fitting.at(-1)] : units.map((_, place) => String(place + 1));
  names.forEach((name, place) => {
    const parts = /^(.*?)\s*[[(]\s*([^\])]*?)\s*[\])]\s*$/.exec(name);
    if (parts) [names[place], units[place]] = [parts[1], parts[2]];
  });
  if (new Set(names).size < width) refuse(`the columns must have names that differ, got ${names.join(", ")}`);
  return { names, units };
}

/** Return which column is what, by its name or, in a file without names, by its place. */
function placesOf(names) {
  const lower = names.map((name) => name.toLowerCase().trim());
  const plain = !names.includes("t") && names.every((name) => /^\d+$/.test(name));
  const places = {};
  Object.entries(GUESSES).forEach(([name, guesses], order) => {
    const wanted = plain ? (name === "angle" ? [] : [String(order + 1)]) : guesses;
    const taken = Object.values(places);
    const place = lower.findIndex((each, i) => wanted.includes(each) && !taken.includes(i));
    if (place >= 0) places[name] = place;
    else if (name !== "keyphasor" && name !== "angle") refuse(`the file must have a column for ${name}, got ${names.join(", ")}`);
  });
  if ("angle" in places) delete places.keyphasor;
  return places;
}

/** How probes usually stand in a table: along x and y, told as displacements. */
export const PROBES = { angles: [0, 90], gains: [1, 1] };

/** Return displacements along x and y of the readings of two probes, at angles [°] and with gains. */
function displacements(first, second, { angles, gains }) {
  if (gains.some((each) => !(each !== 0 && Number.isFinite(each)))) refuse(`the gains of the probes must be numbers other than 0, got ${gains.join(" and ")}`);
  if (!angles.every(Number.isFinite)) refuse(`the angles of the probes must be numbers, got ${angles.join(" and ")}`);
  if (angles[0] === 0 && angles[1] === 90) return [scaled(first, 1 / gains[0]), scaled(second, 1 / gains[1])];
  const [one, other] = angles.map((each) => (each * Math.PI) / 180);
  const between = Math.sin(other - one);
  if (Math.abs(between) < NEARLY_ALONG) refuse(`the probes must not look along one line, got the angles ${angles.join(" and ")} degrees`);
  const mixed = (a, b) => first.map((each, i) => ((each / gains[0]) * a + (second[i] / gains[1]) * b) / between);
  return [mixed(Math.sin(other), -Math.sin(one)), mixed(-Math.cos(other), Math.cos(one))];
}

/** Return a record: times in seconds or as they are, displacements, and the angle where it is known. */
export function recordOf(text, probes = PROBES) {
  const { names, units, columns } = columnsOf(text);
  const places = placesOf(names);
  const unitOf = (name) => ALIASES[units[places[name]]] ?? units[places[name]];
  const [time, length] = [unitOf("t"), unitOf("x")];
  if (!(time in TIMES) && time !== "1") refuse(`the unit of t must be s, ms, us or min, got ${shown(time)}`);
  if (!LENGTHS.includes(length) && length !== "1") refuse(`the unit of x must be one of ${LENGTHS.join(", ")}, got ${shown(length)}`);
  if (unitOf("y") !== length) refuse(`x and y must be in one unit, got ${length} and ${unitOf("y")}`);
  const t = scaled(columns[places.t], TIMES[time] ?? 1);
  const readings = [columns[places.x], columns[places.y]];
  if (t.length < FEWEST_SAMPLES) refuse(`the file must hold at least ${FEWEST_SAMPLES} samples, got ${t.length}`);
  checkTimes(t);
  readings.forEach((values, i) => {
    const at = clippedAt(values);
    if (at >= 0) refuse(`${"xy"[i]} must not be clipped, but stays at ${short(values[at])} from t ${short(t[at])} on`);
  });
  const [x, y] = displacements(...readings, probes);
  const record = { t, x, y, angle: null, time: time === "1" ? "1" : "s", length, samples: t.length, by: "" };
  if ("angle" in places) return { ...record, ...withAngle(record, columns[places.angle], unitOf("angle")), by: names[places.angle] };
  if ("keyphasor" in places) return { ...record, ...byPulses(record, pulsesIn(t, columns[places.keyphasor])), by: names[places.keyphasor] };
  return record;
}

const scaled = (values, factor) => (factor === 1 ? values : values.map((each) => each * factor));

function checkTimes(t) {
  const steps = new Float64Array(t.length - 1);
  for (let i = 1; i < t.length; i++) {
    steps[i - 1] = t[i] - t[i - 1];
    if (!(steps[i - 1] > 0)) refuse(`t must increase, got ${short(t[i])} after ${short(t[i - 1])}`);
  }
  const usual = median(steps);
  const at = steps.findIndex((each) => each > GAP * usual);
  if (at >= 0) refuse(`t must have no gaps, got one of ${short(steps[at])} after ${short(t[at])}; the usual step is ${short(usual)}`);
}

function median(values) {
  const sorted = Float64Array.from(values).sort();
  const half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

/** Return where a reading first stays at its largest or smallest value, after a leap to it; else -1. */
function clippedAt(values) {
  let finest = Infinity, low = Infinity, high = -Infinity;
  for (let i = 0; i < values.length; i++) {
    if (values[i] < low) low = values[i];
    if (values[i] > high) high = values[i];
    const leap = i ? Math.abs(values[i] - values[i - 1]) : 0;
    if (leap > 0 && leap < finest) finest = leap;
  }
  for (const extreme of [high, low]) {
    for (let from = 0; from < values.length; from++) {
      if (values[from] !== extreme) continue;
      let to = from;
      while (to < values.length && values[to] === extreme) to += 1;
      if (to - from >= CLIPPED && from > 0 && Math.abs(values[from] - values[from - 1]) > GAP * finest) return from;
      from = to;
    }
  }
  return -1;
}

// the angle

function withAngle({ t }, values, unit) {
  if (!(unit in ANGLES) && unit !== "1") refuse(`the unit of angle must be rad, deg or rev, got ${shown(unit)}`);
  let angle = scaled(values, ANGLES[unit] ?? 1);
  if (angle.some((each, i) => i > 0 && each < angle[i - 1])) angle = unwrapped(angle);
  const at = angle.findIndex((each, i) => i > 0 && each < angle[i - 1]);
  if (at >= 0) refuse(`angle must never fall, but does after t ${short(t[at - 1])}`);
  return { angle };
}

function unwrapped(values) {
  const found = Float64Array.from(values);
  let turns = 0;
  for (let i = 1; i < values.length; i++) {
    const step = values[i] - values[i - 1];
    let within = step + Math.PI - TURN * Math.floor((step + Math.PI) / TURN) - Math.PI;
    if (within === -Math.PI && step > 0) within = Math.PI;
    if (Math.abs(step) >= Math.PI) turns += within - step;
    found[i] = values[i] + turns;
  }
  return found;
}

/** Return the times at which a sampled signal rises into a pulse: half-way up, between two samples. */
function pulsesIn(t, signal) {
  let low = Infinity, high = -Infinity;
  for (const each of signal) {
    if (each < low) low = each;
    if (each > high) high = each;
  }
  if (low === high) refuse(`keyphasor must have pulses, got the constant ${short(low)}`);
  let height = signal.map((each) => (each - low) / (high - low));
  if (median(height) > 0.5) height = height.map((each) => 1 - each);
  const pulses = [];
  let before = -1; // the last sample that was low, unless one was high since
  for (let i = 0; i < height.length; i++) {
    if (height[i] <= LOW) before = i;
    else if (height[i] >= HIGH) {
      if (before >= 0) pulses.push(halfWay(t, height, before, i));
      before = -1;
    }
  }
  return Float64Array.from(pulses);
}

function halfWay(t, height, before, after) {
  let i = before;
  for (let each = before; each <= after; each++) if (height[each] < 0.5) i = each;
  const part = (0.5 - height[i]) / (height[i + 1] - height[i]);
  return t[i] + part * (t[i + 1] - t[i]);
}

/** Return what lies between pulses, with the angle by a cubic spline through them. */
function byPulses({ t, x, y }, pulses) {
  checkPulses(pulses);
  let least = Infinity;
  for (let i = 1; i < pulses.length; i++) least = Math.min(least, pulses[i] - pulses[i - 1]);
  const slack = 1e-9 * least;
  let from = 0, to = t.length;
  while (from < to && t[from] < pulses[0] - slack) from += 1;
  while (to > from && t[to - 1] > pulses.at(-1) + slack) to -= 1;
  if (to - from < FEWEST_SAMPLES) refuse(`the file must hold at least ${FEWEST_SAMPLES} samples between the pulses of the keyphasor, got ${to - from}`);
  const within = t.slice(from, to);
  return { t: within, x: x.slice(from, to), y: y.slice(from, to), angle: splined(pulses, pulses.map((_, i) => TURN * i), within) };
}

function checkPulses(pulses) {
  if (pulses.length < FEWEST_PULSES) refuse(`keyphasor must have at least ${FEWEST_PULSES} pulses, got ${pulses.length}`);
  const intervals = pulses.slice(1).map((each, i) => each - pulses[i]);
  const usual = usualIntervals(intervals);
  const lost = intervals.findIndex((each, i) => each > LONGER * usual[i]);
  if (lost >= 0) refuse(`keyphasor must not lose pulses, but does after t ${short(pulses[lost])}: the interval there is ${(intervals[lost] / usual[lost]).toFixed(2)} times those beside it`);
  const extra = intervals.findIndex((each, i) => each < SHORTER * usual[i]);
  if (extra >= 0) refuse(`keyphasor must not have pulses too many, but two follow each other too soon after t ${short(pulses[extra])}`);
}

/** Return how long each interval would be, judged by the ones round it. */
function usualIntervals(intervals) {
  const last = intervals.length - 1;
  const usual = intervals.map((_, i) => median([-2, -1, 0, 1, 2].map((away) => intervals[Math.min(Math.max(i + away, 0), last)])));
  if (intervals.length >= FEWEST_PULSES) {
    for (const [end, next, beyond] of [[0, 1, 2], [last, last - 1, last - 2]]) {
      const [low, high] = [intervals[next], intervals[beyond]].sort((one, other) => one - other);
      usual[end] = high < ALIKE * low ? intervals[next] : intervals[end];
    }
  }
  return usual;
}

/** Return a cubic spline through points, without a knot at the second and at the last but one. */
function splined(xs, ys, at) {
  const n = xs.length;
  const slopes = n === 3 ? parabola(xs, ys) : slopesOf(xs, ys);
  const found = new Float64Array(at.length);
  let i = 0;
  at.forEach((x, place) => {
    while (i < n - 2 && x >= xs[i + 1]) i += 1;
    const h = xs[i + 1] - xs[i], slope = (ys[i + 1] - ys[i]) / h, s = x - xs[i];
    const t = (slopes[i] + slopes[i + 1] - 2 * slope) / h;
    found[place] = ys[i] + s * (slopes[i] + s * ((slope - slopes[i]) / h - t + (s * t) / h));
  });
  return found;
}

/** Return the slopes of the parabola through three points. */
function parabola([a, b, c], [p, q, r]) {
  const [one, two] = [(q - p) / (b - a), (r - q) / (c - b)];
  const bend = (two - one) / (c - a);
  return [one - bend * (b - a), one + bend * (b - a), two + bend * (c - b)];
}

function slopesOf(xs, ys) {
  const n = xs.length;
  const h = (i) => xs[i + 1] - xs[i];
  const slope = (i) => (ys[i + 1] - ys[i]) / h(i);
  const [lower, middle, upper, right] = Array.from({ length: 4 }, () => new Float64Array(n));
  for (let i = 1; i < n - 1; i++) {
    [lower[i], middle[i], upper[i]] = [h(i), 2 * (h(i - 1) + h(i)), h(i - 1)];
    right[i] = 3 * (h(i) * slope(i - 1) + h(i - 1) * slope(i));
  }
  let d = xs[2] - xs[0];
  [middle[0], upper[0]] = [h(1), d];
  right[0] = ((h(0) + 2 * d) * h(1) * slope(0) + h(0) ** 2 * slope(1)) / d;
  d = xs[n - 1] - xs[n - 3];
  [middle[n - 1], lower[n - 1]] = [h(n - 3), d];
  right[n - 1] = (h(n - 2) ** 2 * slope(n - 3) + (2 * d + h(n - 2)) * h(n - 3) * slope(n - 2)) / d;
  for (let i = 1; i < n; i++) {
    const part = lower[i] / middle[i - 1];
    middle[i] -= part * upper[i - 1];
    right[i] -= part * right[i - 1];
  }
  const slopes = new Float64Array(n);
  slopes[n - 1] = right[n - 1] / middle[n - 1];
  for (let i = n - 2; i >= 0; i--) slopes[i] = (right[i] - upper[i] * slopes[i + 1]) / middle[i];
  return slopes;
}

// order 1

/** Return order 1 in each whole revolution: speed, forward amplitude, and phase lag. */
export function firstOrder({ t, x, y, angle }) {
  const n = angle.length;
  const turns = angle.map((each) => (each - angle[0]) / TURN);
  const count = Math.floor(turns[n - 1] + (turns[n - 1] - turns[n - 2]) + EDGE);
  if (count < 1) refuse(`the record must hold at least 1 whole revolution, got ${turns[n - 1].toPrecision(3)}`);
  const edges = [];
  for (let i = 0, window = 0; window <= count; window++) {
    while (i < n && turns[i] < window - EDGE) i += 1;
    edges.push(i);
  }
  let fewest = Infinity, at = 0;
  for (let i = 0; i < count; i++) if (edges[i + 1] - edges[i] < fewest) [fewest, at] = [edges[i + 1] - edges[i], i];
  const rate = fewest - 1;
  if (rate <= 2 || fewest < 3) refuse(`the record must hold more than 3 samples a revolution, got ${fewest} at t ${short(t[edges[at]])}`);
  const beside = [];
  for (let order = 2; order < Math.min(BESIDE, (rate - 1) / 2) + SLACK; order++) beside.push(order);
  const orders = [1, -1, ...beside, ...beside.map((each) => -each), 0];
  const found = { speed: new Float64Array(count), amplitude: new Float64Array(count), lag: new Float64Array(count) };
  for (let window = 0; window < count; window++) {
    const [from, to] = [edges[window], edges[window + 1]];
    found.speed[window] = slopeOf(t, angle, from, to);
    const [re, im] = fitted(orders, x, y, angle, from, to);
    found.amplitude[window] = Math.hypot(re, im);
    found.lag[window] = Math.atan2(-im, re);
  }
  return found;
}

function slopeOf(t, angle, from, to) {
  let [time, turn] = [0, 0];
  for (let i = from; i < to; i++) {
    time += t[i];
    turn += angle[i];
  }
  time /= to - from;
  turn /= to - from;
  let [above, below] = [0, 0];
  for (let i = from; i < to; i++) {
    above += (t[i] - time) * (angle[i] - turn);
    below += (t[i] - time) ** 2;
  }
  return above / below;
}

/** Return the complex amplitude of the first of some orders, by least squares. */
function fitted(orders, x, y, angle, from, to) {
  const most = 2 * Math.max(...orders);
  const [re, im] = [new Float64Array(most + 1), new Float64Array(most + 1)]; // sums of exp(i k angle)
  const right = orders.map(() => [0, 0]);
  const powers = [new Float64Array(most + 1), new Float64Array(most + 1)];
  for (let i = from; i < to; i++) {
    const [c, s] = [Math.cos(angle[i]), Math.sin(angle[i])];
    [powers[0][0], powers[1][0]] = [1, 0];
    for (let k = 0; k <= most; k++) {
      const [a, b] = [powers[0][k], powers[1][k]];
      re[k] += a;
      im[k] += b;
      if (k < most) [powers[0][k + 1], powers[1][k + 1]] = [a * c - b * s, a * s + b * c];
    }
    orders.forEach((order, place) => {
      const a = powers[0][Math.abs(order)], b = order < 0 ? powers[1][-order] : -powers[1][order];
      right[place][0] += a * x[i] - b * y[i];
      right[place][1] += a * y[i] + b * x[i];
    });
  }
  const moment = (k) => (k < 0 ? [re[-k], -im[-k]] : [re[k], im[k]]);
  const rows = orders.map((row, place) => [...orders.map((column) => moment(column - row)), right[place]]);
  return solved(rows)[0];
}

/** Solve complex equations, each row with its right side at the end, by elimination with pivots. */
function solved(rows) {
  const n = rows.length;
  for (let column = 0; column < n; column++) {
    let pivot = column;
    for (let row = column + 1; row < n; row++) if (Math.hypot(...rows[row][column]) > Math.hypot(...rows[pivot][column])) pivot = row;
    [rows[column], rows[pivot]] = [rows[pivot], rows[column]];
    const by = rows[column][column];
    for (let row = column + 1; row < n; row++) {
      const part = over(rows[row][column], by);
      for (let k = column; k <= n; k++) rows[row][k] = less(rows[row][k], part, rows[column][k]);
    }
  }
  const found = new Array(n);
  for (let row = n - 1; row >= 0; row--) {
    let left = rows[row][n];
    for (let k = row + 1; k < n; k++) left = less(left, rows[row][k], found[k]);
    found[row] = over(left, rows[row][row]);
  }
  return found;
}

const over = ([a, b], [c, d]) => {
  const size = c * c + d * d;
  return [(a * c + b * d) / size, (b * c - a * d) / size];
};
const less = ([a, b], [c, d], [e, f]) => [a - (c * e - d * f), b - (c * f + d * e)];

// spectra

/** Return the step of equally spaced times; refuse others. */
export function equalStep(t) {
  const mean = (t[t.length - 1] - t[0]) / (t.length - 1);
  for (let i = 0; i < t.length; i++) {
    if (Math.abs(t[i] - (t[0] + mean * i)) > UNEQUAL * mean) refuse(`a spectrum needs equally spaced samples; they are not at t ${short(t[i])}`);
  }
  return mean;
}

/** Return the speed of a record in which it does not change; else nothing. */
export function oneSpeed({ t, angle }) {
  if (!angle) return null;
  const last = angle.length - 1, half = angle.length >> 1;
  const mean = (from, to) => (angle[to] - angle[from]) / (t[to] - t[from]);
  const [early, late] = [mean(0, half), mean(half, last)];
  const middle = 0.5 * (early + late);
  return middle > 0 && Math.abs(late - early) < STEADY * middle ? mean(0, last) : null;
}

function weightsOf(coefficients, size) {
  const weights = new Float64Array(size);
  for (let i = 0; i < size; i++) {
    const angle = -Math.PI + (TURN * i) / size;
    coefficients.forEach((each, k) => (weights[i] += each * Math.cos(k * angle)));
  }
  return weights;
}

/** Return frequencies from minus to plus half the rate, and at each the amplitude of the whirl. */
function linesOf({ x, y }, from, weights, step) {
  const size = weights.length;
  const [re, im] = [new Float64Array(size), new Float64Array(size)];
  let sum = 0;
  for (let i = 0; i < size; i++) {
    re[i] = x[from + i] * weights[i];
    im[i] = y[from + i] * weights[i];
    sum += weights[i];
  }
  transform(re, im);
  const negative = size >> 1;
  const [frequency, amplitude] = [new Float64Array(size), new Float64Array(size)];
  for (let i = 0; i < size; i++) {
    const k = i - negative;
    frequency[i] = (TURN * k) / (size * step);
    amplitude[i] = Math.hypot(re[(k + size) % size], im[(k + size) % size]) / Math.abs(sum);
  }
  return { frequency, amplitude };
}

/** Return the full spectrum of a whole record, its bandwidth and the speed if there is one. */
export function fullSpectrum(record) {
  const step = equalStep(record.t);
  const weights = weightsOf(FLAT_TOP, record.t.length);
  let sum = 0, squares = 0;
  for (const each of weights) {
    sum += each;
    squares += each * each;
  }
  return { ...linesOf(record, 0, weights, step), bandwidth: (TURN * squares) / (sum * sum * step), speed: oneSpeed(record) };
}

/** Return full spectra of one segment after the other, with the speed of each. */
export function spectrogram(record, segment, keep = () => true) {
  const { t, angle } = record;
  const step = equalStep(t);
  const size = Math.min(segment, t.length);
  const weights = weightsOf(HANN, size);
  const hop = Math.max(1, Math.round(size * (1 - OVERLAP)));
  const rows = [];
  for (let from = 0; from + size <= t.length; from += hop) {
    const speed = angle ? (angle[from + size - 1] - angle[from]) / ((size - 1) * step) : null;
    if (keep(speed)) rows.push({ time: t[from] + 0.5 * (size - 1) * step, speed, ...linesOf(record, from, weights, step) });
  }
  return rows;
}

/** Return all that panels draw of a record. */
export function analysed(record) {
  const found = { order: null, rows: [], full: null, notes: [], segment: 0 };
  const noted = (make) => {
    try {
      return make();
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      found.notes.push(error.message);
      return null;
    }
  };
  if (record.angle) found.order = noted(() => firstOrder(record));
  else found.notes.push("there is no column for keyphasor or angle, so neither speed nor phase is known");
  const speed = oneSpeed(record);
  if (record.angle && speed === null) {
    const { rows, segment } = noted(() => cascadeOf(record, found.order)) ?? {};
    if (rows) Object.assign(found, { rows, segment });
  } else found.full = noted(() => within(fullSpectrum(record), speed ? ORDERS * speed : Infinity));
  return found;
}

/** Return spectra over the speed, as fine as can be while it changes, and no more than can be told apart. */
function cascadeOf(record, order) {
  const { t, angle } = record;
  const step = equalStep(t), last = t.length - 1;
  let [low, high] = [Infinity, 0];
  for (const each of order?.speed ?? [(angle[last] - angle[0]) / (t[last] - t[0])]) [low, high] = [Math.min(low, each), Math.max(high, each)];
  const rate = (high - low) / (t[last] - t[0]);
  const fine = Math.min(Math.max(Math.sqrt(TURN / Math.max(rate, 1e-300)) / step, FEWEST), MOST);
  const segment = Math.min(2 ** Math.round(Math.log2(fine)), t.length);
  const apart = (high - low) / MOST_ROWS;
  let before = Infinity;
  const rows = spectrogram(record, segment, (speed) => {
    if (Math.abs(speed - before) < apart) return false;
    before = speed;
    return true;
  });
  return { rows: rows.map((row) => within(row, Math.max(FURTHEST * high, ORDERS * row.speed))), segment };
}

/** Leave out the lines beyond a frequency. */
function within({ frequency, amplitude, ...rest }, furthest) {
  let from = 0, to = frequency.length;
  while (from < to && frequency[from] < -furthest) from += 1;
  while (to > from && frequency[to - 1] > furthest) to -= 1;
  return { ...rest, frequency: frequency.slice(from, to), amplitude: amplitude.slice(from, to) };
}

// the Fourier transform

/** Transform in place; of any length, as a convolution with a chirp where it is no power of two. */
export function transform(re, im) {
  const n = re.length;
  if ((n & (n - 1)) === 0) {
    byHalves(re, im);
    return;
  }
  let m = 1;
  while (m < 2 * n) m *= 2;
  const [c, s] = [new Float64Array(n), new Float64Array(n)];
  for (let i = 0; i < n; i++) {
    const angle = (Math.PI * ((i * i) % (2 * n))) / n;
    [c[i], s[i]] = [Math.cos(angle), Math.sin(angle)];
  }
  const [a, b, p, q] = Array.from({ length: 4 }, () => new Float64Array(m));
  for (let i = 0; i < n; i++) {
    a[i] = re[i] * c[i] + im[i] * s[i];
    b[i] = im[i] * c[i] - re[i] * s[i];
    [p[i], q[i]] = [c[i], s[i]];
    if (i) [p[m - i], q[m - i]] = [c[i], s[i]];
  }
  byHalves(a, b);
  byHalves(p, q);
  for (let i = 0; i < m; i++) [a[i], b[i]] = [a[i] * p[i] - b[i] * q[i], -(a[i] * q[i] + b[i] * p[i])]; // conjugated, to go back
  byHalves(a, b);
  for (let i = 0; i < n; i++) {
    const [u, v] = [a[i] / m, -b[i] / m];
    re[i] = u * c[i] + v * s[i];
    im[i] = v * c[i] - u * s[i];
  }
}

function byHalves(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      const [a, b] = [re[i], im[i]];
      re[i] = re[j];
      im[i] = im[j];
      re[j] = a;
      im[j] = b;
    }
  }
  const [c, s] = [new Float64Array(n >> 1), new Float64Array(n >> 1)];
  for (let k = 0; k < n >> 1; k++) [c[k], s[k]] = [Math.cos((TURN * k) / n), -Math.sin((TURN * k) / n)];
  for (let size = 2; size <= n; size *= 2) {
    const half = size >> 1, stride = n / size;
    for (let from = 0; from < n; from += size) {
      for (let k = 0, at = 0; k < half; k++, at += stride) {
        const i = from + k, j = i + half;
        const a = re[j] * c[at] - im[j] * s[at], b = re[j] * s[at] + im[j] * c[at];
        re[j] = re[i] - a;
        im[j] = im[i] - b;
        re[i] += a;
        im[i] += b;
      }
    }
  }
}
