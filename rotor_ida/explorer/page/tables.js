// What the program says once for itself and for the page; it is written into the page.

const tables = JSON.parse(document.getElementById("tables").textContent);
/** Bytes of a file that can be read. */
export const LARGEST_FILE = tables.largest_file;
