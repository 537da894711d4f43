// Two programs must not share a spool.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

// Of the fields behind the program's name in /proc/PID/stat.
const startField = 19;

// The same for as long as the process runs. Another process with its number, also after a restart of the machine, has
// another one.
function lifeOf(pid) {
  try {
    const stat = readFileSync(`/proc/${pid}/stat`, 'utf8');
    const started = stat.slice(stat.lastIndexOf(')') + 2).split(' ')[startField];
    return `${pid} ${started} ${readFileSync('/proc/sys/kernel/random/boot_id', 'utf8').trim()}`;
  } catch {
    return undefined;
  }
}

export function lock(folder) {
  const path = join(folder, 'pid');
  let held = '';
  try {
    held = readFileSync(path, 'utf8').trim();
  } catch (error) {
    if (error.code !== 'ENOENT') throw error;
  }
  const holder = Number.parseInt(held, 10);
  if (holder && holder !== process.pid && held === lifeOf(holder)) {
    throw new Error(`--spool ${folder}: freelsd-mavlink ${holder} uses it; give this one another folder`);
  }
  writeFileSync(path, lifeOf(process.pid) ?? String(process.pid));
}
