#version 330
// Ink takes no light.

layout(location = 0) out vec4 facing;
layout(location = 1) out vec4 shown;

void main() {
    facing = vec4(0.5, 0.5, 1.0, 1.0);
    shown = vec4(0.16, 0.16, 0.18, 1.0);
}
