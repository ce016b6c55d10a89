"""The document of a plan that has no line on a scan: what others begin with, and a server answers by itself."""

from typing import Any

from breastrig.core.notice import LIMITS_OF_USE


def empty_plan_document(unit: str) -> dict[str, Any]:
    """What `plan_on_fit` gives for a plan without items, without looking at the scan."""
    nothing: dict[str, Any] = {"shapes": [], "lesions": [], "notes": [], "missing": []}
    return {"schema": "breastrig/drawing@1", "name": "plan", "unit": unit, "notice": LIMITS_OF_USE} | nothing
