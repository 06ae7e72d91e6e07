from collections.abc import Sequence

__version__: str

def main(argv: Sequence[bytes]) -> int: ...
