"""Which place teaches which model (places.csv).

The model foldK has seen no picture of the places of fold K, nor of the test-only places; it is judged on fold K.
The shipped model judges rendered worlds: no picture whose texture the report rows of those worlds wear teaches it.
"""
import csv
import os

import numpy as np

NUM_FOLDS = 5
FOLD_MODELS = [f'fold{k}' for k in range(NUM_FOLDS)]
BASELINE_LABELS = {'swindale', 'garfield_park', 'brighton_beach'}
BASELINE_JUDGED = {'cmac_au', 'copr_dunes', 'snowpeak_ebee', 'stubble_bales', 'tuniu_tw'}
MODELS = FOLD_MODELS + ['shipped', 'baseline']

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'places.csv')) as _lines:
    PLACES = {row['place']: row for row in csv.DictReader(_lines)}


def teaches(place, model):
    """May pictures of the place, unlabelled, teach the model?"""
    row = PLACES[place]
    if model == 'shipped':
        return row['teaches'] in ('all', 'shipped')
    if model == 'baseline':
        return row['teaches'] != 'none' and row['pack'] != 'rendered' and place not in BASELINE_JUDGED
    return row['teaches'] in ('all', 'folds') and f"fold{row['fold']}" != model


def labels_teach(place, model):
    return place in BASELINE_LABELS if model == 'baseline' else teaches(place, model)


def places_for(places, model, rule=teaches):
    return np.array([rule(place, model) for place in places], bool)


def is_drone(place):
    return PLACES[place]['view'] == 'drone'


def fold_of(place):
    return int(PLACES[place]['fold'])


# Satellite-like pictures come from another sensor: all of them together weigh as some drone places.
SATELLITE_WEIGHT = {'rsscn7': 6.0, 'vegas_sn2': 0.5}
POLYGONS_OF_A_FULL_PLACE = 12
# What each kind weighs over all places: the more, the worse it is to take it for grass.
KIND_SHARE = {'grass': 0.30, 'rough': 0.13, 'crop': 0.13, 'stubble': 0.06, 'soil': 0.09, 'sand': 0.05, 'tree': 0.07,
              'water': 0.12, 'sealed': 0.09, 'snow': 0.02}
SATELLITE_WEIGHT = {'rsscn7': 6.0, 'vegas_sn2': 0.5}
POLYGONS_OF_A_FULL_PLACE = 12
GRASS_WEIGHT = 3.0     # of a kind in a place: whether it is grass is asked first


def place_weights(places):
    """Weight of each polygon's place, shared out to nothing yet."""
    num_by_pack = {}
    for place in set(places):
        pack = PLACES[place]['pack']
        num_by_pack[pack] = num_by_pack.get(pack, 0) + 1
    weight = {}
    for place, count in zip(*np.unique(places, return_counts=True)):
        pack = PLACES[place]['pack']
        full = min(1.0, count / POLYGONS_OF_A_FULL_PLACE)
        weight[place] = SATELLITE_WEIGHT[pack] / num_by_pack[pack] if pack in SATELLITE_WEIGHT else full
    return weight


def polygon_weights(places, kinds):
    """Weight by place, in it by kind, in it by polygon; then each kind gets its share. kinds: a set by polygon."""
    weight, of_place = np.zeros(len(places)), place_weights(places)
    for place in sorted(of_place):
        here = np.flatnonzero(places == place)
        names = [kinds[i] for i in here]
        for name in set(names):
            of_kind = [i for i, other in zip(here, names) if other == name]
            weight[of_kind] = of_place[place] / len(set(names)) / len(of_kind)
    total = {kind: sum(w for w, of in zip(weight, kinds) if of == {kind}) for kind in KIND_SHARE}
    factor = {kind: KIND_SHARE[kind] / total[kind] if total[kind] > 0 else 0.0 for kind in KIND_SHARE}
    largest = 4 * np.median([f for f in factor.values() if f > 0])      # a kind seen at one place does not rule
    return weight * np.array([np.mean([min(factor[k], largest) for k in of]) for of in kinds])
