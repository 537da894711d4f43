// Reads the float32 layers of the server: one band, strips, uncompressed or deflated.
// It rejects every other TIFF.

const tag = {
  width: 256, height: 257, bits: 258, compression: 259, offsets: 273, rowsPerStrip: 278,
  counts: 279, predictor: 317, format: 339,
};
const typeSize = { 1: 1, 2: 1, 3: 2, 4: 4, 12: 8 };

function readTags(view, little) {
  const at = view.getUint32(4, little);
  const tags = new Map();
  for (let i = 0; i < view.getUint16(at, little); ++i) {
    const entry = at + 2 + 12 * i;
    const type = view.getUint16(entry + 2, little);
    const count = view.getUint32(entry + 4, little);
    if (type !== 3 && type !== 4) continue;
    const isInline = typeSize[type] * count <= 4;
    const begin = isInline ? entry + 8 : view.getUint32(entry + 8, little);
    tags.set(view.getUint16(entry, little), Array.from({ length: count }, (_, k) =>
      (type === 3 ? view.getUint16(begin + 2 * k, little) : view.getUint32(begin + 4 * k, little))));
  }
  return tags;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// {width, height, at(row, col)}; at() is NaN where unseen and outside.
export async function readGeoTiff(buffer) {
  const view = new DataView(buffer);
  const order = view.getUint16(0);
  const little = order === 0x4949;
  if ((!little && order !== 0x4d4d) || view.getUint16(2, little) !== 42) throw new Error('not a TIFF');
  const tags = readTags(view, little);
  const one = (name, fallback) => tags.get(tag[name])?.[0] ?? fallback;
  const compression = one('compression', 1);
  if (one('bits') !== 32 || one('format') !== 3 || one('predictor', 1) !== 1 ||
      ![1, 8, 32946].includes(compression)) {
    throw new Error('not a layer of this server');
  }
  const [width, height] = [one('width'), one('height')];
  const values = new Float32Array(width * height).fill(NaN);
  let next = 0;
  for (let i = 0; i < tags.get(tag.offsets).length; ++i) {
    const strip = new Uint8Array(buffer, tags.get(tag.offsets)[i], tags.get(tag.counts)[i]);
    const plain = compression === 1 ? strip : await inflate(strip);
    const numbers = new DataView(plain.buffer, plain.byteOffset, plain.byteLength);
    for (let k = 0; k + 4 <= plain.byteLength && next < values.length; k += 4) {
      values[next++] = numbers.getFloat32(k, little);
    }
  }
  const isInside = (row, col) => row >= 0 && col >= 0 && row < height && col < width;
  return { width, height, at: (row, col) => (isInside(row, col) ? values[row * width + col] : NaN) };
}
