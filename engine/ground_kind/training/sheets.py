"""Contact sheets of the polygons of one index of the packs, numbered, for a reader to name their kinds.

  sheets.py --data FREELSD_DATA --index 4 --out FOLDER     writes sheet_NN.png and list.csv (the columns of readings.csv)
"""
import argparse
import csv
import os

import cv2
import numpy as np
from PIL import Image

import pictures

TILE_PX = 330
COLUMNS, ROWS = 5, 4


def tile(image, inside, text):
    """The component with as much surrounding again, its outline drawn, whole picture if it is small."""
    ys, xs = np.nonzero(inside)
    side = max(np.ptp(xs), np.ptp(ys), 60) * 1.5
    x, y = (xs.min() + xs.max()) / 2, (ys.min() + ys.max()) / 2
    x0, y0 = int(max(0, x - side / 2)), int(max(0, y - side / 2))
    x1, y1 = int(min(image.shape[1], x + side / 2)), int(min(image.shape[0], y + side / 2))
    drawn = image.copy()
    outlines, _ = cv2.findContours(inside.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(drawn, outlines, -1, (0, 0, 255), max(1, round(side / TILE_PX)))
    part = drawn[y0:y1, x0:x1]
    scale = TILE_PX / max(part.shape[:2])
    part = cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC)
    out = np.zeros((TILE_PX + 20, TILE_PX + 4, 3), np.uint8)
    part = part[:TILE_PX, :TILE_PX]
    out[20:20 + part.shape[0], :part.shape[1]] = part
    cv2.putText(out, text, (2, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1, cv2.LINE_AA)
    return out


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument('--data', default=os.environ.get('FREELSD_DATA'))
    arguments.add_argument('--index', type=int, default=4)
    arguments.add_argument('--out', required=True)
    options = arguments.parse_args()
    os.makedirs(options.out, exist_ok=True)
    tiles, rows = [], []
    for pack in pictures.DRONE_PACKS + pictures.SATELLITE_PACKS:
        folder = f'{options.data}/ground_kinds/{pack}'
        with open(f'{folder}/images.csv') as lines:
            for row in csv.DictReader(lines):
                path = f"{folder}/masks/{row['name']}.png"
                if not os.path.exists(path):
                    continue
                image = pictures.read_picture(f"{folder}/images/{row['name']}.jpg")
                for component, inside in pictures.mask_components(np.array(Image.open(path)), options.index):
                    number = len(tiles) + 1
                    tiles.append(tile(image, inside, f"{number} {row['name'][:22]} {pictures.pack_sampling(pack, row):.2g} m"))
                    rows.append([number, pack, row['name'], options.index, component, '', ''])
    per_sheet = COLUMNS * ROWS
    for k in range(0, len(tiles), per_sheet):
        page = tiles[k:k + per_sheet] + [np.zeros_like(tiles[0])] * (per_sheet - len(tiles[k:k + per_sheet]))
        sheet = np.vstack([np.hstack(page[r * COLUMNS:(r + 1) * COLUMNS]) for r in range(ROWS)])
        cv2.imwrite(f'{options.out}/sheet_{k // per_sheet + 1:02d}.png', sheet)
    with open(f'{options.out}/list.csv', 'w', newline='') as file:
        csv.writer(file).writerows([['number', 'pack', 'picture', 'index', 'component', 'kind', 'reader']] + rows)


if __name__ == '__main__':
    main()
