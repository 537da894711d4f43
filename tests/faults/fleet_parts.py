"""The parts of a fleet that are harmed, and a flight on its way through them."""

import collections
import csv
import hashlib
import http.client
import json
import os
import random
import re
import shlex
import subprocess
import time
import urllib.parse

from harness import Fault, Server, check, multipart
from proxy import Proxy, socket_path

NUM_FRAMES = 12


class Fleet:
    """Two API servers and two workers on the test's cluster; proxies between any two."""

    def __init__(self, tools, folder):
        self.tools, self.folder = tools, folder
        self.database = os.environ["FREELSD_TEST_DATABASE"]
        self.cluster = shlex.split(os.environ["FREELSD_TEST_CLUSTER"])
        self.psql = os.path.join(os.path.dirname(next(word for word in self.cluster if word.endswith("/pg_ctl"))), "psql")
        query = urllib.parse.urlsplit(self.database).query
        self.socket = socket_path(urllib.parse.parse_qs(query)["host"][0])
        self.statement_calls = {}
        self.tokens = {}
        self.num_ended = 0
        self.evaluation_s = 1.0
        self.proxies, self.servers, self.to_api = {}, {}, {}
        for name in ("api-1", "api-2", "worker-1", "worker-2"):
            self.proxies[name] = Proxy(
                self.socket, lambda number, sql, name=name: self._tell(name, number, sql))
            self.start(name)

    def _tell(self, name, number, sql):
        call = self.statement_calls.get(name)
        if call:
            call(number, sql)

    def start(self, name):
        url = (f"postgresql://freelsd@127.0.0.1:{self.proxies[name].port}/postgres"
               "?sslmode=disable&gssencmode=disable")
        if name not in self.servers:
            self.servers[name] = Server(self.tools, self.folder / name, config={
                "database": url, "images": str(self.folder / "images"), "role": name.split("-")[0]})
        server = self.servers[name].start()
        if name.startswith("api"):
            self.to_api[name] = Proxy(server.port)
        else:
            self.tokens[name] = int(self.ask("SELECT max(token) FROM workers"))

    def kill(self, name):
        if name in self.to_api:
            self.to_api.pop(name).close()
        self.servers[name].kill()

    def restart_ended(self):
        """As a supervisor does: a server that lost its lease ends by itself."""
        for name, server in self.servers.items():
            if not server.is_alive():
                self.num_ended += 1
                self.kill(name)
                self.start(name)

    def heal(self):
        """All parts as at the start of a run."""
        self.statement_calls.clear()
        for proxy in [*self.proxies.values(), *self.to_api.values()]:
            proxy.resume()
        self.restart_ended()

    def ask(self, sql):
        return subprocess.run([self.psql, "-qAtX", self.database, "-c", sql], capture_output=True, text=True,
                              check=True, timeout=60).stdout.strip()

    def request(self, method, path, body=None, headers=None, *, patience_s=60):
        """As a client behind nginx: to the other server if one fails, and again; never after 2xx or 4xx."""
        end = time.monotonic() + patience_s
        reason = ""
        while time.monotonic() < end:
            for name in ("api-1", "api-2"):
                try:
                    connection = http.client.HTTPConnection("127.0.0.1", self.to_api[name].port, timeout=10)
                    connection.request(method, path, body, headers or {})
                    answer = connection.getresponse()
                    text = answer.read()
                    connection.close()
                except (OSError, http.client.HTTPException, KeyError) as error:
                    reason = repr(error)
                    continue
                if answer.status < 500 and answer.status != 429:
                    return answer.status, text
                reason = f"{answer.status} {text[:200]!r}"
            time.sleep(0.1)
        raise Fault(f"{method} {path}: no answer in {patience_s} s, {reason}")

    def get_json(self, path):
        status, text = self.request("GET", path)
        check(status == 200, f"GET {path}: {status} {text[:200]!r}")
        return json.loads(text)

    def token_of(self, flight):
        """Of the worker that has the flight; None if there is none."""
        token = self.ask(f"SELECT token FROM claims WHERE flight_id = '{flight}' AND token IS NOT NULL")
        return int(token) if token else None

    def name_of(self, token):
        return next((name for name, own in self.tokens.items() if own == token), None)


class Run:
    """One flight through the fleet; a fault happens meanwhile."""

    def __init__(self, fleet, files, seed):
        self.fleet, self.files = fleet, files
        winds = csv.DictReader(files.poses_csv.splitlines())
        self.metas = [{**meta, "wind": {key: float(wind["wind_" + key]) for key in ("east_mps", "north_mps")}}
                      for meta, wind in zip(files.metas, winds)]
        self.random = random.Random(seed)
        self.acknowledged = {}
        self.claim_s = None
        # The fault came too late to be one.
        self.is_void = False

    def create(self):
        status, text = self.fleet.request(
            "POST", "/v1/flights", json.dumps(self.files.request))
        check(status == 201, f"POST /v1/flights: {status} {text[:300]!r}")
        self.flight = json.loads(text)["id"]

    def put_all(self, between=lambda number: None):
        for number, name in enumerate(self.files.names[:NUM_FRAMES]):
            between(number)
            body, headers = self.frame_body(number)
            status, text = self.fleet.request("PUT", f"/v1/flights/{self.flight}/frames/{name}", body, headers)
            check(status in (200, 201), f"PUT: {status} {text[:200]!r}")
            self.acknowledge(number)

    def frame_body(self, number):
        body, kind = multipart([("image", "i.jpg", self.files.images[number]),
                                ("meta", None, json.dumps(self.metas[number]))])
        return body, {"Content-Type": kind}

    def acknowledge(self, number):
        self.acknowledged[self.files.names[number]] = hashlib.sha256(self.files.images[number]).hexdigest()

    def finish(self):
        status, text = self.fleet.request("POST", f"/v1/flights/{self.flight}/finish")
        check(status in (200, 202), f"finish: {status} {text[:200]!r}")
        self.job = json.loads(text)["id"]

    def await_end(self, patience_s=240):
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            state = self.fleet.get_json(f"/v1/jobs/{self.job}")
            if state["state"] not in ("queued", "running"):
                check(state["state"] == "done", f"the job: {state}")
                return
            self.fleet.restart_ended()
            time.sleep(0.2)
        raise Fault("the job does not end")

    def await_that(self, what, condition, patience_s=60):
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            value = condition()
            if value:
                return value
            time.sleep(0.02)
        raise Fault(f"{what}: not within {patience_s} s")

    def take_owner(self):
        """The name of the worker that has the flight, whose loss is then waited for."""
        self.token = self.fleet.token_of(self.flight)
        return self.fleet.name_of(self.token)

    def is_done(self):
        return self.fleet.get_json(f"/v1/jobs/{self.job}")["state"] == "done"

    def await_takeover(self, since, is_enough=lambda: False):
        """Another worker has the flight: True. What was to be waited for came first: False."""
        def is_over():
            token = self.fleet.token_of(self.flight)
            if token and token != self.token:
                return "taken"
            return is_enough() and "done"
        is_taken = self.await_that("another worker", is_over) == "taken"
        if is_taken:
            self.claim_s = time.monotonic() - since
        return is_taken

    def sites(self):
        text = json.dumps(self.fleet.get_json(f"/v1/flights/{self.flight}/sites"), sort_keys=True)
        text = text.replace(self.flight, "FLIGHT")
        return re.sub(r'"(age_s|updated_at|created_at|mean_ms)": [^,}]+', "", text)

    def compare(self, undisturbed, counts):
        frames = self.fleet.get_json(f"/v1/flights/{self.flight}/frames")["frames"]
        ids = collections.Counter(frame["id"] for frame in frames)
        stored = {frame["id"]: frame["sha256"] for frame in frames}
        counts["acknowledged"] += len(self.acknowledged)
        counts["lost"] += sum(stored.get(name) != sha256 for name, sha256 in self.acknowledged.items())
        counts["twice"] += sum(count - 1 for count in ids.values())
        counts["other sites"] += self.sites() != undisturbed
        counts["unprocessed"] += sum(frame["state"] == "queued" for frame in frames)

    def clear(self):
        self.fleet.request("DELETE", f"/v1/flights/{self.flight}?forget_sites=true")
