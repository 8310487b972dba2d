"""All frames of a folder, each segmented by itself: over processes or machines, resumable."""

from geohue.batch.items import Item, find_items
from geohue.batch.run import batch
from geohue.batch.settings import Settings

__all__ = ["Item", "Settings", "batch", "find_items"]
