"""SIGKILL at random moments of an ingest: nothing acknowledged may be lost, nothing be there twice."""

import collections
import hashlib
import http.client
import json
import random
import threading
import time

import harness
from harness import Fault, Server, check, multipart, percentile, slowdown
from pictures import unlike

NUM_FRAMES = 40
MAX_START_S = 1.0


class Ingest:
    """Frames on their way to one flight, by PUT from two clients, as one stream, or as batches."""

    def __init__(self, server, flight_files, number, way):
        self.server = server
        self.way = way
        self.flight = server.new_flight(flight_files.request)
        self.frames = []
        for i in range(NUM_FRAMES):
            which = i % len(flight_files.images)
            image = unlike(flight_files.images[which], number * NUM_FRAMES + i)
            self.frames.append((f"f{i}", image, flight_files.metas[which]))
        # By frame id: the SHA-256 of what was acknowledged.
        self.acknowledged = {}
        self.threads = []

    def start(self):
        work = {"put": [self._put(0), self._put(1)], "stream": [self._stream],
                "batch": [self._batches]}
        for each in work[self.way]:
            thread = threading.Thread(target=self._until_killed, args=(each,), daemon=True)
            thread.start()
            self.threads.append(thread)

    def join(self):
        for thread in self.threads:
            thread.join(30)
            check(not thread.is_alive(), "a client hangs after the kill")

    @staticmethod
    def _until_killed(work):
        try:
            work()
        except (OSError, http.client.HTTPException, Fault, ValueError):
            # The server was killed: what this client did not hear is not acknowledged.
            return

    def _put(self, half):
        def work():
            connection = self.server.connect()
            for frame, image, meta in self.frames[half::2]:
                status, body = self.server.put_frame(
                    self.flight, frame, image, meta, connection=connection)
                check(status in (200, 201), f"PUT: {status} {body[:200]!r}")
                self.acknowledged[frame] = hashlib.sha256(image).hexdigest()
        return work

    def _batches(self):
        for begin in range(0, NUM_FRAMES, 10):
            some = self.frames[begin:begin + 10]
            poses = "image,latitude_deg,longitude_deg,altitude_m\n" + "".join(
                "{},{latitude_deg},{longitude_deg},{altitude_m}\n".format(frame, **meta["position"])
                for frame, _, meta in some)
            body, kind = multipart([("images", frame, image) for frame, image, _ in some] +
                                   [("poses", "poses.csv", poses)])
            status, answer = self.server.request(
                "POST", f"/v1/flights/{self.flight}/batch", body, {"Content-Type": kind})
            check(status == 202, f"batch: {status} {answer[:200]!r}")
            for frame, image, _ in some:
                self.acknowledged[frame] = hashlib.sha256(image).hexdigest()

    # The acknowledgement of a stream is the list of frames.
    def _stream(self):
        sender = threading.Thread(target=self._until_killed, args=(self._send_stream,), daemon=True)
        sender.start()
        while len(self.acknowledged) < NUM_FRAMES:
            for frame in self.server.frames(self.flight):
                self.acknowledged[frame["id"]] = frame["sha256"]
            time.sleep(0.01)
        sender.join()

    def _send_stream(self):
        connection = self.server.connect()
        connection.putrequest("POST", f"/v1/flights/{self.flight}/stream")
        connection.putheader("Content-Type", "multipart/mixed; boundary=x")
        connection.putheader("Transfer-Encoding", "chunked")
        connection.endheaders()
        for frame, image, meta in self.frames:
            part = (f"--x\r\nContent-Type: application/json\r\n\r\n{json.dumps(meta)}\r\n"
                    f'--x\r\nContent-Disposition: form-data; name="image"; filename="{frame}"\r\n'
                    "Content-Type: image/jpeg\r\n\r\n").encode() + image + b"\r\n"
            connection.send(b"%x\r\n%s\r\n" % (len(part), part))
        connection.send(b"5\r\n--x--\r\n0\r\n\r\n")
        connection.getresponse().read()

    def compare(self, server, counts):
        """After the restart: what was acknowledged is there, each once, with its bytes."""
        listed = server.frames(self.flight)
        ids = collections.Counter(frame["id"] for frame in listed)
        stored = {frame["id"]: frame["sha256"] for frame in listed}
        counts["acknowledged"] += len(self.acknowledged)
        counts["twice"] += sum(count - 1 for count in ids.values())
        for frame, sha256 in self.acknowledged.items():
            counts["lost"] += stored.get(frame) != sha256
        for sha256 in stored.values():
            file = server.data / "images" / sha256[:2] / sha256
            is_whole = file.exists() and hashlib.sha256(file.read_bytes()).hexdigest() == sha256
            counts["damaged"] += not is_whole
        counts["unfinished files"] += len(list((server.data / "images").rglob("*-part")))
        counts["unfinished files"] += len(list((server.data / "spool").iterdir()))
        # What is there can be sent again and is not there twice.
        if self.way == "put" and self.acknowledged:
            frame, image, meta = self.frames[int(next(iter(self.acknowledged))[1:])]
            status, body = server.put_frame(self.flight, frame, image, meta)
            check(status == 200, f"an acknowledged frame sent again: {status} {body[:200]!r}")


def run(tools, folder, flight_files, num_rounds, *, clock=False):
    """Rounds of ingest and kill on one data folder; the clock is set to and fro where asked."""
    generator = random.Random(1)
    counts = collections.Counter()
    starts_s = []
    clock_file = folder / "clock"
    environment = {"FREELSD_CLOCK_FILE": str(clock_file)} if clock else None
    server = Server(tools, folder / "data", preload=tools.clock if clock else None,
                    environment=environment)
    former = None
    former_flights = []
    for number in range(num_rounds):
        if clock:
            clock_file.write_text(str(generator.choice([-1, 1]) * generator.randrange(400 * 86400)))
        server.start()
        starts_s.append(server.started_s / slowdown())
        if former:
            former.compare(server, counts)
        # So that the folder stays small: flights of former rounds go.
        while len(former_flights) > 3:
            status, body = server.request("DELETE", f"/v1/flights/{former_flights.pop(0)}")
            check(status in (200, 204), f"DELETE: {status} {body[:200]!r}")
        former = Ingest(server, flight_files, number, ["put", "put", "stream", "batch"][number % 4])
        former_flights.append(former.flight)
        former.start()
        time.sleep(generator.uniform(0.0, 2.0))
        if clock:
            clock_file.write_text(str(generator.choice([-1, 1]) * generator.randrange(400 * 86400)))
            time.sleep(generator.uniform(0.0, 0.3))
        check(server.is_alive(), "the server ended by itself")
        server.kill()
        former.join()
    server.start()
    former.compare(server, counts)
    status, body = server.get("/readyz")
    check(b"damaged" not in body, f"readyz: {status} {body!r}")
    server.kill()
    seen = (f"{counts['acknowledged']} frames acknowledged, {counts['lost']} lost, "
            f"{counts['twice']} twice, {counts['damaged']} damaged, {counts['unfinished files']} "
            f"unfinished files left; start p50 {percentile(starts_s, 0.5) * 1e3:.0f} ms, max "
            f"{max(starts_s) * 1e3:.0f} ms by the pace of the machine then")
    is_good = not any(counts[key] for key in ("lost", "twice", "damaged", "unfinished files"))
    return seen, is_good and max(starts_s) <= MAX_START_S * harness.patience
