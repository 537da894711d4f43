"""A disk that fills up: writes are refused, reads and recall go on, and space that returns is used."""

import ctypes
import json
import os
import sqlite3

from harness import Server, check
from pictures import noise_png
from recalls import RECALL, store_sites

DISK_BYTES = 24 << 20


class SmallDisk:
    """A tmpfs of its own size; raises OSError where this process may not mount."""

    def __init__(self, folder, num_bytes=DISK_BYTES):
        self.folder = str(folder)
        self.num_bytes = num_bytes
        self.libc = ctypes.CDLL(None, use_errno=True)

    def __enter__(self):
        os.makedirs(self.folder, exist_ok=True)
        options = f"size={self.num_bytes}".encode()
        if self.libc.mount(b"tmpfs", self.folder.encode(), b"tmpfs", 0, options) != 0:
            raise OSError(ctypes.get_errno(), "this process may not mount a small disk")
        return self

    def __exit__(self, *_):
        self.libc.umount2(self.folder.encode(), 2)

    def fill(self, num_left):
        """Takes all room but that many bytes."""
        self.make_room()
        step = 1 << 12
        with open(os.path.join(self.folder, "filler"), "wb") as file:
            status = os.statvfs(self.folder)
            size = max(0, status.f_bavail * status.f_frsize - num_left)
            # The server may have taken some meanwhile.
            while size > 0:
                try:
                    return os.posix_fallocate(file.fileno(), 0, size)
                except OSError:
                    size -= step

    def make_room(self):
        filler = os.path.join(self.folder, "filler")
        if os.path.exists(filler):
            os.remove(filler)


def camera_request(width_px, height_px):
    return {"name": "noise", "camera": {"width_px": width_px, "height_px": height_px,
                                        "fx_px": 300, "fy_px": 300, "cx_px": width_px / 2,
                                        "cy_px": height_px / 2}}


META = {"position": {"latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 500.0},
        "attitude": {"roll_deg": 0, "pitch_deg": 0, "yaw_deg": 0}, "height_above_ground_m": 100}


def fill(server, flight, cycle):
    """Uploads until one is refused; how many were taken."""
    for i in range(400):
        status, body = server.put_frame(flight, f"c{cycle}-{i}", noise_png(320, 240, grey=False), META)
        if status == 201:
            continue
        problem = json.loads(body)
        check(status == 507 and problem["code"] == "StorageFull", f"full: {status} {body[:200]!r}")
        check(problem["retryable"], "507 must be retryable")
        return i
    check(False, "the disk does not fill")


def unnamed_files(data):
    """Image files that neither a frame nor a picture's tile names: all frames are gone by then."""
    database = sqlite3.connect(f"file:{data / 'freelsd.db'}?mode=ro", uri=True)
    named = {row[0] for row in database.execute("SELECT DISTINCT sha256 FROM photo_tiles")}
    named |= {row[0] for row in database.execute("SELECT DISTINCT sha256 FROM frames")}
    database.close()
    return [file for file in (data / "images").rglob("*")
            if file.is_file() and file.name not in named]


def run(tools, folder, flight_files, num_cycles):
    with SmallDisk(folder / "disk"):
        server = Server(tools, folder / "disk" / "data")
        store_sites(server, folder)
        before = server.start().get_json(RECALL, emergency=True)["sites"]
        check(len(before) > 0, "no site to recall")
        num_taken = 0
        process = server.process.pid
        for cycle in range(num_cycles):
            flight = server.new_flight(camera_request(320, 240))
            num_here = fill(server, flight, cycle)
            check(num_here > 0, "nothing fits on an empty disk")
            num_taken += num_here
            check(len(server.frames(flight)) == num_here, "the list is not what was taken")
            sites = server.get_json(RECALL, emergency=True)["sites"]
            check(len(sites) == len(before), "recall answers less on a full disk")
            check(server.get("/healthz")[0] == 200, "healthz on a full disk")
            check(server.get("/readyz")[0] == 503, "readyz on a full disk")
            # Space returns: what the operator deletes. A full disk must let him.
            status, body = server.request("DELETE", f"/v1/flights/{flight}")
            check(status in (200, 204), f"DELETE on a full disk: {status} {body[:200]!r}")
        check(server.process.pid == process and server.is_alive(), "the server was restarted")
        server.kill()
        left = unnamed_files(server.data)
        check(not left, f"{len(left)} image files left that no frame names")
    return (f"{num_cycles} of {num_cycles} recovered without restart, {num_taken} frames taken and "
            f"listed, 507 retryable each time, recall and reads all along"), True
