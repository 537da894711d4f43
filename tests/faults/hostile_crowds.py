"""Crowds of one kind each that try to shut the server's doors: 40 wide reach calls, 1200 reports that
nobody reads, 40 checks of routes with 60 points, 1100 connections that pipeline and read slowly.

Each is measured against its own baseline, in turns. The crowd is another process, so that what it
does takes no time of the measuring one: python3 hostile_crowds.py KIND PORT EMERGENCY_PORT FLIGHT."""

import json
import random
import resource
import socket
import statistics
import subprocess
import sys
import threading
import time

import harness
from harness import Server, check, percentile
from recalls import RECALL, store_flight, timed

# Neither wind nor heading, and an arrival so high that each line takes many steps.
WIDE = "/v1/reach?latitude_deg=47.351&longitude_deg=8.455&altitude_m=1500&altitude_datum=amsl" \
    "&arrival_height_m=400"
PERIOD_S = 0.02
# Of the crowd's process: what its clients do meanwhile is only what the kernel holds for them.
TURN_S = 0.25
# Clients that come in one turn.
MAX_NUM_NEW = 150
MAX_P99_MS, MAX_RATIO, MAX_HEALTH_P99_MS, MAX_REST_S = 30, 1.5, 100, 3


def route():
    """Twenty minutes in 24 winds: as much as one request may ask for."""
    points = [{"latitude_deg": 47.345 + 0.0025 * (number % 2), "longitude_deg": 8.45 + 1e-4 * number,
               "altitude_m": 800} for number in range(60)]
    winds = [{"east_mps": 0.2 * number, "north_mps": 0.1 * number, "weight": 1}
             for number in range(24)]
    return json.dumps({"route": points, "airspeed_mps": 15, "altitude_datum": "amsl",
                       "aircraft": "techpod", "winds": winds}).encode()


def request(method, path, body=b""):
    length = f"Content-Length: {len(body)}\r\n" if body else ""
    return f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n{length}\r\n".encode() + body


class Crowd:
    """That many clients, each of which sends the same. One that comes back does so without reading,
    once it is answered or closed. The others read a few bytes in each turn, and come back when they
    are closed."""

    def __init__(self, port, num_clients, sent, comes_back):
        self.port, self.sent, self.comes_back = port, sent, comes_back
        self.clients = [None] * num_clients

    def take_turn(self):
        num_left = MAX_NUM_NEW
        for number, client in enumerate(self.clients):
            if num_left == 0:
                return
            if client is None or self._is_over(client):
                self.clients[number] = self._new()
                num_left -= 1

    def _is_over(self, client):
        try:
            if self.comes_back:
                client.recv(1, socket.MSG_PEEK)
                is_over = True
            else:
                is_over = not client.recv(512)
        except BlockingIOError:
            return False
        except OSError:
            is_over = True
        if is_over:
            client.close()
        return is_over

    def _new(self):
        client = socket.socket()
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        try:
            client.settimeout(1)
            client.connect(("127.0.0.1", self.port))
            client.setblocking(False)
            client.send(self.sent)
        except OSError:
            client.close()
            return None
        return client


def crowd_of(kind, port, emergency_port, flight):
    if kind == "reach":
        return Crowd(port, 40, request("GET", WIDE), True)
    if kind == "reports":
        return Crowd(port, 1200, request("GET", f"/v1/flights/{flight}?f=html"), True)
    if kind == "routes":
        return Crowd(port, 40, request("POST", "/v1/routes/check", route()), True)
    return Crowd(emergency_port, 1100, request("GET", RECALL) * 100, False)


def press(kind, port, emergency_port, flight):
    resource.setrlimit(resource.RLIMIT_NOFILE, (4096, 4096))
    crowd = crowd_of(kind, int(port), int(emergency_port), flight)
    while True:
        crowd.take_turn()
        time.sleep(TURN_S)


# --- Measuring ---

def recall_paths():
    generator = random.Random(3)
    while True:
        yield RECALL.replace("47.351", f"{47.351 + generator.uniform(-1e-3, 1e-3):.6f}")


def health_paths():
    while True:
        yield "/healthz"


class Prober(threading.Thread):
    """Asks again and again, each time over a connection of its own."""

    def __init__(self, server, paths, emergency, seconds):
        super().__init__()
        self.server, self.paths, self.emergency = server, paths, emergency
        self.end = time.monotonic() + seconds
        self.times_ms, self.num_failed = [], 0

    def run(self):
        while time.monotonic() < self.end:
            begin = time.monotonic()
            connection = self.server.connect(emergency=self.emergency, timeout_s=60)
            try:
                connection.connect()
                timed(self.server, connection, next(self.paths))
                self.times_ms.append((time.monotonic() - begin) * 1e3)
            except (OSError, harness.Fault):
                self.num_failed += 1
            connection.close()
            time.sleep(max(0.0, PERIOD_S - (time.monotonic() - begin)))


def probe(server, seconds):
    """Times of recall and of the main listener's /healthz, at the same time; and what failed."""
    probers = [Prober(server, recall_paths(), True, seconds),
               Prober(server, health_paths(), False, seconds)]
    for prober in probers:
        prober.start()
    for prober in probers:
        prober.join()
        check(prober.times_ms, f"none of {prober.num_failed} requests was answered")
    recall, health = probers
    return recall.times_ms, health.times_ms, recall.num_failed + health.num_failed


class Pressed:
    """The crowd's process, while the block lasts."""

    def __init__(self, kind, server, flight):
        self.arguments = [sys.executable, __file__, kind, str(server.port),
                          str(server.emergency_port), flight]

    def __enter__(self):
        self.process = subprocess.Popen(self.arguments)
        # Until all of them are there.
        time.sleep(2)

    def __exit__(self, *_):
        check(self.process.poll() is None, "the crowd went away by itself")
        self.process.kill()
        self.process.wait()


def is_quick(kind, recall_p99_ms, ratio, health_p99_ms):
    is_good = recall_p99_ms <= MAX_P99_MS and ratio <= MAX_RATIO
    return is_good and (kind != "reach" or health_p99_ms <= MAX_HEALTH_P99_MS)


def run(kind, tools, folder, num_rounds):
    is_short = harness.patience > 1
    seconds = 1 if is_short else 8
    server = Server(tools, folder / "data")
    store_flight(server, folder)
    rounds, num_failed = [], 0
    with server:
        flight = server.get_json("/v1/flights")["flights"][0]["id"]
        # Plans once.
        probe(server, 1)
        for _ in range(num_rounds):
            calm_ms, _, _ = probe(server, seconds)
            with Pressed(kind, server, flight):
                recall_ms, health_ms, failed = probe(server, seconds)
            num_failed += failed
            begin = time.monotonic()
            server.await_idle()
            p99s = [percentile(times, 0.99) for times in (calm_ms, recall_ms, health_ms)]
            rounds.append((p99s[0], p99s[1], p99s[1] / p99s[0], p99s[2], time.monotonic() - begin))
        check(server.is_alive(), "the server ended")
    calm, recall, ratio, health, _ = (statistics.median(each) for each in zip(*rounds))
    rest_s = max(each[4] for each in rounds)
    seen = (f"recall p99 {recall:.1f} ms, alone {calm:.1f} ms ({ratio:.2f} times), main /healthz "
            f"p99 {health:.1f} ms, {num_failed} failed, at rest {rest_s:.1f} s after they left; medians of {num_rounds} rounds in turns "
            f"(times {', '.join(f'{each[2]:.2f}' for each in rounds)})")
    # What nobody waits for any more must not go on.
    is_good = num_failed == 0 and rest_s <= MAX_REST_S * harness.patience
    return seen, is_good and (is_short or is_quick(kind, recall, ratio, health))


def runner(kind):
    return lambda tools, folder, flight_files, num_rounds: run(kind, tools, folder, num_rounds)


if __name__ == "__main__":
    press(*sys.argv[1:])
