"""A teacher for each model: a logistic model on the trunk's principal components, from the labels that may teach it."""
import os

import numpy as np

import windows
from pictures import KINDS
from split import MODELS, NUM_FOLDS, fold_of, labels_teach, places_for, polygon_weights
from teacher import Basis, around, fit_logistic

DECAYS = [3e-3, 1e-2]
BASELINE_DECAY = 3e-3     # three places: no fourth to choose it by
NUM_BASIS_WINDOWS, CELLS_A_WINDOW = 900, 16


def unlabelled_features(trunk, pictures, work):
    """Features of some cells of unlabelled windows, with their places: what the components are computed from."""
    path = f'{work}/basis.npz'
    if not os.path.exists(path):
        drawn, places = windows.draw_windows(pictures, NUM_BASIS_WINDOWS, 77)
        rng, rows = np.random.default_rng(77), []
        for k in range(0, len(drawn), windows.BATCH):
            features = around(windows.trunk_features(trunk, drawn[k:k + windows.BATCH])).permute(0, 2, 3, 1)
            cells = features.reshape(len(features), -1, features.shape[-1]).numpy()
            rows += [c[rng.choice(len(c), CELLS_A_WINDOW, replace=False)] for c in cells]
        np.savez(path, features=np.concatenate(rows).astype(np.float16), places=np.repeat(places, CELLS_A_WINDOW))
    with np.load(path) as file:
        return file['features'].astype(np.float32), file['places']


class Labels:
    """What the logistic fit needs of the labelled polygons."""

    def __init__(self, labelled):
        kinds = [polygon.kinds for _, polygon in labelled.polygons]
        self.kinds, self.place = kinds, labelled.place_of_polygon
        self.allowed = np.array([[k in set_ for k in KINDS] for set_ in kinds], np.float32)
        self.row_polygon, self.row_copy, self.row_is_cell = labelled.polygon, labelled.copy, labelled.is_cell
        self.rows_of_polygon = np.bincount(labelled.polygon, minlength=len(kinds))
        self.is_clean_mean = (labelled.copy == 0) & (labelled.is_cell == 0)

    def row_weights(self, polygon_mask):
        weight = np.zeros(len(self.kinds))
        chosen = np.flatnonzero(polygon_mask)
        weight[chosen] = polygon_weights(self.place[chosen], [self.kinds[i] for i in chosen])
        return (weight / np.maximum(self.rows_of_polygon, 1))[self.row_polygon]


def fit(x, labels, polygon_mask, decay, row_mask=None):
    weight = labels.row_weights(polygon_mask)
    if row_mask is not None:
        weight = weight * row_mask
    use = weight > 0
    return fit_logistic(x[use], labels.allowed[labels.row_polygon[use]], weight[use], decay)


def log_probabilities(x, matrix):
    logits = x @ matrix[:-1] + matrix[-1]
    logits = logits - logits.max(1, keepdims=True)
    return logits - np.log(np.exp(logits).sum(1, keepdims=True))


def choose_decay(x, labels, may_teach, folds):
    """The decay whose logistic models, each fitted without one fold, find that fold's clean polygons most likely.
    Only polygons that may teach are looked at: the choice for a fold's model never sees that fold."""
    told = []
    fold = np.array([fold_of(p) for p in labels.place])
    for decay in DECAYS:
        loss = total = 0.0
        for left_out in folds:
            matrix = fit(x, labels, may_teach & (fold != left_out), decay, labels.row_copy < 2)
            judged = labels.is_clean_mean & (may_teach & (fold == left_out))[labels.row_polygon]
            weight = labels.row_weights(may_teach & (fold == left_out))[judged]
            log_p = log_probabilities(x[judged], matrix)
            right = np.log((np.exp(log_p) * labels.allowed[labels.row_polygon[judged]]).sum(1) + 1e-9)
            loss, total = loss - (weight * right).sum(), total + weight.sum()
        told.append(loss / total)
    return DECAYS[int(np.argmin(told))], told


def fit_heads(labelled, unlabelled, path, decay_of_all=None):
    """model -> (axes, offset): logits of the kinds = features @ axes + offset. Kept in the file."""
    features, places = unlabelled
    labels = Labels(labelled)
    heads = {}
    if os.path.exists(path):
        with np.load(path) as file:
            return {m: (file[m + '_axes'], file[m + '_offset']) for m in MODELS}
    everything = labelled.features.astype(np.float32)
    for model in MODELS:
        basis = Basis(features[places_for(places, model)])
        x = basis.project(everything)
        may_teach = places_for(labels.place, model, labels_teach)
        folds = [k for k in range(NUM_FOLDS) if f'fold{k}' != model]
        decay, told = decay_of_all or BASELINE_DECAY, []
        if decay_of_all is None and model != 'baseline':
            decay, told = choose_decay(x, labels, may_teach, folds)
        matrix = fit(x, labels, may_teach, decay)
        print(f'teacher of {model}: {may_teach.sum()} polygons of {len(set(labels.place[may_teach]))} places, decay {decay}'
              f' {np.round(told, 4)}', flush=True)
        heads[model] = (basis.axes @ matrix[:-1], matrix[-1] - basis.offset @ matrix[:-1])
    np.savez(path, **{f'{m}_{name}': value for m, pair in heads.items() for name, value in zip(('axes', 'offset'), pair)})
    return heads
