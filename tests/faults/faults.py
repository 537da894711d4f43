"""Harms a server in every way that the table names, and writes the table. Called by run.sh."""

import argparse
import datetime
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path
from types import SimpleNamespace

import aborts
import crowds
import disks
import harness
import hostile_crowds
import hostile_images
import kills
import live_flights
import maps
import numbers_in_fields
import promises
import recalls
import slow_clients
from harness import Fault, end_all
from pictures import Flight


CROWDED = "0 recalls failed, p99 <= 30 ms and <= 1.5 times the baseline (median of the rounds)"


def run_kills(tools, folder, flight_files, num_rounds):
    return kills.run(tools, folder, flight_files, num_rounds)


def run_kills_with_clock(tools, folder, flight_files, num_rounds):
    return kills.run(tools, folder, flight_files, num_rounds, clock=True)


# Name, what it must show, how often in the short and in the long form, and what does it; 0: not in
# the short form.
ROWS = [
    ("kill", "SIGKILL at a random moment of a 40-frame ingest", "0 acknowledged frames lost, 0 "
     "twice, start <= 1 s", 4, 200, run_kills),
    ("clock", "the same, with the wall clock set back and forward by up to 400 days", "the same",
     2, 40, run_kills_with_clock),
    ("maps", "SIGKILL while an evaluation of a whole flight stores its map", "the old map or the "
     "new one, never a mixture", 2, 134, maps.run),
    ("disk", "full disk, filled and emptied", "507, reads and recall go on, no restart", 1, 10,
     disks.run),
    ("promises", "every write on a disk of 60 MB with little room: killed after each, and either "
     "database damaged", "nothing refused is there, nothing accepted is lost", 12, 1200,
     promises.run),
    ("finishes", "a finish on a full disk, killed, and either database damaged", "stops with the "
     "reason, goes on when there is room, no site is lost", 0, 10, promises.run_finishes),
    ("database", "spoilt databases, half of them below the running server", "0 crashes, each "
     "gives the emergency answer", 6, 100, recalls.run_damage),
    ("cold", "kill -9, cold start, first emergency answer", "<= 300 ms after exec, all equal", 5,
     100, recalls.run_cold),
    ("truncated", "photographs cut on the way", "all refused", 9, 99,
     hostile_images.run_truncated),
    ("flipped", "photographs with 8 bits turned", "all refused with Repr-Digest", 10, 2000,
     hostile_images.run_flipped),
    ("bombs", "images, archives and bodies that unpack to more than they seem", "<= 16 MiB and "
     "50 ms each", 2, 3, hostile_images.run_bombs),
    ("numbers", "every numeric field with what is no number, or none of use", "422 naming the "
     "field, 400 where it is no JSON", 1, 1, numbers_in_fields.run),
    ("aborts", "uploads whose client vanishes", "no file, descriptor or memory left", 40, 1000,
     aborts.run_aborts),
    ("latency", "emergency answers from many sites while a batch of 12 MP images is processed",
     "p50 <= 2 ms, p99 <= 20 ms", 0, 10000, recalls.run_latency),
    ("roses", "30 clients that ask for wind roses without end (seconds)", "emergency p50 <= 2 ms, "
     "p99 <= 20 ms", 2, 30, recalls.run_roses),
    ("alternates", "live flights that send 10 poses a second each", "each list of alternates <= 1 s "
     "old", 5, 50, live_flights.run),
    ("crowd", "100 slow bodies, 100 slow heads, 100 idle connections, 30 readers of wind roses and a "
     "batch together (seconds)", "0 recalls failed, p99 <= 20 ms", 0, 60, crowds.run),
    ("reach", "40 clients that ask for a wide reach without end, each against its own baseline "
     "(rounds)", CROWDED + ", main /healthz p99 <= 100 ms", 1, 5, hostile_crowds.runner("reach")),
    ("reports", "1200 clients that ask for a flight's report and do not read it (rounds)", CROWDED,
     1, 5, hostile_crowds.runner("reports")),
    ("routes", "40 clients that check a route of 60 points without end (rounds)", CROWDED, 1, 5,
     hostile_crowds.runner("routes")),
    ("pipelining", "1100 connections to the emergency listener, each with 100 requests at once and "
     "slow to read (rounds)", CROWDED, 1, 5, hostile_crowds.runner("pipelining")),
    ("slow", "slow clients in front of nginx", "emergency p99 <= 50 ms, memory flat", 0, 60,
     slow_clients.run),
    ("soak", "a camera of 5 frames a second (minutes)", "memory and descriptors flat", 0, 30,
     aborts.run_soak),
]


def why_skipped(name, tools):
    if name == "slow" and slow_clients.missing(tools):
        return "not installed: " + ", ".join(slow_clients.missing(tools))
    if name == "clock" and tools.clock is None:
        return "no compiler for the preloaded clock"
    return None


def run_row(row, size, tools, work, flight_files):
    """Result, what was seen, seconds."""
    name, _, _, _, _, function = row
    reason = why_skipped(name, tools)
    if reason:
        return "SKIPPED", reason, 0.0
    folder = work / name
    folder.mkdir()
    begin = time.monotonic()
    try:
        seen, is_good = function(tools, folder, flight_files, size)
        result = "passed" if is_good else "FAILED"
    except OSError as error:
        is_skipped = name in ("disk", "promises", "finishes") and "mount" in str(error)
        result, seen = ("SKIPPED" if is_skipped else "FAILED"), str(error)
    except Fault as fault:
        result, seen = "FAILED", str(fault)
    except Exception:
        traceback.print_exc()
        result, seen = "FAILED", traceback.format_exc(limit=1).splitlines()[-1]
    end_all()
    shutil.rmtree(folder, ignore_errors=True)
    return result, seen, time.monotonic() - begin


def clean(text):
    return text.replace("|", "/").replace("\n", " ")[:900]


def write_table(file, lines, form):
    machine = f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the end"
    file.write("# Faults\n\n`tests/faults/run.sh` writes this table. README.md lists the script of each row.\n"
               f"{form} form, {datetime.date.today()}, {platform.system()}, {machine}. "
               "The machine did other work at the same time.\n\n"
               "| fault | size | must show | seen | result |\n|---|---|---|---|---|\n")
    for line in lines:
        file.write("| " + " | ".join(clean(str(cell)) for cell in line) + " |\n")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, required=True, help="folder of the build")
    parser.add_argument("--clock", type=Path, help="library to preload, for the clock")
    parser.add_argument("--long", action="store_true", help="the sizes of the table to keep")
    parser.add_argument("--rows", help="only these, by commas")
    parser.add_argument("--sizes", default="", help="name=N by commas, instead of the form's")
    parser.add_argument("--minutes", type=float, help="of the soak")
    parser.add_argument("--out", type=Path, help="the table, beside the terminal")
    return parser.parse_args()


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    arguments = parse_arguments()
    root = Path(__file__).resolve().parents[2]
    tools = SimpleNamespace(
        root=root, build=arguments.build, clock=arguments.clock,
        server=arguments.build / "server/freelsd-server",
        render=arguments.build / "tests/freelsd-render",
        model=root / "engine/ground_kind/ground_kind.onnx")
    harness.patience = 1.0 if arguments.long else 5.0
    sizes = dict(pair.split("=") for pair in arguments.sizes.split(",") if pair)
    if arguments.minutes:
        sizes["soak"] = arguments.minutes
    wanted = arguments.rows.split(",") if arguments.rows else None
    lines, num_failed = [], 0
    with tempfile.TemporaryDirectory(prefix="freelsd-faults-") as folder:
        work = Path(folder)
        subprocess.run([tools.render, "--out", work / "flight", "--frames", "24", "--width", "564",
                        "--height", "360"], check=True, stdout=subprocess.DEVNULL)
        flight_files = Flight(work / "flight")
        recalls.make_sites(tools, work / "sites", flight_files)
        for row in ROWS:
            name = row[0]
            size = float(sizes.get(name, row[4] if arguments.long else row[3]))
            size = int(size) if size == int(size) else size
            if (wanted and name not in wanted) or size == 0:
                continue
            result, seen, seconds = run_row(row, size, tools, work, flight_files)
            print(f"{result:8} {seconds:6.0f} s  {name} x {size}: {seen}", flush=True)
            num_failed += result == "FAILED"
            lines.append((row[1], size, row[2], seen, result))
            if arguments.out:
                with open(arguments.out, "w") as file:
                    write_table(file, lines, "long" if arguments.long else "short")
    return 1 if num_failed else 0


if __name__ == "__main__":
    sys.exit(main())
