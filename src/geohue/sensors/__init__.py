"""Range sensors with colour cameras beside them: registration, and colours for range points."""
