"""What the audit of the time step has found, in a line."""

from collections.abc import Mapping

import numpy as np

from kneecore.knee.response import Response
from kneecore.knee.step_check import MOVED_DEG

__all__ = ["step_lines"]


def step_lines(responses: Mapping[str, Response]) -> list[str]:
    """Return a line on what half the time step moves, for those knees that were audited."""
    audits = {
        name: np.degrees(np.abs(r.half_step_change))
        for name, r in responses.items()
        if r.half_step_change is not None and r.status != "failed"
    }
    if not audits:
        return []
    name = max(audits, key=lambda one: float(audits[one].max()))
    k = int(np.argmax(audits[name]))
    most = float(audits[name][k])
    what = f"{most:.3f} deg" if np.isfinite(most) else "out of all bounds"
    where = f"{name.replace('_', ' ')} at {responses[name].moment[k]:+g} N m"
    if most > MOVED_DEG:
        return [f"Half the time step moves an angle by more than {MOVED_DEG} deg: {where}, {what}."]
    return [f"Half the time step moves no angle by more than {MOVED_DEG} deg ({where}: {what})."]
