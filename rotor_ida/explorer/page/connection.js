// Questions to the program and its answers; in an exported page, the recorded answers.

const KINDS = { f8: Float64Array, f4: Float32Array, i1: Int8Array };
const PROTOCOL = "rotor-ida";
// Bytes of a file sent at a time, and allowed to wait.
const PIECE = 2 ** 16, MOST_UNSENT = 2 ** 20;
const GONE = "No answer. Is rotor-ida explore still running? If it was restarted, open the address that it printed.";

/** Unpack an answer: 4 bytes with the length of the header, the header as JSON, the arrays. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, [kind, offset, count]] of Object.entries(header.arrays)) {
    arrays[name] = new KINDS[kind](buffer, 4 + length + offset, count);
  }
  return { ...header, arrays };
}

/** The program, over a websocket; of each kind of question it answers the newest one. */
export class Live {
  constructor(key, { answered, opened, said }) {
    Object.assign(this, { key, answered, opened, said });
    this.delay = 500;
    this.#open();
  }

  #open() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/ask`, [`${PROTOCOL}.${this.key}`]);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.delay = 500;
      this.said("");
      this.opened();
    };
    socket.onmessage = (message) => this.answered(unpack(message.data));
    socket.onclose = () => {
      this.said(GONE);
      setTimeout(() => this.#open(), this.delay);
      this.delay = Math.min(2 * this.delay, 5000);
    };
    this.socket = socket;
  }

  /** Ask the questions `abouts` about a rotor, each in place of an older one; a file is requested alone. */
  ask(question, abouts) {
    if (this.socket.readyState !== WebSocket.OPEN) return;
    for (const about of abouts) this.socket.send(JSON.stringify({ ...question, about }));
  }

  /** Send a file in pieces after its question, while `isWanted` returns true. */
  async send(question, file, isWanted) {
    const { socket } = this;
    if (socket.readyState !== WebSocket.OPEN) throw new Error("the program does not answer");
    socket.send(JSON.stringify({ ...question, name: file.name, size: file.size }));
    for (let from = 0; from < file.size; from += PIECE) {
      const piece = await file.slice(from, from + PIECE).arrayBuffer();
      while (socket.bufferedAmount > MOST_UNSENT) await new Promise((resolve) => setTimeout(resolve, 5));
      if (!isWanted() || socket.readyState !== WebSocket.OPEN) return;
      socket.send(piece);
    }
  }
}

/** Answers that were recorded in this page, by course (from the start, up, down) and speed. */
export class Recorded {
  constructor(recorded, answered) {
    Object.assign(this, { recorded, answered });
  }

  ask(question) {
    const { common, courses, course, place } = this.recorded;
    for (const text of [...common, ...courses[course][place]]) {
      const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
      this.answered({ ...unpack(bytes.buffer), number: question.number, side: 0 });
    }
  }
}
