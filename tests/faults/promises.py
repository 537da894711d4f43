"""Every write on a small disk, killed and damaged after each: what was accepted is there, and nothing else."""

import hashlib
import json
import random
import shutil
import time

from disks import META, SmallDisk, camera_request
from harness import Server, check, multipart
from pictures import noise_png
from recalls import store_sites

DISK_BYTES = 60 << 20
DATABASES = ("freelsd.db", "recall.db")


class Promises:
    """What the server has accepted: ids with what tells their content."""

    def __init__(self, server):
        self.obstacles = {}
        self.sites = sites_of(server)
        self.flights = {flight["id"]: {} for flight in flights_of(server)}
        self.jobs = set()


def sites_of(server):
    return {site["properties"]["id"] for site in server.get_json("/v1/sites")["features"]}


def flights_of(server):
    return server.get_json("/v1/flights")["flights"]


def check_sites(server, promised, what):
    """What has a second copy."""
    obstacles = {feature["id"]: feature["properties"]["name"]
                 for feature in server.get_json("/v1/obstacles")["features"]}
    check(obstacles == promised.obstacles, f"{what}: obstacles {differing(obstacles, promised.obstacles)}")
    sites = sites_of(server)
    check(sites == promised.sites, f"{what}: sites {sites ^ promised.sites}")


def check_all(server, promised, what):
    check_sites(server, promised, what)
    flights = {}
    for flight in flights_of(server):
        flights[flight["id"]] = {frame["id"]: frame["sha256"]
                                 for frame in server.frames(flight["id"])}
    check(flights == promised.flights, f"{what}: flights {differing(flights, promised.flights)}")
    jobs = {job["id"] for job in server.get_json("/v1/jobs")["jobs"]}
    check(promised.jobs <= jobs, f"{what}: jobs lost {promised.jobs - jobs}")


def differing(stored, promised):
    return {key: (str(stored.get(key))[:40], str(promised.get(key))[:40])
            for key in {**stored, **promised} if stored.get(key) != promised.get(key)}


class Writer:
    """One request of each kind; the model changes with the answer."""

    def __init__(self, server, promised, generator):
        self.server = server
        self.promised = promised
        self.generator = generator
        self.number = 0
        self.counts = {"accepted": 0, "refused": 0}

    def write(self, kind):
        self.number += 1
        return getattr(self, kind)()

    def _ask(self, wanted, method, path, body=None, headers=None):
        status, answer = self.server.request(method, path, body, headers or {})
        if status in wanted:
            self.counts["accepted"] += 1
            return answer
        problem = json.loads(answer)
        check(status == 507 and problem["code"] == "StorageFull" and problem["retryable"],
              f"{method} {path}: {status} {answer[:200]!r}")
        self.counts["refused"] += 1
        return None

    def flight(self):
        answer = self._ask((201,), "POST", "/v1/flights", json.dumps(camera_request(160, 120)))
        if answer is not None:
            self.promised.flights[json.loads(answer)["id"]] = {}

    def frame(self):
        if not self.promised.flights:
            return self.flight()
        flight = self.generator.choice(sorted(self.promised.flights))
        image = noise_png(160, 120)
        name = f"i{self.number}"
        body, kind = multipart([("image", "i.png", image), ("meta", None, json.dumps(META))])
        if self._ask((201,), "PUT", f"/v1/flights/{flight}/frames/{name}", body,
                     {"Content-Type": kind}) is not None:
            self.promised.flights[flight][name] = hashlib.sha256(image).hexdigest()
        return None

    def _mast(self, name):
        number = self.generator.randrange(200)
        text = f"mast {self.number} " + "x" * self.generator.choice([0, 60])
        return {"type": "Feature", "id": name,
                "geometry": {"type": "Point", "coordinates": [9.0 + number * 1e-3, 48.0]},
                "properties": {"kind": "mast", "name": text, "height_m": 30}}

    def obstacle(self):
        mast = self._mast(f"m{self.generator.randrange(8)}")
        if self._ask((200, 201), "PUT", f"/v1/obstacles/{mast['id']}", json.dumps(mast),
                     {"Content-Type": "application/json"}) is not None:
            self.promised.obstacles[mast["id"]] = mast["properties"]["name"]

    def obstacles(self):
        masts = [self._mast(f"n{i}") for i in range(200)]
        if self._ask((200,), "POST", "/v1/obstacles",
                     json.dumps({"type": "FeatureCollection", "features": masts}),
                     {"Content-Type": "application/json"}) is not None:
            for mast in masts:
                self.promised.obstacles[mast["id"]] = mast["properties"]["name"]

    def delete_obstacle(self):
        if not self.promised.obstacles:
            return self.obstacle()
        name = self.generator.choice(sorted(self.promised.obstacles))
        if self._ask((204,), "DELETE", f"/v1/obstacles/{name}") is not None:
            del self.promised.obstacles[name]
        return None

    def delete_site(self):
        if not self.promised.sites:
            return self.obstacle()
        name = self.generator.choice(sorted(self.promised.sites))
        if self._ask((204,), "DELETE", f"/v1/sites/{name}") is not None:
            self.promised.sites.discard(name)
        return None

    def delete_flight(self):
        if len(self.promised.flights) < 2:
            return self.flight()
        flight = self.generator.choice(sorted(self.promised.flights))
        if self._ask((204,), "DELETE", f"/v1/flights/{flight}") is not None:
            del self.promised.flights[flight]
            # Its jobs go with it.
            self.promised.jobs.clear()
        return None

    def finish(self):
        if not self.promised.flights:
            return self.flight()
        flight = self.generator.choice(sorted(self.promised.flights))
        answer = self._ask((202,), "POST", f"/v1/flights/{flight}/finish")
        if answer is not None:
            self.promised.jobs.add(json.loads(answer)["id"])
        return None


# Those of sites, which are few, come seldom.
KINDS = ["obstacle", "frame", "obstacles", "delete_obstacle", "finish", "flight", "obstacle",
         "delete_flight", "frame", "delete_obstacle", "obstacles", "delete_site"]


def damage(data, name, generator):
    """Nothing of the database is left, or its head is not."""
    file = data / name
    size = file.stat().st_size
    with open(file, "r+b") as stream:
        stream.write(generator.randbytes(size if generator.random() < 0.5 else min(size, 4096)))
    for suffix in ("-wal", "-shm"):
        (data / (name + suffix)).unlink(missing_ok=True)


def check_damaged(tools, server, folder, promised, name, generator):
    """On a copy of the folder, on another disk: the small one has no room to restore anything."""
    data = folder / "damaged"
    shutil.rmtree(data, ignore_errors=True)
    shutil.copytree(server.data, data, ignore=shutil.ignore_patterns("images", "damaged-*"))
    damage(data, name, generator)
    with Server(tools, data) as damaged:
        check_sites(damaged, promised, f"after damage of {name}")
        notices = [notice["text"] for notice in damaged.get_json("/v1/notices")["notices"]]
        told = "restored from the second copy" if name == DATABASES[0] else "made anew"
        check(any(told in notice for notice in notices), f"notices after damage of {name}: {notices}")


def run(tools, folder, flight_files, num_writes):
    generator = random.Random(5)
    with SmallDisk(folder / "disk", DISK_BYTES) as disk:
        server = Server(tools, folder / "disk" / "data")
        store_sites(server, folder)
        server.start()
        promised = Promises(server)
        writer = Writer(server, promised, generator)
        for number in range(num_writes):
            kind = KINDS[number % len(KINDS)]
            what = f"write {number} ({kind})"
            # Most have hardly enough room.
            disk.fill(generator.choice([0, 16, 48, 64, 80, 96, 128, 192, 512, 4096]) << 10)
            writer.write(kind)
            server.kill()
            server.start()
            check_all(server, promised, what)
            disk.make_room()
            server.kill()
            check_damaged(tools, server, folder, promised, DATABASES[number % 2], generator)
            server.start()
        server.kill()
    counts = writer.counts
    return (f"{counts['accepted']} accepted, {counts['refused']} refused with 507; after each a kill "
            "and the damage of a database: none of the first was lost, none of the second was there"
            ), counts["accepted"] > 0 and counts["refused"] > 0


def await_state(server, job, is_wanted, what, timeout_s=120):
    end = time.monotonic() + timeout_s
    while time.monotonic() < end:
        view = server.get_json(f"/v1/jobs/{job}")
        if is_wanted(view):
            return view
        time.sleep(0.2)
    check(False, f"{what}: {view}")


def is_held(view):
    return view["state"] == "queued" and "disk is full" in view["detail"].get("message", "")


def run_finishes(tools, folder, flight_files, num_finishes):
    generator = random.Random(6)
    num_held = 0
    for number in range(num_finishes):
        with SmallDisk(folder / "disk", DISK_BYTES) as disk:
            server = Server(tools, folder / "disk" / "data")
            store_sites(server, folder)
            server.start()
            promised = Promises(server)
            flight = server.new_flight(flight_files.request)
            body, kind = multipart(
                [("images", name, image)
                 for name, image in zip(flight_files.names, flight_files.images)] +
                [("poses", "poses.csv", flight_files.poses_csv)])
            status, answer = server.request(
                "POST", f"/v1/flights/{flight}/batch", body, {"Content-Type": kind})
            check(status == 202, f"batch: {status} {answer[:200]!r}")
            server.await_job(json.loads(answer)["id"])
            status, answer = server.request("POST", f"/v1/flights/{flight}/finish")
            check(status == 202, f"finish: {status} {answer[:200]!r}")
            job = json.loads(answer)["id"]
            disk.fill(generator.choice([0, 64, 256, 1024]) << 10)
            view = await_state(server, job, lambda v: is_held(v) or v["state"] == "done",
                               "it neither stops nor ends")
            num_held += view["state"] == "queued"
            # It does not begin again and again.
            busy_s = server.processor_s()
            time.sleep(5)
            if view["state"] == "queued":
                check(server.processor_s() - busy_s < 2.5, "a finish that is held works on")
                check(view["time_left_s"] is None, f"a time is told: {view}")
            server.kill()
            server.start()
            await_state(server, job, lambda v: is_held(v) or v["state"] == "done",
                        "after a kill it neither stops nor ends")
            disk.make_room()
            view = await_state(server, job, lambda v: v["state"] == "done", "it does not go on", 300)
            promised.sites = sites_of(server)
            server.kill()
            check_damaged(tools, server, folder, promised, DATABASES[number % 2], generator)
    return (f"{num_held} of {num_finishes} stopped with the reason and went on, no site was lost",
            num_held > 0)
