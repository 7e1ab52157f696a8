"""STEP files (AP214) of prisms: a solid with flat faces, written out by hand."""

from collections.abc import Sequence

HEADER = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('{name}'),'2;1');
FILE_NAME('{name}','2024-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 1 1 1 1 }}'));
ENDSEC;
DATA;
"""

CONTEXT = """#1=APPLICATION_CONTEXT('automotive design');
#2=APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#1);
#3=PRODUCT_CONTEXT('',#1,'mechanical');
#4=PRODUCT('{name}','{name}','',(#3));
#5=PRODUCT_DEFINITION_FORMATION('','',#4);
#6=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');
#7=PRODUCT_DEFINITION('design','',#5,#6);
#8=PRODUCT_DEFINITION_SHAPE('','',#7);
#9=SHAPE_DEFINITION_REPRESENTATION(#8,#20);
#10=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({prefix},.METRE.));
#11=(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.));
#12=(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT());
#13=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-6),#10,'distance_accuracy_value','');
#14=(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#13))
GLOBAL_UNIT_ASSIGNED_CONTEXT((#10,#11,#12)) REPRESENTATION_CONTEXT('',''));
"""


def step_of_prism(
    outline: Sequence[tuple[float, float]],
    height: float,
    *,
    name: str = "prism",
    prefix: str = ".MILLI.",
) -> str:
    """A STEP file of a prism over a counter-clockwise outline, from z = 0 up to `height`."""
    lines: list[str] = []
    number = 30

    def put(text: str) -> str:
        nonlocal number
        number += 1
        lines.append(f"#{number}={text};")
        return f"#{number}"

    def point(p: Sequence[float]) -> str:
        return put(f"CARTESIAN_POINT('',({p[0]:.6f},{p[1]:.6f},{p[2]:.6f}))")

    def direction(d: Sequence[float]) -> str:
        return put(f"DIRECTION('',({d[0]:.9f},{d[1]:.9f},{d[2]:.9f}))")

    count = len(outline)
    corners = [(x, y, z) for z in (0.0, height) for x, y in outline]
    vertices = [put(f"VERTEX_POINT('',{point(p)})") for p in corners]
    edges: dict[tuple[int, int], str] = {}

    def edge(a: int, b: int) -> str:
        """An oriented edge; the curve under it is shared with the face beside."""
        if (b, a) in edges:
            return put(f"ORIENTED_EDGE('',*,*,{edges[b, a]},.F.)")
        along = [corners[b][k] - corners[a][k] for k in range(3)]
        length = sum(v * v for v in along) ** 0.5
        vector = put(f"VECTOR('',{direction([v / length for v in along])},1.)")
        line = put(f"LINE('',{point(corners[a])},{vector})")
        edges[a, b] = put(f"EDGE_CURVE('',{vertices[a]},{vertices[b]},{line},.T.)")
        return put(f"ORIENTED_EDGE('',*,*,{edges[a, b]},.T.)")

    def face(loop: Sequence[int], normal: Sequence[float], x: Sequence[float]) -> str:
        around = ",".join(edge(a, b) for a, b in zip(loop, [*loop[1:], loop[0]], strict=True))
        outer = put(f"EDGE_LOOP('',({around}))")
        bound = put(f"FACE_OUTER_BOUND('',{outer},.T.)")
        at = f"{point(corners[loop[0]])},{direction(normal)},{direction(x)}"
        placement = put(f"AXIS2_PLACEMENT_3D('',{at})")
        plane = put(f"PLANE('',{placement})")
        return put(f"ADVANCED_FACE('',({bound}),{plane},.T.)")

    faces = [
        face(list(range(count))[::-1], (0, 0, -1), (1, 0, 0)),
        face([count + k for k in range(count)], (0, 0, 1), (1, 0, 0)),
    ]
    for k in range(count):
        following = (k + 1) % count
        (ax, ay), (bx, by) = outline[k], outline[following]
        length = ((bx - ax) ** 2 + (by - ay) ** 2) ** 0.5
        along = ((bx - ax) / length, (by - ay) / length, 0.0)
        loop = [k, following, count + following, count + k]
        faces.append(face(loop, (along[1], -along[0], 0.0), along))
    shell = put(f"CLOSED_SHELL('',({','.join(faces)}))")
    solid = put(f"MANIFOLD_SOLID_BREP('{name}',{shell})")
    place = f"{point((0, 0, 0))},{direction((0, 0, 1))},{direction((1, 0, 0))}"
    placement = put(f"AXIS2_PLACEMENT_3D('',{place})")
    lines.append(f"#20=ADVANCED_BREP_SHAPE_REPRESENTATION('',({placement},{solid}),#14);")
    context = CONTEXT.format(name=name, prefix=prefix)
    return HEADER.format(name=name) + context + "\n".join(lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"
