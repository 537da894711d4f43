"""Writes a student as ONNX for OpenCV 4.6's dnn and checks that OpenCV gives what torch gives."""
import os
import time

import cv2
import numpy as np
import torch

from student import OFFSET, SCALE

FRAME_SIZE = (752, 480)      # width, height of the frame that is timed
LARGEST_DIFFERENCE = 2e-3    # of a logit


def check(net, path, image):
    """Greatest difference of a logit between torch and OpenCV, and the least milliseconds of one thread."""
    x = (image.astype(np.float32).transpose(2, 0, 1)[None] - OFFSET) / SCALE
    with torch.no_grad():
        expected = net(torch.from_numpy(x)).numpy()
    read = cv2.dnn.readNetFromONNX(path)
    blob = cv2.dnn.blobFromImage(image, 1 / SCALE, mean=(OFFSET,) * 3)
    times = []
    for _ in range(8):
        started = time.process_time()
        read.setInput(blob)
        out = read.forward()
        times.append(1000 * (time.process_time() - started))
    return float(np.abs(out - expected).max()), min(times), out.shape


def export(net, path, image):
    """image: BGR, 8 bit, of FRAME_SIZE. Returns a line of figures."""
    net = net.eval().to(memory_format=torch.contiguous_format)
    x = torch.zeros(1, 3, FRAME_SIZE[1], FRAME_SIZE[0])
    torch.onnx.export(net, x, path, opset_version=11, input_names=['image'], output_names=['logits'])
    difference, milliseconds, shape = check(net, path, image)
    if difference > LARGEST_DIFFERENCE:
        raise RuntimeError(f'{path}: OpenCV differs from torch by {difference}')
    parameters = sum(p.numel() for p in net.parameters())
    return (f'{os.path.basename(path)}: {parameters} parameters, {os.path.getsize(path) / 1e3:.0f} kB, output {shape}, '
            f'greatest difference to torch {difference:.1e}, {milliseconds:.0f} ms of one thread for '
            f'{FRAME_SIZE[0]}x{FRAME_SIZE[1]}')
