#!/usr/bin/env python3
"""Prints how well the networks know places that they never saw.

  evaluate.py --work FOLDER --round NAME [--calibrate ground_kind.json]

Each place is judged by the model of its fold. Scale, shift and threshold used on a fold come from the other folds.
--calibrate also writes scale, shift, threshold and cap of all folds together, which the product uses, and beside that
file those for the model of each fold, from the other folds.
"""
import argparse
import json
import os
import pickle

import numpy as np
import torch

import pictures
import scores
from judge import Judged, judge, student_path
from pictures import KINDS
from split import FOLD_MODELS, NUM_FOLDS, fold_of, is_drone

GRID = np.round(np.arange(0.3, 0.96, 0.01), 2)
MAX_FALSE_RATIO = 0.025        # of the threshold, on the folds it is chosen on
MIN_POLYGONS_A_SIDE = 3


def judged_rows(options, everything):
    """Kept in the work folder by round."""
    path = f'{options.work}/judged_{options.round}.pkl'
    if os.path.exists(path) and not options.again:
        with open(path, 'rb') as file:
            return pickle.load(file)
    rows = []
    for model in FOLD_MODELS:
        network = student_path(options.work, options.round, model)
        if os.path.exists(network):
            rows += judge(network, everything(), lambda place: f'fold{fold_of(place)}' == model)
    with open(path, 'wb') as file:
        pickle.dump(rows, file)
    return rows


def platt(judged, chosen):
    """From single cells, each polygon with the same weight."""
    cells = judged.cells[chosen]
    y = np.repeat(judged.is_grass[chosen].astype(float), cells.shape[1])
    return scores.fit_platt(cells.ravel(), y, np.ones(cells.size))


def calibrated(judged, chosen, line):
    """Mean over a polygon's cells of the calibrated probability."""
    return (1 / (1 + np.exp(-(judged.cells[chosen] * line[0] + line[1])))).mean(1)


def best_threshold(p, y):
    """The least of the grid that calls at most MAX_FALSE_RATIO of other ground grass."""
    fitting = [t for t in GRID if (p[~y] >= t).mean() <= MAX_FALSE_RATIO]
    return float(fitting[0]) if fitting else float(GRID[-1])


def cross_calibrate(judged, usable):
    """p of every usable polygon and whether it is called grass, by scale, shift and threshold of the other folds."""
    p, called = np.full(len(usable), np.nan), np.zeros(len(usable), bool)
    for fold in range(NUM_FOLDS):
        here, others = usable & (judged.fold == fold), usable & (judged.fold != fold)
        if not here.any() or not others.any():
            continue
        line = platt(judged, others)
        threshold = best_threshold(calibrated(judged, others, line), judged.is_grass[others])
        p[here] = calibrated(judged, here, line)
        called[here] = p[here] >= threshold
        print(f'fold {fold}: scale {line[0]:.3f}, shift {line[1]:.3f}, threshold {threshold:.2f}')
    return p, called


def print_pooled(name, judged, usable, p, called):
    y, places = judged.is_grass, judged.place
    low, high = scores.auc_bounds(p[usable], y[usable], places[usable])
    grass, other = usable & y, usable & ~y
    print(f'{name}: {usable.sum()} polygons of {len(set(places[usable]))} places, {grass.sum()} of grass in '
          f'{len(set(places[grass]))} places\n'
          f'  AUC {scores.auc(p[usable], y[usable]):.3f} [{low:.3f}, {high:.3f}], '
          f'calibration error {scores.calibration_error(p[usable], y[usable]):.3f}\n'
          f'  recall {scores.ratio(called[grass].sum(), grass.sum())}, '
          f'other ground called grass {scores.ratio(called[other].sum(), other.sum())}')
    rough = np.array(['rough' in k for k in judged.kinds])
    without = usable & ~rough
    print(f'  without rough grass: AUC {scores.auc(p[without], y[without]):.3f}')
    top = np.argmax(judged.mean, 1)
    for index, kind in enumerate(KINDS):
        of_kind = usable & np.array([k == frozenset([kind]) for k in judged.kinds])
        if of_kind.any():
            print(f'  {kind.ljust(8)} {len(set(places[of_kind])):3d} places, called grass '
                  f'{scores.ratio(called[of_kind].sum(), of_kind.sum())}; named right {(top[of_kind] == index).mean():.2f}')


def print_places(judged, usable, p, called):
    print('place, polygons of grass / other, AUC, found, falsely called grass')
    worst = None
    for place in sorted(set(judged.place[usable])):
        here = usable & (judged.place == place)
        y = judged.is_grass[here]
        value = scores.auc(p[here], y)
        if min(y.sum(), (~y).sum()) >= MIN_POLYGONS_A_SIDE:
            worst = min(worst or (2, ''), (value, place))
        if y.any() or called[here].any():
            print(f"  {place.ljust(34)} {y.sum():3d} / {(~y).sum():3d}  AUC {'  -  ' if value is None else f'{value:.3f}'}  "
                  f'found {called[here][y].sum():3d}, false {called[here][~y].sum():3d}')
    if worst:
        print(f'worst place with {MIN_POLYGONS_A_SIDE} polygons of each side: {worst[1]}, AUC {worst[0]:.3f}')


def calibration(judged, usable):
    """Scale and shift, threshold, and the largest probability that was earned."""
    line = platt(judged, usable)
    p, y = calibrated(judged, usable, line), judged.is_grass[usable]
    threshold = best_threshold(p, y)
    sure = p >= 0.9
    earned = scores.wilson(int(y[sure].sum()), int(sure.sum()))[0] if sure.any() else 0.9
    return {'platt_scale': round(float(line[0]), 4), 'platt_shift': round(float(line[1]), 4),
            'threshold': threshold, 'largest_probability': round(min(0.97, max(0.9, earned)), 3),
            'sure_polygons': int(sure.sum()), 'sure_polygons_of_grass': int(y[sure].sum()),
            'polygons': int(usable.sum()), 'places': len(set(judged.place[usable]))}


def write_calibrated(path, content, judged, usable):
    with open(path, 'w') as file:
        json.dump({**content, 'calibration': calibration(judged, usable)}, file, indent=2)
        file.write('\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--data', default=os.environ.get('FREELSD_DATA'))
    parser.add_argument('--work', required=True)
    parser.add_argument('--round', default='a')
    parser.add_argument('--again', action='store_true', help='judge anew')
    parser.add_argument('--calibrate', help='JSON file whose calibration is written')
    options = parser.parse_args()
    torch.set_num_threads(1)
    loaded = []

    def everything():
        if not loaded:
            loaded.extend(pictures.load_labelled(options.data))
        return loaded

    judged = Judged(judged_rows(options, everything))
    drone = np.array([is_drone(p) for p in judged.place])
    for name, usable in [('drone', judged.is_clear & drone), ('satellite-like', judged.is_clear & ~drone)]:
        p, called = cross_calibrate(judged, usable)
        usable = usable & ~np.isnan(p)
        print_pooled(name, judged, usable, p, called)
        if name == 'drone':
            print_places(judged, usable, p, called)
    if options.calibrate:
        with open(options.calibrate) as file:
            content = json.load(file)
        usable = judged.is_clear & drone
        write_calibrated(options.calibrate, content, judged, usable)
        for fold, model in enumerate(FOLD_MODELS):
            path = os.path.join(os.path.dirname(options.calibrate), f'{model}.json')
            write_calibrated(path, content, judged, usable & (judged.fold != fold))


if __name__ == '__main__':
    main()
