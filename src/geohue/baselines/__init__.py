"""The systems the paper compares with (Fig. 3, 8-13), one file each, behind one table.

>>> from geohue.baselines import BASELINES
>>> BASELINES["edison"].cues
('color', 'geometry')
"""

from __future__ import annotations

from geohue.baselines.registry import BASELINES, Baseline, Job, register_method

__all__ = ["BASELINES", "Baseline", "Job", "register_method"]
