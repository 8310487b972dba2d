"""Pictures, depth maps and disparities as files."""
