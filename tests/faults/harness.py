"""The server as a child process to be harmed, and what the rows of the table share."""

import atexit
import http.client
import json
import os
import re
import select
import signal
import subprocess
import time
from pathlib import Path


# Limits of time are multiplied by it: the short form is to find faults, not busy machines.
patience = 1.0


class Fault(Exception):
    """What a row was not to see: ends the row, and the table says so."""


def check(condition, what):
    if not condition:
        raise Fault(what)


class Server:
    """A freelsd-server on free ports of 127.0.0.1, ended with the block."""

    running = set()  # to be ended where a row stopped within

    def __init__(self, tools, data, *, preload=None, environment=None, config=None):
        self.tools = tools
        self.data = Path(data)
        self.process = None
        self.port = self.emergency_port = None
        self.started_s = None  # from exec to the first answer of /healthz
        self.log = self.data.parent / (self.data.name + ".log")
        self.environment = dict(os.environ, **(environment or {}))
        if preload:
            self.environment["LD_PRELOAD"] = str(preload)
        self.arguments = [
            str(tools.server), "--data", str(self.data), "--listen", "127.0.0.1:0",
            "--emergency-listen", "127.0.0.1:0", "--model", str(tools.model)]
        if config:
            path = self.data.parent / (self.data.name + ".config.json")
            path.write_text(json.dumps(config))
            self.arguments += ["--config", str(path)]

    def __enter__(self):
        return self.start()

    def __exit__(self, *_):
        self.kill()

    def start(self):
        begin = time.monotonic()
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                self.arguments, stdout=subprocess.PIPE, stderr=log, bufsize=0,
                env=self.environment)
        Server.running.add(self)
        try:
            self.port = self._read_port(b"listens on http://127.0.0.1:", begin)
            self.emergency_port = self._read_port(b"emergency recall on http://127.0.0.1:", begin)
        except Fault:
            self.kill()
            raise
        status, _ = self.get("/healthz")
        self.started_s = time.monotonic() - begin
        check(status == 200, f"/healthz answers {status} after the start")
        # Nobody reads on: the log lines of requests go to a pipe that must not fill.
        self._drain()
        return self

    def _read_port(self, key, begin):
        line = b""
        while time.monotonic() - begin < 30:
            if not select.select([self.process.stdout], [], [], 0.1)[0]:
                continue
            line = self.process.stdout.readline()
            if not line:
                break
            if key in line:
                return int(re.search(rb":(\d+)/", line[line.index(key):]).group(1))
        tail = self.log.read_text(errors="replace")[-400:]
        raise Fault(f"the server did not start: {line!r} {tail}")

    def _drain(self):
        import threading
        threading.Thread(target=lambda pipe: [None for _ in pipe], args=(self.process.stdout,),
                         daemon=True).start()

    def kill(self, with_signal=signal.SIGKILL):
        """Ends the process; its exit code, or minus the signal."""
        if self.process is None:
            return None
        if self.process.poll() is None:
            self.process.send_signal(with_signal)
        code = self.process.wait(30)
        self.process = None
        Server.running.discard(self)
        return code

    def is_alive(self):
        return self.process is not None and self.process.poll() is None

    # --- Requests ---

    def connect(self, timeout_s=30, emergency=False):
        port = self.emergency_port if emergency else self.port
        return http.client.HTTPConnection("127.0.0.1", port, timeout=timeout_s)

    def request(self, method, path, body=None, headers=None, *, connection=None, emergency=False):
        """Status and the answer's bytes; over a connection of its own unless one is given."""
        own = connection or self.connect(emergency=emergency)
        try:
            own.request(method, path, body, headers or {})
            answer = own.getresponse()
            return answer.status, answer.read()
        finally:
            if connection is None:
                own.close()

    def get(self, path, **more):
        return self.request("GET", path, **more)

    def get_json(self, path, **more):
        status, body = self.get(path, **more)
        check(status == 200, f"GET {path}: {status} {body[:200]!r}")
        return json.loads(body)

    def new_flight(self, request):
        status, body = self.request("POST", "/v1/flights", json.dumps(request))
        check(status == 201, f"POST /v1/flights: {status} {body[:300]!r}")
        return json.loads(body)["id"]

    def put_frame(self, flight, frame, image, meta, headers=None, connection=None):
        body, kind = multipart([("image", "i.jpg", image), ("meta", None, json.dumps(meta))])
        return self.request("PUT", f"/v1/flights/{flight}/frames/{frame}", body,
                            {"Content-Type": kind, **(headers or {})}, connection=connection)

    def frames(self, flight):
        return self.get_json(f"/v1/flights/{flight}/frames")["frames"]

    def await_job(self, job, timeout_s=900):
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            state = self.get_json(f"/v1/jobs/{job}")
            if state["state"] not in ("queued", "running"):
                return state
            time.sleep(0.5)
        raise Fault(f"the job {job} does not end")

    # --- What the process holds ---

    def _status_kib(self, key):
        text = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(rf"^{key}:\s+(\d+) kB", text, re.M).group(1))

    def resident_mib(self):
        return self._status_kib("VmRSS") / 1024

    def reset_peak(self):
        Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def peak_mib(self):
        return self._status_kib("VmHWM") / 1024

    def processor_s(self):
        """Time on a processor so far, of all threads: what else the machine does is not in it."""
        total = 0
        for task in Path(f"/proc/{self.process.pid}/task").iterdir():
            try:
                total += int((task / "schedstat").read_text().split()[0])
            except OSError:
                continue
        return total * 1e-9

    def _wants_processor(self):
        """Whether a thread runs, waits for its turn, or for the disk."""
        for task in Path(f"/proc/{self.process.pid}/task").iterdir():
            try:
                state = (task / "stat").read_text().rpartition(") ")[2][0]
            except OSError:
                continue
            if state in "RD":
                return True
        return False

    def await_idle(self, timeout_s=120):
        """Until the engine has nothing to do. On a busy machine it may want to work and not come to
        it: what it then does later would be counted as another's."""
        end = time.monotonic() + timeout_s
        while time.monotonic() < end:
            before = self.processor_s()
            wanted = 0
            for _ in range(5):
                time.sleep(0.02)
                wanted += self._wants_processor()
            if wanted == 0 and self.processor_s() - before < 0.003:
                return
        raise Fault("the engine does not come to rest")

    def num_descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))


def multipart(parts, boundary="----freelsd-faults"):
    """Body and content type of (name, file name or None, bytes or text) parts."""
    pieces = []
    for name, file_name, content in parts:
        disposition = f'form-data; name="{name}"'
        if file_name:
            disposition += f'; filename="{file_name}"'
        content = content if isinstance(content, bytes) else content.encode()
        pieces += [f"--{boundary}\r\nContent-Disposition: {disposition}\r\n\r\n".encode(),
                   content, b"\r\n"]
    return b"".join(pieces) + f"--{boundary}--\r\n".encode(), \
        f"multipart/form-data; boundary={boundary}"


@atexit.register
def end_all():
    for server in list(Server.running):
        server.kill()


def slowdown():
    """How many times longer than alone anything takes now, because the machine does other work."""
    ratios = []
    for _ in range(5):
        wall, own = time.monotonic(), time.process_time()
        while time.process_time() - own < 0.03:
            pass
        ratios.append((time.monotonic() - wall) / 0.03)
    return max(1.0, sorted(ratios)[2])


def percentile(values, ratio):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(ratio * len(ordered)))]
