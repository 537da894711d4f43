"""Emergency recall: from damaged databases, after kills, beside slow clients and greedy ones."""

import json
import random
import shutil
import subprocess
import threading
import time

import harness
import many_sites
from harness import Server, check, multipart, percentile, slowdown
from pictures import Flight

# From above the rendered countryside.
RECALL = "/v1/emergency?latitude_deg=47.351&longitude_deg=8.455&altitude_m=900" \
    "&altitude_datum=amsl&wind_east_mps=2&wind_north_mps=0&heading_deg=0"


def without_age(answer):
    """What must be the same after any fault: everything but what time alone changes."""
    for site in answer["sites"] + [answer.get("nearest_miss") or {}]:
        for key in ("age_s", "score"):
            site.pop(key, None)
    return answer


def store_sites(server, folder):
    """Copies the data folder whose sites a real flight gave."""
    shutil.copytree(folder.parent / "sites", server.data)


def store_flight(server, folder):
    """The same with the flight itself."""
    shutil.copytree(folder.parent / "sites-and-flight", server.data)


def make_sites(tools, folder, flight_files):
    """A data folder with the sites of a whole flight, and one with the flight too."""
    with Server(tools, folder) as server:
        flight = server.new_flight(flight_files.request)
        body, kind = multipart(
            [("images", name, image)
             for name, image in zip(flight_files.names, flight_files.images)] +
            [("poses", "poses.csv", flight_files.poses_csv)])
        status, answer = server.request(
            "POST", f"/v1/flights/{flight}/batch", body, {"Content-Type": kind})
        check(status == 202, f"batch: {status} {answer[:300]!r}")
        status, answer = server.request("POST", f"/v1/flights/{flight}/finish")
        job = server.await_job(json.loads(answer)["id"])
        check(job["state"] == "done", f"finish: {job}")
        server.kill(15)
    shutil.copytree(folder, folder.parent / "sites-and-flight")
    with Server(tools, folder) as server:
        # Images would only make copies of the folder slow.
        status, _ = server.request("DELETE", f"/v1/flights/{flight}")
        sites = server.get_json("/v1/sites")["features"]
        recalled = server.get_json(RECALL)["sites"]
        server.kill(15)
    check(len(recalled) > 0, f"of {len(sites)} sites none can be recalled")
    return len(recalled)


def spoil(file, generator):
    """One of the ways in which a file is not what was written; which one."""
    size = file.stat().st_size
    way = generator.choice(["bits", "zeros", "cut", "noise", "swapped pages", "header"])
    data = bytearray(file.read_bytes())
    at = generator.randrange(size)
    if way == "bits":
        for _ in range(generator.choice([1, 20, 400])):
            data[generator.randrange(size)] ^= 1 << generator.randrange(8)
    elif way == "zeros":
        end = min(size, at + generator.randrange(1, 40000))
        data[at:end] = bytes(end - at)
    elif way == "cut":
        del data[at:]
    elif way == "noise":
        end = min(size, at + generator.randrange(1, 20000))
        data[at:end] = generator.randbytes(end - at)
    elif way == "swapped pages":
        a, b = (4096 * generator.randrange(max(1, size // 4096)) for _ in range(2))
        data[a:a + 4096], data[b:b + 4096] = data[b:b + 4096], data[a:a + 4096]
    else:
        for _ in range(8):
            data[generator.randrange(100)] = generator.randrange(256)
    # In place: a running server has it open.
    with open(file, "r+b") as stream:
        stream.write(data)
        stream.truncate(len(data))
    return way


def run_damage(tools, folder, flight_files, num_databases):
    """Each spoilt once: half before the start, half below the running server."""
    generator = random.Random(2)
    reference = None
    num_same = num_answered = num_told = 0
    with_copy = Server(tools, folder / "whole")
    store_sites(with_copy, folder)
    with with_copy as server:
        reference = without_age(server.get_json(RECALL, emergency=True))
    # One copy of everything, as a killed server leaves it.
    for number in range(num_databases):
        server = Server(tools, folder / "data")
        shutil.rmtree(server.data, ignore_errors=True)
        store_sites(server, folder)
        is_running = number % 2 == 1
        if is_running:
            server.start()
        way = spoil(server.data / "freelsd.db", generator)
        if not is_running:
            server.start()
        try:
            answers = [server.get(path) for path in
                       ("/v1/flights", "/v1/sites", "/v1/jobs", "/readyz")]
            told = b"damaged" in answers[3][1]
            answer = server.get_json(RECALL, emergency=True)
            num_answered += 1
            num_same += without_age(answer)["sites"] == reference["sites"]
            num_told += told
            check(server.is_alive(), f"database {number} ({way}) ended the server")
        finally:
            code = server.kill(15)
        check(code == 0, f"database {number} ({way}): exit code {code}")
    return (f"0 crashes, {num_answered} emergency answers, {num_same} of them with the same sites; "
            f"/readyz told of {num_told}"), num_same == num_databases


def run_cold(tools, folder, flight_files, num_starts):
    """kill -9, start, first answer: how long after exec, and whether it is the same."""
    server = Server(tools, folder / "data")
    store_sites(server, folder)
    times_ms, walls_ms, num_same, reference = [], [], 0, None
    for _ in range(num_starts + 1):
        begin = time.monotonic()
        server.start()
        answer = without_age(server.get_json(RECALL, emergency=True))
        elapsed_ms = (time.monotonic() - begin) * 1e3
        walls_ms.append(elapsed_ms)
        elapsed_ms /= slowdown()
        server.kill()
        if reference is None:
            reference = answer
            continue
        times_ms.append(elapsed_ms)
        num_same += answer == reference
    seen = (f"{num_same} of {num_starts} equal; first answer after exec p50 "
            f"{percentile(times_ms, 0.5):.0f} ms, p99 {percentile(times_ms, 0.99):.0f} ms by the pace "
            f"of the machine then (p50 {percentile(walls_ms, 0.5):.0f} ms by the clock)")
    return seen, num_same == num_starts and percentile(times_ms, 0.99) <= 300 * harness.patience


def post_large_batch(server, tools, folder):
    """Twelve photographs of 12 megapixels, and their evaluation; the job."""
    subprocess.run([tools.render, "--out", folder / "large", "--frames", "12", "--width", "4000",
                    "--height", "3000"], check=True, stdout=subprocess.DEVNULL)
    large = Flight(folder / "large")
    flight = server.new_flight(large.request)
    body, kind = multipart([("images", name, image)
                            for name, image in zip(large.names, large.images)] +
                           [("poses", "poses.csv", large.poses_csv)])
    status, answer = server.request(
        "POST", f"/v1/flights/{flight}/batch", body, {"Content-Type": kind})
    check(status == 202, f"batch: {status} {answer[:300]!r}")
    _, answer = server.request("POST", f"/v1/flights/{flight}/finish")
    return json.loads(answer)["id"]


def timed(server, connection, path):
    begin = time.monotonic()
    status, body = server.get(path, connection=connection)
    check(status == 200, f"recall: {status} {body[:200]!r}")
    return (time.monotonic() - begin) * 1e3


def run_latency(tools, folder, flight_files, num_sites):
    """An aircraft that moves on in one wind, then in a wind that changes with each request."""
    server = Server(tools, folder / "data")
    store_sites(server, folder)
    many_sites.fill(server.data, num_sites)
    with server:
        connection = server.connect(emergency=True)
        path = RECALL.replace("altitude_m=900", "altitude_m=700")
        first_ms = timed(server, connection, path) / slowdown()
        job = post_large_batch(server, tools, folder)
        # The server closes one that is idle for so long.
        connection = server.connect(emergency=True)
        pace = [slowdown()]
        same = [timed(server, connection, path.replace("47.351", f"{47.351 + 1e-6 * i:.6f}"))
                for i in range(500)]
        pace.append(slowdown())
        new = [timed(server, connection, path.replace("east_mps=2", f"east_mps={2 + 0.003 * i:.3f}"))
               for i in range(50)]
        state = server.get_json(f"/v1/jobs/{job}")["state"]
        server.await_job(job)
        connection = server.connect(emergency=True)
        begin_s = server.processor_s()
        for i in range(100):
            timed(server, connection, path.replace("47.351", f"{47.351 - 1e-6 * i:.6f}"))
        own_ms = (server.processor_s() - begin_s) * 10
    pace = sum(pace) / 2
    p50, p99 = percentile(same, 0.5) / pace, percentile(same, 0.99) / pace
    seen = (f"{num_sites} sites, first answer {first_ms:.0f} ms, then p50 {p50:.1f} ms, p99 "
            f"{p99:.1f} ms; with another wind each time p50 {percentile(new, 0.5) / pace:.0f} ms, "
            f"p99 {percentile(new, 0.99) / pace:.0f} ms, by the pace of the machine (all took "
            f"{pace:.1f} times as long; job {state}); {own_ms:.1f} ms of processor an answer")
    return seen, p50 <= 2 and p99 <= 20


def latencies_ms(server, seconds, path=RECALL):
    """Over one kept connection of the emergency listener."""
    connection = server.connect(emergency=True)
    times_ms = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        begin = time.monotonic()
        status, body = server.get(path, connection=connection)
        times_ms.append((time.monotonic() - begin) * 1e3)
        check(status == 200, f"recall: {status} {body[:200]!r}")
    connection.close()
    return times_ms


def ask_for_roses(server, path, is_over, statuses):
    """180 winds of each answer are planned, seconds of work over an obstructed field."""
    connection = server.connect(timeout_s=120)
    while not is_over.is_set():
        status, _ = server.get(path, connection=connection)
        statuses.append(status)
    connection.close()


def run_roses(tools, folder, flight_files, seconds):
    """Readers who keep every thread of the main listener planning."""
    server = Server(tools, folder / "data")
    store_sites(server, folder)
    is_over, statuses = threading.Event(), []
    with server:
        sites = [site["id"] for site in server.get_json("/v1/sites")["features"]]
        readers = [threading.Thread(target=ask_for_roses, args=(
            server, f"/v1/sites/{sites[number % len(sites)]}/wind-rose?directions=36"
            "&speeds_mps=1,2,3,4,5", is_over, statuses)) for number in range(30)]
        for reader in readers:
            reader.start()
        try:
            # Until all of them wait for an answer.
            time.sleep(0.5)
            pace = slowdown()
            times_ms = latencies_ms(server, seconds)
        finally:
            is_over.set()
            for reader in readers:
                reader.join()
    # 429: as many as may wait do so.
    check({200} <= set(statuses) <= {200, 429}, f"wind roses answered {set(statuses)}")
    statuses = [status for status in statuses if status == 200]
    p50, p99 = percentile(times_ms, 0.5), percentile(times_ms, 0.99)
    seen = (f"{len(statuses)} roses of 180 winds answered meanwhile; recall p50 {p50:.1f} ms, p99 "
            f"{p99:.1f} ms (the machine took {pace:.1f} times as long)")
    return seen, p50 <= 2 * harness.patience and p99 <= 20 * harness.patience
