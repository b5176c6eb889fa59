// Tables shared by the package and the page, stored in its markup.

export const {
  /** Bytes of a file that can be read. */
  largest_file: LARGEST_FILE,
  /** Of each parameter, by its name: words, symbol, meaning without dimensions and in SI units, and its SI unit. */
  parameters: PARAMETERS,
  /** Range of speeds of a machine, as multiples of its largest one. */
  room: ROOM,
  least_speed: LEAST_SPEED,
  /** Quantities of a data sheet: the names of the ways to give each, and an example. */
  sheet: SHEET,
  /** Number of units of speed in one radian per second. */
  speed_units: SPEED_UNITS,
  /** Acceleration of gravity [m/s²]. */
  gravity: GRAVITY,
  /** Names of the paper's parameters, dimensionless and in SI units. */
  dimensionless: DIMENSIONLESS,
  machine: MACHINE,
  /** Further parameters, with their values in the paper. */
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
