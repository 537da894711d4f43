// Transfer of one list of items, the autopilot's side. An upload replaces the list in place.

import { maxItems, missionType, stored } from './items.js';

const result = { accepted: 0, error: 1, noSpace: 4, invalidSequence: 13, denied: 14, cancelled: 15 };
const uploadTimeout_s = 8;
const repeatAfter_s = 1;

export class ItemProtocol {
  #type;
  #send;
  #hooks;
  #upload;
  items = [];

  // send(name, fields): to the peer in fields. hooks: onTruncate(count), onItem(index), onComplete(),
  // onText(text), home(): the item that stands for item 0, or nothing.
  constructor(type, send, hooks = {}) {
    this.#type = type;
    this.#send = send;
    this.#hooks = hooks;
  }

  get isReceiving() { return this.#upload !== undefined; }

  // A restart forgets the transfer; the items are in permanent storage.
  restart() { this.#upload = undefined; }

  step(now_s) {
    const upload = this.#upload;
    if (!upload) return;
    if (now_s - upload.heard_s > uploadTimeout_s) {
      this.#upload = undefined;
      this.#hooks.onText?.('Mission upload timeout');
      this.#acknowledge(upload.peer, result.cancelled);
    } else if (now_s - upload.asked_s > repeatAfter_s) {
      this.#ask(now_s);
    }
  }

  take(name, fields, peer, now_s) {
    this.#handlers[name]?.call(this, fields, peer, now_s);
  }

  #handlers = {
    MISSION_COUNT: this.#onCount,
    MISSION_ITEM_INT: this.#onItem,
    MISSION_REQUEST_LIST: this.#onRequestList,
    MISSION_REQUEST_INT: (fields, peer) => this.#onRequest(fields, peer),
    MISSION_REQUEST: (fields, peer) => this.#onRequest(fields, peer),
    MISSION_CLEAR_ALL: this.#onClear,
  };

  #onCount({ count }, peer, now_s) {
    const other = this.#upload;
    if (other && (other.peer.systemId !== peer.systemId || other.peer.componentId !== peer.componentId)) {
      this.#acknowledge(peer, result.denied);
      return;
    }
    this.#upload = undefined;
    if (count > maxItems(this.#type)) {
      this.#acknowledge(peer, result.noSpace);
      return;
    }
    this.items.length = Math.min(this.items.length, count);
    this.#hooks.onTruncate?.(count);
    if (count === 0) {
      this.#complete(peer);
      return;
    }
    this.#upload = { peer, count, next: 0, heard_s: now_s, asked_s: now_s };
    this.#ask(now_s);
  }

  #onItem(fields, peer, now_s) {
    const upload = this.#upload;
    if (!upload) return;
    if (fields.seq !== upload.next) {
      this.#acknowledge(peer, result.invalidSequence);
      return;
    }
    if (upload.peer.systemId !== peer.systemId || upload.peer.componentId !== peer.componentId) {
      this.#acknowledge(peer, result.denied);
      return;
    }
    const { result: code, item } = stored(this.#type, fields);
    if (code !== result.accepted) {
      this.#upload = undefined;
      this.#acknowledge(peer, code);
      return;
    }
    this.items[fields.seq] = item;
    this.#hooks.onItem?.(fields.seq);
    upload.heard_s = now_s;
    ++upload.next;
    if (upload.next === upload.count) this.#complete(peer);
    else this.#ask(now_s);
  }

  #complete(peer) {
    this.#upload = undefined;
    this.#hooks.onComplete?.();
    this.#acknowledge(peer, result.accepted);
  }

  #onRequestList(_, peer) {
    if (this.#upload) this.#acknowledge(peer, result.denied);
    else this.#send('MISSION_COUNT', this.#to(peer, { count: this.items.length }));
  }

  #onRequest({ seq }, peer) {
    if (this.#upload) {
      this.#acknowledge(peer, result.denied);
      return;
    }
    const item = (seq === 0 && this.#hooks.home?.()) || this.items[seq];
    if (!item) {
      if (this.#type === missionType.mission) {
        this.#send('MISSION_COUNT', this.#to(peer, { count: this.items.length }));
      }
      this.#acknowledge(peer, result.error);
      return;
    }
    this.#send('MISSION_ITEM_INT', this.#to(peer, { seq, ...item, current: 0, autocontinue: 1 }));
  }

  #onClear(_, peer) {
    if (this.#upload) {
      this.#acknowledge(peer, result.error);
      return;
    }
    this.items = [];
    this.#hooks.onTruncate?.(0);
    this.#acknowledge(peer, result.accepted);
  }

  #ask(now_s) {
    const upload = this.#upload;
    upload.asked_s = now_s;
    this.#send('MISSION_REQUEST', this.#to(upload.peer, { seq: upload.next }));
  }

  #acknowledge(peer, code) { this.#send('MISSION_ACK', this.#to(peer, { type: code })); }

  #to(peer, fields) {
    return { targetSystem: peer.systemId, targetComponent: peer.componentId, missionType: this.#type, ...fields };
  }
}
