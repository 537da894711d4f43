"""Features of every labelled polygon, kept in the work folder; one file a picture, made anew when its polygons change."""
import hashlib
import os
import time
import zlib

import numpy as np

from split import is_drone
from teacher import polygon_rows

# The picture as it is, then some with other colours and scales.
NUM_COPIES = {'drone': 3, 'satellite': 2}


def picture_key(picture):
    content = zlib.crc32(picture.image.tobytes(), zlib.crc32(picture.region.tobytes()))
    return hashlib.sha1(f'{picture.pack}/{picture.name}/{content}'.encode()).hexdigest()[:16]


def cached_rows(trunk, picture, folder):
    path = f'{folder}/{picture_key(picture)}.npz'
    if os.path.exists(path):
        with np.load(path) as file:
            return file['head'], file['features']
    rng = np.random.default_rng(zlib.crc32(f'{picture.pack}/{picture.name}'.encode()))
    copies = NUM_COPIES['drone' if is_drone(picture.place) else 'satellite']
    rows = [row for copy in range(copies) for row in polygon_rows(trunk, picture, copy, rng)]
    head = np.array([row[:3] for row in rows], np.int32).reshape(-1, 3)
    features = np.stack([row[3] for row in rows]).astype(np.float16) if rows else np.zeros((0, 768), np.float16)
    np.savez(path, head=head, features=features)
    return head, features


class Labelled:
    """All rows: place, picture number, polygon number, copy, is_cell, features. polygons: (picture, Polygon) by number."""

    def __init__(self, trunk, pictures, work):
        folder = f'{work}/features'
        os.makedirs(folder, exist_ok=True)
        self.polygons, columns, features, started = [], [], [], time.time()
        for number, picture in enumerate(pictures):
            if not picture.polygons:
                continue
            head, rows = cached_rows(trunk, picture, folder)
            first = len(self.polygons)
            self.polygons += [(picture, polygon) for polygon in picture.polygons]
            columns.append(np.column_stack([head[:, 0] + first, head[:, 1:]]))
            features.append(rows)
            if number % 500 == 0:
                print(f'features of labels: picture {number} of {len(pictures)}, {time.time() - started:.0f} s', flush=True)
        table = np.concatenate(columns)
        self.polygon, self.copy, self.is_cell = table.T
        self.features = np.concatenate(features)
        self.place_of_polygon = np.array([picture.place for picture, _ in self.polygons])
