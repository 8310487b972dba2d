"""SUN RGB-D: image/, depth_bfx/ or depth/ (rotated bits), intrinsics.txt, one folder a scene."""

from __future__ import annotations

from pathlib import Path

from geohue.datasets.frames import Dataset, Frame, sorted_files
from geohue.datasets.pairs import camera_beside

_DEEPEST = 5


def matches(folder: Path) -> bool:
    """Whether a scene lies here or some folders below."""
    return next(iter(_scenes(folder, 0)), None) is not None


def load(folder: Path) -> Dataset:
    """List the scenes; depth with filled holes (depth_bfx) only where there is no raw one."""
    frames = []
    for scene in _scenes(folder, 0):
        color = next(iter(sorted_files(scene / "image", "*.jpg", "*.png")), None)
        kinds = [p for n in ("depth", "depth_bfx") if (p := scene / n).is_dir()]
        depth = next((d for kind in kinds for d in sorted_files(kind, "*.png")), None)
        if color is not None and depth is not None:
            name = scene.relative_to(folder).as_posix() if scene != folder else scene.name
            camera = camera_beside(scene, ("intrinsics.txt",))
            frames.append(Frame(name, color, depth, camera, "sun"))
    return Dataset("sunrgbd", folder, frames)


def _scenes(folder: Path, depth: int) -> list[Path]:
    if not folder.is_dir() or depth > _DEEPEST:
        return []
    here = (folder / "intrinsics.txt").is_file() and (folder / "image").is_dir()
    if here and any((folder / name).is_dir() for name in ("depth", "depth_bfx")):
        return [folder]
    inner = sorted(p for p in folder.iterdir() if p.is_dir() and not p.is_symlink())
    return [scene for place in inner for scene in _scenes(place, depth + 1)]
