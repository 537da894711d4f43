"""Photographs that were cut or changed on the way, and files that unpack to more than they seem."""

import base64
import hashlib
import io
import json
import random
import struct
import zipfile
import zlib

from disks import META, camera_request
import harness
from harness import Server, check
from pictures import chunk, png, segment, with_segment, with_size

MAX_BOMB_MIB = 16.0
MAX_BOMB_MS = 50.0


def put_plain(server, flight, frame, image, connection=None, headers=None):
    return server.put_frame(flight, frame, image, META, headers, connection)


def digest_of(image):
    return {"Repr-Digest": "sha-256=:" + base64.b64encode(hashlib.sha256(image).digest()).decode() +
            ":"}


def run_truncated(tools, folder, flight_files, num_images):
    """One of each percent of a photograph's bytes."""
    with Server(tools, folder / "data") as server:
        flight = server.new_flight(flight_files.request)
        image = flight_files.images[0]
        percents = [100 * (i + 1) // (num_images + 1) for i in range(num_images)]
        refused = 0
        for percent in percents:
            status, body = put_plain(server, flight, f"t{percent}", image[:len(image) * percent // 100])
            check(status != 500, f"cut at {percent} %: {body[:200]!r}")
            refused += status in (415, 422)
        check(not server.frames(flight), "a cut photograph is in the list")
        check(put_plain(server, flight, "whole", image)[0] == 201, "the whole one is refused")
        check(server.is_alive(), "the server ended")
    return f"{refused} of {num_images} refused", refused == num_images


def flipped(image, generator):
    data = bytearray(image)
    for _ in range(8):
        data[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
    return bytes(data)


def run_flipped(tools, folder, flight_files, num_images):
    """Eight bits of each turned: with the digest of what was meant, and without."""
    generator = random.Random(3)
    config = {"max_num_queued_frames": 1000000}
    with Server(tools, folder / "data", config=config) as server:
        flight = server.new_flight(flight_files.request)
        connection = server.connect()
        refused = caught = 0
        for i in range(num_images):
            image = flight_files.images[i % len(flight_files.images)]
            spoilt = flipped(image, generator)
            status, body = put_plain(server, flight, f"d{i}", spoilt, connection, digest_of(image))
            check(status != 500, f"flipped: {body[:200]!r}")
            refused += status == 422
            status, body = put_plain(server, flight, f"p{i}", spoilt, connection)
            check(status in (201, 415, 422, 413), f"flipped: {status} {body[:200]!r}")
            caught += status != 201
        # What slips through decodes without a warning; the engine must live with it.
        if num_images < 100:
            status, body = server.request("DELETE", f"/v1/flights/{flight}")
            flight = server.new_flight(flight_files.request)
            for i in range(3):
                put_plain(server, flight, f"e{i}", flipped(flight_files.images[i], generator))
        status, body = server.request("POST", f"/v1/flights/{flight}/finish")
        state = server.await_job(json.loads(body)["id"])["state"]
        check(state == "done" and server.is_alive(), f"the engine on what slipped through: {state}")
    return (f"with Repr-Digest {refused} of {num_images} refused; without it {caught} of "
            f"{num_images} caught ({100 * caught / num_images:.0f} %), the engine took the rest",
            refused == num_images)


# --- Bombs ---

def zip_of(entries, method=zipfile.ZIP_DEFLATED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method, compresslevel=9) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return buffer.getvalue()


def lying_zip(real_size):
    """The directory says one byte; the data unpack to more."""
    data = zip_of([("a.jpg", bytes(real_size))])
    for signature, at in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        place = data.index(signature) + at
        data = data[:place] + struct.pack("<I", 1) + data[place + 4:]
    return data


def xmp_segment(text):
    return b"http://ns.adobe.com/xap/1.0/\0" + text


def tiff(entries, count):
    """A TIFF directory whose entries say they have many components."""
    rows = b"".join(struct.pack("<HHII", tag, kind, count, 8) for tag, kind in entries)
    return b"Exif\0\0II*\0\x08\0\0\0" + struct.pack("<H", len(entries)) + rows + bytes(4)


def image_bombs(jpeg):
    laughs = b"".join(b'<!ENTITY l%d "%s">' % (i, b"&l%d;" % (i - 1) * 10) for i in range(1, 12))
    deep = b"<a>" * 15000
    wide = b"<x:xmpmeta xmlns:x='adobe:ns:meta/'>" + b"<b c='d'/>" * 6000 + b"</x:xmpmeta>"
    text = zlib.compress(bytes(200 << 20), 9)
    yield "JPEG, 65 500 squared", with_size(jpeg, 65500, 65500)
    yield "JPEG, 16 384 squared", with_size(jpeg, 16384, 16384)
    yield "JPEG, 16 000 x 4000", with_size(jpeg, 16000, 4000)
    yield "JPEG, 8000 squared", with_size(jpeg, 8000, 8000)
    yield "JPEG, no rows", with_size(jpeg, 564, 0)
    yield "PNG, 2^31 squared", png(2**31 - 1, 2**31 - 1)
    yield "PNG, 100 000 squared", png(100000, 100000)
    yield "PNG, 16 384 squared", png(16384, 16384)
    yield "PNG, 8000 squared of zeros", png(8000, 8000)
    yield "PNG, 16 384 x 3900 of zeros", png(16384, 3900, colour=0)
    yield "PNG, 16 bits", png(4000, 4000, bit_depth=16)
    yield "PNG, four channels", png(7900, 7900, colour=6)
    yield "PNG zTXt of 200 MiB", png(564, 360, chunks=[(b"zTXt", b"a\0\0" + text)])
    yield "PNG iTXt of 200 MiB", png(564, 360, chunks=[(b"iTXt", b"XML:com.adobe.xmp\0\1\0\0\0" + text)])
    yield "PNG iCCP of 200 MiB", png(564, 360, chunks=[(b"iCCP", b"a\0\0" + text)])
    yield "PNG, 40 000 texts", png(564, 360, chunks=[(b"tEXt", b"a\0b")] * 40000)
    yield "PNG, 200 000 empty texts", png(564, 360, chunks=[(b"tEXt", b"")] * 200000)
    yield "PNG, 100 000 transparencies", png(564, 360, chunks=[(b"tRNS", bytes(6))] * 100000)
    yield "PNG, text of 2 MiB", png(564, 360, chunks=[(b"tEXt", b"a\0" + b"b" * (2 << 20))])
    yield "XMP, entities", with_segment(jpeg, 0xE1, xmp_segment(
        b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY l0 'ha'>" + laughs + b"]><a>&l11;</a>"))
    yield "XMP, 15 000 deep", with_segment(jpeg, 0xE1, xmp_segment(deep))
    yield "XMP, 6000 wide", with_segment(jpeg, 0xE1, xmp_segment(wide))
    yield "XMP, 30 packets", jpeg[:2] + segment(0xE1, xmp_segment(wide)) * 30 + jpeg[2:]
    yield "EXIF, 2^32 components", with_segment(jpeg, 0xE1, tiff([(0x8825, 5)] * 200, 2**32 - 1))
    yield "EXIF, directory in a circle", with_segment(jpeg, 0xE1, tiff([(0x8769, 4)] * 500, 1))
    yield "EXIF, 4000 entries", with_segment(jpeg, 0xE1, tiff([(0x010F, 2)] * 4000, 60000))


def body_bombs():
    gzipped = zlib.compressobj(9, wbits=31)
    gzip_bytes = gzipped.compress(bytes(200 << 20)) + gzipped.flush()
    yield "gzip body", "json", gzip_bytes, {"Content-Encoding": "gzip"}
    yield "JSON, 100 000 deep", "json", b"[" * 100000, {}
    yield "zip, ratio 1000", "batch", zip_of([("a.jpg", bytes(60 << 20))]), {}
    yield "zip, 30 000 entries", "batch", zip_of([(f"{i}.jpg", b"") for i in range(30000)]), {}
    yield "zip, 300 MiB of poses", "batch", zip_of([("poses.csv", b"a," * (150 << 20))]), {}
    yield "zip that lies of its size", "batch", lying_zip(60 << 20), {}
    inner = zip_of([("a.jpg", bytes(40 << 20))])
    yield "zips in a zip", "batch", zip_of([(f"{i}.zip", inner) for i in range(50)]), {}


def measure(server, send):
    server.await_idle()
    server.reset_peak()
    before_mib, begin_s = server.resident_mib(), server.processor_s()
    status, body = send()
    return status, body, (server.processor_s() - begin_s) * 1e3, server.peak_mib() - before_mib


def run_bombs(tools, folder, flight_files, num_tries):
    worst, num_taken, times_ms = [], 0, []
    with Server(tools, folder / "data") as server:
        flight = server.new_flight(flight_files.request)
        put_plain(server, flight, "ordinary", flight_files.images[0])
        bombs = [(name, lambda image=image, i=i: put_plain(server, flight, f"b{i}", image))
                 for i, (name, image) in enumerate(image_bombs(flight_files.images[0]))]
        for name, kind, body, headers in body_bombs():
            path = f"/v1/flights/{flight}/batch" if kind == "batch" else "/v1/flights"
            bombs.append((name, lambda path=path, body=body, headers=headers:
                          server.request("POST", path, body, headers)))
        for name, send in bombs:
            # The least of some: what else the machine does is not the bomb's.
            tries = [measure(server, send) for _ in range(num_tries)]
            status, body, _, _ = tries[0]
            elapsed_ms, mib = (min(each[i] for each in tries) for i in (2, 3))
            check(server.is_alive() and status != 500, f"{name}: {status} {body[:200]!r}")
            num_taken += status in (200, 201, 202)
            times_ms.append(elapsed_ms)
            worst.append((mib, elapsed_ms, name, status))
    max_mib = MAX_BOMB_MIB * min(2.0, harness.patience)
    max_ms = MAX_BOMB_MS * harness.patience
    failed = [each for each in worst if each[0] > max_mib or each[1] > max_ms]
    most = max(worst)
    slowest = max(worst, key=lambda each: each[1])
    seen = (f"{len(bombs)} bombs, {num_taken} of them harmless and taken; most memory "
            f"{most[0]:.1f} MiB ({most[2]}), longest {slowest[1]:.0f} ms of processor ({slowest[2]})")
    if failed:
        seen += "; over: " + ", ".join(
            f"{name} {mib:.1f} MiB {ms:.0f} ms ({status})" for mib, ms, name, status in failed)
    return seen, not failed
