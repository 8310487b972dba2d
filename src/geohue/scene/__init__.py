"""What every sensor becomes: one kind of scene, made above the sources, which give arrays."""

from geohue.scene.data import SceneData
from geohue.scene.scene import Scene

__all__ = ["Scene", "SceneData"]
