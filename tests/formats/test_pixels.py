"""Pictures and fields as numbers: every kind of PNG, JPEG and .npy, and what is refused."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ipmlang.formats import FormatError
from ipmlang.formats.pixels import Extent, pixel_extent, read_pixels

RANDOM = np.random.default_rng(2)


def png(path: Path, color: int, depth: int, rows: bytes, size: tuple[int, int]) -> None:
    """A PNG written by hand."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        body = kind + content
        return struct.pack(">I", len(content)) + body + struct.pack(">I", zlib.crc32(body))

    head = struct.pack(">IIBBBBB", *size, depth, color, 0, 0, 0)
    content = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + content)


@pytest.mark.parametrize(("mode", "channels"), [("L", 1), ("LA", 2), ("RGB", 3), ("RGBA", 4)])
def test_a_png_has_its_numbers(mode: str, channels: int, tmp_path: Path) -> None:
    numbers = RANDOM.integers(0, 256, (5, 7, channels), dtype=np.uint8)
    path = tmp_path / "a.png"
    Image.fromarray(numbers if channels > 1 else numbers[:, :, 0], mode).save(path)
    assert pixel_extent(path) == Extent(7, 5, channels)
    pixels = read_pixels(path)
    assert pixels.white == 255
    np.testing.assert_array_equal(pixels.numbers, numbers)


def test_a_png_of_16_bits_keeps_them(tmp_path: Path) -> None:
    numbers = RANDOM.integers(0, 65536, (3, 4), dtype=np.uint16)
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in numbers)
    png(tmp_path / "a.png", 0, 16, rows, (4, 3))
    pixels = read_pixels(tmp_path / "a.png")
    assert pixels.white == 65535
    np.testing.assert_array_equal(pixels.numbers[:, :, 0], numbers)


def test_grey_with_opacity_of_16_bits_has_two_channels(tmp_path: Path) -> None:
    png(tmp_path / "a.png", 4, 16, b"\0" + bytes([200, 0, 100, 0]), (1, 1))
    assert pixel_extent(tmp_path / "a.png").channels == 2
    assert read_pixels(tmp_path / "a.png").numbers.tolist() == [[[200, 100]]]


@pytest.mark.parametrize(
    ("depth", "row", "expected"),
    [(1, 0b10100000, [255, 0, 255]), (2, 0b00011000, [0, 85, 170]), (4, 0x0F, [0, 255])],
)
def test_few_bits_are_spread(depth: int, row: int, expected: list[int], tmp_path: Path) -> None:
    png(tmp_path / "a.png", 0, depth, bytes([0, row]), (len(expected), 1))
    pixels = read_pixels(tmp_path / "a.png")
    assert (pixels.numbers[0, :, 0] / pixels.white * 255).tolist() == expected


@pytest.mark.parametrize("opacity", [False, True])
def test_a_palette_gives_its_colours(opacity: bool, tmp_path: Path) -> None:
    image = Image.new("P", (2, 1))
    image.putpalette([10, 20, 30, 40, 50, 60])
    image.putdata([1, 0])
    image.save(tmp_path / "a.png", **({"transparency": 0} if opacity else {}))
    expected = [[[40, 50, 60, 255], [10, 20, 30, 0]]]
    channels = 4 if opacity else 3
    assert pixel_extent(tmp_path / "a.png").channels == channels
    found = read_pixels(tmp_path / "a.png").numbers
    assert found.tolist() == [[each[:channels] for each in expected[0]]]


@pytest.mark.parametrize(("mode", "channels"), [("L", 1), ("RGB", 3)])
def test_a_jpeg(mode: str, channels: int, tmp_path: Path) -> None:
    Image.new(mode, (9, 6), 200 if channels == 1 else (200, 100, 50)).save(tmp_path / "a.jpg")
    assert pixel_extent(tmp_path / "a.jpg") == Extent(9, 6, channels)
    assert read_pixels(tmp_path / "a.jpg").numbers.shape == (6, 9, channels)


@pytest.mark.parametrize("kind", ["u1", "i4", ">f4", "f8", "?"])
@pytest.mark.parametrize("shape", [(4, 3), (4, 3, 1), (4, 3, 2), (1, 1, 4)])
def test_a_field_has_its_numbers(kind: str, shape: tuple[int, ...], tmp_path: Path) -> None:
    numbers = (RANDOM.random(shape) * 9).astype(kind)
    np.save(tmp_path / "a.npy", numbers)
    channels = shape[2] if len(shape) == 3 else 1
    assert pixel_extent(tmp_path / "a.npy") == Extent(shape[1], shape[0], channels)
    pixels = read_pixels(tmp_path / "a.npy")
    assert pixels.white == 1
    np.testing.assert_array_equal(pixels.numbers, numbers.reshape(*shape[:2], channels))


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        (np.array([[1, np.nan], [np.inf, 0]]), "is finite: 2 of 4 are not.*row 0, column 1"),
        (np.zeros(3), r"shape \(3,\)"),
        (np.zeros((2, 2, 5)), r"shape \(2, 2, 5\)"),
        (np.zeros((0, 4)), "empty"),
        (np.array([["a"]]), "holds <U1"),
        (np.array([[{}]], object), "holds object"),
        (np.zeros((1, 1), complex), "holds complex128"),
    ],
)
def test_a_field_that_is_none(numbers: np.ndarray, message: str, tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", numbers, allow_pickle=True)
    with pytest.raises(FormatError, match=message):
        read_pixels(tmp_path / "a.npy")


@pytest.mark.parametrize("size", [0, 5, 20, 60, 90, 127])
@pytest.mark.parametrize("name", ["a.npy", "a.png", "a.jpg"])
def test_what_is_cut_off_is_an_error(name: str, size: int, tmp_path: Path) -> None:
    path = tmp_path / name
    if name == "a.npy":
        np.save(path, np.ones((4, 4)))
    else:
        Image.fromarray(RANDOM.integers(0, 256, (9, 9), dtype=np.uint8)).save(path)
    path.write_bytes(path.read_bytes()[:size])
    with pytest.raises(FormatError):
        read_pixels(path)


def test_what_is_too_large_is_refused_by_its_head_alone(tmp_path: Path) -> None:
    png(tmp_path / "a.png", 0, 8, b"", (20_000, 20_000))
    with pytest.raises(FormatError, match="20,000 x 20,000 pixels: over 67,108,864 pixels"):
        pixel_extent(tmp_path / "a.png")
    np.save(tmp_path / "a.npy", np.zeros((1, 1)))
    content = (tmp_path / "a.npy").read_bytes()
    content = content.replace(b"(1, 1), }      ", b"(9999, 9999), }")
    (tmp_path / "a.npy").write_bytes(content)
    with pytest.raises(FormatError, match="9,999 x 9,999 pixels: over 67,108,864 numbers"):
        pixel_extent(tmp_path / "a.npy")


@pytest.mark.parametrize("head", ["{'descr': (", "{'shape': (1, 1)}", "[[[", "  1\n 2", "\0"])
def test_a_broken_head_of_a_field(head: str, tmp_path: Path) -> None:
    text = head.ljust(117).encode() + b"\n"
    (tmp_path / "a.npy").write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text)
    with pytest.raises(FormatError, match="no array"):
        read_pixels(tmp_path / "a.npy")


@pytest.mark.parametrize("name", ["a.png", "a.npy", "a.jpg"])
def test_a_folder_or_nothing_is_no_picture(name: str, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="cannot read"):
        pixel_extent(tmp_path / name)
    (tmp_path / name).mkdir()
    with pytest.raises(FormatError, match="cannot read"):
        pixel_extent(tmp_path / name)
