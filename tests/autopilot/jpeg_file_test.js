// What a picture tells of itself, without files.

import assert from 'node:assert/strict';
import test from 'node:test';

import { exposureTime, isWhole } from '../../server/mavlink/frames/jpeg_file.js';
import { tinyJpeg } from './tiny_jpeg.js';

const time_us = Date.UTC(2026, 5, 1, 12) * 1000;
const picture = tinyJpeg(1, time_us);
const end = Buffer.from([0xff, 0xd9]);

// A segment with a thumbnail, which has an end of its own.
function withThumbnail(jpeg) {
  const thumbnail = Buffer.concat([Buffer.from('thumb\0'), jpeg]);
  const head = Buffer.from([0xff, 0xe2, 0, 0]);
  head.writeUInt16BE(thumbnail.length + 2, 2);
  return Buffer.concat([jpeg.subarray(0, 2), head, thumbnail, jpeg.subarray(2)]);
}

test('a picture is whole where its pixels have an end, whatever follows', () => {
  const body = picture.subarray(0, picture.length - 2);
  const whole = { plain: picture, trailer: Buffer.concat([picture, Buffer.alloc(8192, 7)]), thumbnail: withThumbnail(picture),
    'bytes before the end': Buffer.concat([body, Buffer.alloc(4, 17), end]), 'two ends': Buffer.concat([picture, end]),
    'bytes between segments': Buffer.concat([picture.subarray(0, 2), Buffer.alloc(5), picture.subarray(2)]) };
  for (const [what, bytes] of Object.entries(whole)) assert.ok(isWhole(bytes), what);
});

test('a picture that is cut anywhere is not whole', () => {
  const long = withThumbnail(picture);
  for (let size = 0; size < long.length; ++size) assert.ok(!isWhole(long.subarray(0, size)), `${size} bytes`);
  assert.ok(!isWhole(Buffer.concat([picture.subarray(0, picture.length / 2), Buffer.alloc(4096)])));
  assert.equal(exposureTime(picture).time_us, time_us);
});
