// Which packets are of our autopilot: one system, its components, one peer.

import { idOf, MavAutopilot, MavComponent, MavType } from './messages.js';

// A peer that is silent for this long may come back from another port of the same host, as a
// simulator or a router does after its restart.
const silence_us = 10e6;

const cameraMessages = new Set(
  [idOf.CAMERA_TRIGGER, idOf.CAMERA_FEEDBACK, idOf.CAMERA_IMAGE_CAPTURED]);

const hostOf = (peer) => peer.split(' ')[0];

export class Pin {
  #heard_us;

  // systemId: nothing means the first autopilot that sends a heartbeat.
  constructor({ systemId, componentId, peerHost } = {}) {
    this.systemId = systemId;
    this.componentId = componentId;
    this.peerHost = peerHost;
    this.peer = undefined;
  }

  // Before a datagram is parsed.
  isPossiblePeer(from, now_us) {
    if (this.peerHost && hostOf(from) !== this.peerHost && from !== 'stream') return false;
    if (this.peer === undefined || this.peer === from) return true;
    return now_us - this.#heard_us > silence_us && hostOf(from) === hostOf(this.peer);
  }

  // Why the packet is refused; nothing if it is of our autopilot. `heartbeat`: its fields, if the
  // packet is one.
  refusal(packet, from, now_us, heartbeat) {
    if (this.systemId !== undefined && packet.systemId !== this.systemId) return 'other_system';
    if (this.componentId !== undefined && packet.componentId !== this.componentId) {
      const isCamera = packet.componentId >= MavComponent.CAMERA &&
        packet.componentId <= MavComponent.CAMERA6 && cameraMessages.has(packet.messageId);
      return isCamera && from === this.peer ? undefined : 'other_component';
    }
    const isPinned = this.peer === from && this.componentId !== undefined;
    if (!isPinned && !this.#pinBy(heartbeat, packet, from)) return 'before_heartbeat';
    this.#heard_us = now_us;
    return undefined;
  }

  // Only an autopilot's heartbeat pins: not one of a ground station, gimbal or camera.
  #pinBy(heartbeat, packet, from) {
    const isAutopilot = heartbeat && heartbeat.autopilot !== MavAutopilot.INVALID &&
      heartbeat.type !== MavType.GCS;
    if (!isAutopilot) return false;
    this.systemId = packet.systemId;
    this.componentId = packet.componentId;
    this.peer = from;
    return true;
  }
}
