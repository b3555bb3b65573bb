"""The Python of the documentation."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def blocks(page: str, *kinds: str) -> str:
    """The blocks of a page marked ```python KIND, one after the other."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"^```python (\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    chosen = [code for kind, code in found if kind in kinds]
    assert chosen, f"{page} has no block of {kinds}"
    return "\n".join(chosen)
