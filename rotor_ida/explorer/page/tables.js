// What the package states once for itself and for the page, which has it in its markup.

export const {
  /** Bytes of a file that can be read. */
  largest_file: LARGEST_FILE,
  /** Of each parameter, by its name: words, symbol, meaning without dimensions and in SI units, and its SI unit. */
  parameters: PARAMETERS,
  /** Speeds of a machine are shown up to so many times its largest one, its curve from this part of that on. */
  room: ROOM,
  least_speed: LEAST_SPEED,
  /** Quantities of a data sheet: the names of the ways to give each, and an example. */
  sheet: SHEET,
  /** How many of a unit of speed are one radian a second. */
  speed_units: SPEED_UNITS,
  /** Acceleration of gravity [m/s²]. */
  gravity: GRAVITY,
  /** Names of what the paper's rotor has, without dimensions and in SI units. */
  dimensionless: DIMENSIONLESS,
  machine: MACHINE,
  /** What a machine has beside either, and the value of each without which it is the paper's rotor. */
  optional: OPTIONAL,
  /** Names of the components of a state. */
  components: START,
  /** Numbers of the kinds of events, of ways of moving with friction, of stability, and of points of a branch. */
  events: EVENTS,
  modes: MODES,
  stability: STABILITY,
  special: SPECIAL,
} = JSON.parse(document.getElementById("tables").textContent);

/** Return the words of numbers of which a table has the number by the word. */
export const wordsOf = (table) => Object.fromEntries(Object.entries(table).map(([word, number]) => [number, word.replace("_", " ")]));
