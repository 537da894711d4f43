// The lists of items of an autopilot, each with its transfer.

import { ItemProtocol } from './item_protocol.js';
import { missionType, stored } from './items.js';
import { Px4ItemProtocol, storedByPx4 } from './px4.js';

// send(name, fields). hooks: of ArduPlane's mission, as of item_protocol.js. onNewMission(current): of PX4.
export function itemLists(isPx4, send, { onNewMission, ...hooks }) {
  return Object.fromEntries(Object.values(missionType).map((type) => {
    const isMission = type === missionType.mission;
    if (isPx4) return [type, new Px4ItemProtocol(type, send, { onComplete: (current) => isMission && onNewMission(current) })];
    return [type, new ItemProtocol(type, send, isMission ? hooks : {})];
  }));
}

// As the autopilot has it. A mission of missions.js is ArduPlane's.
export function storedItem(isPx4, item) {
  if (!isPx4) return stored(missionType.mission, item).item;
  const hasPlace = item.x !== 0 || item.y !== 0;
  return storedByPx4(hasPlace ? item : { ...item, frame: 2 }).item;
}
