// A run-up or run-down at a rate: pieces of a ramp, each continuing the last one.

import { extremes } from "./arrays.js";
import { NOTHING, joined, trackOf } from "./signals.js";

const TURN = 2 * Math.PI;
// Milliseconds to answer a piece, and its most revolutions for good sampling.
const WANTED = 60, MOST_TURNS = 200;
// Largest change of the speed in a piece and in a second, as fractions of the range shown.
const LARGEST_STEP = 1 / 320, FASTEST_SHOWN = 0.1;
// Speed step over which the smallest and the largest radius are drawn.
const WIDTH = 1 / 2000, MOST_POINTS = 12_000;
// Milliseconds from one question about the track to the next while the speed changes.
const TRACKED = 1000;
// Decimals of a speed, at most.
const FINEST = 14;

/** The track of one rotor: its radius over the speed, and its jumps; the state at its end, with the angle of the unbalance. */
class Track {
  constructor(start, range) {
    Object.assign(this, { start, held: start, turned: 0, range, words: "", now: "clear", omega: [], low: [], high: [], jumps: [], falling: [], folds: [], scales: {} });
    // order 1 of each revolution before it last turned back and since, and the spectra since, as the program has them
    Object.assign(this, { legs: NOTHING, ...trackOf() });
    this.turn = []; // the samples of the last revolution, as angle, speed and radius
    this.sum = this.angle = 0;
  }

  /** The direction has changed: start a new line without passed folds. */
  turnBack() {
    this.falling = [];
    this.turn = [];
    this.sum = 0;
    this.before = undefined;
    for (const name of ["omega", "low", "high"]) this[name].push(NaN);
    this.legs = this.order;
  }

  take({ arrays, facts }, way) {
    const { speed, angle, radius } = arrays;
    const { end: start, held, angle: turned, scales, words, now } = facts;
    Object.assign(this, { start, held, turned, scales, words, now });
    this.folds = facts.folds.filter((fold) => fold.way === way);
    for (let i = this.omega.length ? 1 : 0; i < speed.length; i++) {
      this.#draw(speed[i], radius[i]);
      this.#watch(this.angle + angle[i], speed[i], radius[i], way);
    }
    this.angle += angle.at(-1);
  }

  /** Take order 1 and spectra since it last turned back. */
  takeTrack(answer) {
    const { order, rows } = trackOf(answer);
    Object.assign(this, { order: joined(this.legs, order), rows });
  }

  #draw(omega, radius) {
    const last = this.omega.length - 1;
    if (last >= 0 && Math.abs(omega - this.from) < WIDTH * this.range && !Number.isNaN(this.omega[last])) {
      this.low[last] = Math.min(this.low[last], radius);
      this.high[last] = Math.max(this.high[last], radius);
      return;
    }
    this.from = omega;
    this.omega.push(omega);
    this.low.push(radius);
    this.high.push(radius);
    if (this.omega.length > MOST_POINTS) for (const name of ["omega", "low", "high"]) this[name].shift();
  }

  /** Compare the mean radius over a revolution with the folds passed. */
  #watch(angle, omega, radius, way) {
    this.turn.push([angle, omega, radius]);
    this.sum += radius;
    let whole = false;
    while (angle - this.turn[0][0] > TURN) {
      this.sum -= this.turn.shift()[2];
      whole = true;
    }
    if (!whole) return;
    const [mean, here] = [this.sum / this.turn.length, this.turn[this.turn.length >> 1][1]];
    const isLeft = (fold) => Math.abs(mean - fold.other) < Math.abs(mean - fold.radius);
    const passes = (fold) => way * (this.before - fold.omega) < 0 && way * (here - fold.omega) >= 0;
    // a motion off the whirl that ends at a fold does not jump there
    this.falling.push(...this.folds.filter((fold) => passes(fold) && !isLeft(fold)));
    this.before = here;
    this.falling = this.falling.filter((fold) => {
      if (isLeft(fold)) this.jumps.push({ omega: here, radius: mean, fold, way, falls: fold.other < fold.radius });
      return !isLeft(fold);
    });
  }

  /** The smallest and the largest radius over the last revolution. */
  get extent() {
    return extremes(this.turn.map(([, , radius]) => radius));
  }

  get highest() {
    return extremes(this.high, [0, 0])[1];
  }
}

/** The run-up of all rotors shown; it requests its pieces and reports events. */
export class Passage {
  /**
   * `begin` returns speed, limits, the range of speeds that is shown and starts, or nothing while they are not known; `ask` asks for a
   * piece of one rotor; `moved` is called when the speed has changed, `rested` when the run-up has come
   * to rest, and `changed` when it has begun, has stopped or is discarded.
   */
  constructor({ begin, ask, moved, rested, changed }) {
    Object.assign(this, { begin, ask, moved, rested, changed, way: 0, number: 0, begun: false, tracks: [], waiting: new Set(), asked: new Set() });
  }

  get running() {
    return this.way !== 0;
  }

  /** Begin or continue up (1) or down (-1), or begin anew elsewhere than at the drawn runs; stop if it already moves this way. */
  press(way, rate, elsewhere = null) {
    if (elsewhere) this.forget();
    if (!this.begun && !this.#begin(elsewhere ?? this.begin())) return;
    this.setRate(rate);
    this.way = this.way === way ? 0 : way;
    if (!this.running) this.#rest();
    else if (!this.waiting.size && !this.timer) this.#next();
    this.changed();
  }

  /** Change the rate, from the next piece on. */
  setRate(rate) {
    if (rate !== this.rate) this.step = 0;
    this.rate = rate;
  }

  #begin(beginning) {
    if (!beginning) return false;
    const { speed, limits, range, starts } = beginning;
    Object.assign(this, { begun: true, asked: new Set(), tracked: -Infinity, isBehind: false, step: 0, last: 0, speed, limits, range, from: speed, tracks: starts.map((start) => new Track(start, range)) });
    return true;
  }

  #next() {
    const { way, speed } = this;
    const limit = this.limits[way > 0 ? 1 : 0];
    if (way * (limit - speed) <= 0) {
      this.way = 0;
      this.#rest();
      this.changed();
      return;
    }
    if (this.last && this.last !== way) for (const track of this.tracks) track.turnBack();
    this.last = way;
    const turn = (TURN * this.rate) / Math.max(speed, 1);
    // a piece has a revolution at least: waiting for others must not make pieces ever shorter
    const step = Math.min(Math.max(this.step, turn), LARGEST_STEP * this.range, MOST_TURNS * turn);
    // round as it is shown: to a tenth of the step or less
    const digits = Math.min(Math.max(4, Math.ceil(1 - Math.log10(step))), FINEST);
    const to = Number((speed + way * step).toFixed(digits));
    this.to = way * (limit - to) < 0 || to === speed ? limit : to;
    this.number += 1;
    this.sent = performance.now();
    this.waiting = new Set(this.tracks.keys());
    this.tracks.forEach(({ start, turned }, side) => this.ask({ number: this.number, side, start, angle: turned, speed, to: this.to, rate: way * this.rate }));
  }

  take(answer) {
    if (answer.number !== this.number || !this.waiting.delete(answer.side)) return;
    this.tracks[answer.side].take(answer, this.last);
    if (this.waiting.size) return;
    const took = performance.now() - this.sent;
    const step = Math.abs(this.to - this.speed);
    // a piece behind the answer of a track tells nothing of how long it takes itself
    this.step = step * Math.min(Math.max(WANTED / took, this.isBehind ? 1 : 0.3), 3);
    this.isBehind = false;
    this.speed = this.to;
    this.moved(this.speed);
    if (!this.running) this.#rest();
    else {
      this.timer = setTimeout(() => {
        this.timer = 0;
        this.#next();
      }, Math.max((1000 * step) / (FASTEST_SHOWN * this.range) - took, 0));
    }
  }

  /** Ask for the tracks so far by `asks`; while the speed changes not before the last ones have come. */
  askTracks(asks) {
    const now = performance.now();
    if (this.running && (this.asked.size || now - this.tracked < TRACKED)) return;
    this.tracked = now;
    this.isBehind = true;
    this.asked = new Set(this.tracks.keys());
    this.tracks.forEach(({ start }, side) => asks({ number: this.number, side, start, speed: this.speed }));
  }

  takeTrack(answer) {
    if (!this.begun || answer.number > this.number) return;
    this.asked.delete(answer.side);
    this.tracks[answer.side].takeTrack(answer);
  }

  /** Come to rest after the piece being computed, if any. */
  #rest() {
    clearTimeout(this.timer);
    this.timer = 0;
    if (!this.waiting.size) this.rested();
  }

  /** Stop at once: a piece was not answered. */
  fail() {
    if (!this.running && !this.waiting.size) return;
    this.number += 1;
    this.way = 0;
    this.waiting.clear();
    this.#rest();
    this.changed();
  }

  /** Discard it: the rotor or its start has changed. */
  forget() {
    if (!this.begun) return;
    clearTimeout(this.timer);
    this.number += 1;
    Object.assign(this, { way: 0, timer: 0, begun: false, tracks: [] });
    this.waiting.clear();
    this.changed();
  }
}
