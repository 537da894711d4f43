// A proxy in front of a real server. It simulates a token, events and emergency answers.

import http from 'node:http';

// Closes after the test t. emergency: the answer of /v1/emergency, or null for 404.
export async function startStandIn(t, target, { token = null, hasEvents = false, emergency = null, sitesAfter_ms = 0 } = {}) {
  const state = { streams: new Set(), asked: [] };
  const to = new URL(target);

  function play(request, response) {
    const path = request.url.split('?')[0];
    if (token && path.startsWith('/v1/') && request.headers.authorization !== `Bearer ${token}`) {
      response.writeHead(401, { 'Content-Type': 'application/problem+json', 'WWW-Authenticate': 'Bearer' });
      response.end(JSON.stringify({ type: 'about:blank', title: 'Unauthorized', status: 401, code: 'Unauthorized',
        detail: 'a token is needed', errors: [], retryable: false }));
      return true;
    }
    if (path === '/v1/events' && hasEvents) {
      response.writeHead(200, { 'Content-Type': 'text/event-stream' });
      response.write(': hello\n\n');
      state.streams.add(response);
      response.on('close', () => state.streams.delete(response));
      return true;
    }
    if (path === '/v1/events') {
      response.writeHead(404, { 'Content-Type': 'application/problem+json' });
      response.end(JSON.stringify({ title: 'Not Found', status: 404, code: 'NotFound', detail: 'no events here' }));
      return true;
    }
    if (path === '/v1/emergency') {
      state.asked.push(new URL(request.url, target).searchParams);
      response.writeHead(emergency ? 200 : 404, { 'Content-Type': emergency ? 'application/json' : 'application/problem+json' });
      response.end(JSON.stringify(emergency ?? { title: 'Not Found', status: 404, code: 'NotFound', detail: 'nothing here' }));
      return true;
    }
    return false;
  }

  const server = http.createServer(async (request, response) => {
    state.asked.push(request.url);
    if (play(request, response)) return;
    if (/^\/v1\/sites(\?|$)/.test(request.url)) await new Promise((resolve) => { setTimeout(resolve, sitesAfter_ms); });
    const headers = { ...request.headers, host: to.host };
    delete headers.origin;
    delete headers.authorization;
    const asked = http.request({ host: to.hostname, port: to.port, path: request.url, method: request.method, headers },
      (answer) => {
        response.writeHead(answer.statusCode, answer.headers);
        answer.pipe(response);
      }).on('error', () => response.destroy());
    response.on('close', () => asked.destroy());
    request.pipe(asked);
  });
  await new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); });
  t.after(() => {
    server.close();
    server.closeAllConnections();
  });
  return {
    url: `http://127.0.0.1:${server.address().port}`,
    asked: state.asked,
    emit(event, data) {
      for (const stream of state.streams) stream.write(`event: ${event}\ndata: ${JSON.stringify(data)}\n\n`);
    },
  };
}
