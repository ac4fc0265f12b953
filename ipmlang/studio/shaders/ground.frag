#version 330
// The ground shows nothing of its own: it only takes shadows.

layout(location = 0) out vec4 facing;
layout(location = 1) out vec4 shown;

void main() {
    facing = vec4(0.5, 0.5, 1.0, 2.0 / 3.0);
    shown = vec4(1.0);
}
