// Messages by name, as bytes of MAVLink 2.

import { fieldsOf, idOf, messageClasses, messageOf, packetBytes } from '../../../server/mavlink/messages.js';

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
    if (!(name in idOf)) throw new Error(`unknown message ${name}`);
    const bytes = packetBytes(messageOf(name, fields), { ...this.#address, sequence: this.#sequence++, isSigned: Boolean(this.#signing) });
    return this.#signing?.signed(bytes, { linkId: 1, now_ms }) ?? bytes;
  }
}

// Any missing field is 0.
export const allZero = (name) => {
  const fields = {};
  for (const { name: field, arrayLength, type } of messageClasses[idOf[name]].FIELDS) {
    const zero = /^u?int64/.test(type) ? 0n : 0;
    fields[field] = arrayLength && type !== 'char[]' ? Array(arrayLength).fill(zero) : type === 'char[]' ? '' : zero;
  }
  return fields;
};

export { fieldsOf };
