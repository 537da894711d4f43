"""The teacher: a pretrained SqueezeNet's view of the ground, and a logistic model of the ten kinds on top of it.

The trunk's weights are read from FREELSD_TEACHER/compressed_SqueezeNet.net (ImageNet, BSD licence). Nothing of it is
shipped: the student learns only the probabilities that come out here.
"""
import os

import cv2
import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

from colours import vary
from pictures import KINDS

MEAN_BGR = np.array([104, 117, 123], np.float32)
FIRES = [(96, 16, 64), (128, 16, 64), (128, 32, 128), (256, 32, 128), (256, 48, 192), (384, 48, 192), (384, 64, 256),
         (512, 64, 256)]        # inputs, squeezed, expanded (twice)
NUM_FINE, NUM_DEEP = 256, 512   # channels after the third fire module (fire4) and the seventh (fire8)
NUM_FEATURES = NUM_FINE + NUM_DEEP
CELL_PX = 8
MAX_ROWS_A_COPY = 6


def layer_shapes():
    shapes = [(96, 3, 7, 7)]
    for inputs, squeezed, expanded in FIRES:
        shapes += [(squeezed, inputs, 1, 1), (expanded, squeezed, 1, 1), (expanded, squeezed, 3, 3)]
    return shapes + [(1000, 512, 1, 1)]


def read_weights(path):
    """The file: non-zero counts of all layers; then by layer a code book of 256 floats, the biases, one code byte and
    one 4-bit step to the next place per non-zero weight. Returns (weight, bias) by layer."""
    data = np.fromfile(path, np.uint8)
    shapes, position = layer_shapes(), 0

    def take(dtype, count):
        nonlocal position
        size = np.dtype(dtype).itemsize * count
        out = data[position:position + size].view(dtype)
        position += size
        return out

    counts = take(np.uint32, len(shapes)).copy()
    layers = []
    for shape, count in zip(shapes, counts.astype(int)):
        book, bias, codes = take(np.float32, 256).copy(), take(np.float32, shape[0]).copy(), take(np.uint8, count)
        packed = take(np.uint8, (count + 1) // 2)
        steps = np.stack([packed % 16, packed // 16], 1).reshape(-1)[:count].astype(np.int64) + 1
        dense = np.zeros(int(np.prod(shape)), np.uint8)
        dense[np.cumsum(steps) - 1] = codes
        layers.append((book[dense].reshape(shape), bias))
    if position != len(data):
        raise ValueError(f'{path}: {len(data)} bytes, expected {position}')
    return layers


class Fire(nn.Module):
    def __init__(self, inputs, squeezed, expanded):
        super().__init__()
        self.squeeze = nn.Conv2d(inputs, squeezed, 1)
        self.narrow = nn.Conv2d(squeezed, expanded, 1)
        self.wide = nn.Conv2d(squeezed, expanded, 3, padding=1)

    def forward(self, x):
        x = F.relu(self.squeeze(x))
        return F.relu(torch.cat([self.narrow(x), self.wide(x)], 1))


class Trunk(nn.Module):
    """SqueezeNet 1.0 up to fire8. forward: BGR 0..255 (n, 3, h, w) -> features (n, 768, h / 8, w / 8)."""

    def __init__(self, folder):
        super().__init__()
        self.first = nn.Conv2d(3, 96, 7, stride=2, padding=3)
        self.fires = nn.ModuleList([Fire(*f) for f in FIRES[:7]])
        convolutions = [self.first] + [c for f in self.fires for c in (f.squeeze, f.narrow, f.wide)]
        for convolution, (weight, bias) in zip(convolutions, read_weights(f'{folder}/compressed_SqueezeNet.net')):
            convolution.weight.data.copy_(torch.from_numpy(weight))
            convolution.bias.data.copy_(torch.from_numpy(bias))
        self.register_buffer('mean', torch.from_numpy(MEAN_BGR).reshape(1, 3, 1, 1))

    def forward(self, x):
        x = F.max_pool2d(F.relu(self.first(x - self.mean)), 3, 2, ceil_mode=True)
        for fire in self.fires[:3]:
            x = fire(x)
        fine = F.avg_pool2d(torch.sqrt(x), 2)
        x = F.max_pool2d(x, 3, 2, ceil_mode=True)
        for fire in self.fires[3:]:
            x = fire(x)
        return torch.cat([fine, torch.sqrt(x)[..., :fine.shape[2], :fine.shape[3]]], 1)


def around(features):
    """Each cell's mean with its eight neighbours."""
    return F.avg_pool2d(F.pad(features, (1, 1, 1, 1), mode='replicate'), 3, 1)


def features_of(trunk, image):
    """(768, rows, columns) of one picture, BGR 8 bit; the picture's border is continued by reflection."""
    height, width = image.shape[:2]
    bottom, right = -height % 16 + 16, -width % 16 + 16
    image = cv2.copyMakeBorder(image, 16, bottom, 16, right, cv2.BORDER_REFLECT_101)
    x = torch.from_numpy(image.astype(np.float32).transpose(2, 0, 1)[None].copy())
    with torch.no_grad(), torch.cpu.amp.autocast():    # 16 bits: twice as fast, 0.7 % off
        out = trunk(x.contiguous(memory_format=torch.channels_last)).float()
    return out[:, :, 2:-2, 2:-2]


def labelled_part(picture, margin_px=48):
    """Image and regions of the box that holds all polygons, with a margin."""
    rows, columns = np.nonzero(picture.region)
    part = (slice(max(0, rows.min() - margin_px), rows.max() + margin_px),
            slice(max(0, columns.min() - margin_px), columns.max() + margin_px))
    return picture.image[part], picture.region[part]


def polygon_rows(trunk, picture, copy, rng):
    """Features of each polygon of one copy of a picture: its mean, then some single cells (with neighbours).
    Returns (polygon index, copy, row 0 mean or 1 cell, features). Copy 0 is the picture as it is."""
    image, region = labelled_part(picture)
    if copy > 0:
        scale = np.exp(rng.uniform(np.log(0.75), np.log(1.35)))
        size = (max(24, round(image.shape[1] * scale)), max(24, round(image.shape[0] * scale)))
        image = vary(cv2.resize(image, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR), rng,
                     [1.0, 1.8][copy % 2])
        region = cv2.resize(region, size, interpolation=cv2.INTER_NEAREST)
        if copy % 2 == 0:
            image, region = image[:, ::-1], region[:, ::-1]
    features = features_of(trunk, np.ascontiguousarray(image))
    smooth = around(features)[0].numpy()
    features = features[0].numpy()
    rows, columns = features.shape[1:]
    padded = np.zeros((rows * CELL_PX, columns * CELL_PX), np.float32)
    out = []
    for index in range(len(picture.polygons)):
        padded[:] = 0
        inside = (region == index + 1)[:rows * CELL_PX, :columns * CELL_PX]
        padded[:inside.shape[0], :inside.shape[1]] = inside
        share = padded.reshape(rows, CELL_PX, columns, CELL_PX).mean((1, 3))
        if share.sum() == 0:
            continue
        out.append((index, copy, 0, (features * share).sum((1, 2)) / share.sum()))
        cells = np.argwhere(share > min(0.6, 0.8 * share.max()))
        for row, column in rng.permutation(cells)[:MAX_ROWS_A_COPY - 1]:
            out.append((index, copy, 1, smooth[:, row, column]))
    return out


class Basis:
    """Principal components of the features: of fire4 and of fire8 each, over the fourth root of their variance."""

    def __init__(self, features, num_fine=48, num_deep=80):
        mean, spread = features.mean(0), features.std(0)
        spread = spread + 0.05 * spread.mean() + 1e-3
        z = (features - mean) / spread
        parts = []
        for low, high, count in [(0, NUM_FINE, num_fine), (NUM_FINE, NUM_FEATURES, num_deep)]:
            variance, axes = np.linalg.eigh((z[:, low:high].T @ z[:, low:high]).astype(np.float64) / len(z))
            variance, axes = variance[::-1][:count], axes[:, ::-1][:, :count]
            part = np.zeros((NUM_FEATURES, count))
            part[low:high] = axes / variance ** 0.25 / np.sqrt((variance ** 0.5).mean())
            parts.append(part)
        axes = np.hstack(parts) / spread[:, None]
        self.axes, self.offset = axes.astype(np.float32), (mean @ axes).astype(np.float32)

    def project(self, features):
        return features @ self.axes - self.offset


def fit_logistic(x, allowed, weight, decay, iterations=50):
    """Multinomial logistic model with partial labels. x: (n, d); allowed: (n, kinds) 0/1; returns (d + 1, kinds)."""
    x, weight = torch.from_numpy(x.astype(np.float32)), torch.from_numpy((weight / weight.sum()).astype(np.float32))
    log_allowed = torch.log(torch.from_numpy(allowed.astype(np.float32)) + 1e-9)
    matrix = torch.zeros(x.shape[1] + 1, len(KINDS), requires_grad=True)
    optimiser = torch.optim.LBFGS([matrix], max_iter=iterations, history_size=10, line_search_fn='strong_wolfe')

    def loss():
        optimiser.zero_grad()
        log_p = torch.log_softmax(x @ matrix[:-1] + matrix[-1], 1)
        value = -(torch.logsumexp(log_p + log_allowed, 1) * weight).sum() + decay * (matrix[:-1] ** 2).sum()
        value.backward()
        return value

    optimiser.step(loss)
    return matrix.detach().numpy()
