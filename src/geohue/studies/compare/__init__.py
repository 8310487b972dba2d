"""Every method on one scene, side by side: the plates of Fig. 8, 9 and 11-13.

>>> from geohue.studies.compare import plan_cells
>>> [cell.name for cell in plan_cells(["nncsc", "edison"], ["fusion", "color"])]
['nncsc-fusion', 'nncsc-color', 'edison-fusion', 'edison-color']
"""

from __future__ import annotations

from geohue.studies.compare.cells import Cell, Comparison, Result, plan_cells
from geohue.studies.compare.plate import draw_plate
from geohue.studies.compare.run import compare

__all__ = ["Cell", "Comparison", "Result", "compare", "draw_plate", "plan_cells"]
