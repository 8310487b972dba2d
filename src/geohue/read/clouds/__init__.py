"""Point clouds as files, one format a module; `cloud.py` knows which is which."""
