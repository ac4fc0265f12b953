#version 330
// The ends of an edge, drawn a little towards the eye so that its own faces do not hide it.

in vec3 position;
in vec4 row_x;
in vec4 row_y;
in vec4 row_z;

uniform mat4 projection;
uniform vec3 eye;

void main() {
    vec4 local = vec4(position, 1.0);
    vec3 world = vec3(dot(row_x, local), dot(row_y, local), dot(row_z, local));
    gl_Position = projection * vec4(mix(world, eye, 0.0008), 1.0);
}
