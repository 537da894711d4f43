// Small JPEG files of a camera, each different, with the time of the exposure in EXIF.

// 32 x 32 pixels of a rendered meadow.
const image = Buffer.from(
  '/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgICAgMCAgIDAwMDBAYEBAQEBAgGBgUGCQgKCgkICQkKDA8MCgsOCwkJDRENDg8QEBEQCgwSEx' +
  'IQEw8QEBD/2wBDAQMDAwQDBAgEBAgQCwkLEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBD/wAARCAAg' +
  'ACADASIAAhEBAxEB/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUFBAQAAAF9AQIDAAQRBRIhMUEGE1FhBy' +
  'JxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJipKT' +
  'lJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi4+Tl5ufo6erx8vP09fb3+Pn6/8QAHwEAAwEBAQEBAQEBAQAAAA' +
  'AAAAECAwQFBgcICQoL/8QAtREAAgECBAQDBAcFBAQAAQJ3AAECAxEEBSExBhJBUQdhcRMiMoEIFEKRobHBCSMzUvAVYnLRChYkNOEl8RcYGRom' +
  'JygpKjU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVmZ2hpanN0dXZ3eHl6goOEhYaHiImKkpOUlZaXmJmaoqOkpaanqKmqsrO0tba3uLm6wsPExc' +
  'bHyMnK0tPU1dbX2Nna4uPk5ebn6Onq8vP09fb3+Pn6/9oADAMBAAIRAxEAPwDrrKSO8RvMnMbRsWjCnuMAYB7YzxTNautCuBDaazYR3L29wJoS' +
  'xIKFerAjgHkD8atwaXGIBPdSpC4bfIPM3fKOd3HHrjGa4TVtTS51SZh5E8aBIfNVix4y3XGP4sYx2PJ7fm9TE1KdOShJ22PYzNwhQbaV3odXJD' +
  '4f1W2a8t71YtzGNVn6ZGf4hzj6gdK5vUtBuYyzfY4mt42Lb7YhgcH1Bp6OscasicKOX+8Dz0xT9QupI0ZbKd4jFj95FwADk465/wD1V5cZ007O' +
  'NvT/AC1X3WPmLpEtp4sW+ji099QVo1GCXi2ZU8c8YPWq0fhwrK0kc4JMrMWAyoyT2z7gd65K3eJQIrTAbIQnPBBzxj15P5Vutrfnoy/aWWSI7Q' +
  'sJAOR7emcn8q9SWEqYqHuO36ntONXM6V5NKz+82FgWwXE/zxxuQBjALdT2wfrWHqU0FxI0zLtCNkHdtbb9fTrV+LUrqezW1vLd38vaWVh8xwME' +
  'kY5JyOn96sjUp7K9mKMj2wiCgu4PY9cdun41w/2fXpSu1fzWpwVMvr0ne10f/9k=', 'base64');

export const tinyCamera = { width_px: 32, height_px: 32, fx_px: 19.8, fy_px: 19.8, cx_px: 15.5, cy_px: 15.5,
  distortion: { model: 'none', coefficients: [] } };

function segment(marker, content) {
  const head = Buffer.from([0xff, marker, 0, 0]);
  head.writeUInt16BE(content.length + 2, 2);
  return Buffer.concat([head, content]);
}

// TIFF with one directory: DateTimeOriginal, SubSecTimeOriginal and OffsetTimeOriginal.
function exif(time_us, { hasFraction = true, offset } = {}) {
  const text = new Date(time_us / 1000).toISOString();
  const texts = [[0x9003, `${text.slice(0, 10).replaceAll('-', ':')} ${text.slice(11, 19)}`]];
  if (offset) texts.push([0x9011, offset]);
  if (hasFraction) texts.push([0x9291, String(Math.floor(time_us) % 1e6).padStart(6, '0')]);
  const start = 8 + 18;
  const bytes = Buffer.alloc(start + 2 + 12 * texts.length + 4 + 40 * texts.length);
  bytes.write('II*\0\x08\0\0\0\x01\0', 'latin1');
  bytes.writeUInt16LE(0x8769, 10);
  bytes.writeUInt16LE(4, 12);
  bytes.writeUInt32LE(1, 14);
  bytes.writeUInt32LE(start, 18);
  bytes.writeUInt16LE(texts.length, start);
  texts.forEach(([tag, value], i) => {
    const entry = start + 2 + 12 * i;
    const at = start + 2 + 12 * texts.length + 4 + 40 * i;
    bytes.writeUInt16LE(tag, entry);
    bytes.writeUInt16LE(2, entry + 2);
    bytes.writeUInt32LE(value.length + 1, entry + 4);
    bytes.writeUInt32LE(at, entry + 8);
    bytes.write(value, at, 'latin1');
  });
  return Buffer.concat([Buffer.from('Exif\0\0', 'latin1'), bytes]);
}

// time_us: of the camera's clock; without it there is no EXIF.
export function tinyJpeg(id, time_us, options) {
  const parts = [image.subarray(0, 2)];
  if (time_us !== undefined) parts.push(segment(0xe1, exif(time_us, options)));
  parts.push(segment(0xfe, Buffer.from(`picture ${id}`)), image.subarray(2));
  return Buffer.concat(parts);
}
