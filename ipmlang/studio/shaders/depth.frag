#version 330
// Depth alone, of what is solid.

void main() {}
