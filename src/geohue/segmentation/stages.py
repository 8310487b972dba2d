"""The stages of a run, in words."""

STAGES = {
    "features": "reading colour and geometry",
    "limbs": "looking for limbs",
    "cuts": "letting many cuts vote",
    "merge": "merging regions",
    "borders": "drawing borders",
    "k": "choosing the number of segments",
    "weight": "choosing the weight",
    "cut": "cutting the scene",
    "refine": "removing small regions",
    "quality": "measuring the quality",
    "reunite": "reuniting parts of a surface",
    "fill": "filling pixels without depth",
}
"""What to tell the user as each stage of `geohue.segment` begins."""
