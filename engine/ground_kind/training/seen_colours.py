"""How the colours of the training's windows lie, so that the product can say "not sure" outside of them."""
import numpy as np

from colours import vary

NAMES = ['mean_luma', 'spread_luma', 'log_green_over_red', 'log_green_over_blue', 'mean_saturation']
SHARE_INSIDE = 0.995


def statistics(image):
    """Five numbers of an 8-bit BGR image, from values 0..1: mean and standard deviation of luma
    (0.114 B + 0.587 G + 0.299 R), logarithms of the ratios of the mean colours (each plus 0.02), and the mean over the
    pixels of (largest - smallest channel) / (largest channel + 0.02)."""
    x = image.reshape(-1, 3).astype(np.float32) / 255
    luma = x @ np.array([0.114, 0.587, 0.299], np.float32)
    blue, green, red = x.mean(0) + 0.02
    largest = x.max(1)
    saturation = ((largest - x.min(1)) / (largest + 0.02)).mean()
    return np.array([luma.mean(), luma.std(), np.log(green / red), np.log(green / blue), saturation])


def describe(windows, strength, seed=3, count=4000):
    """Mean, inverse covariance and the distance that holds 99.5 % of the windows as the student sees them."""
    rng = np.random.default_rng(seed)
    seen = []
    for index in rng.choice(len(windows), min(count, len(windows)), replace=False):
        window = windows[index]
        seen.append(statistics(vary(window, rng, strength) if rng.random() < 0.85 else window))
    seen = np.array(seen)
    mean, inverse = seen.mean(0), np.linalg.inv(np.cov(seen.T))
    distance = np.sqrt(np.einsum('ni,ij,nj->n', seen - mean, inverse, seen - mean))
    return {'names': NAMES, 'mean': np.round(mean, 5).tolist(), 'inverse_covariance': np.round(inverse, 4).tolist(),
            'largest_distance': round(float(np.quantile(distance, SHARE_INSIDE)), 3), 'windows': len(seen)}
