"""JSON Schemas as files: the same bytes whichever Python wrote them."""

from typing import Any


def unwrapped(node: Any) -> Any:
    """Return a schema with its descriptions on one line: Pythons differ in how they indent docstrings."""
    if isinstance(node, dict):
        return {
            key: " ".join(value.split()) if key == "description" and isinstance(value, str) else unwrapped(value)
            for key, value in node.items()
        }
    return [unwrapped(value) for value in node] if isinstance(node, list) else node
