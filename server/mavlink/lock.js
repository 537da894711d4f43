// Two programs must not share a spool.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

// After a restart of the machine another program may have the number.
function isOurs(pid) {
  try {
    return readFileSync(`/proc/${pid}/cmdline`, 'utf8').includes('freelsd-mavlink');
  } catch {
    return false;
  }
}

export function lock(folder) {
  const path = join(folder, 'pid');
  let holder;
  try {
    holder = Number.parseInt(readFileSync(path, 'utf8'), 10);
  } catch (error) {
    if (error.code !== 'ENOENT') throw error;
  }
  if (holder && holder !== process.pid && isOurs(holder)) {
    throw new Error(`--spool ${folder}: freelsd-mavlink ${holder} uses it; give this one another folder`);
  }
  writeFileSync(path, String(process.pid));
}
