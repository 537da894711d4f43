// Messages by name, as bytes of MAVLink 2.

import { fieldsOf, messageClasses, packetBytes, checksumExtraOf } from '../../../server/mavlink/messages.js';

const classOf = new Map();
export const messageIdOf = new Map();
for (const [id, messageClass] of Object.entries(messageClasses)) {
  classOf.set(messageClass.MSG_NAME, messageClass);
  messageIdOf.set(messageClass.MSG_NAME, Number(id));
}

// Counts packets of one sender and signs them if it has a key.
export class Sender {
  #address;
  #signing;
  #sequence = 0;

  // address: systemId, componentId. signing: as of server/mavlink/signing.js.
  constructor(address, signing) {
    this.#address = address;
    this.#signing = signing;
  }

  bytes(name, fields, now_ms) {
    const messageClass = classOf.get(name);
    if (!messageClass) throw new Error(`unknown message ${name}`);
    const message = Object.assign(new messageClass(), fields);
    const bytes = packetBytes(message, { ...this.#address, sequence: this.#sequence++ });
    if (!this.#signing) return bytes;
    const extra = checksumExtraOf(messageClass.MSG_ID);
    return this.#signing.signed(bytes, { linkId: 1, extra, now_ms });
  }
}

// Any missing field is 0.
export const allZero = (name) => {
  const fields = {};
  for (const { name: field, arrayLength, type } of classOf.get(name).FIELDS) {
    const zero = /^u?int64/.test(type) ? 0n : 0;
    fields[field] = arrayLength && type !== 'char[]' ? Array(arrayLength).fill(zero) : type === 'char[]' ? '' : zero;
  }
  return fields;
};

export { fieldsOf };
