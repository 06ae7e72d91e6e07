"""The command: ``python -m momentree``, and the script ``momentree`` that pip installs."""

import os
import sys

from momentree._core import main as _main


def main() -> int:
    """Run the command with the arguments of this process.

    Returns:
        The exit code: 0 done, 1 the simulation failed, 2 bad input or usage, 3 interrupted.
    """
    # As the system gave them: a file's name need not be text.
    return _main([b"momentree", *map(os.fsencode, sys.argv[1:])])


if __name__ == "__main__":
    sys.exit(main())
