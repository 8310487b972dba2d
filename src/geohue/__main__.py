"""``python -m geohue``."""

from geohue.cli import main

if __name__ == "__main__":
    main()
