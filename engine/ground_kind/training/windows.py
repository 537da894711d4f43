"""Unlabelled windows of 128 pixels at about 0.2 m, and what the teacher of each model says of them.

Chunks of windows are kept in the work folder. The trunk sees a window once for all models; a model's own teacher is
a linear map of the trunk's features. A window of a place that may not teach a model has no answer for that model.
"""
import os
import time
import zlib

import cv2
import numpy as np
import torch

from colours import vary
from pictures import KINDS
from split import KIND_SHARE, MODELS, PLACES, is_drone, teaches
from teacher import around

WINDOW_PX = 128
CHUNK = 2000
BATCH = 16
CELLS = WINDOW_PX // 8
POLYGONS_OF_A_FULL_KIND, SATELLITE_PLACE = 4, 0.15     # weight of a place among those that show a kind
DOUBT = 0.05                # share of a label's answer that the other kinds keep
MAX_BLACK = 0.25            # share of a window outside an orthophoto
# Windows of a chunk by place: flights and big places by hand, the others by the root of their area.
SHARE = {'swindale': 150, 'garfield_park': 130, 'brighton_beach': 90, 'snowpeak_ebee': 130, 'cmac_au': 90, 'stubble_bales': 40,
         'copr_dunes': 25, 'honduras_pool': 50, 'painted_worlds': 60, 'textured_worlds': 60, 'ground_worlds': 40}
SATELLITE_SHARE = {'rsscn7': 620, 'vegas_sn2': 30}


def shares(pictures):
    """(place, weight) of every place that may teach some model."""
    area, views = {}, {}
    for p in pictures:
        if PLACES[p.place]['teaches'] != 'none':
            area[p.place] = area.get(p.place, 0) + p.image.shape[0] * p.image.shape[1]
            views[p.place] = PLACES[p.place]['pack']
    weight = {place: float(SHARE.get(place, np.clip(np.sqrt(a) / 35, 4, 25))) for place, a in area.items()}
    for pack, total in SATELLITE_SHARE.items():
        here = [place for place in area if views[place] == pack]
        whole = sum(np.sqrt(area[place]) for place in here)
        weight.update({place: total * np.sqrt(area[place]) / whole for place in here})
    return weight


def draw_window(image, rng, truth=None):
    """A window; with the truth of each pixel also that of each cell's centre."""
    height, width = image.shape[:2]
    smallest = np.clip(90 / min(height, width), 0.7, 2.0)    # small pictures are enlarged, not mirrored all over
    scale = smallest * np.exp(rng.uniform(0, np.log(2.0)))
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) * scale
    reach = 0.4 * WINDOW_PX / scale
    x = rng.uniform(min(reach, width / 2), max(width - reach, width / 2))
    y = rng.uniform(min(reach, height / 2), max(height - reach, height / 2))
    shift = WINDOW_PX / 2 - turn @ np.array([x, y])
    move, size = np.hstack([turn, shift[:, None]]), (WINDOW_PX, WINDOW_PX)
    window = cv2.warpAffine(image, move, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
    if truth is None:
        return window
    warped = cv2.warpAffine(truth, move, size, flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_REFLECT_101)
    return window, warped[4::8, 4::8]


def rendered_windows(pictures, count, seed):
    """Windows of rendered frames; the answer is the true kind (0.98), NaN where a cell has none."""
    rng = np.random.default_rng(seed)
    windows, told = [], np.full((count, len(KINDS), CELLS, CELLS), np.nan, np.float16)
    for k in range(count):
        picture = pictures[rng.integers(len(pictures))]
        window, truth = draw_window(picture.image, rng, picture.truth)
        windows.append(window)
        for kind in np.unique(truth[truth < len(KINDS)]):
            answer = np.full((len(KINDS), 1), np.log(0.02 / (len(KINDS) - 1)))
            answer[kind] = np.log(0.98)
            told[k][:, truth == kind] = answer
    return np.stack(windows), told


def polygons_by_kind(pictures, model):
    """kind -> place -> (picture, polygon number): polygons of a single kind that may teach the model."""
    found = {}
    for picture in pictures:
        if teaches(picture.place, model):
            for number, polygon in enumerate(picture.polygons, 1):
                if len(polygon.kinds) == 1:
                    of_kind = found.setdefault(next(iter(polygon.kinds)), {})
                    of_kind.setdefault(picture.place, []).append((picture, number))
    return found


def draw_labelled_window(picture, number, rng):
    """A window that shows a part of the polygon, and the polygon of each cell's centre (0: none)."""
    points = np.argwhere(picture.region == number)
    point = points[rng.integers(len(points))][::-1]
    scale, angle = np.exp(rng.uniform(np.log(0.75), np.log(1.4))), rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) * scale
    shift = WINDOW_PX / 2 + rng.uniform(-30, 30, 2) - turn @ point
    move, size = np.hstack([turn, shift[:, None]]), (WINDOW_PX, WINDOW_PX)
    window = cv2.warpAffine(picture.image, move, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
    region = cv2.warpAffine(picture.region, move, size, flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_REFLECT_101)
    return window, region[4::8, 4::8]


def labelled_windows(pictures, model, count, seed):
    """Windows around labelled polygons by kind (KIND_SHARE), place, polygon. The answer: the label's kinds share 0.95;
    NaN where nothing is labelled."""
    rng, found = np.random.default_rng(seed), polygons_by_kind(pictures, model)
    kinds = [kind for kind in KIND_SHARE if kind in found]
    share = np.array([KIND_SHARE[kind] for kind in kinds])
    shown = np.zeros((count, WINDOW_PX, WINDOW_PX, 3), np.uint8)
    told = np.full((count, len(KINDS), CELLS, CELLS), np.nan, np.float16)
    for k in range(count):
        of_kind = found[kinds[rng.choice(len(kinds), p=share / share.sum())]]
        places = sorted(of_kind)
        weight = np.array([min(1, len(of_kind[p]) / POLYGONS_OF_A_FULL_KIND) * (1 if is_drone(p) else SATELLITE_PLACE)
                           for p in places])
        here = of_kind[places[rng.choice(len(places), p=weight / weight.sum())]]
        picture, number = here[rng.integers(len(here))]
        if not (picture.region == number).any():     # drawn over by a later polygon
            continue
        shown[k], cells = draw_labelled_window(picture, number, rng)
        for other in np.unique(cells[cells > 0]):
            allowed = np.array([kind in picture.polygons[other - 1].kinds for kind in KINDS])
            answer = np.where(allowed, (1 - DOUBT) / allowed.sum(), DOUBT / (~allowed).sum())
            told[k][:, cells == other] = np.log(answer)[:, None]
    return shown, told


def draw_windows(pictures, count, seed):
    """Windows (count, 128, 128, 3) and their places."""
    rng = np.random.default_rng(seed)
    weight = shares(pictures)
    places = sorted(weight)
    chance = np.array([weight[p] for p in places])
    by_place = {place: [p for p in pictures if p.place == place] for place in places}
    windows, names = [], []
    while len(windows) < count:
        place = places[rng.choice(len(places), p=chance / chance.sum())]
        root = np.sqrt([p.image.shape[0] * p.image.shape[1] for p in by_place[place]])
        window = draw_window(by_place[place][rng.choice(len(root), p=root / root.sum())].image, rng)
        if (window.max(2) < 6).mean() <= MAX_BLACK:
            windows.append(window)
            names.append(place)
    return np.stack(windows), np.array(names)


def trunk_features(trunk, windows):
    x = torch.from_numpy(windows.astype(np.float32).transpose(0, 3, 1, 2).copy())
    with torch.no_grad(), torch.cpu.amp.autocast():    # 16 bits: twice as fast, 0.7 % off
        return trunk(x.contiguous(memory_format=torch.channels_last)).float()


def copies_of(windows, rng):
    """Two views of each window: as it is; turned by half and varied. With the way back."""
    yield windows, lambda p: p
    yield np.stack([vary(w, rng, 1.4) for w in windows[:, ::-1, ::-1]]), lambda p: p[..., ::-1, ::-1]


def answers(trunk, heads, windows, rng):
    """Mean log probabilities over the copies, by model: (models, n, kinds, 16, 16). heads: model -> (axes, offset)."""
    axes = np.concatenate([heads[m][0] for m in MODELS], 1)
    offset = np.concatenate([heads[m][1] for m in MODELS])
    total = 0
    for copy, back in copies_of(windows, rng):
        features = around(trunk_features(trunk, copy)).permute(0, 2, 3, 1).reshape(-1, axes.shape[0]).numpy()
        logits = (features @ axes + offset).reshape(len(windows), CELLS, CELLS, len(MODELS), len(KINDS))
        log_p = logits - np.log(np.exp(logits - logits.max(-1, keepdims=True)).sum(-1, keepdims=True)) - logits.max(
            -1, keepdims=True)
        total = total + back(log_p.transpose(3, 0, 4, 1, 2))
    return total / 2


def make_chunk(trunk, heads, pictures, number, folder, tag):
    """Draws chunk `number` and asks the teachers, unless the work folder has it."""
    path = f'{folder}/{tag}_{number:03d}'
    if os.path.exists(path + '.npz'):
        return
    started = time.time()
    seed = zlib.crc32(tag.encode()) % 100000 + number
    windows, places = draw_windows(pictures, CHUNK, seed)
    rng = np.random.default_rng([seed, 1])
    told = np.zeros((len(MODELS), CHUNK, len(KINDS), CELLS, CELLS), np.float16)
    for k in range(0, CHUNK, BATCH):
        told[:, k:k + BATCH] = answers(trunk, heads, windows[k:k + BATCH], rng)
    np.savez(path + '.part.npz', windows=windows, places=places, told=told)
    os.rename(path + '.part.npz', path + '.npz')
    print(f'{tag} windows {number}: {time.time() - started:.0f} s', flush=True)


def load_chunks(folder, tag, numbers, model):
    """Windows, answers and places of all chunks that may teach the model, joined."""
    parts = []
    for number in numbers:
        with np.load(f'{folder}/{tag}_{number:03d}.npz') as file:
            places = file['places']
            mine = np.array([teaches(place, model) for place in places])
            parts.append((file['windows'][mine], file['told'][MODELS.index(model)][mine], places[mine]))
    return [np.concatenate(column) for column in zip(*parts)]
