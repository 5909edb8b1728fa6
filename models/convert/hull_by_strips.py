"""The hull of a platform that bends, by strips, before there is a database of its shapes."""

import tempfile
from pathlib import Path

import fowtlib as fw
from fowtlib.components.platform import ElasticFloater

MODELS = Path(__file__).parents[1]


def hull_by_strips(platform: str, depth: float, shapes: int) -> ElasticFloater:
    """Of `platforms/<platform>.yaml` in sea water of this depth [m]."""
    file = MODELS / "platforms" / f"{platform}.yaml"
    text = f"""fowtlib: 1
world: {{class: World, water_depth: {depth} m, water_density: 1025 kg/m^3}}
parts: {{platform: {{use: {file}, parts: {{hull: {{database: null, shapes: {shapes}}}}}}}}}
connect:
  - [world.frame, platform.world]
"""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hull.yaml"
        path.write_text(text)
        return fw.load(path).root.find("platform.hull")
