"""Every numeric field of every request, with each value that is no use as a number."""

import copy
import json
import urllib.parse

from disks import META
from harness import Server, check
from recalls import RECALL, store_sites

MARK = "@@"
# What is sent, and what must come back: statuses, and whether the field is to be named.
VALUES = [("1e308", {422}, True), ("-1e308", {422}, True), ('"12"', {422}, True),
          ("true", {422}, True), ("[]", {422}, True), ("{}", {422}, True),
          ("NaN", {400}, False), ("Infinity", {400}, False), ("-Infinity", {400}, False),
          ("1e999", {400}, False), ("null", {200, 201, 422}, True),
          ("-0.0", {200, 201, 422}, True), ("5e-324", {200, 201, 422}, True)]
QUERY_VALUES = [("1e308", {422}, True), ("-1e308", {422}, True), ("twelve", {400}, True),
                ("NaN", {400}, True), ("inf", {400}, True), ("1e999", {400}, True),
                ("", {400, 422}, True), ("-0.0", {200, 422}, True), ("5e-324", {200, 422}, True),
                ("0x10", {400}, True), ("1,5", {400}, True)]


def numeric_paths(value, path=()):
    """Of every number in it."""
    if isinstance(value, dict):
        return [each for key in value for each in numeric_paths(value[key], path + (key,))]
    if isinstance(value, list):
        return [each for i in range(len(value)) for each in numeric_paths(value[i], path + (i,))]
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return [path] if is_number else []


def with_token(value, path, token):
    """JSON text with the token, valid or not, in that place."""
    changed = copy.deepcopy(value)
    place = changed
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = MARK
    return json.dumps(changed).replace(f'"{MARK}"', token)


def is_named(path, problem):
    """Whether an error points at the field, at the list that it is in, or names it."""
    pointer = "/" + "/".join(str(key) for key in path)
    names = [key for key in path if isinstance(key, str)]
    for error in problem.get("errors", []):
        at = error["pointer"]
        if at == pointer or (pointer.startswith(at + "/") and at.endswith("/" + names[-1])):
            return True
        # A rule over several fields stands at one of them and names the others.
        if names[-1] in at or names[-1] in error["detail"]:
            return True
    return False


class Tally:
    def __init__(self):
        self.num_fields = self.num_sent = 0
        self.wrong = []

    def note(self, place, token, status, body, wanted, must_name, path):
        self.num_sent += 1
        good = status in wanted
        if good and status == 422 and must_name:
            good = is_named(path, json.loads(body))
        if not good:
            self.wrong.append(f"{place} {'/'.join(map(str, path))} = {token}: {status} "
                              f"{body[:160].decode(errors='replace')}")


def flight_request(info):
    """One with every number that there is."""
    options = {}
    for stage, fields in info["options"].items():
        if stage == "preset":
            continue
        options[stage] = {name: field["default"] for name, field in fields.items()
                          if field["default"] is not None}
    aircraft = {key: value for key, value in info["aircraft_profiles"]["techpod"].items()
                if isinstance(value, (int, float))}
    return {"name": "numbers",
            "camera": {"width_px": 564, "height_px": 360, "fx_px": 348.75, "fy_px": 348.75,
                       "cx_px": 281.5, "cy_px": 179.5,
                       "distortion": {"model": "radtan", "coefficients": [0.01, 0, 0, 0]}},
            "body_from_camera": {"translation_m": [0, 0, 0],
                                 "quaternion_wxyz": [0.7071068, 0, 0, 0.7071068]},
            "origin": {"latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 400.0},
            "aircraft": aircraft, "options": options}


def frame_meta():
    return dict(META, timestamp_us=1717236000000000, position_sd_m=1.0, attitude_sd_deg=1.0,
                wind={"east_mps": 1.0, "north_mps": 2.0})


def check_bodies(server, tally, requests):
    for place, base, send in requests:
        status, body = send(json.dumps(base))
        check(status in (200, 201), f"{place} as it should be: {status} {body[:300]!r}")
        for path in numeric_paths(base):
            tally.num_fields += 1
            for token, wanted, must_name in VALUES:
                status, body = send(with_token(base, path, token))
                tally.note(place, token, status, body, wanted, must_name, path)


def check_telemetry(server, flight, tally):
    """A bad line is told of by number, the rest goes on."""
    base = {"timestamp_us": 1717236000000000, "position": META["position"],
            "attitude": META["attitude"], "wind": {"east_mps": 1, "north_mps": 2}}
    for path in numeric_paths(base):
        tally.num_fields += 1
        for token, wanted, _ in VALUES:
            lines = json.dumps(base) + "\n" + with_token(base, path, token) + "\n"
            status, body = server.request("POST", f"/v1/flights/{flight}/telemetry", lines)
            answer = json.loads(body)
            told = answer.get("rejected", [])
            good = status == 200 and (200 in wanted or len(told) == 1)
            if good and told:
                names_it = wanted == {400} or path[-1] in told[0]["detail"] or "quaternion" in told[0]["detail"]
                good = told[0]["line"] == 2 and names_it
            tally.num_sent += 1
            if not good:
                tally.wrong.append(f"telemetry {path} = {token}: {status} {body[:160]!r}")


def check_queries(server, tally, site):
    recall = urllib.parse.parse_qs(RECALL.split("?")[1])
    recall = {key: value[0] for key, value in recall.items()}
    recall.update(glide_ratio="9", limit="3")
    approach = {"wind_east_mps": "1", "wind_north_mps": "1", "landing_airspeed_mps": "13",
                "flight_path_angle_deg": "4", "max_bank_deg": "11", "approach_height_m": "12",
                "crosswind_uncertainty_deg": "30", "touchdown_uncertainty_m": "10",
                "glide_ratio": "12", "glide_airspeed_mps": "13", "max_slope_deg": "8",
                "max_roughness_m": "0.5", "safety_margin_m": "2", "path_half_width_m": "5",
                "ground_roll_m": "30", "min_area_m2": "900"}
    for place, base in (("/v1/emergency", recall), (f"/v1/sites/{site}/approach", approach),
                        ("/v1/sites", {"limit": "5"})):
        for key in base:
            if key == "altitude_datum":
                continue
            tally.num_fields += 1
            for token, wanted, must_name in QUERY_VALUES:
                query = urllib.parse.urlencode(dict(base, **{key: token}))
                status, body = server.get(f"{place}?{query}")
                wanted_here = wanted | {409} if "approach" in place and 200 in wanted else wanted
                tally.note(place, token, status, body, wanted_here, must_name, (key,))


def run(tools, folder, flight_files, _):
    tally = Tally()
    server = Server(tools, folder / "data", config={"max_num_queued_frames": 1000000})
    store_sites(server, folder)
    with server:
        sites = server.get_json("/v1/sites")["features"]
        site = sites[0]["properties"]["id"]
        base = flight_request(server.get_json("/v1/info"))
        flight = server.new_flight(flight_files.request)
        image = flight_files.images[0]
        serial = iter(range(10**9))

        def put(text):
            from harness import multipart
            body, kind = multipart([("image", "i.jpg", image), ("meta", None, text)])
            return server.request("PUT", f"/v1/flights/{flight}/frames/n{next(serial)}", body,
                                  {"Content-Type": kind})

        recall = {"latitude_deg": 47.351, "longitude_deg": 8.455, "altitude_m": 900,
                  "wind_east_mps": 2, "wind_north_mps": 0, "heading_deg": 0, "glide_ratio": 9,
                  "limit": 3}
        post = lambda path: lambda text: server.request("POST", path, text)
        check_bodies(server, tally, [("POST /v1/flights", base, post("/v1/flights")),
                                     ("PUT frame", frame_meta(), put),
                                     ("POST /v1/emergency", recall, post("/v1/emergency"))])
        check_telemetry(server, flight, tally)
        check_queries(server, tally, site)
        check(server.is_alive(), "the server ended")
    seen = f"{tally.num_fields} fields, {tally.num_sent} requests, {len(tally.wrong)} wrong"
    if tally.wrong:
        seen += ": " + "; ".join(tally.wrong[:5])
        print("\n".join(tally.wrong))
    return seen, not tally.wrong
