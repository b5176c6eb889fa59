// The form for a data sheet: words with units, which the program makes a machine of.

import { valueShown } from "./controls.js";
import { PARAMETERS, SHEET } from "./tables.js";

const $ = (id) => document.getElementById(id);
const inWords = (name) => {
  const words = name.replaceAll("_", " ");
  return words[0].toUpperCase() + words.slice(1);
};

export class DataSheetForm {
  /** `ask` is told the quantities that were typed; `given` returns the machine that is shown, if there is one. */
  constructor({ ask, given }) {
    this.given = given;
    this.rows = SHEET.map(({ names, example }) => this.#row(names, example));
    $("sheet-fields").replaceChildren(...this.rows.map(({ box }) => box));
    $("sheet-cancel").addEventListener("click", () => this.close());
    $("sheet-form").addEventListener("submit", (event) => {
      event.preventDefault();
      $("sheet-wrong").textContent = "";
      ask(Object.fromEntries(this.rows.map(({ way, field }) => [way.value, field.value])));
    });
  }

  /** A quantity: the ways to give it, and a field for words with a unit. */
  #row(names, example) {
    const box = Object.assign(document.createElement("div"), { className: "control" });
    const way = Object.assign(document.createElement("select"), { disabled: names.length === 1 });
    for (const name of names) way.add(new Option(inWords(name), name));
    way.setAttribute("aria-label", `Quantity: ${inWords(names[0])}`);
    const field = Object.assign(document.createElement("input"), { type: "text", placeholder: example, id: `sheet-${names[0]}` });
    const label = () => field.setAttribute("aria-label", `${inWords(way.value)}${PARAMETERS[way.value] ? `: ${PARAMETERS[way.value].si_meaning}` : ""}`);
    way.addEventListener("change", () => {
      field.value = "";
      label();
    });
    label();
    box.append(way, field);
    return { box, way, field };
  }

  /** Open the form with what is known of the machine that is shown. */
  open() {
    const given = this.given();
    for (const { way, field } of this.rows) {
      if (!field.value && way.value in given) field.value = valueShown(way.value, given[way.value]).replace("¹·⁵", "^1.5");
    }
    $("sheet-wrong").textContent = "";
    $("sheet").showModal();
  }

  fail(message) {
    $("sheet-wrong").textContent = message;
  }

  close() {
    for (const { field } of this.rows) field.value = "";
    $("sheet").close();
  }
}
