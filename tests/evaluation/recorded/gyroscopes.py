#!/usr/bin/env python3
"""Prints what polynomials in time leave of the turn during readout, by the gyroscopes of a camera.

Usage: gyroscopes.py FLIGHT   (a folder with images/ of a Parrot Sequoia; needs exiftool)
Units: pixels of the photograph, root mean square over the photographs. The axes are the sensor's.
"""
import base64
import glob
import json
import struct
import subprocess
import sys

FOCAL_PX = 1795.5  # of the photographs in garfield_park
RADIUS_PX = 1000.0  # a turn about the optical axis moves a point at this distance
READOUT_S = 0.164
SAMPLE = struct.Struct("<Qfff4x")  # microseconds; radians per second
MAX_POWER = 6


def samples_of(tags):
    data = base64.b64decode(tags["IMUAngularVelocity"].lstrip(".") + "===")
    return list(SAMPLE.iter_unpack(data[: len(data) // SAMPLE.size * SAMPLE.size]))


def turn_of(samples, axis):
    """Shares of the readout in [-0.5, 0.5], and the turn so far."""
    shares, turns, turn = [-0.5], [0.0], 0.0
    for before, after in zip(samples, samples[1:]):
        turn += 0.5 * (before[axis] + after[axis]) * (after[0] - before[0]) * 1e-6
        share = (after[0] - samples[0][0]) * 1e-6 / READOUT_S - 0.5
        if share > 0.5:
            break
        shares.append(share)
        turns.append(turn)
    return shares, turns


def residuals(xs, ys, power):
    """What is left of ys after orthogonal polynomials in xs up to a power."""
    basis, left = [], list(ys)
    for k in range(power + 1):
        column = [x**k for x in xs]
        for other in basis:
            along = sum(a * b for a, b in zip(column, other))
            column = [a - along * b for a, b in zip(column, other)]
        norm = sum(a * a for a in column) ** 0.5
        basis.append([a / norm for a in column])
        along = sum(a * b for a, b in zip(left, basis[-1]))
        left = [a - along * b for a, b in zip(left, basis[-1])]
    return left


def main():
    images = sorted(glob.glob(sys.argv[1] + "/images/*"))
    output = subprocess.run(["exiftool", "-j", "-XMP:all"] + images, capture_output=True, check=True)
    flights = [samples_of(tags) for tags in json.loads(output.stdout)]
    print("| power | x px | y px | z px |\n|---|---|---|---|")
    for power in range(1, MAX_POWER + 1):
        row = []
        for axis, scale in ((1, FOCAL_PX), (2, FOCAL_PX), (3, RADIUS_PX)):
            squares = []
            for samples in flights:
                left = residuals(*turn_of(samples, axis), power)
                squares.append(sum(a * a for a in left) / len(left))
            row.append(scale * (sum(squares) / len(squares)) ** 0.5)
        print(f"| {power} | " + " | ".join(f"{value:.2f}" for value in row) + " |")


if __name__ == "__main__":
    main()
