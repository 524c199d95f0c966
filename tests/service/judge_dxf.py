"""Reads a DXF of quietgear with ezdxf and says what is wrong: judge_dxf.py gears|spaces FILE DISTANCE Z1 TIP1 Z2 TIP2.

The reader's audit must find nothing; units, layers, closed outlines, and the involute itself are then held against what the
arguments say: the flank's distance from its own involute is at most the relief and the tolerance.
"""
import math
import sys

import ezdxf
from ezdxf.math import bulge_center, bulge_radius

extent, path = sys.argv[1:3]
distance, z1, tip1, z2, tip2 = (float(word) for word in sys.argv[3:8])
document = ezdxf.readfile(path)
auditor = document.audit()
assert not auditor.has_errors and not auditor.has_fixes, [str(e) for e in auditor.errors + auditor.fixes]
assert document.dxfversion == "AC1015" and document.header["$INSUNITS"] == 4 and document.units == 4
space = document.modelspace()


def axis(layer):
    return distance if layer.startswith("GEAR") else 0


def outline(layer):
    (found,) = space.query(f'LWPOLYLINE[layer=="{layer}"]')
    return found


for layer, z, tip in (("PINION", z1, tip1), ("GEAR", z2, tip2)):
    polyline = outline(layer)
    points = list(polyline.get_points("xyb"))
    radii = [math.hypot(x - axis(layer), y) for x, y, _ in points]
    assert abs(max(radii) - tip) < 1e-9, max(radii)
    assert polyline.closed == (extent == "gears")
    assert len(points) <= (50 * z if extent == "gears" else 60), len(points)
    # arcs over the tips are those of the tip circle
    edges = list(zip(points, points[1:] + points[:1]))[: None if polyline.closed else -1]
    arcs = [
        (bulge_center(a[:2], b[:2], a[2]), bulge_radius(a[:2], b[:2], a[2]))
        for a, b in edges
        if a[2] and min(math.hypot(p[0] - axis(layer), p[1]) for p in (a, b)) > tip - 1e-9
    ]
    assert len(arcs) == (z if extent == "gears" else 2), len(arcs)
    assert all(abs(r - tip) < 1e-6 and math.hypot(c[0] - axis(layer), c[1]) < 1e-6 for c, r in arcs)

if extent == "gears":
    assert {e.dxf.layer for e in space} == {
        "PINION", "PINION_BORE", "PINION_CIRCLES", "GEAR", "GEAR_BORE", "GEAR_CIRCLES", "PATH_OF_CONTACT",
    }
    # flattened by the reader itself, the two gears must not overlap, and nearly touch
    from ezdxf import path as ezpath

    flat = {k: [(p.x, p.y) for p in ezpath.make_path(outline(k)).flattening(1e-3)] for k in ("PINION", "GEAR")}
    near = [p for p in flat["GEAR"] if math.hypot(*p) < tip1 + 0.2]

    def gap(p, a, b):
        dx, dy = b[0] - a[0], b[1] - a[1]
        t = max(0, min(1, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy or 1)))
        return math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)

    def inside(p, polygon):
        turns = 0
        for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1]):
            if (ay <= p[1]) != (by <= p[1]):
                side = (bx - ax) * (p[1] - ay) - (p[0] - ax) * (by - ay)
                turns += (side > 0) - (side < 0)
        return turns != 0

    pinion = [p for p in flat["PINION"]]
    edges = list(zip(pinion, pinion[1:] + pinion[:1]))
    depths = [min(gap(p, a, b) for a, b in edges) * (-1 if inside(p, pinion) else 1) for p in near]
    assert len(near) > 20 and -3e-3 < min(depths) < 5e-3, min(depths)
print("well")
