#!/usr/bin/env python3
"""To look at what the networks say.

  look.py photographs --work FOLDER --round NAME --out FOLDER
      lays the likeliest kinds over ten photographs of places left out, each by the model of its fold
  look.py rendered --rendered FOLDER --network FILE.onnx --calibration FILE.json
      prints the share of pixels called grass by what they truly show; FOLDER: freelsd-frames --pool report --pictures
"""
import argparse
import collections
import glob
import json
import os

import cv2
import numpy as np
import torch

import pictures
from judge import BORDER_PX, STRIDE_PX, brightened, load_student, padded, probabilities, student_path
from pictures import KINDS
from split import fold_of
from student import OFFSET, SCALE

COLOURS = {'grass': (60, 220, 60), 'rough': (40, 160, 200), 'crop': (220, 220, 0), 'stubble': (0, 200, 255),
           'soil': (30, 80, 150), 'sand': (150, 220, 240), 'tree': (20, 90, 20), 'water': (230, 80, 20),
           'sealed': (160, 160, 160), 'snow': (255, 255, 255)}      # BGR
PHOTOGRAPHS = [('flights', 'IMG_1447'), ('flights', 'IMG_161122_164703_0136_RGB'), ('flights', 'DJI_0029'),
               ('places', 'IMG_2188'), ('places', '2018080501004918Z'), ('drone_places', 'fbd_a'),
               ('drone_places', 'shf_b'), ('drone_places', 'rur_a'), ('drone_places', 'ott_a'),
               ('heziro_il', 'P7100019')]
COVERS = ['meadow', 'stubble', 'soil', 'scrub', 'gravel', 'road', 'tree', 'hedge', 'house', 'crop', 'water', 'bare tree',
          'boulder', 'ditch', 'fence', 'pole', 'vehicle', 'animal', 'doubt']     # by number of Cover
WIDTH_PX = 640


def overlay(image, p):
    """The picture above, the kinds laid over it below; grass stronger the surer it is."""
    kind = p.argmax(0)
    colour = np.array([COLOURS[k] for k in KINDS], np.uint8)[kind]
    colour = cv2.resize(colour, image.shape[1::-1], interpolation=cv2.INTER_NEAREST)
    laid = cv2.addWeighted(image, 0.5, colour, 0.5, 0)
    both = np.vstack([image, laid])
    scale = WIDTH_PX / image.shape[1]
    return cv2.resize(both, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC)


def look_at_photographs(options):
    os.makedirs(options.out, exist_ok=True)
    for picture in pictures.load_labelled(options.data):
        if (picture.pack, picture.name) in PHOTOGRAPHS:
            net = load_student(student_path(options.work, options.round, f'fold{fold_of(picture.place)}'))
            cv2.imwrite(f'{options.out}/{picture.place}.png', overlay(picture.image, probabilities(net, picture.image)))


def grass_by_opencv(network, image, calibration):
    """Calibrated probability of grass at a quarter of the picture's size, as the product computes it."""
    frame = padded(brightened(image))
    network.setInput(cv2.dnn.blobFromImage(frame, 1 / SCALE, mean=(OFFSET,) * 3))
    logits = network.forward()[0]
    e = np.exp(logits - logits.max(0))
    p = np.clip(e[0] / e.sum(0), 1e-6, 1 - 1e-6)
    line = calibration['platt_scale'] * np.log(p / (1 - p)) + calibration['platt_shift']
    first = BORDER_PX // STRIDE_PX
    out = (1 / (1 + np.exp(-line)))[first:, first:]
    return out[:-(-image.shape[0] // STRIDE_PX), :-(-image.shape[1] // STRIDE_PX)]


def look_at_rendered(options):
    network = cv2.dnn.readNetFromONNX(options.network)
    with open(options.calibration) as file:
        calibration = json.load(file)['calibration']
    called, seen = collections.Counter(), collections.Counter()
    for path in sorted(glob.glob(f'{options.rendered}/*_cover.png')):
        image, cover = pictures.read_picture(path.replace('_cover.png', '.png')), cv2.imread(path, cv2.IMREAD_UNCHANGED)
        p = grass_by_opencv(network, image, calibration)
        p = cv2.resize(p.astype(np.float32), cover.shape[1::-1], interpolation=cv2.INTER_LINEAR)
        look = os.path.basename(path).split('_')[0]
        for index in np.unique(cover):
            here = p[cover == index]
            seen[look, index] += here.size
            called[look, index] += int((here >= calibration['threshold']).sum())
    for look, index in sorted(seen):
        if seen[look, index] > 300 and index < len(COVERS) - 1:
            print(f'{look.ljust(9)} {COVERS[index].ljust(10)} {seen[look, index]:9d} pixels, called grass '
                  f'{called[look, index] / seen[look, index]:.3f}')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('what', choices=['photographs', 'rendered'])
    parser.add_argument('--data', default=os.environ.get('FREELSD_DATA'))
    parser.add_argument('--work')
    parser.add_argument('--round', default='a')
    parser.add_argument('--out', default='looked_at')
    parser.add_argument('--rendered')
    parser.add_argument('--network')
    parser.add_argument('--calibration')
    options = parser.parse_args()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    if options.what == 'photographs':
        look_at_photographs(options)
    else:
        look_at_rendered(options)


if __name__ == '__main__':
    main()
