"""The layouts of the old library's structs: offsets, sizes, files and macros."""

import json
from pathlib import Path

LAYOUT = json.loads((Path(__file__).parent / "data" / "libgazebo-layout.json").read_text())
