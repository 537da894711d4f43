// Looks into the folder of the camera. A file counts once it has stayed as it is for a while, so that
// one that is being copied is not read.

import { readdir, stat } from 'node:fs/promises';
import { join } from 'node:path';

const isPicture = (name) => /^[^.].*\.jpe?g$/i.test(name);
const settle_ms = 2000;
const maxNumFiles = 20_000;

export class PictureFolder {
  #folder;
  #files = new Map();
  numIgnored = 0;
  lastError;

  constructor(folder) { this.#folder = folder; }

  // [{ name, size, mtime_ms, isSettled }]; nothing if the folder cannot be read. now_ms: a clock that
  // never steps.
  async look(now_ms) {
    let names;
    try {
      names = (await readdir(this.#folder)).filter(isPicture).sort();
      this.lastError = undefined;
    } catch (error) {
      this.lastError = error.message;
      return undefined;
    }
    this.numIgnored = Math.max(0, names.length - maxNumFiles);
    const before = this.#files;
    this.#files = new Map();
    for (const name of names.slice(-maxNumFiles)) {
      const found = await stat(join(this.#folder, name)).catch(() => undefined);
      if (!found?.isFile()) continue;
      const last = before.get(name);
      const isSame = last && last.size === found.size && last.mtime_ms === found.mtimeMs;
      this.#files.set(name, { name, size: found.size, mtime_ms: found.mtimeMs, since_ms: isSame ? last.since_ms : now_ms });
    }
    return [...this.#files.values()].map(({ since_ms, ...file }) => ({ ...file, isSettled: now_ms - since_ms >= settle_ms }));
  }
}
