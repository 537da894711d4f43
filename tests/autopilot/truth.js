// What a recording says, read without the link's own code path: decoded messages in order.

import { fieldsOf, nameOf } from '../../server/mavlink/messages.js';
import { packetsInDatagram } from '../../server/mavlink/framing.js';
import { Link } from '../../server/mavlink/link.js';

// The simulator's wind: 6 m/s from 70 degrees.
export const trueWind = {
  east_mps: -6 * Math.sin((70 * Math.PI) / 180), north_mps: -6 * Math.cos((70 * Math.PI) / 180),
};

export function messagesOf(records) {
  return records.flatMap(({ time_us, bytes }) => packetsInDatagram(bytes).packets.map((packet) => (
    { time_us, packet, name: nameOf(packet.messageId), fields: fieldsOf(packet) })));
}

// Runs the records through a link without sockets. `keep(name)`: which messages it may hear.
export function throughLink(records, { keep = () => true, onStep = () => {} } = {}) {
  const lines = [];
  const events = [];
  let now_us = records[0].time_us;
  const link = new Link({
    emit: (line) => lines.push(line),
    onEvent: (sentence) => events.push(sentence),
    steady_us: () => now_us,
  });
  for (const { time_us, packet, name, fields } of messagesOf(records)) {
    now_us = time_us;
    if (!keep(name)) continue;
    link.take(packet.bytes, '127.0.0.1 5760', true, time_us);
    onStep(link, name, fields);
  }
  return { link, lines, events };
}
