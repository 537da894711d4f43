"""Asks servers the requests of requests/ and compares or writes their answers. Called by run.sh."""

import argparse
import copy
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

from answers import Ids, difference, recorded_form

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(ROOT / "tests/faults"))
from harness import Fault, Server, check, multipart  # noqa: E402

# Ten days after the photographs were taken: ages and scores are the same each time.
DEMO_BEGIN_S = 1718107200  # 2024-06-11 12:00 UTC
REAL_BEGIN_S = 1468152000  # 2016-07-10 12:00 UTC


# Requests that change nothing, though they have a body.
READING = ("/v1/emergency", "/v1/reach", "/v1/routes/check")


class Clock:
    """The server's wall clock: it stands still, and is moved on before each request that changes something."""

    def __init__(self, tools, file, begin_s):
        self.tools, self.file, self.now_s = tools, file, begin_s
        self.advance(0)

    def advance(self, seconds=1):
        self.now_s += seconds
        # Replaced, so that nobody reads half of it.
        unfinished = self.file.with_suffix(".new")
        unfinished.write_text(f"at {self.now_s}")
        os.replace(unfinished, self.file)

    def server(self, data):
        return Server(self.tools, data, preload=self.tools.clock,
                      environment={"FREELSD_CLOCK_FILE": str(self.file)})


def post(server, clock, path, body=None, headers=None):
    clock.advance()
    status, answer = server.request("POST", path, body, headers)
    check(status < 300, f"POST {path}: {status} {answer[:300]!r}")
    return json.loads(answer)["id"]


def submit(server, clock, ids, request, photographs, poses):
    """Sends a flight as one batch, finishes it and waits."""
    flight = post(server, clock, "/v1/flights", json.dumps(request))
    ids.hide(flight.encode())
    files = [("images", path.name, path.read_bytes()) for path in photographs]
    body, kind = multipart(files + [("poses", "poses.csv", poses.read_bytes())])
    jobs = [post(server, clock, f"/v1/flights/{flight}/batch", body, {"Content-Type": kind})]
    await_done(server, jobs[0])
    jobs.append(post(server, clock, f"/v1/flights/{flight}/finish"))
    await_done(server, jobs[1])
    for job in jobs:
        ids.hide(job.encode())
    server.await_idle()


def await_done(server, job):
    state = server.await_job(job)
    check(state["state"] == "done", f"the job: {state}")


# --- Parts: each leaves a data folder and the ids in it ---

def make_demo(tools, folder, clock, ids):
    photographs = tools.photographs
    if photographs is None:
        photographs = folder / "photographs"
        subprocess.run([tools.render, "--out", photographs, "--seed", "1", "--frames", "72"], check=True,
                       stdout=subprocess.DEVNULL)
    request = json.loads((photographs / "flight.json").read_text())
    with clock.server(folder / "data") as server:
        submit(server, clock, ids, request, sorted(photographs.glob("*.jpg")), photographs / "poses.csv")
        check(server.kill(signal.SIGTERM) == 0, "the server did not end well")


def make_real(tools, folder, clock, ids):
    source = Path(os.environ["FREELSD_DATA"]) / "flights/swindale"
    request = {"name": "swindale", "aircraft": {"profile": "small"}, "altitude_datum": "amsl"}
    with clock.server(folder / "data") as server:
        submit(server, clock, ids, request, sorted((source / "images").iterdir()), source / "poses.csv")
        check(server.kill(signal.SIGTERM) == 0, "the server did not end well")


def damage(data):
    """The first database ends early; what recall needs is in the second one."""
    os.truncate(data / "freelsd.db", 5000)


def lose(data):
    for name in ("freelsd.db", "recall.db"):
        (data / name).write_bytes(b"x" * 20000)


def remove_logs(data):
    """Of the databases: what they would bring back."""
    for path in list(data.glob("*-wal")) + list(data.glob("*-shm")):
        path.unlink()


class Part:
    """Requests to one server, in their order."""

    def __init__(self, name, begin_s, make, spoil=None):
        self.name, self.begin_s, self.make, self.spoil = name, begin_s, make, spoil
        self.requests = json.loads((HERE / f"requests/{name}.json").read_text())
        names = [request["name"] for request in self.requests]
        check(len(set(names)) == len(names), f"requests/{name}.json: a name is there twice")

    def run(self, tools, work, made):
        """(request, recorded form, whole answer) of each; `made` has the folders of flights that are evaluated."""
        folder = work / self.name
        folder.mkdir()
        if self.make not in made:
            made[self.make] = self._evaluate(tools, folder)
        source, ids = made[self.make]
        # What this part adds is not known to the next one.
        ids = copy.deepcopy(ids)
        shutil.copytree(source, folder / "asked")
        if self.spoil:
            remove_logs(folder / "asked")
            self.spoil(folder / "asked")
        clock = Clock(tools, folder / "clock", self.begin_s + 3600)
        with clock.server(folder / "asked") as server:
            server.await_idle()
            ids.feed = json.loads(server.get("/v1/changes?limit=1")[1]).get("feed", "").encode()
            sites = sites_to_ask(server)
            for request in self.requests:
                yield request, *ask(server, clock, request, ids, sites, folder / "asked")
            check(server.is_alive(), "the server ended")
            check(server.kill(signal.SIGTERM) == 0, "the server did not end well")

    def _evaluate(self, tools, folder):
        ids = Ids()
        self.make(tools, folder, Clock(tools, folder / "clock", self.begin_s), ids)
        return folder / "data", ids


def sites_to_ask(server):
    """The first site of each sort, by the word that stands for it in a path."""
    status, body = server.get("/v1/sites")
    sites = {}
    for feature in json.loads(body)["features"] if status == 200 else []:
        word = "{rejected}" if feature["properties"]["verdict"] == "rejected" else "{best}"
        sites.setdefault(word, feature["properties"]["id"])
    return sites


# On a loaded machine an emergency answer can leave out sites; it says so, and is asked for again.
OUT_OF_TIME = b"not every stored site in reach was evaluated"
NUM_TRIES = 3


def ask(server, clock, request, ids, sites, data):
    method, path = request["ask"].split(" ", 1)
    for word, site in sites.items():
        path = path.replace(word, site)
    body = request.get("body")
    if body is not None and not isinstance(body, str):
        body = json.dumps(body)
    # Answers have links to where the client found the server.
    headers = {"Host": "127.0.0.1:8080"}
    if body is not None:
        headers["Content-Type"] = "application/json"
    headers.update(request.get("headers", {}))
    changes = method != "GET" and path.partition("?")[0] not in READING
    if changes:
        clock.advance()
    for number in range(NUM_TRIES):
        if number:
            print(f"    asked again, the answer ran out of time: {request['name']}", flush=True)
        connection = server.connect(timeout_s=120, emergency=request.get("listener") == "emergency")
        connection.request(method, ids.show(path), body and ids.show(body), headers)
        answer = connection.getresponse()
        content = answer.read().replace(str(data).encode(), b"DATA")
        connection.close()
        if OUT_OF_TIME not in content:
            break
    if changes:
        # What follows from it is done behind the answer.
        server.await_idle()
    return recorded_form(request, answer.status, answer.headers, content, ids)


PARTS = {"demo": ("demo", DEMO_BEGIN_S, make_demo),
         "real": ("real", REAL_BEGIN_S, make_real),
         "damaged": ("damaged", DEMO_BEGIN_S, make_demo, damage),
         "lost": ("lost", DEMO_BEGIN_S, make_demo, lose)}


def why_skipped(name):
    if name != "real":
        return None
    folder = os.environ.get("FREELSD_DATA")
    if not folder:
        return "FREELSD_DATA is not set"
    return None if (Path(folder) / "flights/swindale").is_dir() else "FREELSD_DATA has no flights/swindale"


def processor():
    """What decides how numbers are rounded: libraries choose their code by it."""
    wanted = ("ssse3", "sse4_1", "sse4_2", "avx", "f16c", "fma", "avx2", "avx512f", "avx512bw", "avx512vl",
              "avx512_vnni", "asimd", "asimddp", "sve")
    with open("/proc/cpuinfo") as lines:
        flags = next((set(line.split()) for line in lines if line.startswith(("flags", "Features"))), set())
    return " ".join([platform.machine()] + [flag for flag in wanted if flag in flags]) + "\n"


class Answers:
    """The recorded ones of a part: compared, or written anew."""

    def __init__(self, folder, is_written, whole):
        self.folder, self.is_written, self.whole = folder, is_written, whole
        self.left = {path.stem for path in folder.glob("*.txt")}
        self.num_different = 0
        # Their status and headers, which no rounding changes.
        self.num_other_heads = 0
        for path in (folder if is_written else None, whole):
            if path:
                path.mkdir(parents=True, exist_ok=True)

    def take(self, request, form, whole):
        """Compares or writes; a difference is counted and printed."""
        name = request["name"]
        file = self.folder / f"{name}.txt"
        self.left.discard(name)
        if self.whole:
            (self.whole / name).write_bytes(whole)
        if self.is_written:
            file.write_bytes(form.encode())
            return
        recorded = file.read_bytes().decode() if file.exists() else ""
        if recorded == form:
            return
        self.num_different += 1
        self.num_other_heads += recorded.split("\n\n")[0] != form.split("\n\n")[0]
        print(f"DIFFERENT {self.folder.name}/{name}: {request['ask']}", flush=True)
        print(difference(recorded, form) if recorded else "    nothing is recorded", flush=True)

    def end(self):
        """Answers without a request are differences too, or removed."""
        for name in sorted(self.left):
            if self.is_written:
                (self.folder / f"{name}.txt").unlink()
            else:
                print(f"DIFFERENT {self.folder.name}/{name}: there is no such request any more")
                self.num_different += 1
                self.num_other_heads += 1


def run_part(name, arguments, tools, made):
    """Numbers of differences, and of those in status or headers."""
    begin = time.monotonic()
    part = Part(*PARTS[name])
    answers = Answers(arguments.answers / name, arguments.write, arguments.whole and arguments.whole / name)
    for request, form, whole in part.run(tools, arguments.work, made):
        answers.take(request, form, whole)
    answers.end()
    word = "written" if arguments.write else f"{answers.num_different} different"
    print(f"{name}: {len(part.requests)} answers, {word}, {time.monotonic() - begin:.0f} s", flush=True)
    return answers.num_different, answers.num_other_heads


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--clock", type=Path, required=True, help="library to preload")
    parser.add_argument("--work", type=Path, required=True, help="folder for what is thrown away")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--answers", type=Path, default=HERE / "answers")
    parser.add_argument("--whole", type=Path)
    parser.add_argument("--photographs", type=Path)
    return parser.parse_args()


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    arguments = parse_arguments()
    tools = SimpleNamespace(server=arguments.build / "server/freelsd-server",
                            render=arguments.build / "tests/freelsd-render", clock=arguments.clock,
                            model=ROOT / "engine/ground_kind/ground_kind.onnx", photographs=arguments.photographs)
    made, num_different, num_other_heads = {}, 0, 0
    names = arguments.parts.split(",")
    if not set(names) <= set(PARTS):
        sys.exit(f"--parts: of {', '.join(PARTS)}")
    for name in names:
        reason = why_skipped(name)
        if reason:
            print(f"SKIPPED: {name}: {reason}", flush=True)
            continue
        try:
            different, other_heads = run_part(name, arguments, tools, made)
            num_different += different
            num_other_heads += other_heads
        except Fault as fault:
            print(f"FAILED {name}: {fault}", flush=True)
            return 1
    return outcome(arguments, num_different, num_other_heads)


def outcome(arguments, num_different, num_other_heads):
    file = arguments.answers / "processor.txt"
    if arguments.write:
        file.write_text(processor())
    recorded = file.read_text() if file.exists() else ""
    if num_different and not num_other_heads and recorded and recorded != processor():
        print(f"SKIPPED: {num_different} answers differ, but were recorded on another kind of processor\n"
              f"    recorded {recorded.strip()}\n    now      {processor().strip()}\n"
              "    Record what the earlier revision answers here, with --write --answers DIR, and compare with that.")
        return 77
    return 1 if num_different else 0


if __name__ == "__main__":
    sys.exit(main())
