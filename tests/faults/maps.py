"""SIGKILL while an evaluation stores its map: afterwards the old map is there, or the new one."""

import hashlib
import json
import random
import time

from harness import Server, check, multipart
from pictures import unlike

LAYERS = ("elevation", "hazard", "photo")


def state_of(server, flight):
    """All bytes of the map in files, and its sites without their times; None without a map."""
    status, body = server.get(f"/v1/flights/{flight}/map")
    if status == 404:
        return None
    check(status == 200, f"map: {status} {body[:200]!r}")
    digest = hashlib.sha256()
    for layer in LAYERS:
        status, body = server.get(f"/v1/flights/{flight}/map/{layer}.tif")
        check(status == 200, f"{layer}.tif: {status} {body[:200]!r}")
        digest.update(body)
    sites = []
    for site in server.get_json(f"/v1/flights/{flight}/sites")["features"]:
        name = site["properties"]["id"]
        layers = server.get_json(f"/v1/sites/{name}/layers")["layers"]
        sites.append((name, site["geometry"], site["properties"]["verdict"], len(layers)))
    digest.update(json.dumps(sorted(sites, key=str)).encode())
    return digest.hexdigest()


def run(tools, folder, flight_files, num_rounds):
    generator = random.Random(3)
    counts = {"old": 0, "new": 0}
    server = Server(tools, folder / "data").start()
    flight = server.new_flight(flight_files.request)
    body, kind = multipart(
        [("images", name, image)
         for name, image in zip(flight_files.names, flight_files.images)] +
        [("poses", "poses.csv", flight_files.poses_csv)])
    status, answer = server.request(
        "POST", f"/v1/flights/{flight}/batch", body, {"Content-Type": kind})
    check(status == 202, f"batch: {status} {answer[:300]!r}")
    finish(server, flight)
    longest_s = 1.0
    before = state_of(server, flight)
    check(before is not None, "the flight has no map")
    for number in range(num_rounds):
        which = number % len(flight_files.images)
        image = unlike(flight_files.images[which], 7000 + number)
        status, answer = server.put_frame(
            flight, f"more{number}", image, flight_files.metas[which])
        check(status == 201, f"PUT: {status} {answer[:200]!r}")
        begin = time.monotonic()
        status, answer = server.request("POST", f"/v1/flights/{flight}/finish")
        check(status == 202, f"finish: {status} {answer[:200]!r}")
        job = json.loads(answer)["id"]
        if number % 4 == 0:
            # How long it takes, without a kill.
            ended = server.await_job(job)
            check(ended["state"] == "done", f"round {number}: the evaluation fails: {ended}")
            longest_s = time.monotonic() - begin
            before = state_of(server, flight)
            continue
        # Near the end, where the map is stored.
        time.sleep(longest_s * generator.uniform(0.4, 1.05))
        server.kill()
        server.start()
        seen = state_of(server, flight)
        ended = server.await_job(job)
        check(ended["state"] == "done", f"round {number}: the evaluation does not go on: {ended}")
        after = state_of(server, flight)
        check(seen in (before, after), f"round {number}: a map that is neither the old nor the new")
        counts["old" if seen == before else "new"] += 1
        check(not list((server.data / "images").rglob("*-part")), "unfinished files are left")
        before = after
    server.kill()
    return (f"after a kill {counts['old']} times the old map, {counts['new']} times the new one, "
            "never another"), counts["old"] + counts["new"] > 0


def finish(server, flight):
    status, answer = server.request("POST", f"/v1/flights/{flight}/finish")
    check(status == 202, f"finish: {status} {answer[:200]!r}")
    job = server.await_job(json.loads(answer)["id"])
    check(job["state"] == "done", f"finish: {job}")
