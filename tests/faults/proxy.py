"""A TCP proxy that stalls or resets its connections, and reads what clients tell PostgreSQL."""

import os
import socket
import struct
import threading


class Proxy:
    """On a free port of 127.0.0.1, in front of a Unix socket's path or of a port."""

    def __init__(self, target, on_statement=None):
        self.target = target
        # Called with SQL or 'COMMIT' before it is passed on: (connection's number, statement).
        self.on_statement = on_statement
        self.is_open = threading.Event()
        self.is_open.set()
        self.connections = []
        self.lock = threading.Lock()
        self.listener = socket.create_server(("127.0.0.1", 0), backlog=64)
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        self.is_open.set()
        self.listener.close()
        self.reset()

    def stall(self):
        """Passes nothing on until resume; new connections wait too."""
        self.is_open.clear()

    def resume(self):
        self.is_open.set()

    def reset(self):
        """Ends all connections with a reset."""
        with self.lock:
            connections, self.connections = self.connections, []
        for connection in connections:
            for end in connection:
                try:
                    end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                    # Wakes the thread that reads; the close of both then resets.
                    end.shutdown(socket.SHUT_RD)
                except OSError:
                    pass

    def _connect(self):
        if isinstance(self.target, int):
            return socket.create_connection(("127.0.0.1", self.target))
        end = socket.socket(socket.AF_UNIX)
        end.connect(self.target)
        return end

    def _accept(self):
        number = 0
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            number += 1
            try:
                server = self._connect()
            except OSError:
                client.close()
                continue
            with self.lock:
                self.connections.append((client, server))
            reader = StatementReader(number, self.on_statement) if self.on_statement else None
            threading.Thread(target=self._serve, args=(client, server, reader), daemon=True).start()

    def _serve(self, client, server, reader):
        back = threading.Thread(target=self._pass, args=(server, client, None), daemon=True)
        back.start()
        self._pass(client, server, reader)
        back.join()
        client.close()
        server.close()
        with self.lock:
            if (client, server) in self.connections:
                self.connections.remove((client, server))

    def _pass(self, source, target, reader):
        try:
            while data := source.recv(1 << 16):
                if reader:
                    reader.take(data)
                self.is_open.wait()
                target.sendall(data)
        except OSError:
            pass
        with self.lock:
            is_reset = (source, target) not in self.connections and (target, source) not in self.connections
        for end in (source, target):
            try:
                end.shutdown(socket.SHUT_RD if is_reset else socket.SHUT_RDWR)
            except OSError:
                pass


class StatementReader:
    """The client's side of PostgreSQL's protocol, version 3, without encryption."""

    def __init__(self, number, on_statement):
        self.number = number
        self.on_statement = on_statement
        self.rest = b""
        self.has_started = False
        self.prepared = {}

    def take(self, data):
        self.rest += data
        while True:
            head = 1 if self.has_started else 0
            if len(self.rest) < head + 4:
                return
            length = head + struct.unpack(">I", self.rest[head:head + 4])[0]
            if len(self.rest) < length:
                return
            message, self.rest = self.rest[:length], self.rest[length:]
            if self.has_started:
                self._read(message[:1], message[5:])
            self.has_started = True

    def _read(self, kind, body):
        if kind == b"Q":
            self.on_statement(self.number, body.rstrip(b"\0").decode())
        elif kind == b"P":
            name, sql = body.split(b"\0")[:2]
            self.prepared[name] = sql.decode()
        elif kind == b"B":
            self.on_statement(self.number, self.prepared.get(body.split(b"\0")[1], ""))


def socket_path(folder):
    return os.path.join(folder, ".s.PGSQL.5432")
