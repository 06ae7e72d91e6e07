"""Writes meshes as Collada."""

from pathlib import Path

from solids import indexed


def write_collada(path: Path, parts: dict) -> None:
    """In millimetres. `parts`: by name, the colour (red, green, blue; 0 to 1) and the triangles."""
    effects = materials = geometries = nodes = ""
    for name, (colour, triangles) in parts.items():
        points, corners = indexed([tuple(tuple(1000 * c for c in p) for p in t) for t in triangles])
        rgba = " ".join(map(str, colour))
        effects += (
            f'<effect id="{name}-effect"><profile_COMMON><technique sid="common"><lambert><diffuse><color>{rgba} 1</color>'
            "</diffuse></lambert></technique></profile_COMMON></effect>\n"
        )
        materials += f'<material id="{name}-material"><instance_effect url="#{name}-effect"/></material>\n'
        numbers = " ".join("{:g} {:g} {:g}".format(*p) for p in points)
        geometries += (
            f'<geometry id="{name}" name="{name}"><mesh><source id="{name}-points"><float_array id="{name}-array" '
            f'count="{3 * len(points)}">{numbers}</float_array><technique_common><accessor source="#{name}-array" '
            f'count="{len(points)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" '
            f'type="float"/></accessor></technique_common></source><vertices id="{name}-vertices"><input '
            f'semantic="POSITION" source="#{name}-points"/></vertices><triangles material="m" count="{len(corners)}"><input '
            f'semantic="VERTEX" source="#{name}-vertices" offset="0"/><p>{" ".join(str(c) for t in corners for c in t)}</p>'
            "</triangles></mesh></geometry>\n"
        )
        nodes += (
            f'<node id="{name}-node"><instance_geometry url="#{name}"><bind_material><technique_common><instance_material '
            f'symbol="m" target="#{name}-material"/></technique_common></bind_material></instance_geometry></node>\n'
        )
    path.write_text(
        '<?xml version="1.0" encoding="utf-8"?>\n<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">\n'
        '<asset><unit name="millimetre" meter="0.001"/><up_axis>Z_UP</up_axis></asset>\n'
        f"<library_effects>{effects}</library_effects>\n<library_materials>{materials}</library_materials>\n"
        f"<library_geometries>{geometries}</library_geometries>\n"
        f'<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>\n'
        '<scene><instance_visual_scene url="#scene"/></scene>\n</COLLADA>\n'
    )
