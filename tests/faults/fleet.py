"""Harms the parts of a fleet and compares what comes out with an undisturbed run. Called by fleet.sh."""

import argparse
import collections
import http.client
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from pathlib import Path
from types import SimpleNamespace

from fleet_parts import NUM_FRAMES, Fleet, Run
from harness import Fault, check, end_all, percentile
from pictures import Flight

MAX_CLAIM_S = 15.0


def send_and_finish(run):
    run.create()
    run.put_all()
    run.finish()


def harm_undisturbed(run):
    send_and_finish(run)
    run.await_that("an evaluation", lambda: is_evaluated(run), 120)
    begin = time.monotonic()
    run.await_end()
    run.fleet.evaluation_s = time.monotonic() - begin


def harm_frontend(run):
    run.create()
    kill_at = run.random.randrange(1, NUM_FRAMES - 1)
    killed = []

    def between(number):
        if number >= kill_at and not killed and (name := run.take_owner()):
            run.fleet.kill(name)
            killed.append(time.monotonic())
    run.put_all(between)
    run.is_void = not killed
    if killed:
        run.await_takeover(killed[0])
    run.finish()
    run.await_end()


def is_evaluated(run):
    return run.fleet.ask(f"SELECT 1 FROM jobs WHERE flight_id = '{run.flight}' AND kind = 'finish' AND state > 0")


def evaluate_for_a_while(run):
    """Sends a flight and waits for a moment of its evaluation; the name of its worker."""
    send_and_finish(run)
    run.await_that("an evaluation", lambda: is_evaluated(run), 120)
    time.sleep(run.random.uniform(0.0, 0.7 * run.fleet.evaluation_s))
    return run.take_owner()


def harm_evaluation(run):
    name = evaluate_for_a_while(run)
    if name:
        run.fleet.kill(name)
    run.is_void = not name or not run.await_takeover(time.monotonic(), run.is_done)
    run.await_end()


def harm_commit(run):
    """Killed when the COMMIT of sites or of a map comes: before the database has it, or just after."""
    is_before = run.random.random() < 0.5
    writing, killed = {}, []

    def watch(name):
        def on_statement(number, sql):
            if sql == "BEGIN":
                writing[name, number] = False
            elif "INTO sites" in sql or "SET is_in_force" in sql:
                writing[name, number] = True
            if killed or sql != "COMMIT" or not writing.get((name, number)):
                return
            killed.append((name, time.monotonic()))
            if is_before:
                os.kill(run.fleet.servers[name].process.pid, signal.SIGKILL)
                raise OSError("the commit does not arrive")
        return on_statement

    for name in ("worker-1", "worker-2"):
        run.fleet.statement_calls[name] = watch(name)
    send_and_finish(run)
    run.await_that("a commit of sites", lambda: killed, 120)
    name, since = killed[0]
    run.token = run.fleet.tokens[name]
    run.fleet.kill(name)
    run.fleet.statement_calls.clear()
    # Where the last commit of all arrived, there is nothing left to take.
    run.await_takeover(since, run.is_done)
    run.await_end()


def harm_api(run):
    run.create()
    kill_at = run.random.randrange(1, NUM_FRAMES)

    def between(number):
        if number == kill_at:
            delay_s = run.random.uniform(0.0, 0.05)
            threading.Timer(delay_s, run.fleet.kill, ["api-1"]).start()
    run.put_all(between)
    run.finish()
    run.await_end()


def harm_database(run):
    run.create()
    stop_at = run.random.randrange(0, 2 * NUM_FRAMES)

    def stop():
        subprocess.run([*run.fleet.cluster, "-m", "immediate", "stop"], check=True, capture_output=True)
        time.sleep(run.random.uniform(0.0, 2.0))
        subprocess.run([*run.fleet.cluster, "start"], check=True, capture_output=True)
    run.put_all(lambda number: stop() if number == stop_at else None)
    run.finish()
    if stop_at >= NUM_FRAMES:
        time.sleep(run.random.uniform(0.0, 5.0))
        stop()
    run.await_end()


def harm_link(run):
    """Between a client and an API server, or a server and the database; for longer than a lease or for a moment."""
    fleet = run.fleet
    run.create()
    begin_at = run.random.randrange(0, NUM_FRAMES)
    which = run.random.choice(["client", "api-1", "worker-1", "worker-2"])
    is_stall = run.random.random() < 0.5
    for_s = run.random.choice([0.5, 3.0, 12.0])

    def disturb():
        proxy = fleet.to_api["api-1"] if which == "client" else fleet.proxies[which]
        if not is_stall:
            proxy.reset()
            return
        proxy.stall()
        threading.Timer(for_s, proxy.resume).start()
    run.put_all(lambda number: disturb() if number == begin_at else None)
    run.finish()
    time.sleep(run.random.uniform(0.0, 4.0))
    disturb()
    run.await_end()
    time.sleep(0.5)


def harm_all_links(run):
    """All along, one after another, those of clients and those to the database, several at a time."""
    fleet = run.fleet
    run.create()
    is_over = threading.Event()

    def disturb():
        while not is_over.wait(run.random.uniform(0.05, 0.5)):
            proxy = run.random.choice([*fleet.proxies.values(), *fleet.to_api.values()])
            if run.random.random() < 0.5:
                proxy.reset()
                continue
            proxy.stall()
            threading.Timer(run.random.uniform(0.1, 3.0), proxy.resume).start()
    disturber = threading.Thread(target=disturb)
    disturber.start()
    try:
        run.put_all(lambda number: time.sleep(0.1))
        run.finish()
        time.sleep(4.0)
    finally:
        is_over.set()
        disturber.join()
    time.sleep(3.0)
    run.await_end()


def from_both(run, method, path, body=None, headers=None):
    """The answers of both API servers to the same request at once."""
    answers = {}

    def ask(name):
        connection = http.client.HTTPConnection("127.0.0.1", run.fleet.servers[name].port, timeout=60)
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        answers[name] = (answer.status, answer.read())
        connection.close()
    threads = [threading.Thread(target=ask, args=(name,)) for name in ("api-1", "api-2")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return [answers[name] for name in sorted(answers)]


def harm_together(run):
    run.create()
    for number, name in enumerate(run.files.names[:NUM_FRAMES]):
        body, headers = run.frame_body(number)
        answers = from_both(run, "PUT", f"/v1/flights/{run.flight}/frames/{name}", body, headers)
        check(sorted(status for status, _ in answers) in ([200, 201], [200, 200]), f"PUT twice: {answers}")
        run.acknowledge(number)
    answers = from_both(run, "POST", f"/v1/flights/{run.flight}/finish")
    check(all(status in (200, 202) for status, _ in answers), f"finish twice: {answers}")
    jobs = {json.loads(text)["id"] for _, text in answers}
    check(len(jobs) == 1, f"two finishes: {answers}")
    run.job = jobs.pop()
    run.await_end()


def harm_pause(run):
    name = evaluate_for_a_while(run)
    if not name:
        run.is_void = True
        run.await_end()
        return
    process = run.fleet.servers[name].process
    process.send_signal(signal.SIGSTOP)
    is_taken = run.await_takeover(time.monotonic(), run.is_done)
    run.is_void = not is_taken
    process.send_signal(signal.SIGCONT)
    if is_taken:
        try:
            status = process.wait(20)
        except subprocess.TimeoutExpired as error:
            raise Fault("a worker whose lease was over goes on") from error
        check(status == 75, f"the paused worker ended with {status}")
    run.await_end()


ROWS = [
    ("frontend", "SIGKILL of a worker while frames arrive", harm_frontend),
    ("evaluation", "SIGKILL of a worker in an evaluation", harm_evaluation),
    ("commit", "SIGKILL of a worker in a commit of sites", harm_commit),
    ("api", "SIGKILL of an API server under upload", harm_api),
    ("database", "immediate shutdown of PostgreSQL", harm_database),
    ("link", "a link that stalls or resets", harm_link),
    ("links", "all links that stall and reset all along", harm_all_links),
    ("together", "the same frames and finishes to two API servers at once", harm_together),
    ("pause", "a worker paused past its lease", harm_pause),
]


def run_once(fleet, files, seed, harm, undisturbed, counts):
    """The time until another worker had the flight, or None; False if the fault came too late."""
    run = Run(fleet, files, seed)
    try:
        harm(run)
        fleet.heal()
        run.compare(undisturbed, counts)
        run.clear()
    finally:
        fleet.heal()
    return False if run.is_void else run.claim_s


def run_row(fleet, files, row, undisturbed, arguments):
    name, _, harm = row
    counts, claims_s, num_done, seed = collections.Counter(), [], 0, arguments.seed
    while num_done < arguments.times and seed < arguments.seed + 3 * arguments.times + 3:
        seed += 1
        claim_s = run_once(fleet, files, f"{name} {seed}", harm, undisturbed, counts)
        if claim_s is False:
            counts["too late"] += 1
            continue
        num_done += 1
        if claim_s is not None:
            claims_s.append(claim_s)
        print(f"{name} {num_done}: claimed after {claim_s and round(claim_s, 1)} s, {dict(counts)}", flush=True)
    seen = (f"{counts['acknowledged']} frames acknowledged, {counts['lost']} lost, {counts['twice']} twice, "
            f"{counts['unprocessed']} unprocessed; other sites {counts['other sites']} times")
    if claims_s:
        seen += f"; claimed after p50 {percentile(claims_s, 0.5):.1f} s, max {max(claims_s):.1f} s ({len(claims_s)} times)"
    if counts["too late"]:
        seen += f"; {counts['too late']} more came too late to be a fault"
    is_good = not any(counts[key] for key in ("lost", "twice", "unprocessed", "other sites"))
    return num_done, seen, is_good and num_done == arguments.times and max(claims_s, default=0) <= MAX_CLAIM_S


def undisturbed_sites(fleet, files):
    run = Run(fleet, files, 0)
    harm_undisturbed(run)
    sites = run.sites()
    check('"verdict": "landable"' in sites, f"no landable site without a fault: {sites[:400]}")
    run.clear()
    return sites


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--rows", help="only these, by commas")
    parser.add_argument("--seed", type=int, default=0)
    root = Path(__file__).resolve().parents[2]
    parser.add_argument("--build", type=Path, default=root / "build/release")
    parser.add_argument("--flight", type=Path)
    parser.add_argument("--out", type=Path)
    return parser.parse_args()


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    arguments = parse_arguments()
    names = arguments.rows.split(",") if arguments.rows else [row[0] for row in ROWS]
    root = Path(__file__).resolve().parents[2]
    server = arguments.build / "server/freelsd-server"
    tools = SimpleNamespace(server=server, model=root / "engine/ground_kind/ground_kind.onnx")
    lines, has_failed = [], False
    with tempfile.TemporaryDirectory(prefix="freelsd-fleet-") as folder:
        photos = arguments.flight or Path(folder) / "flight"
        if not arguments.flight:
            subprocess.run([arguments.build / "tests/freelsd-render", "--out", photos, "--frames", str(NUM_FRAMES)],
                           check=True)
        fleet = Fleet(tools, Path(folder))
        files = Flight(photos)
        undisturbed = undisturbed_sites(fleet, files)
        for row in (row for row in ROWS if row[0] in names):
            try:
                num_done, seen, is_good = run_row(fleet, files, row, undisturbed, arguments)
            except (Fault, OSError, subprocess.SubprocessError) as fault:
                traceback.print_exc()
                num_done, seen, is_good = arguments.times, str(fault)[:500], False
                fleet.heal()
            has_failed |= not is_good
            lines.append(f"| {row[1]} | {num_done} | {seen} | {'passed' if is_good else 'FAILED'} |")
            print(lines[-1], flush=True)
        end_all()
    if arguments.out:
        arguments.out.write_text("| fault | times | seen | result |\n|---|---|---|---|\n" + "\n".join(lines) + "\n")
    sys.exit(1 if has_failed else 0)


if __name__ == "__main__":
    main()
