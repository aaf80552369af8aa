"""``python -m mcsim``."""

from mcsim.cli import main

if __name__ == "__main__":
    main()
