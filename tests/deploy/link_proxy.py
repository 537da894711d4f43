#!/usr/bin/env python3
"""A link between two servers that can be cut, stall and reset.

    link_proxy.py PORT_FILE MODE_FILE TARGET_PORT

Listens on a free port, which it writes to PORT_FILE, and passes bytes on to TARGET_PORT as MODE_FILE says, which is read
before each piece: `pass`; `cut` (nothing is accepted, what is open is closed); `flaky` (half of the connections are
reset after some 20 KB, one in eight pieces stalls for a second).
"""
import os
import random
import socket
import struct
import sys
import threading
import time

port_file, mode_file, target_port = sys.argv[1], sys.argv[2], int(sys.argv[3])
random.seed(7)


def mode():
    try:
        with open(mode_file) as file:
            return file.read().strip()
    except OSError:
        return "cut"


def reset(connection):
    try:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        connection.close()
    except OSError:
        pass


def carry(source, sink, both, budget):
    try:
        while True:
            source.settimeout(0.2)
            try:
                piece = source.recv(4096)
            except socket.timeout:
                if mode() == "cut":
                    break
                continue
            if not piece or mode() == "cut":
                break
            if mode() == "flaky":
                budget[0] -= len(piece)
                if budget[0] < 0:
                    break
                if random.random() < 0.125:
                    time.sleep(1.0)
            sink.sendall(piece)
    except OSError:
        pass
    for connection in both:
        try:
            connection.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        reset(connection)


def serve(client):
    if mode() == "cut":
        return reset(client)
    try:
        server = socket.create_connection(("127.0.0.1", target_port), timeout=2)
    except OSError:
        return reset(client)
    both = (client, server)
    budget = [random.randrange(2000, 40000) if random.random() < 0.5 else 1 << 40]
    for pair in (both, both[::-1]):
        threading.Thread(target=carry, args=(*pair, both, budget), daemon=True).start()


listener = socket.create_server(("127.0.0.1", 0))
with open(port_file + ".new", "w") as file:
    file.write(str(listener.getsockname()[1]))
os.rename(port_file + ".new", port_file)
while True:
    connection, _ = listener.accept()
    threading.Thread(target=serve, args=(connection,), daemon=True).start()
