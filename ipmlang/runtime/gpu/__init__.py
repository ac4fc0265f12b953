"""The second executor: the IR as data for one compute shader.

What comes in is a program, what goes out is the same table of instances that numpy makes. The
numpy executor says what is right. OpenGL is imported only when a device is opened.
"""
