// A measured file, dropped on the page or chosen: the program reads and analyses it, and it goes nowhere else.

import { nearestIn, scaled } from "./arrays.js";
import { colour } from "./plot.js";
import { trackOf } from "./signals.js";
import { LARGEST_FILE } from "./tables.js";
import { told, withUnit } from "./units.js";

// Default probes: along x and y, with readings as displacements.
const PROBES = { angles: [0, 90], gains: [1, 1] };
// Metres in a unit of length; a reading in volts needs a scale.
const METRES = { m: 1, mm: 1e-3, um: 1e-6, nm: 1e-9, in: 0.0254, mil: 2.54e-5 };
const SHOWN = { um: "µm" };
// Micrometres a volt, of a probe with the usual 200 mV a mil.
const VOLT = 127;
// The fields of the probes, in order.
const FIELDS = { angles: ["measured-angle-x", "measured-angle-y"], gains: ["measured-gain-x", "measured-gain-y"] };
// What may give the rotation of the shaft, and the fields of columns and of units by what they are of.
const TURNS = ["keyphasor", "angle", "speed"];
const COLUMNS = ["t", "x", "y", "turn"], UNITS = ["t", "length", "turn"];
const $ = (id) => document.getElementById(id);

export class Measured {
  /**
   * `send` gives a file to the program, `changed` is called when the display must change, `scales` returns those
   * of the machine, if it is one; `listens` to files that are dropped.
   */
  constructor({ send, changed, scales, listens }) {
    Object.assign(this, { send, changed, scales, found: null, number: 0, reading: null });
    $("measured-choose").addEventListener("click", () => $("measured-file").click());
    $("measured-file").addEventListener("change", () => {
      this.#readOne([...$("measured-file").files]);
      $("measured-file").value = ""; // the same file may be chosen again
    });
    $("measured-remove").addEventListener("click", () => this.remove());
    for (const name of ["length", "time", "period", "scale", "mark"]) $(`measured-${name}`).addEventListener("change", () => this.#show());
    for (const id of Object.values(FIELDS).flat()) $(id).addEventListener("change", () => this.#read(this.file, probesShown(), chosenShown()));
    const choices = ["measured-turn", ...COLUMNS.map((name) => `measured-column-${name}`), ...UNITS.map((name) => `measured-unit-${name}`)];
    for (const id of choices) $(id).addEventListener("change", () => this.#choose(id));
    if (listens) this.#listenToDrops();
  }

  #listenToDrops() {
    const holdsFiles = ({ dataTransfer }) => dataTransfer?.types.includes("Files");
    addEventListener("dragover", (event) => {
      if (!holdsFiles(event)) return;
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    addEventListener("dragleave", ({ relatedTarget }) => relatedTarget || document.body.classList.remove("dropping"));
    addEventListener("drop", (event) => {
      document.body.classList.remove("dropping");
      if (!holdsFiles(event)) return;
      event.preventDefault();
      this.#readOne([...event.dataTransfer.files]);
    });
  }

  /** Read a file, or the two of a COMTRADE record. */
  #readOne(files) {
    const file = files.length > 1 ? combined(files) : files[0];
    if (file) this.read(file);
    else if (files.length) this.#say(`One file at a time, or the .cfg and the .dat of a COMTRADE record: of ${files.length} none is read.`, true);
  }

  /** Read a file; what was there stays until the new one has been understood. */
  read(file) {
    this.#read(file, PROBES, { columns: {}, units: {} });
  }

  /** Read the file again with the columns and units that were chosen. */
  #choose(id) {
    if (id === "measured-turn" && !$("measured-column-turn").value) return; // its column is still to be chosen
    this.#read(this.file, this.file === this.shown ? probesShown() : PROBES, chosenShown());
  }

  /** Read a file of probes at some angles and with some gains; columns that are not chosen are guessed. */
  #read(file, probes, { columns, units }) {
    if (file.size > LARGEST_FILE) {
      this.#say(`${file.name} has ${told(file.size / 1e6, 4)} MB, and at most ${Math.floor(LARGEST_FILE / 1e6)} MB can be read.`, true);
      return;
    }
    const number = (this.number += 1);
    this.reading = { file, probes, number };
    this.#say(`Reading ${file.name} …`);
    this.send({ about: "upload", number, probe_angles: probes.angles, gains: probes.gains, columns, units }, file, () => this.reading?.number === number)
      .catch(({ message }) => this.fail(message, number));
  }

  /** Say why the file that was sent last is not shown. */
  fail(message, number = this.reading?.number) {
    if (number === undefined || number !== this.reading?.number) return;
    const { name } = this.reading.file;
    this.reading = null;
    this.#say(`${name} is not shown: ${message}.${this.found ? ` ${this.found.name} stays.` : ""}`, true);
  }

  /** The file was of a rotor, which the page shows. */
  isOfRotor({ number }) {
    if (number !== this.reading?.number) return false;
    this.reading = null;
    this.#say(this.found ? this.said : "");
    return true;
  }

  /** Take what the program has found in a file. */
  take({ number, facts, arrays }) {
    if (number !== this.reading?.number) return;
    const { file, probes } = this.reading;
    this.#offer(facts);
    if (facts.trouble) {
      this.fail(facts.trouble, number);
      this.file = file; // its columns can be chosen
      return;
    }
    this.reading = null;
    const { full_frequency: frequency, full_amplitude: amplitude } = arrays;
    this.found = { ...facts, ...trackOf({ arrays }), full: frequency ? { frequency, amplitude, speed: facts.speed } : null };
    const isNew = file !== this.shown || probes === PROBES;
    this.file = this.shown = file;
    if (isNew) this.#suggest(this.found);
    this.#show();
  }

  /** Offer the columns of a file, those that were guessed or chosen among them. */
  #offer({ names, columns, units }) {
    const turn = TURNS.find((name) => name in columns) ?? $("measured-turn").value;
    $("measured-turn").value = turn;
    for (const name of COLUMNS) {
      const options = [new Option("as guessed", ""), ...names.map(([column, unit]) => new Option(unit ? `${column} [${unit}]` : column, column))];
      $(`measured-column-${name}`).replaceChildren(...options);
      $(`measured-column-${name}`).value = columns[name === "turn" ? turn : name] ?? "";
    }
    for (const name of UNITS) $(`measured-unit-${name}`).value = units[{ t: "t", length: "x", turn }[name]] ?? "";
    $("measured-columns").hidden = false;
  }

  /** Put into the form what suits a new file. */
  #suggest({ time, length }) {
    for (const [name, ids] of Object.entries(FIELDS)) ids.forEach((id, i) => ($(id).value = PROBES[name][i]));
    $("measured-length").value = length in METRES || length === "V" || length === "mV" ? length : "um";
    if (length === "1" && !this.scales()) $("measured-length").value = "1";
    $("measured-time").value = time === "1" && !this.scales() ? "1" : "s";
    $("measured-mark").value = 0;
    $("measured-period").value = "";
    $("measured-scale").value = /V$/.test(length) && this.scales() ? VOLT : "";
  }

  /** Forget the file. */
  remove() {
    this.reading = this.found = this.file = this.shown = null;
    $("measured-columns").hidden = true;
    this.#say("");
    this.#show();
    $("measured-choose").focus();
  }

  #show() {
    this.kept = null;
    $("measured-form").hidden = !this.found;
    this.refresh();
    this.changed(Boolean(this.found));
  }

  /** Request the data needed to compare the file with the page, and describe it. */
  refresh() {
    if (!this.found) return;
    const { name, samples, time, length, by, order, notes } = this.found;
    const isMachine = Boolean(this.scales());
    const volts = /V$/.test($("measured-length").value);
    const plain = $("measured-length").value === "1";
    $("measured-scale").closest("label").hidden = plain || (isMachine && !volts);
    $("measured-scale-name").textContent = volts && isMachine ? "µm a volt" : `1 of length [${SHOWN[$("measured-length").value] ?? $("measured-length").value}]`;
    $("measured-period").closest("label").hidden = isMachine || $("measured-time").value === "1";
    const { scales } = this;
    const speeds = order.speed.length ? `, ${this.#speeds(scales())}` : "";
    const asked = isMachine ? "enter the µm per volt" : "enter the scale of the page, or choose SI units for it";
    const isOpen = this.#units(scales()) ? "" : ` To draw it, ${asked}.`;
    const guessed = [time === "1" && isMachine ? "times are assumed to be in s" : "", length === "1" && isMachine ? "lengths in the unit chosen below" : ""].filter(Boolean).join(" and ");
    this.#say(this.said = `${name}: ${samples.toLocaleString("en")} samples${by ? `, turned by ${by}` : ""}${speeds}${guessed ? `; ${guessed}` : ""}. It stays on the machine of the program.${isOpen}${notes.map((each) => ` Note: ${each}.`).join("")}`);
  }

  #speeds(scales) {
    const { order: { speed }, time } = this.found;
    const last = speed.at(-1);
    const units = this.#units(scales);
    if (!units) return `from speed ${told(speed[0])} to ${told(last)}${time === "s" ? " rad/s" : ""}`;
    const shown = (value) => (scales ? withUnit(scales, "rate", value * units.rate, 4) : told(value * units.rate));
    return `from speed ${shown(speed[0])} to ${shown(last)}`;
  }

  /** Return what a unit of the file is without dimensions: of length, and of the speed. */
  #units(scales) {
    const unit = $("measured-length").value, own = this.found.length;
    const [given, period] = ["scale", "period"].map((name) => $(`measured-${name}`).valueAsNumber);
    const volts = /V$/.test(unit);
    // of a reading in volts the choice says which they are; of one without a unit what it is in
    const factor = own in METRES && unit in METRES ? METRES[own] / METRES[unit] : 1;
    if (scales) {
      if (volts && !(given > 0)) return null;
      const metres = volts ? given * (unit === "mV" ? 1e-9 : 1e-6) : unit === "1" ? scales.length : METRES[unit];
      return { length: (factor * metres) / scales.length, rate: 1 / scales.rate };
    }
    const [length, rate] = [unit === "1" ? 1 : factor / given, $("measured-time").value === "1" ? 1 : period];
    return Number.isFinite(length) && length > 0 && rate > 0 ? { length, rate } : null;
  }

  /** Return what panels draw of the file at a speed of the page; nothing while there is none. */
  source(scales, speed) {
    if (!this.found) return null;
    const units = this.#units(scales?.length ? scales : null);
    if (!units) return null;
    const key = JSON.stringify(units);
    if (this.kept?.key !== key) this.kept = { key, ...this.#scaled(units) };
    const { order, rows, full } = this.kept;
    return {
      name: "measured", icon: "line-key measured", ink: () => colour("measured"), order, rows, curve: null, exact: null, sparse: true,
      lines: full ? linesAt(full, full.speed ?? speed) : nearest(rows, speed, scales),
    };
  }

  #scaled({ length, rate }) {
    const { order, rows, full } = this.found;
    const mark = (Math.PI / 180) * ($("measured-mark").valueAsNumber || 0);
    const whirl = (each) => ({ ...each, frequency: scaled(each.frequency, rate), amplitude: scaled(each.amplitude, length), speed: each.speed && each.speed * rate });
    return {
      order: { speed: scaled(order.speed, rate), amplitude: scaled(order.amplitude, length), lag: order.lag.map((each) => each + mark) },
      rows: rows.map(whirl), full: full && whirl(full),
    };
  }

  #say(text, isWrong = false) {
    $("measured-said").textContent = text;
    $("measured-said").classList.toggle("wrong", isWrong);
  }
}

/** Return the two files of a COMTRADE record as one, which its standard calls .cff; null for others. */
function combined(files) {
  const [head, data] = [".cfg", ".dat"].map((ending) => files.find(({ name }) => name.toLowerCase().endsWith(ending)));
  if (files.length !== 2 || !head || !data) return null;
  return new File(["--- file type: CFG ---\r\n", head, "\r\n--- file type: DAT ---\r\n", data], head.name.replace(/\.cfg$/i, ".cff"));
}

/** Return the angles of the probes from the form. */
const probesShown = () => Object.fromEntries(Object.entries(FIELDS).map(([name, ids]) => [name, ids.map((id) => $(id).valueAsNumber)]));

/** Return the columns and units that the form has, by signal; those that are not chosen are left out. */
function chosenShown() {
  const turn = $("measured-turn").value;
  const kept = (pairs) => Object.fromEntries(pairs.filter(([, value]) => value));
  const unit = (name) => $(`measured-unit-${name}`).value;
  return {
    columns: kept(COLUMNS.map((name) => [name === "turn" ? turn : name, $(`measured-column-${name}`).value])),
    units: kept([["t", unit("t")], ["x", unit("length")], ["y", unit("length")], [turn, turn === "keyphasor" ? "" : unit("turn")]]),
  };
}

const linesAt = ({ frequency, amplitude }, speed, words = "") => (speed > 0 ? { over: scaled(frequency, 1 / speed), amplitude, told: words } : null);

/** Return the lines at the speed that is nearest to another. */
function nearest(rows, speed, scales) {
  if (!rows.length || !(speed > 0)) return null;
  const row = rows[nearestIn(rows.map((each) => each.speed), speed)];
  return linesAt(row, row.speed, `at speed ${scales?.rate ? withUnit(scales, "rate", row.speed, 4) : told(row.speed)}, Hann window`);
}
