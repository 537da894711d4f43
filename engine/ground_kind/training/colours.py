"""What another camera, another day or another file would do to the same ground: colour, haze, blur, noise, JPEG."""
import cv2
import numpy as np

AIR = np.array([0.75, 0.72, 0.70], np.float32)        # BGR of haze
LUMA = np.array([0.114, 0.587, 0.299], np.float32)    # of BGR


def vary_colours(x, rng, strength):
    """x: BGR 0..1, float."""
    if rng.random() < 0.85:     # white balance and exposure, per channel
        gain = rng.normal(0, 0.30 * strength) + rng.normal(0, 0.10 * strength, 3)
        x = x * np.exp(gain).astype(np.float32)
    if rng.random() < 0.8:
        saturation = np.float32(max(0.0, rng.uniform(1 - 0.6 * strength, 1 + 0.5 * strength)))
        grey = (x @ LUMA)[..., None]
        x = grey + (x - grey) * saturation
    if rng.random() < 0.3:      # hue turned by a few degrees
        turn = np.float32(rng.normal(0, 0.08 * strength))
        x = x + turn * (x[..., [1, 2, 0]] - x[..., [2, 0, 1]])
    if rng.random() < 0.5:
        x = np.clip(x, 0, 1) ** np.float32(np.exp(rng.normal(0, 0.25 * strength)))
    if rng.random() < 0.3:
        clear = np.float32(rng.uniform(1 - 0.35 * strength, 1))
        x = x * clear + AIR * np.float32(rng.uniform(0.7, 1.1)) * (1 - clear)
    return x


def vary_sharpness(x, rng):
    what = rng.random()
    if what < 0.4:
        x = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.3, 1.3))
    elif what < 0.5:
        x = 1.6 * x - 0.6 * cv2.GaussianBlur(x, (0, 0), 1.0)
    if rng.random() < 0.4:
        x = x + rng.standard_normal(x.shape, dtype=np.float32) * np.float32(rng.uniform(0.005, 0.04))
    return x


def vary(image, rng, strength):
    """image: BGR, 8 bit. strength 1: other days of one camera; 1.8: other cameras."""
    x = vary_sharpness(vary_colours(image.astype(np.float32) / 255, rng, strength), rng)
    out = (np.clip(x, 0, 1) * 255).astype(np.uint8)
    if rng.random() < 0.3:
        out = cv2.imdecode(cv2.imencode('.jpg', out, [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(30, 90))])[1], 1)
    return out
