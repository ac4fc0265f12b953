"""SVG on standard input to PNG on standard output: a program of its own, run by `png.py`.

A picture library that meets a hostile file may crash, hang or take all memory; in a process of its
own it can do none of this to us. Arguments: memory limit in bytes, `white` or `transparent`. It
imports nothing of the project, so that it starts quickly.
"""

from __future__ import annotations

import contextlib
import sys


def main() -> int:
    """Rasterize at the size that the SVG states; 3 says that the library is missing."""
    limit, background = int(sys.argv[1]), sys.argv[2]
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource  # not on Windows

        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    try:
        import pyvips
    except (ImportError, OSError) as error:
        print(error, file=sys.stderr)
        return 3
    try:
        image = pyvips.Image.svgload_buffer(sys.stdin.buffer.read(), unlimited=True)
        if background == "white":
            image = image.flatten(background=[255, 255, 255])
        sys.stdout.buffer.write(image.write_to_buffer(".png", keep=0))
    except pyvips.Error as error:
        print(error.detail or error.message, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
