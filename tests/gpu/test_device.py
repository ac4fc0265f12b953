"""The device: what it computes, holds and refuses, who may use it, and what it says in bad luck."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ipmlang.compiler.diagnostics import Diagnostic, IpmError
from ipmlang.runtime.gpu import context as contexts
from ipmlang.runtime.gpu import device as devices
from ipmlang.runtime.gpu.device import Device, device, release

DOUBLED = """#version 430
layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Values { uint values[]; };
void main() { values[gl_GlobalInvocationID.x] *= 2u; }
"""


def the_error(caught: pytest.ExceptionInfo[IpmError]) -> Diagnostic:
    (found,) = caught.value.diagnostics
    return found


def test_a_shader_computes(card: Device) -> None:
    values = np.arange(128, dtype=np.uint32)
    buffer = card.buffer(values.tobytes())
    buffer.bind(0)
    card.dispatch(card.compile(DOUBLED, "doubled"), 2, "doubled")
    assert (buffer.array(np.uint32) == 2 * values).all()
    assert buffer.array(np.uint32, 2, offset=8).tolist() == [4, 6]
    buffer.release()


def test_buffers_are_written_copied_and_cleared(card: Device) -> None:
    first, second = card.buffer(16), card.buffer(16)
    first.write(np.array([[1.5], [2.5]]))
    second.clear()
    first.copy_to(second, 8, offset=8, there=0)
    assert second.array(np.float64).tolist() == [2.5, 0.0]
    assert first.read(8) == np.float64(1.5).tobytes()
    empty = card.buffer(b"")
    empty.write(b"")
    assert empty.read() == b""
    assert len(empty.array(np.float64)) == 0
    for each in (first, second, empty):
        each.release()


def test_a_shader_is_compiled_once(card: Device) -> None:
    assert card.compile(DOUBLED, "doubled") is card.compile(DOUBLED, "again")


def test_a_wrong_shader_is_told_by_its_first_complaint(card: Device) -> None:
    with pytest.raises(IpmError) as caught:
        card.compile("#version 430\nlayout(local_size_x = 1) in;\nvoid main() { x = 1; }", "vm")
    assert the_error(caught).code == "gpu-failed"
    assert "the shader `vm`" in the_error(caught).message
    assert "x" in the_error(caught).message.partition("`vm`")[2]
    assert "=====" not in the_error(caught).message
    assert "\n" not in the_error(caught).message


def test_a_buffer_beyond_one_block_is_refused_unasked(card: Device) -> None:
    card.limits = replace(card.limits, block_bytes=1 << 20)
    with pytest.raises(IpmError) as caught:
        card.buffer((1 << 20) + 1)
    assert the_error(caught).code == "gpu-memory"
    assert "1,048,577" in the_error(caught).message
    card.buffer(1 << 20).release()


def test_a_full_card_is_told(card: Device) -> None:
    card.limits = replace(card.limits, block_bytes=1 << 60)
    with pytest.raises(IpmError) as caught:
        card.buffer(1 << 55)
    assert the_error(caught).code == "gpu-memory"
    card.finish("what follows")  # and leaves nothing that a later check would stumble over


def test_too_many_work_groups_are_refused(card: Device) -> None:
    with pytest.raises(IpmError) as caught:
        card.dispatch(card.compile(DOUBLED, "doubled"), (1, card.limits.groups[1] + 1), "wide")
    assert the_error(caught).code == "gpu-failed"


def test_info_and_limits_are_what_the_driver_says(card: Device) -> None:
    assert card.info.renderer == card.context.info["GL_RENDERER"]
    assert card.info.opengl[0] == "4"
    assert set(card.info.record()) == {
        "renderer", "vendor", "opengl", "driver", "moderngl", "software",
    }  # fmt: skip
    assert card.limits.block_bytes >= 1 << 27
    assert card.limits.blocks >= 8
    assert min(card.limits.groups) >= 65535
    assert card.is_software == any(name in card.info.renderer for name in ("llvmpipe", "softpipe"))


class _Driver:
    """A context whose driver says what a test wants it to say."""

    def __init__(self, *, info: dict[str, Any] | None = None, errors: tuple[str, ...] = ()) -> None:
        self.info = {
            "GL_RENDERER": "NVIDIA H200/PCIe/SSE2",
            "GL_VENDOR": "NVIDIA Corporation",
            "GL_VERSION": "4.6.0 NVIDIA 580.159.04",
        } | (info or {})
        self.version_code = 460
        self.left = list(errors)

    @property
    def error(self) -> str:
        return self.left.pop(0) if self.left else "GL_NO_ERROR"


def test_a_real_card_is_none_of_software() -> None:
    told = Device(_Driver()).info  # type: ignore[arg-type]
    assert (told.driver, told.opengl, told.software) == ("NVIDIA 580.159.04", "4.6.0", False)


def test_limits_that_do_not_fit_or_are_not_told() -> None:
    strange = {"GL_MAX_SHADER_STORAGE_BLOCK_SIZE": -1, "GL_MAX_COMPUTE_WORK_GROUP_COUNT": (0, 0, 0)}
    limits = Device(_Driver(info=strange)).limits  # type: ignore[arg-type]
    assert limits.block_bytes > 1 << 30
    assert limits.groups == (65535,) * 3
    assert Device(_Driver()).limits.block_bytes == 1 << 27  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("errors", "code", "said", "lost"),
    [
        (("GL_OUT_OF_MEMORY",), "gpu-memory", "out of memory", False),
        (("GL_INVALID_OPERATION",), "gpu-failed", "GL_INVALID_OPERATION", False),
        (("GL_UNKNOWN_ERROR",) * 99, "gpu-failed", "was lost", True),
    ],
)
def test_errors_of_the_driver(errors: tuple[str, ...], code: str, said: str, lost: bool) -> None:
    broken = Device(_Driver(errors=errors))  # type: ignore[arg-type]
    with pytest.raises(IpmError) as caught:
        broken.check("derive")
    assert the_error(caught).code == code
    assert said in the_error(caught).message
    assert "--backend cpu" in (the_error(caught).hint or "")
    assert broken.lost is lost


def test_after_a_lost_context_comes_another(card: Device) -> None:
    card.lost = True
    fresh = device()
    assert fresh is not card
    assert not fresh.lost
    fresh.buffer(4).release()


def test_buffers_of_a_released_card_leave_those_of_the_next_alone(card: Device) -> None:
    old = card.buffer(8)
    release()
    new = device().buffer(np.float64(2.5).tobytes())
    old.release()
    assert new.array(np.float64).tolist() == [2.5]


def test_one_device_until_it_is_released(card: Device) -> None:
    assert device() is card
    release()
    assert device() is not card
    release()
    release()  # which is nothing to do


def test_the_context_outlives_pictures_and_they_share_it(card: Device) -> None:
    from ipmlang.studio.context import gl_context

    with gl_context() as context:
        assert context is card.context
    card.buffer(4).release()
    assert "Invalid" not in type(card.context.mglo).__name__


def test_another_thread_is_refused(card: Device) -> None:
    found: list[str] = []

    def ask() -> None:
        for what in (device, lambda: card.buffer(4), lambda: card.compile(DOUBLED, "d"), release):
            try:
                what()
            except IpmError as error:
                found.append(error.diagnostics[0].message)

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    assert len(found) == 4
    assert all("another thread" in each for each in found)
    card.buffer(4).release()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked here")
@pytest.mark.parametrize("released", [False, True])
def test_a_forked_process_is_refused(card: Device, released: bool) -> None:
    if released:
        release()
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            devices.device()
            said = "it computes"
        except IpmError as error:
            said = error.diagnostics[0].message
        os.write(write, said.encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.close(write)
    with os.fdopen(read) as told:
        assert "forked" in told.read()
    device().buffer(4).release()


def _renderer() -> str:
    return device().info.renderer


def test_a_spawned_process_has_its_own(card: Device) -> None:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(_renderer) == card.info.renderer


@pytest.mark.usefixtures("no_device")
def test_without_opengl_the_packages_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(version: int, **settings: str) -> None:
        raise Exception("libEGL.so.1 not loaded")  # what the library raises is no better

    monkeypatch.setattr(contexts, "_context", nothing)
    with pytest.raises(IpmError) as caught:
        device()
    assert the_error(caught).code == "no-opengl"
    assert "OpenGL 4.3" in the_error(caught).message
    assert contexts.PACKAGES in (the_error(caught).hint or "")


@pytest.mark.usefixtures("no_device")
def test_an_old_card_draws_but_does_not_compute(monkeypatch: pytest.MonkeyPatch) -> None:
    made = contexts._context

    def old(version: int, **settings: str) -> object:
        if version > 330:
            raise ValueError("Requested OpenGL version 430, got version 330")
        context = made(version, **settings)
        context.version_code = 330
        return context

    monkeypatch.setattr(contexts, "_context", old)
    with contexts.shared_context(contexts.DRAWING), pytest.raises(IpmError) as caught:
        device()
    assert the_error(caught).code == "no-opengl"
    assert "3.3" in the_error(caught).message


def test_a_process_ends_quietly_with_the_device_open(card: Device) -> None:
    ask = "from ipmlang.runtime.gpu.device import device; device().buffer(64)"
    ended = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")
