#!/usr/bin/env python3
"""What each part of the recipe is worth, by places left out.

  ablate.py places --work FOLDER --windows NAME        learning curve of the teacher over the number of places
  ablate.py student --work FOLDER --windows NAME --chunks N --steps N [--folds 0 1]
      the student with all parts, and without one of them, from scratch, equally long
Settings are not chosen by these figures.
"""
import argparse
import os

import numpy as np
import torch

import heads
import pictures
import scores
import student
import windows
from evaluate import best_threshold, calibrated, platt
from judge import Judged, judge
from labelled import Labelled
from split import FOLD_MODELS, fold_of, is_drone, places_for
from teacher import Basis, Trunk

SIZES = [3, 6, 12, 25, 50, 200]
PARTS = ['all parts', 'without colour variation', 'without unlabelled places', 'half the places', 'without teacher']
DECAY = 1e-2


def curve(options):
    """Teacher: labels of a random part of the places that may teach a fold's model, drone places first."""
    trunk = Trunk(options.teacher).eval().to(memory_format=torch.channels_last)
    everything = pictures.load_labelled(options.data)
    labelled = Labelled(trunk, everything, options.work)
    labels = heads.Labels(labelled)
    features, places = heads.unlabelled_features(trunk, None, options.work)
    x = labelled.features.astype(np.float32)
    rows = np.flatnonzero(labels.is_clean_mean)
    place = labels.place[labels.row_polygon[rows]]
    kinds = [labels.kinds[i] for i in labels.row_polygon[rows]]
    is_grass = np.array([k == {'grass'} for k in kinds])
    judged = np.array([('grass' not in k or len(k) == 1) and is_drone(q) for k, q in zip(kinds, place)])
    told = {size: np.full(len(rows), np.nan) for size in SIZES}
    for fold, model in enumerate(FOLD_MODELS):
        projected = Basis(features[places_for(places, model)]).project(x)
        may_teach = places_for(labels.place, model)
        rng = np.random.default_rng(fold)
        names = rng.permutation(sorted(set(labels.place[may_teach])))
        rich = [n for n in names if is_drone(n) and (labels.place == n).sum() >= 10]
        order = rich + [n for n in names if n not in rich]
        here = judged & np.array([fold_of(q) == fold for q in place])
        for size in SIZES:
            chosen = may_teach & np.isin(labels.place, order[:size])
            matrix = heads.fit(projected, labels, chosen, DECAY, labels.row_copy < 2)
            told[size][here] = np.exp(heads.log_probabilities(projected[rows[here]], matrix))[:, 0]
    for size in SIZES:
        p, y = told[size][judged], is_grass[judged]
        low, high = scores.auc_bounds(p, y, place[judged])
        print(f'teacher from at most {size} places: AUC {scores.auc(p, y):.3f} [{low:.3f}, {high:.3f}], '
              f'calibration error {scores.calibration_error(p, y):.3f}, {judged.sum()} polygons', flush=True)


def without_part(part, shown, told, places, labelled_places):
    """Windows, answers and strength of the colour variation."""
    keep = np.ones(len(shown), bool)
    if part == 'without unlabelled places':
        keep = np.isin(places, labelled_places)
    if part == 'half the places':
        names = np.unique(places)
        keep = np.isin(places, np.random.default_rng(4).permutation(names)[:len(names) // 2])
    return shown[keep], told[keep], 0.0 if part == 'without colour variation' else 1.8


def students(options):
    everything = pictures.load_labelled(options.data)
    labelled_places = sorted({p.place for p in everything})
    rows = {part: [] for part in PARTS}
    for model in [f'fold{k}' for k in options.folds]:
        shown, told, places = windows.load_chunks(f'{options.work}/windows', options.windows, range(options.chunks), model)
        for part in PARTS:
            if part == 'without teacher':
                some = windows.labelled_windows(everything, model, 6000, 9)
                strength = 1.8
            else:
                *some, strength = without_part(part, shown, told, places, labelled_places)
            net = student.train(*some, options.steps, 1, strength=strength, name=f'{part}, {model}')
            path = f"{options.work}/students/ablation_{part.replace(' ', '_')}_{model}.pt"
            torch.save(net.state_dict(), path)
            rows[part] += judge(path, everything, lambda q: f'fold{fold_of(q)}' == model and is_drone(q))
    for part in PARTS:
        report(part, Judged(rows[part]))


def report(part, judged):
    """Calibrated on the same polygons: only the ranking and the parts' order count."""
    usable = judged.is_clear
    p, y = calibrated(judged, usable, platt(judged, usable)), judged.is_grass[usable]
    threshold = best_threshold(p, y)
    low, high = scores.auc_bounds(p, y, judged.place[usable])
    print(f'{part}: {usable.sum()} polygons of {len(set(judged.place[usable]))} places, AUC {scores.auc(p, y):.3f} '
          f'[{low:.3f}, {high:.3f}], found {scores.ratio(int((p[y] >= threshold).sum()), int(y.sum()))} at '
          f'{(p[~y] >= threshold).mean():.3f} of other ground', flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('what', choices=['places', 'student'])
    parser.add_argument('--data', default=os.environ.get('FREELSD_DATA'))
    parser.add_argument('--teacher', default=os.environ.get('FREELSD_TEACHER'))
    parser.add_argument('--work', required=True)
    parser.add_argument('--windows', default='a')
    parser.add_argument('--chunks', type=int, default=5)
    parser.add_argument('--steps', type=int, default=800)
    parser.add_argument('--folds', type=int, nargs='+', default=[0, 1])
    options = parser.parse_args()
    torch.set_num_threads(1)
    if options.what == 'places':
        curve(options)
    else:
        students(options)


if __name__ == '__main__':
    main()
