"""The words of `turtle` and `limit` items: what each sets, and what holds without it."""

from __future__ import annotations

from ipmlang.compiler.ops.record import SettingRecord

TABLE = (
    SettingRecord("turtle", "angle", "number",
                  "Degrees that `+`, `-`, `&` and the other turns take without an argument.", 90.0),
    SettingRecord("turtle", "step", "number",
                  "Distance that `F` and `f` take without an argument.", 1.0),
    SettingRecord("turtle", "width", "number",
                  "Width that the pen starts with, and that `!` sets without an argument.", 1.0,
                  above=0),
    SettingRecord("turtle", "frame", "string",
                  "`abop` starts a 3-D turtle as the book does: heading +x, left +y, up +z.",
                  None, words=("abop",)),
    SettingRecord("limit", "shapes", "int",
                  "Most shapes that a derivation may make in all; where modules thread, operations "
                  "and brackets count, too.",
                  50_000_000.0, above=0),
    SettingRecord("limit", "steps", "int", "Most generations; 5,000 where there are scopes.",
                  200_000.0, above=0),
    SettingRecord("limit", "depth", "int", "Greatest depth of the derivation tree.",
                  200_000.0, above=0),
    SettingRecord("limit", "memory", "int", "Most bytes, beyond what the process had at its start.",
                  8e9, above=0),
)  # fmt: skip

VERSIONS = (1,)
DIRECTIONS = ("uniform", "up", "down")  # `start … direction`: where walkers first look
AVOIDABLE = ("collisions",)  # `start … avoiding`
