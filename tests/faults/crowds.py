"""Emergency recall beside a crowd of clients that harm together: slow, idle, greedy and busy ones."""

import json
import random
import socket
import threading
import time

from harness import Server, check, percentile
from recalls import RECALL, ask_for_roses, post_large_batch, store_sites, timed

NUM_SLOW = 100
NUM_READERS = 30
HEAD = b"POST /v1/emergency HTTP/1.1\r\nHost: localhost\r\n"


def connect(port):
    connection = socket.create_connection(("127.0.0.1", port), timeout=5)
    connection.setblocking(False)
    return connection


class SlowClients:
    """Keeps that many connections open; each sends its next byte once in a while, and comes back
    when the server closes it."""

    def __init__(self, port, begin, more):
        self.port, self.begin, self.more = port, begin, more
        self.connections = [None] * NUM_SLOW
        self.num_closed = 0

    def take_turn(self):
        for number, connection in enumerate(self.connections):
            if connection is None:
                self.connections[number] = connection = self._new()
                continue
            try:
                # An answer, or the end: the server has had enough.
                connection.recv(4096)
                self.num_closed += 1
                connection.close()
                self.connections[number] = None
            except BlockingIOError:
                if self.more:
                    self._send(connection, self.more)
            except OSError:
                self.connections[number] = None

    def _new(self):
        try:
            connection = connect(self.port)
        except OSError:
            return None
        self._send(connection, self.begin)
        return connection

    def _send(self, connection, data):
        try:
            if data:
                connection.send(data)
        except OSError:
            pass

    def close(self):
        for connection in self.connections:
            if connection is not None:
                connection.close()


def crowd_of(port):
    """100 slow bodies, 100 slow heads, 100 that send nothing."""
    body = HEAD + b"Content-Type: application/json\r\nContent-Length: 1000\r\n\r\n"
    return [SlowClients(port, body, b" "), SlowClients(port, HEAD, b"X"),
            SlowClients(port, b"", b"")]


def press(crowd, is_over):
    while not is_over.is_set():
        for clients in crowd:
            clients.take_turn()
        is_over.wait(0.25)


def recall_times_ms(server, seconds):
    """Each request over a connection of its own, as in an emergency, at about 20 a second."""
    generator = random.Random(3)
    times_ms, num_failed = [], 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        path = RECALL.replace("47.351", f"{47.351 + generator.uniform(-1e-3, 1e-3):.6f}")
        connection = server.connect(emergency=True, timeout_s=60)
        try:
            times_ms.append(timed(server, connection, path))
        except OSError:
            num_failed += 1
        connection.close()
        time.sleep(0.05)
    return times_ms, num_failed


def run(tools, folder, flight_files, seconds):
    server = Server(tools, folder / "data")
    store_sites(server, folder)
    is_over, statuses = threading.Event(), []
    with server:
        calm_ms, _ = recall_times_ms(server, 3)
        sites = [site["id"] for site in server.get_json("/v1/sites")["features"]]
        crowd = crowd_of(server.emergency_port)
        threads = [threading.Thread(target=press, args=(crowd, is_over))]
        threads += [threading.Thread(target=ask_for_roses, args=(
            server, f"/v1/sites/{sites[number % len(sites)]}/wind-rose?directions=36"
            "&speeds_mps=1,2,3,4,5", is_over, statuses)) for number in range(NUM_READERS)]
        for thread in threads:
            thread.start()
        try:
            job = post_large_batch(server, tools, folder)
            times_ms, num_failed = recall_times_ms(server, seconds)
            status, answer = server.get(f"/v1/jobs/{job}")
            state = json.loads(answer)["state"] if status == 200 else status
        finally:
            is_over.set()
            for thread in threads:
                thread.join()
            num_closed = [clients.num_closed for clients in crowd]
            for clients in crowd:
                clients.close()
        check(server.is_alive(), "the server ended")
        check(times_ms, f"none of {num_failed} recalls was answered")
    p50, p99 = percentile(times_ms, 0.5), percentile(times_ms, 0.99)
    seen = (f"{len(times_ms)} recalls in {seconds} s, {num_failed} failed: p50 {p50:.1f} ms, p99 "
            f"{p99:.1f} ms, longest {max(times_ms):.0f} ms (alone p99 "
            f"{percentile(calm_ms, 0.99):.1f} ms); closed meanwhile: {num_closed[0]} slow bodies, "
            f"{num_closed[1]} slow heads, {num_closed[2]} idle; {len(statuses)} roses; job {state}")
    return seen, num_failed == 0 and p99 <= 20
