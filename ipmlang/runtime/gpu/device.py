"""The graphics card as a computer: compute shaders, storage buffers, its limits and its trouble.

Takes GLSL and bytes; gives shaders that are compiled once a process and buffers that refuse what
the card cannot hold. Whatever goes wrong is an `IpmError`: `no-opengl` where there is no card,
`gpu-memory` where it is full, `gpu-failed` for all else. It knows no grammar and no bytecode.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from ipmlang.compiler.diagnostics import IpmError, fail
from ipmlang.runtime.gpu import context as contexts
from ipmlang.runtime.gpu.storage import Storage

if TYPE_CHECKING:
    import moderngl

_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software", "microsoft basic render")
_GUARANTEED_BLOCK = 1 << 27  # bytes; what OpenGL 4.3 promises of one storage block
_LARGEST_BLOCK = (1 << 31) - 4  # where a driver's answer does not fit the 32 bits it is asked in
_FULL = "GL_OUT_OF_MEMORY"
_MOST_ERRORS = 16  # a lost context answers every question with an error
_ON_CPU = "derive on the CPU: --backend cpu"

_TROUBLE = frozenset({"no-opengl", "gpu-memory", "gpu-failed"})


@dataclass(frozen=True, slots=True)
class DeviceInfo:
    """Who computes: the card's name and maker, OpenGL's version, the driver's, moderngl's;
    `software`: no card at all, a program that plays one.
    """

    renderer: str
    vendor: str
    opengl: str
    driver: str
    moderngl: str
    software: bool

    def record(self) -> dict[str, object]:
        """The same as JSON."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class DeviceLimits:
    """What one dispatch may use: bytes of a storage block, how many blocks, work groups and their
    size along each axis, invocations of a group.
    """

    block_bytes: int
    blocks: int
    groups: tuple[int, int, int]
    group_size: tuple[int, int, int]
    invocations: int


class Device:
    """An open card. Everything must be asked for in the thread that opened it."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.info = _info_of(context)
        self.limits = _limits_of(context)
        self.lost = False
        self.on_full: Callable[[], None] | None = None  # gives back what is only kept
        self.compile_seconds = 0.0
        self._shaders: dict[str, moderngl.ComputeShader] = {}

    @property
    def is_software(self) -> bool:
        """Whether a program plays the card: right, but slower than numpy."""
        return self.info.software

    def compile(self, source: str, name: str) -> moderngl.ComputeShader:
        """The shader of a text, compiled at its first use; `name` is what an error calls it. What a
        driver leaves until the first dispatch is not in `compile_seconds`.
        """
        contexts.check_thread()
        if source not in self._shaders:
            from moderngl import Error

            begun = time.perf_counter()
            try:
                self._shaders[source] = self.context.compute_shader(source)
            except Error as error:
                message = f"the driver refuses the shader `{name}`: {_first_complaint(str(error))}"
                raise fail("gpu-failed", message, hint=_ON_CPU) from error
            self.compile_seconds += time.perf_counter() - begun
        return self._shaders[source]

    def buffer(self, content: bytes | bytearray | memoryview | int) -> Storage:
        """A storage buffer with this content, or of so many bytes that are not set. Where the card
        is full, what is kept for later goes first.
        """
        contexts.check_thread()
        try:
            return self._allocated(content)
        except IpmError as error:
            give_back, self.on_full = self.on_full, None
            if give_back is None or not is_full(error):
                raise
        give_back()
        return self._allocated(content)

    def _allocated(self, content: bytes | bytearray | memoryview | int) -> Storage:
        size = content if isinstance(content, int) else memoryview(content).nbytes
        if size > self.limits.block_bytes:
            raise self.too_large(size)
        contexts.collect(self.context)
        self._errors()  # what was asked before is no matter; a lost context has no last error
        from moderngl import Error

        try:
            if isinstance(content, int) or not size:
                made = self.context.buffer(reserve=max(size, 4))
            else:
                made = self.context.buffer(content)
        except (Error, MemoryError) as error:
            raise self._full(size) from error
        storage = Storage(made, size)
        errors = self._errors()
        if errors:
            storage.release()
            raise self._full(size) if errors == [_FULL] else self._broken(errors, "buffer")
        return storage

    def dispatch(
        self, shader: moderngl.ComputeShader, groups: int | Sequence[int], name: str
    ) -> None:
        """Run a shader on so many work groups; what it wrote is seen by what is asked for next."""
        contexts.check_thread()
        counts = (groups,) if isinstance(groups, int) else tuple(groups)
        if any(count > most for count, most in zip(counts, self.limits.groups, strict=False)):
            message = f"the shader `{name}` needs {counts} work groups; the card has at most "
            raise fail("gpu-failed", message + str(self.limits.groups), hint=_ON_CPU)
        self._errors()  # what was asked before is no matter; a lost context has no last error
        shader.run(*counts)
        self.context.memory_barrier()
        self.check(name)

    def finish(self, name: str) -> None:
        """Wait until all is computed, and report what went wrong meanwhile."""
        contexts.check_thread()
        self.context.finish()
        self.check(name)

    def check(self, name: str) -> None:
        """Raise what OpenGL has to say against what was asked since the last check."""
        errors = self._errors()
        if not errors:
            return
        raise self._broken(errors, name)

    def _broken(self, errors: Sequence[str], name: str) -> IpmError:
        if _FULL in errors:
            message = f"the graphics card is out of memory in `{name}`"
            return fail("gpu-memory", message, hint=_ON_CPU)
        # A lost context answers for ever, by a name that moderngl does not know.
        self.lost = len(errors) == _MOST_ERRORS or "GL_UNKNOWN_ERROR" in errors
        what = "was lost" if self.lost else f"reports {errors[0]}"
        return fail("gpu-failed", f"the graphics card {what} in `{name}`", hint=_ON_CPU)

    def too_large(self, size: int) -> IpmError:
        """The error of a buffer that no block of this card can be."""
        message = f"the graphics card takes {self.limits.block_bytes:,} bytes in one piece, "
        return fail("gpu-memory", message + f"and {size:,} are needed", hint=_ON_CPU)

    def close(self) -> None:
        """Release shaders and the context; buffers with it, unless pictures still hold it."""
        give_back, self.on_full = self.on_full, None
        if give_back is not None:
            give_back()
        self._shaders.clear()
        contexts.give_back(self.context)

    def _errors(self) -> list[str]:
        """What OpenGL reports, each once, and no more than it takes to see that it never ends."""
        found: list[str] = []
        while len(found) < _MOST_ERRORS and (error := self.context.error) != "GL_NO_ERROR":
            found.append(error)
        return found

    def _full(self, size: int) -> IpmError:
        message = f"the graphics card has no memory for another {size:,} bytes"
        return fail("gpu-memory", message, hint=_ON_CPU)


def is_of_card(error: IpmError) -> bool:
    """Whether an error is the card's, not the grammar's, so that numpy may do better."""
    return error.diagnostics[0].code in _TROUBLE


def is_full(error: IpmError) -> bool:
    """Whether the card has no memory for it; what it can do with less may still be done."""
    return error.diagnostics[0].code == "gpu-memory"


class _Open:
    """The device of this process; compiling costs seconds, so derivations share it."""

    device: Device | None = None


def device() -> Device:
    """The open device, opened now if none is; it stays open until `release` or the process ends.

    Raises IpmError `no-opengl` where there is none with compute shaders, and `gpu-failed` in
    another thread or in a forked process.
    """
    found = _Open.device
    contexts.check_thread()
    if found is not None and found.lost:
        contexts.discard(found.context)
    if found is None or not contexts.is_open(found.context):
        found = _Open.device = Device(contexts.take(contexts.COMPUTING))
    return found


def release() -> None:
    """Close the device, if one is open."""
    contexts.check_thread()
    found, _Open.device = _Open.device, None
    if found is not None:
        found.close()


def _info_of(context: moderngl.Context) -> DeviceInfo:
    from importlib.metadata import version as version_of

    renderer, vendor, version = (
        str(context.info[f"GL_{name}"]) for name in ("RENDERER", "VENDOR", "VERSION")
    )
    number, _, driver = version.partition(" ")
    driver = re.sub(r"^\([^)]*\)\s*", "", driver)  # which profile it is says nothing of the driver
    software = any(name in renderer.lower() for name in _SOFTWARE)
    return DeviceInfo(renderer, vendor, number, driver or vendor, version_of("moderngl"), software)


def _limits_of(context: moderngl.Context) -> DeviceLimits:
    """What the driver says, or the least that OpenGL 4.3 promises where it says nothing."""
    info = context.info
    block = int(info.get("GL_MAX_SHADER_STORAGE_BLOCK_SIZE", _GUARANTEED_BLOCK))
    return DeviceLimits(
        block if 0 < block <= _LARGEST_BLOCK else _LARGEST_BLOCK,
        int(info.get("GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS", 8)),
        _axes(info.get("GL_MAX_COMPUTE_WORK_GROUP_COUNT"), 65535, 65535),
        _axes(info.get("GL_MAX_COMPUTE_WORK_GROUP_SIZE"), 1024, 64),
        int(info.get("GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS", 1024)),
    )


def _axes(found: object, plane: int, depth: int) -> tuple[int, int, int]:
    if isinstance(found, tuple) and len(found) == 3 and all(count > 0 for count in found):
        return int(found[0]), int(found[1]), int(found[2])
    return plane, plane, depth


def _first_complaint(log: str) -> str:
    """The first line that the driver wrote itself, below moderngl's headings."""
    lines = [line.strip() for line in log.splitlines()]
    ruled = [number for number, line in enumerate(lines) if line and not line.strip("=")]
    rest = lines[ruled[-1] + 1 :] if ruled else lines
    return next((line for line in rest if line), "it does not say why")
