#version 330
// A square under the model, wide enough for every shadow that is worth showing.

uniform mat4 projection;
uniform float level;
uniform float reach;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    gl_Position = projection * vec4(corner * reach, level, 1.0);
}
