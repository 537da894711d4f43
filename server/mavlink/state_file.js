// Small files of state beside the spool.

import { readFileSync, renameSync, writeFileSync } from 'node:fs';

const tell = (text) => console.error(text);

// The object in the file; nothing if there is none. A power cut may leave a file empty or half written: it is set aside,
// because the program must run without it too.
export function readState(path, log = tell, reviver = undefined) {
  let text;
  try {
    text = readFileSync(path, 'utf8');
  } catch (error) {
    if (error.code === 'ENOENT') return undefined;
    throw error;
  }
  try {
    const value = JSON.parse(text, reviver);
    if (typeof value === 'object' && value !== null) return value;
    throw new SyntaxError(`expected an object, got ${text}`);
  } catch (error) {
    renameSync(path, `${path}.broken`);
    log(`${path} cannot be read and is set aside as ${path}.broken: ${error.message}`);
    return undefined;
  }
}

// The old text or the new one, also after the program was killed.
export function replaceFile(path, text, mode = 0o600) {
  writeFileSync(`${path}.new`, text, { mode });
  renameSync(`${path}.new`, path);
}
