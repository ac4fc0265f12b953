"""Both executors make the same at the edges: the same errors, in the same words and with the same
way to the shape; numbers that snap, are huge, or hardly there; growth that is deep, wide or long.
"""

from __future__ import annotations

import pytest

from ipmlang.compiler import compile_text
from ipmlang.compiler.diagnostics import Diagnostic
from ipmlang.runtime import derive
from ipmlang.runtime.gpu.device import Device
from ipmlang.runtime.scene import Scene
from tests.agreement import assert_agree, outcome

ERRORS = {
    "not-a-number": (
        "A(n) : n > 0 --> F(1 / (n - 1)) A(n - 1)\nA(n) : else --> F\nstart A(3)",
        "A(n) : n > 0 --> [B(1 / (n - 1))] A(n - 1)\nA(n) : else --> F\nB(x) --> F(x)\nstart A(3)",
        "A(n) : n > 0 --> [F(sqrt(n - 2))] A(n - 1)\nA(n) : else --> F\nstart A(3)",
        "A(n) : n > 0 --> *(1e30) F A(n - 1)\nA(n) : else --> F\nstart A(30)",
        "A(n) --> repeat(i < 1 / n) { [F] }\nstart A(0) A(1)",
        "A --> at(1, 2, 3, 0, 0, 0, 0) F\nstart A",
    ),
    "scale-not-positive": ("A(n) : n > 0 --> *(n - 1) F A(n - 1)\nA(n) : else --> F\nstart A(3)",),
    "no-production": ("A(n) : n > 2 --> F [A(n - 1)] A(n - 1)\nstart A(6)",),
    "over-100-percent": (
        "A(n) : (n * 30)% --> F [A(n - 1)]\nA(n) : else --> F\nstart repeat(i < 8) { A(i) }",
    ),
    "out-of-range": (
        "A(n) : weight n --> F\nA(n) : weight 1 --> F F\nstart repeat(i < 4) { A(2 - i) }",
    ),
    "limit-steps": (
        "A --> F [A] A\nlimit steps 12\nstart A",
        "A --> F A\nlimit steps 300\nstart A",
        "A --> F A F\nlimit steps 300\nstart A",
    ),
    "limit-shapes": (
        "A --> split x { ~1: A | ~1: A }\nlimit shapes 3000\nstart A on box(1, 1, 1)",
        "A(n) --> repeat(i < n) { [F] }\nstart A(1e12)",
        "A --> [F] [A] [A]\nlimit shapes 2000\nstart A",
    ),
}
NUMBERS = (
    "A(n) --> repeat(i < n) { [F(i)] } F\n"
    "start A(2.5) A(3.0000000001) A(3.00000001) A(2.9999999999) A(-3) A(0)",
    "A --> split x { { ~2: T }* }\nstart repeat(i < 40) { [size(i * 0.5, 1, 1) A] }",
    "A --> split x { { ~2: T | 0.5: U }+ | ~0.1: T }\nB --> A\n"
    "start repeat(i < 40) { [size(i * 0.25, 1, 1) B] } nil",
    "A(n) --> repeat(i < tiles(n, 0.4)) { [F] }\n"
    "start repeat(k < 60) { [A(k * 0.1)] [A(k * 0.2)] }",
    "A(n) --> repeat(i < floor(n / 0.1)) { [F] }\nstart repeat(k < 60) { [A(k * 0.1)] }",
    "A(n) --> repeat(i < round(n)) { [F] } repeat(i < ceil(n * 3)) { [F] }\n"
    "start repeat(k < 60) { [A(k * 0.25)] [A(k * 0.1)] }",
    "A(n) : mod(n, 0.3) == 0 --> F\nA(n) : else --> F(2)\nstart repeat(k < 60) { [A(k * 0.1)] }",
    "A(n) : n >= 0.3 * 3 --> F\nA(n) : else --> F(2)\nstart repeat(k < 30) { [A(k * 0.1)] }",
    "A(n) : n == 0 --> F(n) F(sign(n))\nA(n) : else --> F(abs(n))\nstart A(-0) A(0 * -1) A(-1)",
    "A(n) --> at(n, n) +(n) F(n) [/(n) F]\nstart repeat(i < 14) { [A(pow(10, i))] }",
    "A(n) --> +(n) F [/(n) F]\nstart [A(1e6)] [A(123456789.5)] [A(1e15)] [A(-720)] [A(1e-300)]",
    "A --> [at(1, 2, 3, 2, 0, 0, 2) F [&(30) F]] [at(0, 0, 1, 1, 1, 1, 1, 2) F]\nstart A",
    "A --> F(gauss(3, 0.5)) +(gauss(0, 90)) F(rand()) F(irand(-9, 9))\n"
    "start repeat(i < 300) { [A] }",
    "A(n) --> F(2 + noise(n, n * 0.7, 3)) F(2 + noise(n)) F(2 + noise(-n, 5))\n"
    "start repeat(i < 300) { [A(i * 0.13)] }",
    "A(n) --> F(exp(n)) F(log(n + 0.1) + 9) F(pow(n, 1.7)) +(atan2(n, 2)) F(tan(n) + 5)\n"
    "    +(asin(n / 50)) +(acos(n / 50)) F\nstart repeat(i < 300) { [A(i * 0.13)] }",
    f"A --> F(pick({', '.join(map(str, range(40)))}))\nstart repeat(i < 300) {{ [A] }}",
)
GROWTH = (
    "A(n) : n > 0 --> F(1) +(3) A(n - 1)\nA(n) : else --> F\nstart A(3000)",
    "A(n) : n > 0 --> F(1) [-(40) F] +(3) A(n - 1)\nA(n) : else --> F\nstart A(900) A(9)",
    "A(n) : n > 0 --> F +(1) [B(n)] A(n - 1)\nA(n) : else --> F\n"
    "B(n) : n > 0 --> F(0.1) B(n - 60)\nB(n) : else --> nil\nstart A(400)",
    "A(n) : n > 0 --> +(10) F A(n - 1) -(10) f(1)\nA(n) : else --> F\nstart A(900) F",
    "A --> repeat(i < 3) except (1) { [F(1 / (i - 1))] [f(1 / (i - 1)) F] }\nstart A",
    "A(n) : n > 0 --> F(1) +(3) A(n - 1) B\nA(n) : else --> F\nB --> -(1) F\nstart A(700)",
    "A(n) : n > 0 --> repeat(i < 6) { [+(i * 60) f(2) *(0.5) A(n - 1)] }\nA(n) : else --> F\n"
    "start A(5)",
    "A --> repeat(i < 100) { repeat(j < 60) { [at(i, j) F] } }\nstart A",
    "A --> repeat(i < 5000) { f(0.1) +(0.01) [F] }\nstart A",
    "A(n) : 30% --> F [A(n)] A(n)\nstart A(1) A(2) steps 9",
    "A --> nil\nstart A",
    "A --> repeat(i < 0) { F }\nstart A",
    "A --> " + "[F " * 60 + "] " * 60 + "F\nstart A A",
    "A --> " + "F(1) +(2) [f(2) F] " * 300 + "\nstart A",
    "A(x) --> " + " ".join(f"with (v{k} = x + {k}) F(v{k})" for k in range(150))
    + " " + " ".join(f"F(v{k})" for k in range(150)) + "\nstart A(1)",
    "".join(f"A : weight {k + 1} --> F({k}) [+({k}) B]\n" for k in range(30))
    + "B --> F\nstart repeat(i < 200) { [A] }",
    "A(a, b, c, d, e, g, h, i, j) : a > 0 --> F(b + c + d + e + g + h + i + j)\n"
    "    [A(a - 1, j, b, c, d, e, g, h, i)]\nA(a, b, c, d, e, g, h, i, j) : else --> F\n"
    "start A(5, 1, 2, 3, 4, 5, 6, 7, 8)",
)  # fmt: skip


@pytest.mark.parametrize(
    ("code", "text"), [(code, text) for code, texts in ERRORS.items() for text in texts]
)
def test_errors_are_the_same(code: str, text: str, card: Device) -> None:
    program = compile_text(f"ipm 1\n{text}\n")[1]
    wanted = outcome(lambda: derive(program, seed=5))
    found = outcome(lambda: derive(program, seed=5, backend="gpu"))
    assert isinstance(wanted, Diagnostic) and wanted.code == code
    assert isinstance(found, Diagnostic)
    assert (found.code, found.message, found.trail) == (code, wanted.message, wanted.trail)


@pytest.mark.parametrize("text", [*NUMBERS, *GROWTH])
def test_scenes_are_the_same(text: str, card: Device) -> None:
    program = compile_text(f"ipm 1\n{text}\n")[1]
    found = outcome(lambda: derive(program, seed=5, backend="gpu"))
    assert_agree(outcome(lambda: derive(program, seed=5)), found)
    assert isinstance(found, Scene) and found.backend == "gpu"
