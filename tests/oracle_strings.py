"""A slow, obviously right string L-system and turtle, to hold the engine against.

Programs are plain data (`System`): modules are (name, arguments), expressions are nested tuples.
Strings are Python lists that are rewritten one module after the other; the turtle walks them with a
stack and 3 x 3 matrices. Only the key scheme is shared with the engine, through its single-number
functions, because draws are part of what is compared.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ipmlang.runtime import keys

# 2.0 | ("p", i) | ("uniform", site) | ("index", repeat) | ("add" | "mul" | "sub" | "lt" …, a, b)
Expr = float | tuple
# ("[",) | ("]",) | (name, *exprs) | ("repeat", number, count, body, holes)
Element = tuple


@dataclass
class Rule:
    head: str
    body: list[Element]
    guard: Expr | None = None
    chance: tuple[str, Expr] | None = None
    left: list = field(default_factory=list)  # names, or lists for branches on the right
    right: list = field(default_factory=list)
    interpret: bool = False


@dataclass
class System:
    axiom: list[Element]
    rules: list[Rule]
    steps: int | None
    arity: dict[str, int]
    ignore: tuple[str, ...] = ()
    planar: bool = True
    tropism: tuple[float, float, float, float] | None = None


@dataclass
class Module:
    name: str
    args: tuple[float, ...]
    key: tuple[int, int] = (0, 0)
    silent: bool = False


def value(expr: Expr, params: list[float], key: tuple[int, int], copies: dict[int, int]) -> float:
    if not isinstance(expr, tuple):
        return float(expr)
    match expr[0]:
        case "p":
            return params[expr[1]]
        case "uniform":
            return keys.uniform_single(*key, expr[1], *copies.values())
        case "index":
            return float(copies[expr[1]])
    a, b = (value(each, params, key, copies) for each in expr[1:])
    match expr[0]:
        case "add":
            return a + b
        case "sub":
            return a - b
        case "mul":
            return a * b
        case "lt":
            return float(a < b)
        case "ge":
            return float(a >= b)
    raise AssertionError(expr)


def successor(
    body: list[Element],
    params: list[float],
    module: Module,
    sites: list[int],
    copies: dict[int, int],
    silent: bool,
) -> list[Module]:
    out: list[Module] = []
    start = sites[0]
    for element in body:
        if element[0] == "repeat":
            _, number, count, inner, holes = element
            times = value(count, params, module.key, copies)
            begin = sites[0]
            for index in range(max(0, math.ceil(times - 1e-9))):
                sites[0] = begin
                out += successor(
                    inner,
                    params,
                    module,
                    sites,
                    {**copies, number: index},
                    silent or any(value(h, params, module.key, copies) == index for h in holes),
                )
            sites[0] = begin + count_sites(inner)
        elif element[0] in "[]":
            out.append(Module(element[0], ()))
        else:
            args = tuple(value(each, params, module.key, copies) for each in element[1:])
            key = keys.child_single(*module.key, sites[0], *copies.values())
            sites[0] += 1
            out.append(Module(element[0], args, key, silent))
    assert sites[0] == start + count_sites(body)
    return out


def count_sites(body: list[Element]) -> int:
    return sum(count_sites(e[3]) if e[0] == "repeat" else 0 if e[0] in "[]" else 1 for e in body)


def close_of(string: list[Module], at: int) -> int:
    depth = 0
    for i in range(at, len(string)):
        depth += {"[": 1, "]": -1}.get(string[i].name, 0)
        if depth == 0:
            return i
    raise AssertionError


def left_of(string: list[Module], at: int, ignore: tuple[str, ...]) -> int:
    at -= 1
    depth = 0
    while at >= 0:
        name = string[at].name
        if name == "]":
            depth += 1
        elif name == "[":
            depth -= depth > 0
        elif depth == 0 and name not in ignore:
            return at
        at -= 1
    return -1


def matches_left(string: list[Module], at: int, names: list, system: System) -> list[float] | None:
    found: list[float] = []
    for name in reversed(names):
        at = left_of(string, at, system.ignore)
        if at < 0 or name not in ("*", string[at].name):
            return None
        found = (list(string[at].args) if name != "*" else []) + found
    return found


def matches_right(string: list[Module], at: int, names: list, system: System) -> list[float] | None:
    """Match names from position `at` on, which is the first that may match."""
    found: list[float] = []
    for name in names:
        if isinstance(name, list):
            while at < len(string) and string[at].name in system.ignore:
                at += 1
            inner = None
            while inner is None:
                while at < len(string) and string[at].name in system.ignore:
                    at += 1
                if at >= len(string) or string[at].name != "[":
                    return None
                inner = matches_right(string, at + 1, name, system)
                at = close_of(string, at) + 1
            found += inner
            continue
        while at < len(string) and string[at].name in ("[", *system.ignore):
            at = close_of(string, at) + 1 if string[at].name == "[" else at + 1
        if at >= len(string) or string[at].name == "]" or name not in ("*", string[at].name):
            return None
        found += list(string[at].args) if name != "*" else []
        at += 1
    return found


def rewrite(
    string: list[Module], at: int, rules: list[Rule], system: System
) -> list[Module] | None:
    """The successor of one module, None when no rule applies."""
    module = string[at]
    held: list[tuple[Rule, list[float]]] = []
    for rule in rules:
        left = matches_left(string, at, rule.left, system)
        right = matches_right(string, at + 1, rule.right, system)
        if left is None or right is None:
            continue
        params = left + list(module.args) + right
        if rule.guard is not None and not value(rule.guard, params, module.key, {}):
            continue
        held.append((rule, params))
    u, total = keys.choice_single(*module.key), 0.0
    weights = sum(
        value(r.chance[1], p, module.key, {})
        for r, p in held
        if r.chance and r.chance[0] == "weight"
    )
    for rule, params in held:
        if rule.chance:
            amount = value(rule.chance[1], params, module.key, {})
            total += (
                amount / 100 if rule.chance[0] == "percent" else amount / weights if weights else 0
            )
            if u >= total:
                continue
        return successor(rule.body, params, module, [0], {}, module.silent)
    return None


def cut(string: list[Module]) -> list[Module]:
    """Each `cut` goes with the rest of its branch; a polygon or path still closes."""
    out: list[Module] = []
    skip = None
    depth = braces = 0
    for module in string:
        depth += module.name == "["
        if module.name == "cut" and skip is None:
            skip, braces = depth, 0
        if module.name == "]" and skip == depth:
            skip = None
        depth -= module.name == "]"
        braces += (
            {"{": 1, "}": -1, "path{": 1, "}path": -1}.get(module.name, 0)
            if skip is not None
            else 0
        )
        if skip is None or braces < 0:
            out.append(module)
            braces = 0
    return out


def derive(system: System, seed: int) -> list[Module]:
    axiom = Module("", (), keys.root(seed))
    string = cut(successor(system.axiom, [], axiom, [0], {}, False))
    plain = [rule for rule in system.rules if not rule.interpret]
    heads = {rule.head for rule in plain}
    step = 0
    while step != system.steps and any(module.name in heads for module in string):
        step += 1
        after: list[Module] = []
        for at, module in enumerate(string):
            rules = [rule for rule in plain if rule.head == module.name]
            made = rewrite(string, at, rules, system) if rules else [module]
            if made is None:
                assert system.steps is not None, "no rule applies"
                key = keys.child_single(*module.key, keys.CHOICE_SITE)
                made = [Module(module.name, module.args, key, module.silent)]
            after += made
        string = cut(after)
    return string


def interpret(system: System, string: list[Module]) -> list[Module]:
    rules = [rule for rule in system.rules if rule.interpret]
    after: list[Module] = []
    for at, module in enumerate(string):
        own = [rule for rule in rules if rule.head == module.name]
        made = rewrite(string, at, own, system) if own else None
        after += [module] if made is None else made
    return cut(after)


@dataclass
class State:
    position: np.ndarray
    axes: np.ndarray  # columns: what local x, y, z become, handedness and scale included
    pens: dict[str, float]
    layer: float = 0.0

    def copy(self) -> State:
        return State(self.position.copy(), self.axes.copy(), dict(self.pens), self.layer)


def about(axis: str, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array(
        {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
    )


TURNS = {
    "+": ("z", 1),
    "-": ("z", -1),
    "&": ("y", 1),
    "^": ("y", -1),
    "\\": ("x", -1),
    "/": ("x", 1),
}


@dataclass
class Line:
    """The parts of a path, points each."""

    parts: list[list[np.ndarray]]

    def draw(self, begin: np.ndarray, end: np.ndarray) -> None:
        if not self.parts or abs(self.parts[-1][-1] - begin).max() > 1e-8:
            self.parts.append([begin])
        self.parts[-1].append(end)

    def mark(self, point: np.ndarray) -> None:
        if not self.parts:
            self.parts.append([])
        self.parts[-1].append(point)


def walk(system: System, string: list[Module], upright: bool = False) -> tuple[list, list]:
    """Rows (kind, position, axes, argument, pens, layer, key) and outlines, in order: the corners
    of a polygon, or the points of each part of a path.
    """
    axes = np.eye(3)
    if upright:
        axes = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
    state = State(np.zeros(3), axes, {"width": math.nan})
    stack: list[State] = []
    polygons: list[list] = []
    opened: list[list | Line] = []
    rows: list[tuple] = []
    for module in string:
        name, args = module.name, module.args
        if name == "[":
            stack.append(state.copy())
        elif name == "]":
            state = stack.pop()
        elif name in TURNS:
            # on the right of the matrix: a mirrored frame turns the mirrored way by itself
            axis, sign = TURNS[name]
            state.axes = state.axes @ about(axis, sign * args[0])
        elif name in ("F", "f"):
            begin = state.position.copy()
            state.position = begin + state.axes @ np.array([args[0], 0, 0])
            if opened and isinstance(opened[-1], Line):
                if name == "F" and not module.silent:
                    opened[-1].draw(begin, state.position.copy())
            elif opened:
                opened[-1] += [begin, state.position.copy()]
            elif name == "F" and not module.silent:
                rows.append(
                    (
                        "F",
                        begin,
                        state.axes.copy(),
                        args[0],
                        dict(state.pens),
                        state.layer,
                        module.key,
                    )
                )
            if name == "F" and system.tropism is not None:
                bend(state, system.tropism)
        elif name == "at":
            begin = state.position
            state.position = begin + state.axes @ np.array([args[0], args[1], 0])
            if opened and not isinstance(opened[-1], Line):
                opened[-1] += [begin, state.position]
        elif name == "*":
            state.axes = state.axes * args[0]
        elif name == "mirror":
            state.axes = state.axes @ np.diag([-1.0, 1, 1])
        elif name == "$":
            level(state)
        elif name == "!":
            state.pens["width"] = args[0]
        elif name == "layer":
            state.layer += args[0]
        elif name == "{":
            opened.append([])
        elif name == "path{":
            opened.append(Line([]))
        elif name == "}path":
            line = opened.pop()
            assert isinstance(line, Line)
            parts = [part for part in line.parts if len(part) > 1]
            if parts and not module.silent:
                polygons.append(parts)
                rows.append(
                    ("}", np.zeros(3), np.eye(3), 0.0, dict(state.pens), state.layer, module.key)
                )
        elif name == "}":
            points = opened.pop()
            assert not isinstance(points, Line)
            kept = [
                p for i, p in enumerate(points) if i == 0 or abs(p - points[i - 1]).max() > 1e-9
            ]
            if len(kept) > 1 and abs(kept[0] - kept[-1]).max() < 1e-9:
                kept.pop()
            if len(kept) >= 3 and not module.silent:
                polygons.append(kept)
                rows.append(
                    ("}", np.zeros(3), np.eye(3), 0.0, dict(state.pens), state.layer, module.key)
                )
        elif name == "vertex" and opened:
            here = opened[-1]
            (here.mark if isinstance(here, Line) else here.append)(state.position.copy())
        elif name == "asset" and not module.silent:
            rows.append(
                (
                    "asset",
                    state.position.copy(),
                    state.axes.copy(),
                    0.0,
                    dict(state.pens),
                    state.layer,
                    module.key,
                )
            )
    return rows, polygons


def turned_world(state: State, axis: np.ndarray, radians: float) -> None:
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    state.axes = (
        np.eye(3) + math.sin(radians) * cross + (1 - math.cos(radians)) * cross @ cross
    ) @ state.axes


def bend(state: State, tropism: tuple[float, float, float, float]) -> None:
    heading = state.axes[:, 0] / np.linalg.norm(state.axes[:, 0])
    torque = np.cross(heading, tropism[:3])
    length = np.linalg.norm(torque)
    if length > 1e-12:
        turned_world(state, torque / length, tropism[3] * length)


def level(state: State) -> None:
    size = np.linalg.norm(state.axes[:, 0])
    heading = state.axes[:, 0] / size
    left = np.cross([0, 0, 1], heading)
    if np.linalg.norm(left) < 1e-12:
        return
    left /= np.linalg.norm(left)
    hand = np.sign(np.linalg.det(state.axes))
    state.axes = size * np.column_stack((heading, left * hand, np.cross(heading, left)))
