"""What a student says of the polygons of whole pictures, as the product would ask it."""
import os

import numpy as np
import torch

from pictures import KINDS
from split import fold_of
from student import OFFSET, SCALE, Student

BORDER_PX = 24          # continued by reflection: the padding of the network's own layers spoils the border
STRIDE_PX = 4
CELLS_A_POLYGON = 24


DARK_LUMA, BRIGHTENED_LUMA, LARGEST_GAIN = 76.0, 102.0, 5.0      # of 255


def brightened(image):
    """A picture darker than the training's pictures are, multiplied; others as they are. Mean luma is that of every
    fourth row and column."""
    luma = float((image[::4, ::4].reshape(-1, 3) @ np.array([0.114, 0.587, 0.299])).mean())
    if luma >= DARK_LUMA:
        return image
    gain = min(BRIGHTENED_LUMA / max(luma, 1.0), LARGEST_GAIN)
    return np.clip(image * gain, 0, 255).astype(np.uint8)


def padded(image):
    """The picture with a reflected border, its size a multiple of 16."""
    height, width = image.shape[:2]
    bottom, right = BORDER_PX + -(height + 2 * BORDER_PX) % 16, BORDER_PX + -(width + 2 * BORDER_PX) % 16
    mode = 'reflect' if min(height, width) > BORDER_PX + 16 else 'symmetric'
    return np.pad(image, ((BORDER_PX, bottom), (BORDER_PX, right), (0, 0)), mode=mode)


def probabilities(net, image):
    """(kinds, rows, columns) at a quarter of the picture's size. image: BGR at 0.2 m."""
    x = (padded(brightened(image)).astype(np.float32).transpose(2, 0, 1)[None] - OFFSET) / SCALE
    with torch.no_grad():
        p = torch.softmax(net(torch.from_numpy(x)), 1)[0].numpy()
    first = BORDER_PX // STRIDE_PX
    rows, columns = -(-image.shape[0] // STRIDE_PX), -(-image.shape[1] // STRIDE_PX)
    return p[:, first:first + rows, first:first + columns]


def judge_picture(net, picture, rng):
    """By polygon: mean probabilities, logits of grass of some cells (padded with NaN)."""
    p = probabilities(net, picture.image)
    means, cells = [], []
    for index in range(len(picture.polygons)):
        rows, columns = np.nonzero(picture.region == index + 1)
        if len(rows) == 0:
            means.append(np.full(len(KINDS), np.nan))
            cells.append(np.full(CELLS_A_POLYGON, np.nan))
            continue
        of_pixels = p[:, rows // STRIDE_PX, columns // STRIDE_PX]
        means.append(of_pixels.mean(1))
        grass = np.clip(rng.choice(of_pixels[0], CELLS_A_POLYGON), 1e-6, 1 - 1e-6)
        cells.append(np.log(grass / (1 - grass)))
    return np.array(means), np.array(cells)


class Judged:
    """One row per polygon: place, pack, picture, polygon, kinds, mean (n, 10), cells (n, 24)."""

    def __init__(self, rows):
        self.place, self.pack, self.picture, self.polygon, self.kinds, mean, cells = zip(*rows)
        self.place, self.mean, self.cells = np.array(self.place), np.array(mean), np.array(cells)
        self.is_grass = np.array([k == frozenset(['grass']) for k in self.kinds])
        self.is_clear = np.array(['grass' not in k or len(k) == 1 for k in self.kinds]) & ~np.isnan(self.mean[:, 0])
        self.fold = np.array([fold_of(p) for p in self.place])


def load_student(path):
    net = Student()
    net.load_state_dict(torch.load(path))
    return net.eval()


def judge(path, pictures, is_judged):
    """Rows of all polygons of the pictures whose place is judged."""
    net, rng, rows = load_student(path), np.random.default_rng(0), []
    for picture in pictures:
        if picture.polygons and is_judged(picture.place):
            means, cells = judge_picture(net, picture, rng)
            rows += [(picture.place, picture.pack, picture.name, polygon.name, polygon.kinds, mean, cell)
                     for polygon, mean, cell in zip(picture.polygons, means, cells)]
    return rows


def student_path(work, name, model):
    return os.path.join(work, 'students', f'{name}_{model}.pt')
