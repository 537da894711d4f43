// Which requests for map tiles run at once.

// Runs tasks in the order of their arrival, at most numAtOnce at a time. A task whose signal is aborted before its turn
// never starts.
export function createQueue(numAtOnce) {
  const waiting = [];
  let numRunning = 0;

  function next() {
    while (numRunning < numAtOnce && waiting.length > 0) {
      const { task, signal, resolve, reject } = waiting.shift();
      if (signal.aborted) {
        reject(signal.reason);
        continue;
      }
      ++numRunning;
      task().then(resolve, reject).finally(() => {
        --numRunning;
        next();
      });
    }
  }

  // task(): a promise. Returns its result, or rejects with the reason of the signal.
  return (task, signal) => new Promise((resolve, reject) => {
    waiting.push({ task, signal, resolve, reject });
    next();
  });
}

// Whether a TileJSON's URL names another server than the page's own. origin: of the page.
export const isElsewhere = (template, origin) => /^[a-z]+:\/\//i.test(template) && !template.toLowerCase().startsWith(`${origin.toLowerCase()}/`);

// The path of a tile on this server. template: URL of a TileJSON. Its host is left out: a proxy may have changed
// it, and the token goes to no other server.
export const tilePath = (template, { x, y, z }) =>
  template.replace(/^[a-z]+:\/\/[^/]*/i, '').replace('{z}', z).replace('{x}', x).replace('{y}', y);
