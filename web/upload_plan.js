// Distributes photographs to requests. Pure functions: no DOM, no requests.

const kImage = /\.(jpe?g|png)$/i;
const kPoses = /\.(csv|txt|ndjson|jsonl)$/i;
const kChunkFiles = 8;
const kChunkBytes = 24 << 20;

const byName = new Intl.Collator('en', { numeric: true });

// Files by kind: {images, poses, zip, flightJson, ignored}.
export function sortOut(files) {
  const result = { images: [], poses: null, zip: null, flightJson: null, ignored: [] };
  for (const file of files) {
    if (kImage.test(file.name)) result.images.push(file);
    else if (/\.zip$/i.test(file.name) && !result.zip) result.zip = file;
    else if (kPoses.test(file.name) && !result.poses) result.poses = file;
    else if (/\.json$/i.test(file.name) && !result.flightJson) result.flightJson = file;
    else result.ignored.push(file);
  }
  result.images.sort((a, b) => byName.compare(a.name, b.name));
  return result;
}

// Must match how the server derives the frame id from a file name.
export const frameId = (name) => name.replace(/[^A-Za-z0-9._-]/g, '_');

const unquoted = (cell) => cell.trim().replace(/^"(.*)"$/, '$1');

// {linesOf(names)}: the part of a pose file about these photographs. null if the file cannot be split
// and must go into one request with all photographs.
export function splitPoses(text, names) {
  const lines = text.split(/\r?\n/).filter((line) => line.trim() !== '');
  const wanted = new Set(names);
  if (lines[0]?.startsWith('{')) {
    const keyed = new Map(lines.map((line) => [JSON.parse(line).image, line]));
    return { linesOf: (some) => some.filter((n) => keyed.has(n)).map((n) => keyed.get(n)).join('\n') };
  }
  const separator = [',', ';', '\t'].find((s) => lines[0]?.includes(s));
  if (!separator) return null;
  const rows = lines.slice(1).map((line) => line.split(separator).map(unquoted));
  const hits = (column) => rows.filter((row) => wanted.has(row[column])).length;
  const column = (rows[0] ?? []).findIndex((_, c) => hits(c) > 0);
  // A quoted separator would shift the columns: only the server parses such files.
  if (column < 0 || /"[^"\n]*[,;\t][^"\n]*"/.test(text)) return null;
  const keyed = new Map(rows.map((row, i) => [row[column], lines[i + 1]]));
  return {
    linesOf(some) {
      const own = some.filter((name) => keyed.has(name)).map((name) => keyed.get(name));
      return own.length ? [lines[0], ...own].join('\n') : '';
    },
  };
}

// Groups of {file} for one request each. Small groups limit what a lost connection repeats.
export function chunksOf(entries) {
  const chunks = [];
  let size = Infinity;
  for (const entry of entries) {
    if (size + entry.file.size > kChunkBytes || chunks.at(-1)?.length >= kChunkFiles) {
      chunks.push([]);
      size = 0;
    }
    chunks.at(-1).push(entry);
    size += entry.file.size;
  }
  return chunks;
}

// The sent share of each file, 0 to 1. sent: bytes of the whole request.
export function sharesOf(files, sent) {
  let before = 0;
  return files.map((file) => {
    const share = Math.min(1, Math.max(0, (sent - before) / Math.max(1, file.size)));
    before += file.size;
    return share;
  });
}

export async function sha256(file) {
  // Browsers offer crypto.subtle only over HTTPS and on localhost.
  if (!globalThis.crypto?.subtle) return null;
  const digest = await crypto.subtle.digest('SHA-256', await file.arrayBuffer());
  return [...new Uint8Array(digest)].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}
