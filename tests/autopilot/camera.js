// A camera in a stand-in: each trigger takes a picture, and a copying program brings it to a folder,
// sometime and somehow.

import { createHash } from 'node:crypto';
import { renameSync, utimesSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { fieldsOf, nameOf } from '../../server/mavlink/messages.js';
import { packetsInDatagram } from '../../server/mavlink/framing.js';
import { tinyJpeg } from './tiny_jpeg.js';

export const digestOf = (bytes) => createHash('sha256').update(bytes).digest('hex');

export class Camera {
  #plane;
  #folder;
  #random;
  #timeOf;
  #isExif;
  // Of each picture: name, bytes, time of the camera's clock, and the message of its trigger.
  taken = [];

  // clockOffset_s: the camera's clock less UTC. isExif: its files tell their time.
  constructor(plane, { folder, random, clockOffset_s = 0, isExif = true }) {
    this.#plane = plane;
    this.#folder = folder;
    this.#random = random;
    this.#timeOf = () => Math.round(plane.utc_us + 1e6 * (clockOffset_s + 0.03 * random.gauss()));
    this.#isExif = isExif;
    const send = plane.onSend;
    plane.onSend = (bytes) => {
      for (const packet of packetsInDatagram(bytes).packets) {
        if (nameOf(packet.messageId) === 'CAMERA_FEEDBACK') this.#message = { utc_us: plane.utc_us, ...fieldsOf(packet) };
      }
      send(bytes);
    };
  }

  #message;

  // A picture that nobody triggered has no message.
  expose({ isTriggered = true } = {}) {
    this.#message = undefined;
    if (isTriggered) this.#plane.takePicture();
    const time_us = this.#timeOf();
    const number = this.taken.length + 1;
    const bytes = tinyJpeg(`${number} ${this.#random.uniform()}`, this.#isExif ? time_us : undefined);
    const picture = { name: `DSC${String(number).padStart(5, '0')}.JPG`, bytes, time_us, message: this.#message, sha256: digestOf(bytes) };
    this.taken.push(picture);
    return picture;
  }

  // fileTime_us: of the file; some copying programs leave the camera's time, others that of copying.
  drop({ name, bytes }, { as = name, fileTime_us } = {}) {
    const path = join(this.#folder, as);
    writeFileSync(`${path}.part`, bytes);
    if (fileTime_us) utimesSync(`${path}.part`, fileTime_us / 1e6, fileTime_us / 1e6);
    renameSync(`${path}.part`, path);
  }

  // Written in place, with a pause in the middle.
  async dropSlowly({ name, bytes }, pause) {
    const path = join(this.#folder, name);
    writeFileSync(path, bytes.subarray(0, bytes.length / 2));
    await pause();
    writeFileSync(path, bytes);
  }
}
