// What a JPEG file tells of itself without being decoded: whether it is whole, and when it was taken.

const startOfImage = 0xffd8;
const endOfImage = 0xd9;
const startOfScan = 0xda;
const app1 = 0xe1;
const exifMark = 'Exif\0\0';
const exifPointer = 0x8769;
const ascii = 2;
const maxNumEntries = 1000;
// Time, fraction of its second, offset from UTC: of the exposure, else of the digitizing.
const timeTags = [[0x9003, 0x9291, 0x9011], [0x9004, 0x9292, 0x9012]];

// Place of the next marker's code from `at` on. A zero follows a plain 0xff of pixels, codes from 0xd0
// to 0xd7 stand between them, and 0xff fills.
function nextMarker(bytes, at) {
  for (let found = bytes.indexOf(0xff, at); found >= 0; found = bytes.indexOf(0xff, found + 1)) {
    const code = bytes[found + 1];
    if (code !== undefined && code !== 0 && code !== 0xff && !(code >= 0xd0 && code <= 0xd7)) return found + 1;
  }
  return undefined;
}

// True if the file reaches the end of its image, whatever follows. The thumbnail has ends of its own
// within a segment.
export function isWhole(bytes) {
  if (bytes.length < 4 || bytes.readUInt16BE(0) !== startOfImage) return false;
  let isScanned = false;
  for (let at = nextMarker(bytes, 2); at !== undefined && at + 3 <= bytes.length;) {
    if (bytes[at] === endOfImage) return isScanned;
    isScanned ||= bytes[at] === startOfScan;
    at = nextMarker(bytes, at + 1 + bytes.readUInt16BE(at + 1));
  }
  return isScanned && bytes[bytes.length - 2] === 0xff && bytes[bytes.length - 1] === endOfImage;
}

// The TIFF part of EXIF.
function exifOf(bytes) {
  for (let at = 2; at + 4 <= bytes.length && bytes[at] === 0xff && bytes[at + 1] !== startOfScan;) {
    const size = bytes.readUInt16BE(at + 2);
    const content = bytes.subarray(at + 4, at + 2 + size);
    if (bytes[at + 1] === app1 && content.subarray(0, exifMark.length).toString('latin1') === exifMark) {
      return content.subarray(exifMark.length);
    }
    at += 2 + size;
  }
  return undefined;
}

class Tiff {
  #bytes;
  #isLittle;

  constructor(bytes) {
    this.#bytes = bytes;
    this.#isLittle = bytes.subarray(0, 2).toString('latin1') === 'II';
  }

  word(at) { return this.#isLittle ? this.#bytes.readUInt16LE(at) : this.#bytes.readUInt16BE(at); }
  long(at) { return this.#isLittle ? this.#bytes.readUInt32LE(at) : this.#bytes.readUInt32BE(at); }

  // Places of the entries of a directory, by tag.
  entries(at) {
    const count = Math.min(this.word(at), maxNumEntries);
    return new Map(Array.from({ length: count }, (_, i) => [this.word(at + 2 + 12 * i), at + 2 + 12 * i]));
  }

  text(entry) {
    if (entry === undefined || this.word(entry + 2) !== ascii) return undefined;
    const size = this.long(entry + 4);
    const at = size <= 4 ? entry + 8 : this.long(entry + 8);
    return this.#bytes.subarray(at, at + size).toString('latin1').replace(/\0.*$/s, '').trim();
  }
}

function timeFrom(dateText, fractionText, offsetText) {
  const parts = /^(\d{4})[:-](\d\d)[:-](\d\d)[ T](\d\d):(\d\d):(\d\d)$/.exec(dateText ?? '');
  if (!parts) return undefined;
  const [year, month, ...rest] = parts.slice(1).map(Number);
  const time_us = Date.UTC(year, month - 1, ...rest) * 1000;
  const offset = /^([+-])(\d\d):(\d\d)$/.exec(offsetText ?? '');
  const offset_us = offset ? Number(`${offset[1]}1`) * (Number(offset[2]) * 60 + Number(offset[3])) * 60e6 : 0;
  // Some cameras write zeros for a fraction that they do not know.
  const isFine = /^\d+$/.test(fractionText ?? '') && !/^0+$/.test(fractionText);
  const fraction_us = isFine ? Math.round(Number(`0.${fractionText}`) * 1e6) : 0;
  return { time_us: time_us + fraction_us - offset_us, isFine };
}

// { time_us, isFine } by the camera's clock; without isFine it is a whole second. Nothing if the
// file does not tell, or tells nonsense. A time without its offset counts as UTC.
export function exposureTime(bytes) {
  try {
    const exif = exifOf(bytes);
    if (!exif) return undefined;
    const tiff = new Tiff(exif);
    const pointer = tiff.entries(tiff.long(4)).get(exifPointer);
    if (pointer === undefined) return undefined;
    const entries = tiff.entries(tiff.long(pointer + 8));
    for (const tags of timeTags) {
      const time = timeFrom(...tags.map((tag) => tiff.text(entries.get(tag))));
      if (time) return time;
    }
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
  }
  return undefined;
}
