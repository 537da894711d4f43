// Detects changes: by Server-Sent Events if the server offers them, else by polling.

import { Problem, call, paths } from './api.js';

const POLL_MS = 2000;
// A missed event must not leave the page outdated.
const POLL_WITH_EVENTS_MS = 15000;
const RETRY_MS = 5000;
// Events come in bursts: one refresh serves all of them.
const GATHER_MS = 250;

const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

// Calls onEvent(name, data: text) for every event of the stream until it ends.
async function readEvents(response, onEvent) {
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = '';
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    const blocks = (rest + value).replaceAll('\r\n', '\n').split('\n\n');
    rest = blocks.pop();
    for (const block of blocks) {
      const name = /^event: ?(.*)$/m.exec(block);
      const data = /^data: ?(.*)$/m.exec(block);
      if (name || data) onEvent(name?.[1] ?? 'message', data?.[1] ?? '');
    }
  }
}

// Never runs refresh() twice at once. follow(flight) selects the flight of the events. onMap(data) receives the events of
// its map, which change nothing else.
export function createLive(refresh, onTransport, onMap) {
  let flight = null;
  let stop = new AbortController();
  let hasEvents = false;
  let canListen = true;
  let isWanted = false;
  let wake = () => {};

  async function loop() {
    for (;;) {
      isWanted = false;
      await refresh();
      if (!isWanted) {
        const wait = pause(hasEvents ? POLL_WITH_EVENTS_MS : POLL_MS);
        await Promise.race([wait, new Promise((resolve) => { wake = resolve; })]);
      }
      if (hasEvents) await pause(GATHER_MS);
    }
  }

  function now() {
    isWanted = true;
    wake();
  }

  function report(has) {
    hasEvents = has;
    onTransport(has ? 'events' : 'polling');
  }

  async function listen(signal) {
    while (!signal.aborted) {
      try {
        const response = await call(paths.events(flight), { signal, headers: { Accept: 'text/event-stream' } });
        if (!response.headers.get('Content-Type')?.startsWith('text/event-stream')) throw new Problem(501, {});
        report(true);
        await readEvents(response, (name, data) => {
          if (name === 'map') onMap(JSON.parse(data));
          else now();
        });
      } catch (error) {
        // This server has no events: polling continues.
        if ([404, 405, 501].includes(error.status)) canListen = false;
      }
      if (signal.aborted || !canListen) return;
      report(false);
      await pause(RETRY_MS);
    }
  }

  return {
    start() { loop(); },
    now,
    follow(wanted) {
      if (wanted === flight) return;
      flight = wanted;
      stop.abort();
      stop = new AbortController();
      report(false);
      if (flight && canListen) listen(stop.signal);
    },
  };
}
