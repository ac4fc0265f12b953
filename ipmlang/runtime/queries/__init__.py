"""What shapes ask about each other: occlusion in two passes, and totals of earlier phases.

`asking` is what bodies and guards call; `occluders` and `totals` answer. Nothing here makes shapes.
"""
