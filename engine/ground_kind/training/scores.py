"""Figures over polygons: p is the probability of fit grass, y whether the polygon is fit grass."""
import numpy as np


def auc(p, y):
    """Share of pairs in the right order; ties count half. None without both sides."""
    p, y = np.asarray(p, float), np.asarray(y, bool)
    if y.all() or not y.any():
        return None
    values, inverse, counts = np.unique(p, return_inverse=True, return_counts=True)
    rank = (np.cumsum(counts) - (counts - 1) / 2)[inverse]
    positives = y.sum()
    return float((rank[y].sum() - positives * (positives + 1) / 2) / (positives * (len(y) - positives)))


def calibration_error(p, y, bins=10):
    p, y = np.asarray(p, float), np.asarray(y, float)
    slot = np.minimum((p * bins).astype(int), bins - 1)
    return float(sum(abs(p[slot == k].mean() - y[slot == k].mean()) * (slot == k).mean() for k in np.unique(slot)))


def wilson(hits, count, z=1.96):
    """95 % bounds of a share."""
    if count == 0:
        return 0.0, 1.0
    share = hits / count
    middle = share + z * z / (2 * count)
    half = z * np.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    return float((middle - half) / (1 + z * z / count)), float((middle + half) / (1 + z * z / count))


def ratio(hits, count):
    low, high = wilson(hits, count)
    return f'{hits} of {count} = {hits / count:.3f} [{low:.3f}, {high:.3f}]' if count else '0 of 0'


def auc_bounds(p, y, places, rounds=400, seed=0):
    """95 % bounds by drawing places with replacement: polygons of one place are not independent."""
    rng = np.random.default_rng(seed)
    names = np.unique(places)
    members = {n: np.flatnonzero(places == n) for n in names}
    drawn = []
    for _ in range(rounds):
        index = np.concatenate([members[n] for n in rng.choice(names, len(names))])
        value = auc(p[index], y[index])
        if value is not None:
            drawn.append(value)
    return np.percentile(drawn, [2.5, 97.5])


def fit_platt(logit, y, weight):
    """scale, shift of p = 1 / (1 + exp(-(scale * logit + shift))), by Newton's method with a weak pull to 1, 0."""
    x = np.stack([logit, np.ones_like(logit)], 1)
    w, prior = np.array([1.0, 0.0]), np.array([1.0, 0.0])
    weight = weight / weight.sum()
    for _ in range(50):
        p = 1 / (1 + np.exp(-np.clip(x @ w, -30, 30)))
        gradient = x.T @ (weight * (p - y)) + 1e-4 * (w - prior)
        hessian = (x * (weight * p * (1 - p))[:, None]).T @ x + 1e-4 * np.eye(2)
        step = np.linalg.solve(hessian, gradient)
        w = w - step / max(1.0, np.abs(step).max())
    return w
