"""Clients that vanish within an upload, and a camera that stays for long."""

import json
import random
import socket
import struct
import time

from disks import META
from harness import Server, check, multipart, percentile
from pictures import unlike
from recalls import RECALL

SETTLE_S = 20


def abort(server, request, generator):
    """Sends a part of it and goes: in order, or with a reset."""
    with socket.create_connection(("127.0.0.1", server.port)) as client:
        if generator.random() < 0.5:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        try:
            client.sendall(request[:generator.randrange(1, len(request))])
        except OSError:
            return


def requests_to(flight, flight_files):
    """One of each kind of upload, whole."""
    image = flight_files.images[0]
    frame, frame_kind = multipart([("image", "i.jpg", image), ("meta", None, json.dumps(META))])
    batch, batch_kind = multipart(
        [("images", name, image) for name, image in
         zip(flight_files.names[:6], flight_files.images[:6])])
    line = json.dumps({"timestamp_us": 1, "position": META["position"]}).encode() + b"\n"
    zipped = b"PK\3\4" + bytes(200000)
    stream = b"--x\r\nContent-Type: image/jpeg\r\nX-Timestamp-Us: 5\r\n\r\n" + image
    kinds = [("PUT", f"frames/aborted", frame, frame_kind),
             ("PUT", f"frames/aborted", image, "image/jpeg"),
             ("POST", "batch", batch, batch_kind),
             ("POST", "batch", zipped, "application/zip"),
             ("POST", "stream", stream, "multipart/mixed; boundary=x"),
             ("POST", "telemetry", line * 2000, "application/x-ndjson")]
    for method, path, body, kind in kinds:
        # One byte more than is ever sent: no prefix of it is a whole request.
        yield (f"{method} /v1/flights/{flight}/{path} HTTP/1.1\r\nHost: localhost\r\n"
               f"Content-Type: {kind}\r\nContent-Length: {len(body) + 1}\r\n\r\n").encode() + body


def files_of(server):
    return [str(file) for folder in ("images", "spool")
            for file in (server.data / folder).rglob("*") if file.is_file()]


def run_aborts(tools, folder, flight_files, num_uploads):
    generator = random.Random(4)
    with Server(tools, folder / "data") as server:
        flight = server.new_flight(flight_files.request)
        requests = list(requests_to(flight, flight_files))
        # Threads and pools are made when first needed: they are no leak.
        for _ in range(len(requests) * 20):
            abort(server, generator.choice(requests), generator)
        settle(server)
        # A pool still grows where more requests meet than ever before; a leak grows each time.
        for _ in range(2):
            descriptors, memory_mib = server.num_descriptors(), server.resident_mib()
            for _ in range(num_uploads):
                abort(server, generator.choice(requests), generator)
            settle(server, descriptors)
            grown_mib = server.resident_mib() - memory_mib
            more = server.num_descriptors() - descriptors
            if more <= 2:
                break
        files = files_of(server)
        check(server.is_alive(), "the server ended")
        check(not server.frames(flight), "a frame of an aborted upload is in the list")
        status, body = server.put_frame(flight, "after", flight_files.images[0], META)
        check(status == 201, f"an upload afterwards: {status} {body[:200]!r}")
    seen = (f"{num_uploads} aborted: {len(files)} files, {more:+d} descriptors, "
            f"{grown_mib:+.1f} MiB")
    return seen, not files and more <= 2 and grown_mib < 16


def settle(server, num_descriptors=None):
    """Until nothing is read any more; where it is said, until there are no more descriptors than before."""
    end = time.monotonic() + SETTLE_S
    before = None
    while time.monotonic() < end:
        now = (server.num_descriptors(), len(files_of(server)))
        is_quiet = now == before if num_descriptors is None else now[0] <= num_descriptors
        if is_quiet and not now[1]:
            return
        before = now
        time.sleep(0.5)


def run_soak(tools, folder, flight_files, minutes, frames_per_second=5.0):
    """A camera of five frames a second, recall and lists beside it; memory after the first quarter."""
    config = {"max_stored_image_bytes": 64 << 20}
    with Server(tools, folder / "data", config=config) as server:
        samples, times_ms = [], []
        statuses = {}
        begin = time.monotonic()
        number = 0
        flight = None
        while (now := time.monotonic() - begin) < minutes * 60:
            # As flights are: a new one each minute, the old one finished.
            if number % int(60 * frames_per_second) == 0:
                if flight:
                    server.request("POST", f"/v1/flights/{flight}/finish")
                flight = server.new_flight(flight_files.request)
            which = number % len(flight_files.images)
            meta = dict(flight_files.metas[which], timestamp_us=number * 200000)
            status, body = server.put_frame(
                flight, f"f{number}", unlike(flight_files.images[which], number), meta)
            check(status in (201, 429), f"soak: {status} {body[:200]!r}")
            statuses[status] = statuses.get(status, 0) + 1
            sent = time.monotonic()
            check(server.get(RECALL, emergency=True)[0] == 200, "recall while it soaks")
            times_ms.append((time.monotonic() - sent) * 1e3)
            number += 1
            if number % 25 == 0:
                samples.append((now, server.resident_mib(), server.num_descriptors()))
            time.sleep(max(0.0, number / frames_per_second - (time.monotonic() - begin)))
        check(server.is_alive(), "the server ended")
    return soak_result(samples, statuses, times_ms, minutes)


def soak_result(samples, statuses, times_ms, minutes):
    warm = [each for each in samples if each[0] > minutes * 60 / 4]
    check(len(warm) >= 4, "too few samples: soak for longer")
    half = len(warm) // 2
    mean = lambda rows, i: sum(row[i] for row in rows) / len(rows)
    slope = (mean(warm[half:], 1) - mean(warm[:half], 1)) / (minutes * 0.75 / 2)
    descriptors = mean(warm[half:], 2) - mean(warm[:half], 2)
    seen = (f"{minutes:g} min, {sum(statuses.values())} frames ({statuses.get(429, 0)} answered "
            f"429): memory {warm[0][1]:.0f} to {warm[-1][1]:.0f} MiB, {slope:+.2f} MiB/min, "
            f"descriptors {descriptors:+.1f}; recall p50 {percentile(times_ms, 0.5):.1f} ms, p99 "
            f"{percentile(times_ms, 0.99):.1f} ms")
    return seen, slope < 5 and descriptors < 8
