// UDP, TCP and serial behind one interface: open(address, onBytes) -> { send, close }.
// onBytes(bytes, from, isDatagram); `from` names the peer and is what send() takes.

import dgram from 'node:dgram';
import net from 'node:net';

const retryAfter_ms = 1000;
const receiveBufferBytes = 4 * 1024 * 1024;
const defaultBaud = 57600;

// "udp:14550" listens on loopback only; "udp:0.0.0.0:14550" on every address.
export function parseAddress(text) {
  const [kind, ...rest] = text.split(':');
  const number = Number(rest.at(-1));
  const isPort = Number.isInteger(number) && number > 0 && number < 65536;
  if (kind === 'udp' && rest.length <= 2 && isPort) {
    return { kind, host: rest.length === 2 ? rest[0] : '127.0.0.1', port: number };
  }
  if (kind === 'tcp' && rest.length === 2 && isPort) return { kind, host: rest[0], port: number };
  if (kind === 'serial' && rest[0]?.startsWith('/')) {
    const baud = rest.length > 1 ? number : defaultBaud;
    if (rest.length <= 2 && Number.isInteger(baud) && baud > 0) return { kind, path: rest[0], baud };
  }
  throw new Error(`--connect ${text}: expected udp:PORT, udp:ADDRESS:PORT, tcp:HOST:PORT or serial:/dev/NAME:BAUD`);
}

function openUdp({ host, port }, onBytes, onState) {
  return new Promise((resolve, reject) => {
    const type = net.isIPv6(host) ? 'udp6' : 'udp4';
    const socket = dgram.createSocket({ type });
    socket.once('error', reject);
    socket.on('message', (bytes, from) => onBytes(bytes, `${from.address} ${from.port}`, true));
    socket.bind(port, host, () => {
      socket.off('error', reject);
      socket.on('error', (error) => onState(error.message));
      // The system may allow less.
      try { socket.setRecvBufferSize(receiveBufferBytes); } catch { /* its default is used */ }
      onState('open');
      resolve({
        send: (bytes, to) => {
          const [address, toPort] = to.split(' ');
          socket.send(bytes, Number(toPort), address);
        },
        close: () => socket.close(),
      });
    });
  });
}

// Opens again and again: the autopilot may start later, or go away and come back.
function keepOpen(openOnce, onBytes, onState) {
  let stream;
  let timer;
  let isClosed = false;
  const open = () => {
    let hasEnded = false;
    const end = (reason) => {
      if (hasEnded) return;
      hasEnded = true;
      stream = undefined;
      onState(reason);
      if (!isClosed) timer = setTimeout(open, retryAfter_ms);
    };
    const opened = openOnce(() => { stream = opened; onState('open'); });
    opened.on('data', (bytes) => onBytes(bytes, 'stream', false));
    opened.on('error', (error) => { end(error.message); opened.destroy?.(); });
    opened.on('close', () => end('closed'));
  };
  open();
  return {
    send: (bytes) => stream?.write(bytes),
    close: () => {
      isClosed = true;
      clearTimeout(timer);
      stream?.destroy?.();
    },
  };
}

function openTcp({ host, port }, onBytes, onState) {
  return keepOpen((onOpen) => {
    const socket = net.connect({ host, port, noDelay: true });
    socket.once('connect', onOpen);
    return socket;
  }, onBytes, onState);
}

async function openSerial({ path, baud }, onBytes, onState) {
  // Only where it is used: the package has native code for each processor.
  const { SerialPort } = await import('serialport');
  return keepOpen((onOpen) => {
    const port = new SerialPort({ path, baudRate: baud });
    port.once('open', onOpen);
    return port;
  }, onBytes, onState);
}

const openers = { udp: openUdp, tcp: openTcp, serial: openSerial };

export const open = async (address, onBytes, onState = () => {}) =>
  openers[address.kind](address, onBytes, onState);
