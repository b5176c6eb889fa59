// The form for a data sheet: values with units, which the program converts to a machine.

import { valueShown } from "./controls.js";
import { PARAMETERS, SHEET } from "./tables.js";
import { element } from "./tools.js";

const $ = (id) => document.getElementById(id);
const inWords = (name) => {
  const words = name.replaceAll("_", " ");
  return words[0].toUpperCase() + words.slice(1);
};

export class DataSheetForm {
  /** `ask` receives the typed quantities; `given` returns the machine shown, if any. */
  constructor({ ask, given }) {
    this.given = given;
    this.rows = SHEET.map(({ names, example }) => this.#row(names, example));
    $("sheet-fields").replaceChildren(...this.rows.map(({ box }) => box));
    $("sheet-open").addEventListener("click", () => this.#open());
    $("sheet").addEventListener("close", () => this.rows.forEach(({ field }) => (field.value = "")));
    $("sheet-form").addEventListener("submit", (event) => {
      if (event.submitter === $("sheet-cancel")) return; // which closes it
      event.preventDefault();
      $("sheet-wrong").textContent = "";
      ask(Object.fromEntries(this.rows.map(({ way, field }) => [way.value, field.value])));
    });
  }

  /** A quantity: the ways to give it, and a field for a value with a unit. */
  #row(names, example) {
    const box = element("div", "", "control");
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

  /** Open the form with the data of the machine shown. */
  #open() {
    const given = this.given();
    for (const { way, field } of this.rows) {
      if (!field.value && way.value in given) field.value = valueShown(way.value, given[way.value]).replace("¹·⁵", "^1.5");
    }
    $("sheet-wrong").textContent = "";
    $("sheet").showModal();
  }
}
