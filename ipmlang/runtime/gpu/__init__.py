"""The second executor: the IR as data for one compute shader of OpenGL 4.3.

What comes in is a program, what goes out is the same table of instances that numpy makes: the same
keys, terminals and choices. The numpy executor says what is right. Read `context` (the one OpenGL
context of a process) and `device` (shaders, buffers, what can go wrong) first; OpenGL is imported
only when a device is opened.
"""
