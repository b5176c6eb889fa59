// The address of a page keeps its state after the #; each change is a step of the browser's history.

const KEY = "rotor-ida-key";
// Changes within this many milliseconds are one change, undone together.
const ONE_MOVEMENT = 1000;
// Milliseconds without a newer change before the address is written.
const PAUSE = 250;
const depth = () => history.state?.depth ?? 0;

/** Return the key of the program: a given one, or that of this tab or of another one. */
export function keyKept(given) {
  const key = given ?? sessionStorage.getItem(KEY) ?? localStorage.getItem(KEY) ?? "";
  sessionStorage.setItem(KEY, key);
  localStorage.setItem(KEY, key);
  return key;
}

/**
 * The address of one page, with its buttons to undo and redo.
 *
 * `told` returns the state as an address, `show` shows that of `location.hash`; it returns false if there is none.
 */
export class Address {
  #timer = null;
  #moved = -Infinity;
  #isNew = false;
  #newest = 0;

  constructor({ told, show, undo, redo }) {
    Object.assign(this, { told, show, undo, redo });
    undo.addEventListener("click", () => history.back());
    redo.addEventListener("click", () => history.forward());
    addEventListener("popstate", () => this.#back());
    addEventListener("keydown", (event) => {
      const typing = event.target.matches?.('input[type="number"]');
      if (typing || event.key.toLowerCase() !== "z" || !(event.ctrlKey || event.metaKey)) return;
      event.preventDefault();
      (event.shiftKey ? redo : undo).click();
    });
  }

  /** Write the first state. */
  begin() {
    this.#newest = depth();
    history.replaceState({ depth: this.#newest }, "", this.told());
    this.#enable();
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
    if (this.#isNew) history.pushState({ depth: depth() + 1 }, "", next);
    else history.replaceState({ depth: depth() }, "", next);
    if (this.#isNew) this.#newest = depth();
    this.#isNew = false;
    this.#enable();
  }

  /** Show the state of the address after the browser went back or forward. */
  #back() {
    clearTimeout(this.#timer);
    this.#timer = null;
    if (this.show() === false) return;
    this.#isNew = false;
    this.#enable();
  }

  #enable() {
    this.undo.disabled = depth() === 0;
    this.redo.disabled = depth() >= this.#newest;
  }
}
