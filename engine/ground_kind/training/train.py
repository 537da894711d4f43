#!/usr/bin/env python3
"""Makes ground_kind.onnx, and the models that judge places left out, from FREELSD_DATA and FREELSD_TEACHER.

  train.py --work FOLDER [--models shipped fold0 ...] [--chunks N] [--steps N]

Every intermediate result is kept in the work folder: an interrupted run goes on where it was. README.md says more.
"""
import argparse
import json
import os
import sys

# Large tensors come and go: without this, half of the time goes into mapping fresh memory. Read at start only.
MALLOC = {'MALLOC_MMAP_THRESHOLD_': '4000000000', 'MALLOC_TRIM_THRESHOLD_': '8000000000', 'OMP_NUM_THREADS': '1'}
if any(os.environ.get(name) != value for name, value in MALLOC.items()):
    os.execve(sys.executable, [sys.executable] + sys.argv, {**os.environ, **MALLOC})

import cv2  # noqa: E402
import numpy as np  # noqa: E402
import torch  # noqa: E402

import export  # noqa: E402
import heads  # noqa: E402
import judge  # noqa: E402
import pictures  # noqa: E402
import seen_colours  # noqa: E402
import student  # noqa: E402
import windows  # noqa: E402
from labelled import Labelled  # noqa: E402
from split import FOLD_MODELS, MODELS  # noqa: E402
from teacher import Trunk  # noqa: E402

RENDERED_SHARE = 0.5    # of rendered windows with true kinds, beside all others


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--data', default=os.environ.get('FREELSD_DATA'), help='default: FREELSD_DATA')
    parser.add_argument('--teacher', default=os.environ.get('FREELSD_TEACHER'), help='default: FREELSD_TEACHER')
    parser.add_argument('--rendered', help='folder that freelsd-frames --pool tuning --pictures wrote; may be left out')
    parser.add_argument('--work', required=True, help='folder of intermediate results')
    parser.add_argument('--models', nargs='+', default=['shipped'] + FOLD_MODELS, choices=MODELS)
    parser.add_argument('--chunks', type=int, default=10, help='of 2000 unlabelled windows each')
    parser.add_argument('--steps', type=int, default=4000, help='of 32 windows each')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--round', default='a', help='name of this training in the work folder')
    parser.add_argument('--start', help='round whose networks the training starts from')
    parser.add_argument('--rate', type=float, default=3e-3)
    parser.add_argument('--decay', type=float, help='pull to zero of the teachers; else chosen by places left out')
    parser.add_argument('--strength', type=float, default=1.8, help='of the colour variation')
    parser.add_argument('--labelled', type=float, default=0.0, help='windows around labels for each of the teacher')
    parser.add_argument('--windows', default='a', help='name of the windows in the work folder')
    return parser.parse_args()


def teach_windows(options):
    """Labels -> teachers -> their answers on all chunks of windows."""
    folder = f'{options.work}/windows'
    os.makedirs(folder, exist_ok=True)
    if all(os.path.exists(f'{folder}/{options.windows}_{k:03d}.npz') for k in range(options.chunks)):
        return folder
    trunk = Trunk(options.teacher).eval().to(memory_format=torch.channels_last)
    everything = pictures.load(options.data, options.rendered)
    pictures.write_table(everything, f'{options.work}/table.csv')
    labelled = Labelled(trunk, everything, options.work)
    told = heads.fit_heads(labelled, heads.unlabelled_features(trunk, everything, options.work),
                           f'{options.work}/heads_{options.windows}.npz', options.decay)
    for number in range(options.chunks):
        windows.make_chunk(trunk, told, everything, number, folder, options.windows)
    return folder


def train_student(options, folder, model):
    path = f'{options.work}/students/{options.round}_{model}.pt'
    net = student.Student()
    if os.path.exists(path):
        net.load_state_dict(torch.load(path))
        return net.eval()
    shown, told, _ = windows.load_chunks(folder, options.windows, range(options.chunks), model)
    if options.labelled > 0:
        count = round(len(shown) * options.labelled)
        more = windows.labelled_windows(pictures.load_labelled(options.data), model, count, options.seed)
        shown, told = np.concatenate([shown, more[0]]), np.concatenate([told, more[1]])
    if model == 'shipped' and options.rendered:     # worlds judge it: their truth has more say than the teacher
        count = round(len(shown) * RENDERED_SHARE)
        more = windows.rendered_windows(list(pictures.rendered(options.rendered)), count, options.seed)
        shown, told = np.concatenate([shown, more[0]]), np.concatenate([told, more[1]])
    start = torch.load(f'{options.work}/students/{options.start}_{model}.pt') if options.start else None
    net = student.train(shown, told, options.steps, options.seed, start, options.rate,
                        strength=options.strength, name=f'{options.round} {model}')
    torch.save(net.state_dict(), path)
    return net


def describe(options, folder):
    """What the product must know beside the network; evaluate.py --calibrate adds the calibration."""
    shown, _, _ = windows.load_chunks(folder, options.windows, range(options.chunks), 'shipped')
    content = {'kinds': pictures.KINDS, 'metres_per_pixel': pictures.GROUND_SAMPLING_M, 'stride_px': 4,
               'input': {'order': 'BGR', 'offset': student.OFFSET, 'scale': student.SCALE, 'multiple_of_px': 16,
                         'border_px': judge.BORDER_PX, 'dark_luma': judge.DARK_LUMA,
                         'brightened_luma': judge.BRIGHTENED_LUMA, 'largest_gain': judge.LARGEST_GAIN},
               'colours': seen_colours.describe(shown, options.strength)}
    with open(f'{options.work}/folds/ground_kind.json', 'w') as file:
        json.dump(content, file, indent=2)
        file.write('\n')


def main():
    options = read_arguments()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    for name in ('students', 'folds'):
        os.makedirs(f'{options.work}/{name}', exist_ok=True)
    folder = teach_windows(options)
    frame = cv2.resize(pictures.read_picture(f'{options.data}/flights/swindale/images/IMG_1447.JPG'), export.FRAME_SIZE,
                       interpolation=cv2.INTER_AREA)
    for model in options.models:
        net = train_student(options, folder, model)
        name = 'ground_kind' if model == 'shipped' else model
        if model == 'shipped':
            describe(options, folder)
        print(export.export(net, f'{options.work}/folds/{name}.onnx', frame), flush=True)


if __name__ == '__main__':
    main()
