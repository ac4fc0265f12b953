#version 330
// One triangle over the whole picture, and where each pixel of it looks.

uniform mat3 rays;  // columns: to the right edge, to the upper edge, to the middle

out vec2 spot;
out vec3 ray;

void main() {
    spot = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    ray = rays * vec3(spot * 2.0 - 1.0, 1.0);
    gl_Position = vec4(spot * 2.0 - 1.0, 0.0, 1.0);
}
