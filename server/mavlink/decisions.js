// What the link decided, for people: the newest lines, numbered from 1 in each run of the program.

import { randomBytes } from 'node:crypto';

const maxNumKept = 50;
const longestText = 500;

export class Decisions {
  #lines = [];
  #next = 1;
  run = randomBytes(8).toString('hex');
  onAdd = () => {};

  // kind: a word such as 'mission', 'engine', 'guidance', 'link'.
  add(kind, text, now_ms = Date.now()) {
    this.#lines.push({ id: this.#next++, at: new Date(now_ms).toISOString(), text: text.slice(0, longestText), kind });
    if (this.#lines.length > maxNumKept) this.#lines.shift();
    this.onAdd();
  }

  get newest() { return [...this.#lines]; }
}
