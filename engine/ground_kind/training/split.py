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
        return row['teaches'] == 'all'
    if model == 'baseline':
        return row['teaches'] != 'none' and place not in BASELINE_JUDGED
    return row['teaches'] != 'none' and f"fold{row['fold']}" != model


def labels_teach(place, model):
    return place in BASELINE_LABELS if model == 'baseline' else teaches(place, model)


def places_for(places, model, rule=teaches):
    return np.array([rule(place, model) for place in places], bool)


def is_drone(place):
    return PLACES[place]['view'] == 'drone'


def fold_of(place):
    return int(PLACES[place]['fold'])


# Satellite-like pictures come from another sensor: all of them together weigh as some drone places.
GRASS = frozenset(['grass'])
SATELLITE_WEIGHT = {'rsscn7': 6.0, 'vegas_sn2': 0.5}
POLYGONS_OF_A_FULL_PLACE = 12
GRASS_WEIGHT = 3.0     # of a kind in a place: whether it is grass is asked first


def polygon_weights(places, kinds):
    """Weight by place, in it by kind, in it by polygon. places, kinds: by polygon (kinds: any hashable)."""
    weight = np.zeros(len(places))
    num_by_pack = {}
    for place in set(places):
        pack = PLACES[place]['pack']
        num_by_pack[pack] = num_by_pack.get(pack, 0) + 1
    for place in sorted(set(places)):
        here = np.flatnonzero(places == place)
        pack = PLACES[place]['pack']
        full = min(1.0, len(here) / POLYGONS_OF_A_FULL_PLACE)
        share = SATELLITE_WEIGHT[pack] / num_by_pack[pack] if pack in SATELLITE_WEIGHT else full
        names = [kinds[i] for i in here]
        worth = {name: GRASS_WEIGHT if name == GRASS else 1.0 for name in set(names)}
        for name in worth:
            of_kind = [i for i, other in zip(here, names) if other == name]
            weight[of_kind] = share * worth[name] / sum(worth.values()) / len(of_kind)
    return weight
