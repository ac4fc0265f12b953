"""What shapes ask about each other: occlusion in two passes, totals and lines of earlier phases.

`asking` and `snapping` are what bodies and guards call; `occluders`, `totals` and `lines` answer.
Nothing here makes shapes.
"""
