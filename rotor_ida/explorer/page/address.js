// The address of a page keeps its state after the #; each change is a step of the browser's history.

const KEY = "rotor-ida-key";
// Changes within this many milliseconds are one step.
const ONE_MOVEMENT = 1000;
// Milliseconds without a newer change before the address is written.
const PAUSE = 250;

/** Return the key of the program: a given one, or that of this tab or of another one. */
export function keyKept(given) {
  const key = given ?? sessionStorage.getItem(KEY) ?? localStorage.getItem(KEY) ?? "";
  sessionStorage.setItem(KEY, key);
  localStorage.setItem(KEY, key);
  return key;
}

/** The address of one page: `told` returns the state, and `show` shows that of `location.hash`. */
export class Address {
  #timer = null;
  #moved = -Infinity;
  #isNew = false;

  constructor({ told, show }) {
    this.told = told;
    addEventListener("popstate", () => {
      clearTimeout(this.#timer);
      this.#timer = null;
      this.#isNew = false;
      show();
    });
    history.replaceState(null, "", told());
  }

  /** Store the state soon; that before a change stays in the history. */
  keep() {
    const now = performance.now();
    if (now - this.#moved > ONE_MOVEMENT) this.#isNew = true;
    this.#moved = now;
    this.#timer ??= setTimeout(() => this.#write(), PAUSE);
  }

  #write() {
    this.#timer = null;
    const next = this.told();
    if (next === location.hash) return;
    if (this.#isNew) history.pushState(null, "", next);
    else history.replaceState(null, "", next);
    this.#isNew = false;
  }
}
