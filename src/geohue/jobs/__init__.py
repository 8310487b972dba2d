"""Many independent jobs: over processes, resumable, none of which can stop the others."""
