"""All frames of a folder, each segmented by itself: over processes or machines, resumable."""

from geohue.studies.batch.items import Item, find_items
from geohue.studies.batch.run import batch
from geohue.studies.batch.settings import Settings

__all__ = ["Item", "Settings", "batch", "find_items"]
