"""The network that is shipped: small, fully convolutional, taught by the teacher's probabilities."""
import copy
import time

import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

from colours import vary
from pictures import KINDS

OFFSET, SCALE = 110.0, 60.0    # input: (BGR - 110) / 60


def block(inputs, outputs, size=3, stride=1, dilation=1):
    padding = dilation * (size // 2)
    return nn.Sequential(nn.Conv2d(inputs, outputs, size, stride, padding, dilation, bias=False), nn.BatchNorm2d(outputs),
                         nn.ReLU(inplace=True))


class Student(nn.Module):
    """(n, 3, h, w) -> logits (n, kinds, h / 4, w / 4); h and w are multiples of 16. Field of view 119 px, 23.8 m at 0.2 m."""

    def __init__(self, stem=16, fine=32, width=64, mixed=96, dilations=(1, 2, 3)):
        super().__init__()
        self.stem = nn.Sequential(block(3, stem, 3, 2), block(stem, fine, 3, 2))
        self.fine = block(fine, fine)
        self.down = block(fine, width, 3, 2)
        self.body = nn.ModuleList([block(width, width, 3, 1, d) for d in dilations])
        self.mix = block(2 * width, mixed, 1)
        self.kinds = nn.Conv2d(mixed, len(KINDS), 1)

    def coarse(self, x):
        """Logits at stride 8, where the teacher speaks."""
        x = self.stem(x)
        x = near = self.down(x + self.fine(x))
        for layer in self.body:
            x = x + layer(x)
        return self.kinds(self.mix(torch.cat([near, x], 1)))

    def forward(self, x):
        return F.interpolate(self.coarse(x), scale_factor=2, mode='bilinear', align_corners=False)


def turned(x, how):
    """One of the eight turns and mirrorings of the last two axes."""
    x = np.rot90(x, how % 4, axes=(-2, -1))
    return x[..., ::-1] if how >= 4 else x


def draw_batch(windows, told, size, strength, rng):
    """Half of the windows is varied by up to `strength`, a third mildly, the rest is as it was."""
    images, targets = [], []
    for index in rng.integers(len(windows), size=size):
        chance, how = rng.random(), int(rng.integers(8))
        window = windows[index]
        if strength > 0 and chance < 0.85:
            window = vary(window, rng, strength if chance < 0.5 else 0.55 * strength)
        images.append(turned(window.transpose(2, 0, 1), how))
        targets.append(turned(told[index], how))
    x = (torch.from_numpy(np.stack(images).astype(np.float32)) - OFFSET) / SCALE
    return x.contiguous(memory_format=torch.channels_last), torch.from_numpy(np.stack(targets).astype(np.float32))


def divergence(logits, log_target):
    """Kullback-Leibler from the teacher, by window; the border cells are left out: the window ends there. Cells
    without a target (NaN) do not count."""
    has_target = ~torch.isnan(log_target[:, 0])
    log_target = torch.log_softmax(torch.nan_to_num(log_target), 1)
    cell = (log_target.exp() * (log_target - torch.log_softmax(logits, 1))).sum(1) * has_target
    return cell[:, 1:-1, 1:-1].sum((1, 2)) / has_target[:, 1:-1, 1:-1].sum((1, 2)).clamp(min=1)


def follow(average, net, rate):
    with torch.no_grad():
        for slow, fast in zip(average.state_dict().values(), net.state_dict().values()):
            if slow.dtype.is_floating_point:
                slow.lerp_(fast, rate)
            else:
                slow.copy_(fast)


def train(windows, told, steps, seed, start=None, rate=3e-3, batch=32, strength=1.8, name=''):
    """Returns the running mean of the weights over the last hundreds of steps."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    net = Student()
    if start is not None:
        net.load_state_dict(start)
    net.train().to(memory_format=torch.channels_last)
    average = copy.deepcopy(net)
    optimiser = torch.optim.AdamW(net.parameters(), rate, weight_decay=1e-2)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps, pct_start=0.1)
    started, recent = time.time(), []
    for step in range(1, steps + 1):
        x, target = draw_batch(windows, told, batch, strength, rng)
        with torch.cpu.amp.autocast():
            logits = net.coarse(x)
        loss = divergence(logits.float(), target).mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        follow(average, net, max(0.005, 1 / step))
        recent.append(float(loss))
        if step % 100 == 0:
            print(f'{name} step {step} of {steps}: divergence {np.mean(recent[-100:]):.3f}, '
                  f'{time.time() - started:.0f} s', flush=True)
    return average.eval()
