"""Alternates of many live flights at once: how old each list is when it is read."""

import json
import random
import threading
import time

import many_sites
from harness import Server, check, percentile
from recalls import store_sites

RATE_HZ = 10
NUM_SITES = 1000
# As many streams as a server takes at the same time.
NUM_SENDERS = 8
READ_PERIOD_S = 0.4
SPEED_DEG_PER_S = 15.0 / 111195


class Aircraft:
    """Flies straight over the stored sites. Each sample has the time at which it is sent."""

    def __init__(self, server, number):
        self.flight = server.new_flight(
            {"name": f"live {number}", "altitude_datum": "amsl", "aircraft": {"profile": "small"}})
        generator = random.Random(number)
        self.latitude = 47.351 + generator.uniform(-0.05, 0.05)
        self.longitude = 8.455 + generator.uniform(-0.05, 0.05)
        self.wind = generator.uniform(-3, 3), generator.uniform(-3, 3)
        self.begin = time.time()

    def line(self):
        now = time.time()
        sample = {"timestamp_us": int(now * 1e6), "position": {
            "latitude_deg": self.latitude + SPEED_DEG_PER_S * (now - self.begin),
            "longitude_deg": self.longitude, "altitude_m": 900}}
        # An autopilot's estimate changes slowly, but in time it needs other plans.
        change = 0.01 * int(now - self.begin)
        sample["wind"] = {"east_mps": self.wind[0] + change, "north_mps": self.wind[1]}
        return json.dumps(sample) + "\n"


class Load:
    """Sends and reads until its end. One connection for several flights: each holds a thread."""

    def __init__(self, server, fleet, seconds):
        self.server, self.fleet = server, fleet
        self.end = time.monotonic() + seconds
        self.begin = time.monotonic()
        self.num_sent, self.ages_s, self.told_ages_s, self.faults = 0, [], [], []
        self.lock = threading.Lock()
        senders = [threading.Thread(target=self._guard, args=(self._send, fleet[i::NUM_SENDERS]))
                   for i in range(min(NUM_SENDERS, len(fleet)))]
        self.threads = senders + [threading.Thread(target=self._guard, args=(self._read, fleet))]

    def run(self):
        for thread in self.threads:
            thread.start()
        for thread in self.threads:
            thread.join()
        check(not self.faults, "; ".join(self.faults[:3]))
        # A busy server takes the poses late.
        return time.monotonic() - self.begin

    def _guard(self, work, fleet):
        try:
            work(fleet, self.server.connect())
        except Exception as error:
            self.faults.append(repr(error))

    def _send(self, fleet, connection):
        due = time.monotonic()
        while due < self.end:
            time.sleep(max(0.0, due - time.monotonic()))
            due += 1 / RATE_HZ
            for aircraft in fleet:
                status, body = self.server.request(
                    "POST", f"/v1/flights/{aircraft.flight}/telemetry", aircraft.line(),
                    connection=connection)
                check(status == 200, f"telemetry: {status} {body[:200]!r}")
                with self.lock:
                    self.num_sent += 1

    def _read(self, fleet, connection):
        # Until the first list of each has come.
        time.sleep(1.0)
        while time.monotonic() < self.end:
            due = time.monotonic() + READ_PERIOD_S
            for aircraft in fleet:
                answer = self.server.get_json(
                    f"/v1/flights/{aircraft.flight}/alternates", connection=connection)
                self.ages_s.append(time.time() - answer["pose"]["timestamp_us"] * 1e-6)
                self.told_ages_s.append(answer["pose"]["age_s"])
                check(answer["sites"], f"nothing in reach: {answer}")
            time.sleep(max(0.0, due - time.monotonic()))


def run(tools, folder, flight_files, num_flights):
    """Age: from sending a pose to reading a list that is computed from it."""
    server = Server(tools, folder / "data")
    store_sites(server, folder)
    many_sites.fill(server.data, NUM_SITES)
    with server:
        fleet = [Aircraft(server, number) for number in range(num_flights)]
        seconds = 30 if num_flights >= 50 else 5
        load = Load(server, fleet, seconds)
        begin = server.processor_s()
        seconds = load.run()
        busy = (server.processor_s() - begin) / seconds
        server.kill(15)
    rate_hz = load.num_sent / num_flights / seconds
    seen = (f"{num_flights} flights at {rate_hz:.1f} Hz, {len(load.ages_s)} lists read: age p50 "
            f"{percentile(load.ages_s, 0.5):.2f} s, p99 {percentile(load.ages_s, 0.99):.2f} s, worst "
            f"{max(load.ages_s):.2f} s (told at most {max(load.told_ages_s):.2f} s); "
            f"{busy:.2f} processors")
    return seen, max(load.ages_s) <= 1.0 and rate_hz >= 0.9 * RATE_HZ
