#version 330
// Corners of a mesh under the matrix of their copy: into the picture, with what the surface needs.

in vec3 position;
in vec4 normal;  // and in w what tells copies apart
in vec4 color;
in vec2 uv;
in vec4 row_x;
in vec4 row_y;
in vec4 row_z;
in vec4 paint;

uniform mat4 projection;
uniform float passes;

out vec3 world;
out vec3 outward;
out vec4 tone;
out vec2 place;
flat out float chance;

void main() {
    vec4 local = vec4(position, 1.0);
    world = vec3(dot(row_x, local), dot(row_y, local), dot(row_z, local));
    // The cofactors of the matrix turn normals, also where it flattens or mirrors.
    outward = vec3(
        dot(cross(row_y.xyz, row_z.xyz), normal.xyz),
        dot(cross(row_z.xyz, row_x.xyz), normal.xyz),
        dot(cross(row_x.xyz, row_y.xyz), normal.xyz));
    float length_of = length(outward);
    outward = length_of > 0.0 ? outward / length_of : vec3(0.0);
    tone = paint.a > 0.0 ? paint : color;
    place = uv;
    // Copies that lie behind each other must not be let through by the same passes.
    float mixed = fract(dot(vec3(row_x.w, row_y.w, row_z.w), vec3(17.31, 29.77, 41.13)) + normal.w);
    chance = floor(mixed * passes) / passes;
    gl_Position = projection * vec4(world, 1.0);
}
