// Reads a measured file beside the page, so that a long one does not hold it up.

import { Refusal, analysed, recordOf } from "./record.js";

onmessage = async ({ data: { file, number, probes } }) => {
  try {
    const began = performance.now();
    const record = recordOf(await file.text(), probes);
    const { time, length, samples, by } = record;
    postMessage({ number, name: file.name, time, length, samples, by, ...analysed(record), took: performance.now() - began });
  } catch (error) {
    const why = error instanceof Refusal ? error.message : `it cannot be read: ${error.message}`;
    postMessage({ number, name: file.name, refused: why });
  }
};
