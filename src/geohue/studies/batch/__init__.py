"""All frames of a folder, each segmented by itself: over processes or machines, resumable."""

from geohue.studies.batch.run import batch
from geohue.studies.batch.settings import Settings
from geohue.studies.items import Item, find_items

__all__ = ["Item", "Settings", "batch", "find_items"]
