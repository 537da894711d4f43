"""The data set: labelled and unlabelled pictures of the ground, each resampled to 0.2 m per pixel.

A picture has a place, and polygons; a polygon has one kind, or several where its source does not tell them apart.
All polygons of all packs form one table (Table.rows): picture, metres per pixel, place, polygon, kind, reader.
"""
import collections
import csv
import glob
import os
import re

import cv2
import numpy as np
from PIL import Image

KINDS = ['grass', 'rough', 'crop', 'stubble', 'soil', 'sand', 'tree', 'water', 'sealed', 'snow']
GROUND_SAMPLING_M = 0.2
MIN_POLYGON_PX = 16        # 0.64 m2; smaller ones tell the network nothing
MIN_RENDERED_PX = 250
MAX_COMPONENTS = 14        # of one kind in one picture, the largest
HERE = os.path.dirname(os.path.abspath(__file__))
EVALUATION = os.path.join(HERE, '../../../tests/evaluation')

# Words of the packs' own labels -> kinds. Kinds that the source keeps together stay together.
PACK_INDEX = {1: 'grass', 2: 'rough', 3: 'crop', 4: 'stubble|soil|sand', 5: 'tree', 6: 'water', 7: 'sealed', 8: ''}
GRASS_INDEX = {1: 'grass', 2: 'tree', 3: 'rough', 4: 'crop|stubble', 5: 'soil', 6: 'sealed', 7: 'sealed',
               8: 'water'}
REGION_CLASS = {'1': 'grass', '2': 'tree', '3': 'rough', '5': 'soil', '6': 'sealed', '7': 'sealed', '8': 'water'}
PLACE_CLASS = {'grass': 'grass', 'rough_grass': 'rough', 'crop': 'crop', 'stubble': 'stubble', 'soil': 'soil',
               'scrub': 'rough', 'tree': 'tree', 'water': 'water', 'paved': 'sealed', 'built': 'sealed'}
DRONE_PACKS = ['drone_places', 'drone_singles', 'heziro_il', 'neon_10cm', 'oam_tcd', 'servo_decatur']
SATELLITE_PACKS = ['rsscn7_s1', 'rsscn7_s2', 'rsscn7_unlabelled', 'vegas_sn2']

# freelsd-frames --pictures: what a pixel of a rendered frame shows, by number of Cover; the others have no kind.
COVER_KIND = {0: 'grass', 1: 'stubble', 2: 'soil', 3: 'rough', 4: 'soil', 5: 'sealed', 6: 'tree', 7: 'tree', 8: 'sealed',
              9: 'crop', 10: 'water', 11: 'tree'}
NO_KIND = 255

Polygon = collections.namedtuple('Polygon', 'name kinds reader pixels')


def read_picture(path):
    image = cv2.imread(path, cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if image is None:
        raise FileNotFoundError(path)
    return image


class Picture:
    """image: BGR at 0.2 m. region: 0 where unlabelled, else 1 + index into polygons."""

    def __init__(self, pack, place, name, image, sampling_m):
        scale = sampling_m / GROUND_SAMPLING_M
        height, width = image.shape[:2]
        size = (max(8, round(width * scale)), max(8, round(height * scale)))
        how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
        self.pack, self.place, self.name, self.sampling_m = pack, place, name, sampling_m
        self.image = cv2.resize(image, size, interpolation=how)
        self.source_size = (width, height)
        self.region = np.zeros(size[::-1], np.uint16)
        self.polygons = []

    def add_mask(self, mask, name, kinds, reader):
        """mask: source pixels, true inside."""
        share = cv2.resize(mask.astype(np.float32), self.region.shape[::-1], interpolation=cv2.INTER_AREA)
        inside = share > 0.6
        if inside.sum() < MIN_POLYGON_PX:
            return
        self.polygons.append(Polygon(name, frozenset(kinds.split('|')), reader, int(inside.sum())))
        self.region[inside] = len(self.polygons)

    def add_rings(self, rings, name, kinds, reader):
        """rings: x, y in source pixels; the first is the outline, the others are holes."""
        mask = np.zeros(self.source_size[::-1], np.uint8)
        for ring, value in zip(rings, [1] + [0] * len(rings)):
            cv2.fillPoly(mask, [np.round(ring).astype(np.int32)], value)
        self.add_mask(mask, name, kinds, reader)


def numbers(text):
    return np.array(text.replace(';', ' ').replace(',', ' ').split(), float).reshape(-1, 2)


def slug(text):
    return re.sub('[^a-z0-9]+', '_', text.lower().split(',')[0].split('(')[0]).strip('_')


def pack_place(pack, row):
    if pack.startswith('rsscn7'):
        name = row['name']            # neighbours in number show one town: blocks of ten
        return f'rsscn7_{name[0]}{int(name[1:]) // 10:02d}'
    if pack == 'drone_singles' and row['place'].startswith('SUAS'):
        return 'suas_field_md'
    return slug(row['place']) if pack not in ('heziro_il', 'vegas_sn2', 'servo_decatur') else pack


def pack_sampling(pack, row):
    if pack in SATELLITE_PACKS:       # pictures of 0.5 m are not enlarged further: they would only be blurred
        return 0.25
    return float(row['gsd_m_est'] or 0.1)


def split_readings():
    """(pack, picture, index, component) -> kinds, reader: what a reader saw where the index keeps kinds together."""
    with open(os.path.join(HERE, 'readings.csv')) as lines:
        return {(r['pack'], r['picture'], int(r['index']), int(r['component'])): (r['kind'], r['reader'])
                for r in csv.DictReader(lines)}


def mask_components(mask, index):
    """Connected pieces of one index, numbered in scan order; the largest ones."""
    count, piece, stats, _ = cv2.connectedComponentsWithStats((mask == index).astype(np.uint8))
    largest = sorted(range(1, count), key=lambda c: -stats[c, cv2.CC_STAT_AREA])[:MAX_COMPONENTS]
    return [(c, piece == c) for c in sorted(largest)]


def add_components(picture, mask, names, readings, reader):
    for index, kinds in names.items():
        for component, inside in mask_components(mask, index):
            key = (picture.pack, picture.name, index, component)
            read_kinds, read_by = readings.get(key, (kinds, reader))
            if read_kinds and read_kinds != 'doubt':
                picture.add_mask(inside, f'{index}.{component}', read_kinds, read_by)


def own_polygons():
    """polygons.csv: pack, picture, polygon, kind, reader, x y x y ... in pixels of the stored picture."""
    with open(os.path.join(HERE, 'polygons.csv')) as lines:
        return list(csv.DictReader(lines))


def ground_kind_packs(data, with_unlabelled=True):
    readings = split_readings()
    own = {(row['pack'], row['picture']) for row in own_polygons()}
    for pack in DRONE_PACKS + SATELLITE_PACKS:
        folder = f'{data}/ground_kinds/{pack}'
        with open(f'{folder}/images.csv') as lines:
            for row in csv.DictReader(lines):
                path = f"{folder}/masks/{row['name']}.png"
                if not with_unlabelled and not os.path.exists(path) and (pack, row['name']) not in own:
                    continue
                image = read_picture(f"{folder}/images/{row['name']}.jpg")
                picture = Picture(pack, pack_place(pack, row), row['name'], image, pack_sampling(pack, row))
                if os.path.exists(path):
                    mask = np.array(Image.open(path))   # OpenCV would expand the palette
                    add_components(picture, mask, PACK_INDEX, readings, 'pack')
                yield picture


def flight_sampling(place, width):
    with open(f'{EVALUATION}/grass_cameras.csv') as lines:
        for row in csv.DictReader(line for line in lines if not line.startswith('#')):
            if row['place'] == place:
                return float(row['height_m']) / (float(row['focal_ratio']) * width)
    raise KeyError(place)


def flights(data):
    readings = split_readings()
    for place in ['swindale', 'garfield_park', 'brighton_beach']:
        regions = collections.defaultdict(list)
        with open(f'{EVALUATION}/labels/{place}.csv') as lines:
            for row in csv.DictReader(lines):
                regions[row['photograph']].append(row)
        for path in sorted(glob.glob(f'{data}/flights/{place}/images/*')):
            name = os.path.splitext(os.path.basename(path))[0]
            image = read_picture(path)
            picture = Picture('flights', place, name, image, flight_sampling(place, image.shape[1]))
            grass_mask = f'{data}/grass/masks/{place}__{name}.png'
            if os.path.exists(grass_mask):   # drawn on the same photograph, 1600 pixels wide
                mask = cv2.resize(cv2.imread(grass_mask, -1), picture.source_size, interpolation=cv2.INTER_NEAREST)
                add_components(picture, mask, GRASS_INDEX, readings, 'grass')
            for row in regions.get(name, []):
                kinds = REGION_CLASS.get(row['class'])
                if kinds:
                    rings = [numbers(ring) for ring in row['rings'].split('|')]
                    picture.add_rings(rings, 'region ' + row['region'], kinds, 'regions')
            yield picture


def place_samplings():
    with open(f'{EVALUATION}/places/cameras.csv') as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith('#')))


def places(data):
    cameras = place_samplings()
    for place in sorted({row['place'] for row in cameras}):
        polygons = collections.defaultdict(list)
        with open(f'{EVALUATION}/places/labels/{place}.txt') as lines:
            for line in lines:
                if line.strip() and not line.startswith('#'):
                    name, word, photograph, *ring = line.split()
                    kind = 'sand' if (place, word) == ('copr_dunes', 'soil') else PLACE_CLASS[word]
                    polygons[photograph].append((name, kind, np.array(ring, float).reshape(-1, 2)))
        for path in sorted(glob.glob(f'{data}/places/{place}/*')):
            name = os.path.splitext(os.path.basename(path))[0]
            is_picture = re.search(r'\.(jpe?g|png|tif)$', path, re.I) and not re.search('(mask|_label|_ann|dsm)$', name)
            if not is_picture:
                continue
            fitting = [c for c in cameras if c['place'] == place and name.startswith(c['photograph_prefix'])]
            sampling_m = float(max(fitting, key=lambda c: len(c['photograph_prefix']))['ground_sampling_m'])
            picture = Picture('places', place, name, read_picture(path), sampling_m)
            for photograph, labels in polygons.items():
                if name.startswith(photograph):
                    for label, kinds, ring in labels:
                        picture.add_rings([ring], label, kinds, 'places')
            yield picture


def terrain(data):
    """The one orthophoto whose detail is that of its pixels; the others are coloured points of 1 m."""
    place, name = 'honduras_pool', 'honduras_pool_ortho'
    picture = Picture('terrain', place, name, read_picture(f'{data}/terrain/{place}/{name}.tif'), 0.2)
    with open(f'{EVALUATION}/labels/ground/{place}.csv') as lines:
        for row in csv.DictReader(lines):
            kinds = REGION_CLASS.get(row['class'])
            if kinds:
                rings = [numbers(ring) for ring in row['rings'].split('|')]
                picture.add_rings(rings, 'region ' + row['region'], kinds, 'regions')
    yield picture


def rendered(folder):
    """Frames of worlds of the tuning seeds and their covers; every second frame has labels."""
    for number, path in enumerate(sorted(glob.glob(f'{folder}/*_cover.png'))):
        name = os.path.basename(path)[:-len('_cover.png')]
        look = name.split('_')[0]
        picture = Picture('rendered', f'{look}_worlds', name, read_picture(f'{folder}/{name}.png'), GROUND_SAMPLING_M)
        cover = cv2.imread(path, cv2.IMREAD_UNCHANGED)
        picture.truth = np.full(cover.shape, NO_KIND, np.uint8)     # number of the kind of each pixel
        for index, kind in COVER_KIND.items():
            picture.truth[cover == index] = KINDS.index(kind)
        for index, kind in COVER_KIND.items() if number % 2 == 0 else ():
            count, piece, stats, _ = cv2.connectedComponentsWithStats((cover == index).astype(np.uint8))
            largest = sorted(range(1, count), key=lambda c: -stats[c, cv2.CC_STAT_AREA])[:3]
            for c in largest:
                if stats[c, cv2.CC_STAT_AREA] >= MIN_RENDERED_PX:
                    picture.add_mask(piece == c, f'{index}.{c}', kind, 'truth')
        yield picture


def add_own_polygons(pictures):
    by_name = {(p.pack, p.name): p for p in pictures}
    for row in own_polygons():
        picture = by_name[(row['pack'], row['picture'])]
        picture.add_rings([numbers(row['ring'])], row['polygon'], row['kind'], row['reader'])


def load(data, rendered_folder=None):
    pictures = [p for source in (flights, places, terrain, ground_kind_packs) for p in source(data)]
    pictures += rendered(rendered_folder) if rendered_folder else []
    add_own_polygons(pictures)
    return pictures


def load_labelled(data):
    pictures = [p for source in (flights, places, terrain) for p in source(data)]
    pictures += ground_kind_packs(data, with_unlabelled=False)
    add_own_polygons(pictures)
    return [p for p in pictures if p.polygons]


def write_table(pictures, path):
    with open(path, 'w', newline='') as file:
        table = csv.writer(file)
        table.writerow(['pack', 'picture', 'metres_per_pixel', 'place', 'polygon', 'kind', 'reader', 'pixels_at_0.2_m'])
        for p in pictures:
            for q in p.polygons:
                table.writerow([p.pack, p.name, f'{p.sampling_m:.4g}', p.place, q.name, '|'.join(sorted(q.kinds)),
                                q.reader, q.pixels])
