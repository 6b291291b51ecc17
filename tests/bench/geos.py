"""Judges the fences and legs of `cargo run --release -p backseat-bench --example fences -- FOLDER` with GEOS.

    python tests/bench/geos.py FOLDER

Needs Shapely 2. Prints for each fence how many verdicts and distances agree with ours, and what a leg costs in several
ways of asking GEOS, from arrays, so that Python's own time is left out. Exits 1 where a leg that we let pass is
not inside, or one that we reject is, or where a distance differs, by more than a micrometre.
"""

import json
import pathlib
import sys
import time

import numpy as np
import shapely

# This close to the margin either verdict is right.
TIE_M = 1e-6
EDGE_THICKNESS_M = 1e-6


def main(folder):
    print(f"Shapely {shapely.__version__}, GEOS {shapely.geos_version_string}")
    print("| fence | vertices | legs | inside | disagree | distances apart | ours | prepared | distance | buffer, prepared | buffer |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    wrong = total = 0
    for path in sorted(pathlib.Path(folder).glob("*.json")):
        legs = np.loadtxt(path.with_suffix(".csv"), delimiter=",", skiprows=1)
        wrong += judge(path.stem, json.loads(path.read_text()), legs)
        total += len(legs)
    print(f"{total} legs, {wrong} disagree")
    return 1 if wrong else 0


def judge(name, fence, legs):
    radius_m, spare_m = legs[:, 4], legs[:, 5]
    lines = shapely.linestrings(legs[:, :4].reshape(-1, 2, 2))
    # GEOS rejects a line without length as invalid, but accepts a point.
    places = (legs[:, 0] == legs[:, 2]) & (legs[:, 1] == legs[:, 3])
    lines[places] = shapely.points(legs[places, :2])
    zones = [(zone["keep_in"], zone["margin_m"], shapely.from_wkt(zone["wkt"])) for zone in fence["zones"]]
    assert all(polygon.is_valid for _, _, polygon in zones)

    expected_m = distances(zones, lines, radius_m)
    inside = ~np.isnan(spare_m)
    wrong = (inside != (expected_m >= 0)) & (np.abs(expected_m) > TIE_M)
    apart_m = np.abs(expected_m - spare_m)[inside]
    wrong[inside] |= apart_m > TIE_M
    for index in np.flatnonzero(wrong)[:5]:
        print(f"{name}: leg {index}: ours {spare_m[index]}, GEOS {expected_m[index]}: {legs[index].tolist()}")

    few = 500
    times = [
        fence["ours_ns"],
        timed(prepared, zones, lines, radius_m),
        timed(distances, zones, lines[:few], radius_m[:few]),
        timed(prepared_buffer, zones, lines[:few], radius_m[:few]),
        timed(buffer, zones, lines[:few], radius_m[:few]),
    ]
    cells = [name, fence["vertices"], len(legs), inside.sum(), wrong.sum(), f"{apart_m.max():.0e} m"]
    cells += [f"{ns / 1000:.2f} us" for ns in times]
    print("|", " | ".join(map(str, cells)), "|", flush=True)
    return int(wrong.sum())


def distances(zones, lines, radius_m):
    """The clearance of each leg, negative if it is not allowed, from distances and without prepared geometries."""
    spare_m = np.full(len(lines), -np.inf)
    for keep_in, margin_m, polygon in zones:
        if keep_in:
            inside = shapely.covers(polygon, lines)
            from_edge_m = shapely.distance(polygon.boundary, lines) - reach(margin_m, radius_m)
            spare_m = np.maximum(spare_m, np.where(inside, from_edge_m, -np.inf))
    for keep_in, margin_m, polygon in zones:
        if not keep_in:
            spare_m = np.minimum(spare_m, shapely.distance(polygon, lines) - reach(margin_m, radius_m))
    return spare_m


def reach(margin_m, radius_m):
    """The distance that a leg must keep from an edge, whose own thickness is a micrometre."""
    return np.maximum(margin_m + radius_m, EDGE_THICKNESS_M)


def prepared(zones, lines, radius_m):
    """The fastest exact method: prepared containment, and prepared `dwithin` of the boundary."""
    holds = np.zeros(len(lines), bool)
    for keep_in, margin_m, polygon in zones:
        if keep_in:
            boundary = polygon.boundary
            shapely.prepare([polygon, boundary])
            inside = shapely.contains_properly(polygon, lines)
            inside[inside] = ~shapely.dwithin(boundary, lines[inside], radius_m[inside] + margin_m)
            holds |= inside
    for keep_in, margin_m, polygon in zones:
        if not keep_in:
            shapely.prepare(polygon)
            holds[holds] = ~shapely.dwithin(polygon, lines[holds], radius_m[holds] + margin_m)
    return holds


def prepared_buffer(zones, lines, radius_m):
    """The method of most scripts, prepared: is the buffered leg inside? Round ends with eight edges in a quarter."""
    return buffer(zones, lines, radius_m, shapely.prepare)


def buffer(zones, lines, radius_m, prepare=shapely.destroy_prepared):
    """The method of most scripts."""
    holds = np.zeros(len(lines), bool)
    for keep_in, margin_m, polygon in zones:
        if keep_in:
            prepare(polygon)
            holds |= shapely.contains(polygon, shapely.buffer(lines, radius_m + margin_m, quad_segs=8))
    for keep_in, margin_m, polygon in zones:
        if not keep_in:
            prepare(polygon)
            holds &= ~shapely.intersects(polygon, shapely.buffer(lines, radius_m + margin_m, quad_segs=8))
    return holds


def timed(way, zones, lines, radius_m):
    """Nanoseconds for each leg, the better of two rounds."""
    best = float("inf")
    for _ in range(2):
        start = time.process_time_ns()
        way(zones, lines, radius_m)
        best = min(best, (time.process_time_ns() - start) / len(lines))
    return best


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
