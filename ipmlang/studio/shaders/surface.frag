#version 330
// What is seen in a pixel: which way it faces, and its colour. Light comes later.

in vec3 world;
in vec3 outward;
in vec4 tone;
in vec2 place;
flat in float chance;

uniform vec3 eye;
uniform bool textured;
uniform sampler2D image;
uniform float turn;  // which of the passes this is, 0 to 1

layout(location = 0) out vec4 facing;  // normal and kind, 0 to 1
layout(location = 1) out vec4 shown;   // colour, sRGB

void main() {
    vec4 color = tone;
    if (textured) color *= texture(image, place);
    // Opacity is the share of passes that see the surface.
    if (color.a <= fract(turn + chance)) discard;
    vec3 flat_normal = normalize(cross(dFdx(world), dFdy(world)));
    vec3 toward_eye = eye - world;
    if (dot(flat_normal, toward_eye) < 0.0) flat_normal = -flat_normal;
    vec3 smooth_normal = dot(outward, outward) > 0.0 ? normalize(outward) : flat_normal;
    if (dot(smooth_normal, flat_normal) < 0.0) smooth_normal = -smooth_normal;
    facing = vec4(smooth_normal * 0.5 + 0.5, 1.0 / 3.0);
    shown = vec4(color.rgb, 1.0);
}
